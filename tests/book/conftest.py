"""A browser, and the two ways in which readers open the book: from a file and from a server."""

import http.server
import shutil
import threading
from collections.abc import Iterator
from functools import partial

import pytest
from built_book import HTML
from playwright.sync_api import Browser, sync_playwright

# WebGL without a graphics card, and no errand of the browser's own.
_FLAGS = (
    "--no-sandbox",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--no-first-run",
)
_CHROMIUM_NAMES = ("chromium", "chromium-browser", "google-chrome")


@pytest.fixture(scope="session", autouse=True)
def _book_is_built() -> None:
    if not (HTML / "index.html").is_file():
        pytest.fail(f"there is no built book at {HTML}: run make book", pytrace=False)


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    executable = next(filter(None, map(shutil.which, _CHROMIUM_NAMES)), None)
    if executable is None:
        pytest.fail(
            f"none of {', '.join(_CHROMIUM_NAMES)} is on the path; install Chromium, "
            "on Debian for example by: apt-get install chromium",
            pytrace=False,
        )
    with sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=executable, args=list(_FLAGS))
        yield chromium
        chromium.close()


class _QuietHandler(http.server.SimpleHTTPRequestHandler):
    def log_message(self, format: str, *args: object) -> None:  # noqa: A002
        """Say nothing."""


@pytest.fixture(scope="session")
def served_root() -> Iterator[str]:
    """The book on a server of this machine."""
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), partial(_QuietHandler, directory=HTML))
    thread = threading.Thread(target=server.serve_forever)
    thread.start()
    yield f"http://127.0.0.1:{server.server_port}/"
    server.shutdown()
    thread.join()
    server.server_close()


@pytest.fixture(params=["file", "server"])
def root(request: pytest.FixtureRequest) -> str:
    """Where the book is opened: the address that all its pages begin with."""
    if request.param == "file":
        return f"{HTML.as_uri()}/"
    return request.getfixturevalue("served_root")
