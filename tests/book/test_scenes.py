"""Every scene is drawn, and what is to move moves; a keyboard gets past it and a finger scrolls over it."""

import pytest
from built_book import HTML, PAGES, html_file
from open_scene import OpenScene, open_scene, scrolled, soon
from playwright.sync_api import Browser
from visit import PHONE, TOUCH, visit

COLORS_OF_A_BACKGROUND = 20
MOST_TAB_STOPS = 10


def _has_scene(page: str) -> bool:
    file = html_file(page)
    return file.is_file() and 'class="meshcat-scene"' in file.read_text(encoding="utf-8")


PAGES_WITH_SCENES = [page for page in PAGES if _has_scene(page)]


def test_some_page_has_a_scene() -> None:
    assert PAGES_WITH_SCENES


@pytest.mark.parametrize("page", PAGES_WITH_SCENES)
def test_scenes_draw_and_move(browser: Browser, root: str, page: str) -> None:
    with visit(browser, root, page) as visited:
        visited.page.evaluate("checks.unfold()")
        iframes = visited.page.locator("iframe.meshcat-scene")
        assert iframes.count() > 0, f"{page} has lost its scenes"
        for i in range(iframes.count()):
            scene = open_scene(page, iframes.nth(i))
            colors = scene.picture()["colors"]
            assert colors > COLORS_OF_A_BACKGROUND, f"{scene.title} shows {colors} colours: only a background"
            if scene.frame.evaluate("checks.hasAnimation()"):
                assert scene.changes(), f"{scene.title} has an animation that does not play"
            _try_keyboard(scene)
        problems = visited.problems
    assert not problems, f"{page}: {problems}"


def _try_keyboard(scene: OpenScene) -> None:
    stops = scene.tab_stops()
    assert 1 <= stops <= MOST_TAB_STOPS, f"{scene.title} has {stops} Tab stops"
    if scene.frame.evaluate("checks.hasSliders()"):
        before = scene.picture()["digest"]
        scene.frame.locator("#controls [role=group] input").first.press("PageUp")
        assert soon(lambda: scene.picture()["digest"] != before), f"{scene.title}: a slider moves nothing"


@pytest.mark.parametrize("page", PAGES_WITH_SCENES)
def test_a_swipe_that_starts_on_a_scene_scrolls_the_page(browser: Browser, page: str) -> None:
    with visit(browser, f"{HTML.as_uri()}/", page, **TOUCH) as visited:
        visited.resize(PHONE)
        visited.page.evaluate("checks.unfold()")
        iframes = visited.page.locator("iframe.meshcat-scene")
        for i in range(iframes.count()):
            scene = open_scene(page, iframes.nth(i))
            before = scrolled(visited.page)
            scene.swipe(up=150)
            assert soon(lambda before=before: scrolled(visited.page) > before + 75), (
                f"{scene.title} traps a swipe"
            )
