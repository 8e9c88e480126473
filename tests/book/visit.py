"""A page opened in a browser that reaches nothing but the book, with a record of what went wrong."""

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from playwright.sync_api import Browser, ConsoleMessage, Page, Request, Response

DESKTOP = (1280, 900)
PHONE = (390, 844)
TOUCH = {"has_touch": True, "is_mobile": True}

SECONDS_TO_SETTLE = 30


@dataclass
class Visit:
    """An open page and what has been asked for, refused and complained about since it was opened."""

    page: Page
    requests: list[str] = field(default_factory=list)
    unanswered: set[Request] = field(default_factory=set)
    problems: list[str] = field(default_factory=list)

    def resize(self, size: tuple[int, int]) -> None:
        self.page.set_viewport_size({"width": size[0], "height": size[1]})

    def settle(self) -> None:
        """Wait until every request was answered."""
        end = time.monotonic() + SECONDS_TO_SETTLE
        while self.unanswered and time.monotonic() < end:
            self.page.wait_for_timeout(50)
        self.problems += [f"{request.url} is not answered" for request in self.unanswered]


@contextmanager
def visit(
    browser: Browser, root: str, address: str, scheme: str = "light", **profile: bool | str
) -> Iterator[Visit]:
    """Open a page of the book at `root`; every request that leads elsewhere is refused and recorded.

    The address is that of the page in the book, without `.html`, and may end in a query. A profile, such as
    :data:`TOUCH`, says what else the browser is.
    """
    name, _, query = address.partition("?")
    context = browser.new_context(
        viewport={"width": DESKTOP[0], "height": DESKTOP[1]},
        color_scheme=scheme,  # type: ignore[arg-type]
        service_workers="block",
        **profile,  # type: ignore[arg-type]
    )
    context.add_init_script(path=Path(__file__).with_name("page_checks.js"))
    visited = Visit(context.new_page())
    context.route(lambda url: not url.startswith(root), lambda route: route.abort())
    _record(visited, root)
    try:
        visited.page.goto(f"{root}{name}.html?{query}" if query else f"{root}{name}.html", wait_until="load")
        yield visited
    finally:
        context.close()


def _record(visited: Visit, root: str) -> None:
    problems = visited.problems

    def requested(request: Request) -> None:
        visited.requests.append(request.url)
        visited.unanswered.add(request)
        if not request.url.startswith((root, "data:", "blob:", "about:")):
            problems.append(f"asks for {request.url}, outside of the book")

    def failed(request: Request) -> None:
        visited.unanswered.discard(request)
        problems.append(f"{request.url} failed: {request.failure}")

    def answered(response: Response) -> None:
        if response.status >= 400:
            problems.append(f"{response.url} answered {response.status}")

    def said(message: ConsoleMessage) -> None:
        if message.type == "error":
            problems.append(f"console error: {message.text}")

    page = visited.page
    page.on("request", requested)
    page.on("response", answered)
    page.on("console", said)
    page.on("requestfinished", lambda request: visited.unanswered.discard(request))
    page.on("requestfailed", failed)
    page.on("pageerror", lambda error: problems.append(f"script error: {error}"))
