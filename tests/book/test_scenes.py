"""Every scene is drawn, and what is to move moves: pixels are read back from the browser."""

import time
from collections.abc import Callable
from dataclasses import dataclass

import pytest
from built_book import PAGES, html_file
from playwright.sync_api import Browser, Frame, Locator
from playwright.sync_api import TimeoutError as PlaywrightTimeout
from visit import visit

SECONDS_TO_DRAW = 30
SECONDS_TO_MOVE = 10
COLORS_OF_A_BACKGROUND = 20


def _has_scene(page: str) -> bool:
    file = html_file(page)
    return file.is_file() and 'class="meshcat-scene"' in file.read_text(encoding="utf-8")


PAGES_WITH_SCENES = [page for page in PAGES if _has_scene(page)]


@dataclass(frozen=True)
class OpenScene:
    """A scene whose viewer has started."""

    title: str
    element: Locator
    frame: Frame

    def picture(self) -> dict[str, int]:
        return self.frame.evaluate("checks.picture()")

    def changes(self) -> bool:
        """Whether the picture becomes another one soon."""
        before = self.picture()["digest"]
        return _soon(lambda: self.picture()["digest"] != before)


def test_some_page_has_a_scene() -> None:
    assert PAGES_WITH_SCENES


@pytest.mark.parametrize("page", PAGES_WITH_SCENES)
def test_scenes_draw_and_move(browser: Browser, root: str, page: str) -> None:
    with visit(browser, root, page) as visited:
        iframes = visited.page.locator("iframe.meshcat-scene")
        assert iframes.count() > 0, f"{page} has lost its scenes"
        for i in range(iframes.count()):
            scene = _open(page, iframes.nth(i))
            colors = scene.picture()["colors"]
            assert colors > COLORS_OF_A_BACKGROUND, f"{scene.title} shows {colors} colours: only a background"
            if scene.frame.evaluate("checks.hasAnimation()"):
                assert scene.changes(), f"{scene.title} has an animation that does not play"
            if scene.frame.evaluate("checks.hasSliders()"):
                _try_slider(scene)
        problems = visited.problems
    assert not problems, f"{page}: {problems}"


def _open(page: str, element: Locator) -> OpenScene:
    title = f"{page}: scene '{element.get_attribute('title')}'"
    assert element.get_attribute("title"), f"{page}: a scene has no title for those who do not see it"
    element.scroll_into_view_if_needed()
    handle = element.element_handle()
    frame = handle and handle.content_frame()
    assert frame, f"{title} is no frame"
    try:
        frame.wait_for_function("document.title === 'scene-ready'", timeout=1000 * SECONDS_TO_DRAW)
    except PlaywrightTimeout:
        said = f"{frame.title()}: {frame.inner_text('body')[:200]}"
        pytest.fail(f"{title} is not drawn after {SECONDS_TO_DRAW} s; it says {said}")
    return OpenScene(title, element, frame)


def _try_slider(scene: OpenScene) -> None:
    slider = scene.frame.evaluate_handle("checks.firstSlider()").as_element()
    box = slider and slider.bounding_box()
    assert slider, f"{scene.title}: the first control is no slider"
    assert box, f"{scene.title}: the first slider is not shown"
    before = scene.picture()["digest"]
    slider.click(position={"x": 0.8 * box["width"], "y": 0.5 * box["height"]}, timeout=1000 * SECONDS_TO_MOVE)
    assert _soon(lambda: scene.picture()["digest"] != before), f"{scene.title}: a slider moves nothing"


def _soon(holds: Callable[[], bool]) -> bool:
    end = time.monotonic() + SECONDS_TO_MOVE
    while time.monotonic() < end:
        if holds():
            return True
        time.sleep(0.1)
    return False
