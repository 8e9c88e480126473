"""A scene whose viewer has started, and what a reader does to it."""

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest
from playwright.sync_api import Frame, Locator, Page

SECONDS_TO_DRAW = 30
SECONDS_TO_MOVE = 10

MOST_TABS = 60
"""So many Tab presses tell a trap from a long way."""

_STAND_BEFORE = """scene => {
  const before = document.createElement("button"), after = document.createElement("button");
  before.textContent = after.textContent = "beside the scene";
  scene.before(before);
  scene.after(after);
  before.focus();
  window.isBehind = () => document.activeElement === after;
}"""


@dataclass(frozen=True)
class OpenScene:
    """A scene whose viewer has started."""

    title: str
    element: Locator
    frame: Frame

    def picture(self) -> dict[str, int]:
        return self.frame.evaluate("checks.picture()")

    def camera(self) -> list[float]:
        return self.frame.evaluate("checks.camera()")

    def changes(self) -> bool:
        """Whether the picture becomes another one soon."""
        before = self.picture()["digest"]
        return soon(lambda: self.picture()["digest"] != before)

    def tab_stops(self) -> int:
        """Tab presses inside the scene from what is before it to what is behind it."""
        page = self.element.page
        self.element.evaluate(_STAND_BEFORE)
        for presses in range(1, MOST_TABS):
            page.keyboard.press("Tab")
            if page.evaluate("isBehind()"):
                return presses - 1
        return pytest.fail(f"{self.title}: {MOST_TABS} Tab presses do not lead past it")

    def middle(self) -> tuple[float, float]:
        """Middle of the picture in the window [CSS pixels]."""
        box = self.frame.locator("#pane").bounding_box()
        assert box, f"{self.title}: the picture is not shown"
        return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2

    def swipe(self, up: float) -> None:
        """Swipe with a finger from the middle of the picture so many pixels upwards."""
        x, y = self.middle()
        devtools = self.element.page.context.new_cdp_session(self.element.page)
        steps = np.linspace(0, up, 11)
        for kind, step in zip(["touchStart", *["touchMove"] * 10], steps, strict=True):
            devtools.send(
                "Input.dispatchTouchEvent", {"type": kind, "touchPoints": [{"x": x, "y": y - step}]}
            )
            self.element.page.wait_for_timeout(20)
        devtools.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})
        devtools.detach()


def open_scene(page: str, element: Locator) -> OpenScene:
    """Scroll to a scene and wait until its viewer draws."""
    title = f"{page}: scene '{element.get_attribute('title')}'"
    assert element.get_attribute("title"), f"{page}: a scene has no title for those who do not see it"
    element.scroll_into_view_if_needed()
    handle = element.element_handle()
    frame = handle and handle.content_frame()
    assert frame, f"{title} is no frame"
    # Asked from outside, because the scene lets nobody evaluate a text in it.
    if not soon(lambda: frame.title() == "scene-ready", SECONDS_TO_DRAW):
        said = f"{frame.title()}: {frame.inner_text('body')[:200]}"
        pytest.fail(f"{title} is not drawn after {SECONDS_TO_DRAW} s; it says {said}")
    return OpenScene(title, element, frame)


def scrolled(page: Page) -> float:
    """Pixels that a page is scrolled down."""
    return page.evaluate("scrollY")


def soon(holds: Callable[[], bool], seconds: float = SECONDS_TO_MOVE) -> bool:
    """Whether a condition comes to hold within some seconds."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if holds():
            return True
        time.sleep(0.1)
    return False
