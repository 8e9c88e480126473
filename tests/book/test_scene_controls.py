"""What a reader does to a scene, on a page that is made here: keyboard, touch, wheel, theme, notebook."""

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from typing import TypeAlias

import numpy as np
import pytest
from open_scene import OpenScene, open_scene, scrolled, soon
from playwright.sync_api import Browser, Page
from visit import PHONE, TOUCH, visit

from dexterity import robots, scenes
from dexterity.scenes import Body, Scene, Slider

SQUARE = np.array([[-0.2, -0.2, 0.0], [-0.2, 0.2, 0.0], [0.2, 0.2, 0.0], [0.2, -0.2, 0.0]])
BEFORE_AND_BEHIND = "<p>{}</p>".format("A line of text. " * 1200)
"""Text of more than a window's height."""

Opened: TypeAlias = Callable[..., AbstractContextManager[tuple[OpenScene, Page]]]


@pytest.fixture
def opened(browser: Browser, tmp_path: Path) -> Opened:
    """Open a scene on a page between two long texts, from a file."""

    @contextmanager
    def opening(
        scene: Scene, in_notebook: bool = False, phone: bool = False, **profile: str
    ) -> Iterator[tuple[OpenScene, Page]]:
        html, root = scene._repr_html_(), 'data-content_root="./" data-theme="light"'
        if in_notebook:
            html, root = scenes.standalone(html), ""
        else:
            scenes.copy_viewer(tmp_path / "_static" / "meshcat")
        head = '<meta charset="utf-8"><meta name="viewport" content="width=device-width">'
        body = BEFORE_AND_BEHIND + html + BEFORE_AND_BEHIND
        text = f'<!DOCTYPE html><html lang="en" {root}><head>{head}</head><body>{body}</body></html>'
        (tmp_path / "page.html").write_text(text, encoding="utf-8")
        with visit(
            browser, f"{tmp_path.as_uri()}/", "page", **(TOUCH if phone else {}), **profile
        ) as visited:
            if phone:
                visited.resize(PHONE)
            yield open_scene("page", visited.page.locator("iframe")), visited.page
        assert not visited.problems

    return opening


def with_sliders() -> Scene:
    scene = Scene("A vehicle with an arm")
    scene.add_chain(robots.uvms(), np.zeros(12), name="uvms")
    scene.add_sliders("uvms")
    return scene


def animated(values: np.ndarray) -> Scene:
    scene = Scene("An arm that moves")
    scene.add_chain(robots.puma560(), np.zeros(6), name="arm")
    scene.animate("arm", values, frames_per_second=2.0)
    return scene


def with_everything() -> Scene:
    """An animation, and as many sliders as may have a Tab stop each, and one more."""
    scene = animated(np.linspace(0, 1, 60).reshape(10, 6))
    values = np.array([0.0, 1.0])
    for i in range(6):
        moved = np.stack([np.eye(4)] * 2)
        moved[1, 0, 3] = 0.1
        body = Body("body", slider="s", poses=moved, rods=np.array([[[0, 0, i], [1.0, 0, i]]]))
        scene.add_mechanism([body], [Slider("s", values, 0.5)], name=f"m{i}")
    return scene


# ---- keyboard ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("made", [with_sliders, with_everything, lambda: animated(np.zeros((2, 6)))])
@pytest.mark.parametrize("phone", [False, True])
def test_ten_tab_stops_at_most(opened: Opened, made: Callable[[], Scene], phone: bool) -> None:
    with opened(made(), phone=phone) as (scene, _):
        scene.frame.evaluate("panel.open = true")
        assert 1 <= scene.tab_stops() <= 10


def test_arrow_keys_choose_a_slider_and_move_its_joint(opened: Opened) -> None:
    with opened(with_sliders()) as (scene, page):
        before = scene.picture()["digest"]
        scene.frame.get_by_label("x", exact=True).focus()
        page.keyboard.press("ArrowDown")
        page.keyboard.press("ArrowDown")
        page.keyboard.press("ArrowRight")
        moved = scene.frame.evaluate(
            "[document.activeElement.labels[0].textContent, document.activeElement.value]"
        )
        assert moved == ["z", "0.01"]
        assert soon(lambda: scene.picture()["digest"] != before)
        joint = "uvms/link0/joint0/link1/joint1/link2/joint2"
        nodes = ["meshcat", *joint.split("/")]
        assert scene.frame.evaluate("nodes => viewer.scene_tree.find(nodes).object.position.z", nodes) == 0.01
        page.keyboard.press("ArrowUp")
        assert scene.frame.evaluate("document.activeElement.labels[0].textContent") == "y"


def test_a_slider_says_its_value_with_its_unit(opened: Opened) -> None:
    with opened(with_sliders()) as (scene, _):
        slider = scene.frame.get_by_label("θm1", exact=True)
        slider.press("ArrowLeft")
        assert slider.get_attribute("aria-valuetext") == "−0.01 rad"
        group = scene.frame.get_by_role("group", name="Sliders that move the scene")
        assert group.get_by_role("slider").count() == 12
        assert "12 sliders" in (scene.frame.locator("canvas").get_attribute("aria-label") or "")


def test_reset_takes_everything_back(opened: Opened) -> None:
    with opened(with_sliders()) as (scene, _):
        camera, picture = scene.camera(), scene.picture()["digest"]
        scene.frame.get_by_label("θm2", exact=True).press("PageUp")
        scene.frame.locator("canvas").press("ArrowLeft")
        assert soon(lambda: scene.camera() != camera)
        scene.frame.get_by_role("button", name="Reset").click()
        assert scene.camera() == pytest.approx(camera)
        assert soon(lambda: scene.picture()["digest"] == picture)
        assert scene.frame.get_by_label("θm2", exact=True).input_value() == "0"


def test_arrow_keys_turn_the_scene(opened: Opened) -> None:
    with opened(with_sliders()) as (scene, page):
        before = scene.camera()
        scene.frame.locator("canvas").focus()
        page.keyboard.press("ArrowLeft")
        assert scene.camera() != pytest.approx(before)
        assert np.linalg.norm(scene.camera()) == pytest.approx(np.linalg.norm(before), rel=0.2)


def test_the_viewers_own_panel_is_gone(opened: Opened) -> None:
    with opened(with_sliders()) as (scene, _):
        assert scene.frame.locator(".dg").count() == 0
        assert scene.frame.get_by_text("Save / Load").count() == 0


# ---- animations -------------------------------------------------------------------------------------

ONE_BY_ONE = np.zeros((7, 6))
ONE_BY_ONE[1:4, 0] = 0.4
ONE_BY_ONE[4:, 1] = 0.4
ONE_BY_ONE[4:, 0] = 0.4


def test_the_joint_that_moves_is_named(opened: Opened) -> None:
    first, second, *_ = robots.puma560().joint_names
    with opened(animated(ONE_BY_ONE)) as (scene, _):
        time = scene.frame.get_by_label("Time")
        shown = scene.frame.locator("#moving")
        for seconds, text in ((0.25, first), (1.0, "nothing"), (1.75, second)):
            time.evaluate(
                "(slider, to) => { slider.value = to; slider.dispatchEvent(new Event('input')); }", seconds
            )
            assert shown.text_content() == f"Moves: {text}"
        assert scene.frame.get_by_role("button", name="Play").count() == 1


def test_an_animation_can_be_stopped_and_goes_on(opened: Opened) -> None:
    with opened(animated(np.linspace(0, 1, 12).reshape(2, 6))) as (scene, _):
        assert scene.changes()
        scene.frame.get_by_role("button", name="Pause").click()
        assert not scene.frame.evaluate("viewer.animator.playing")
        scene.frame.get_by_role("button", name="Play").click()
        assert scene.changes()


def test_reduced_motion_is_respected(opened: Opened) -> None:
    with opened(animated(np.linspace(0, 1, 12).reshape(2, 6)), reduced_motion="reduce") as (scene, _):
        assert not scene.frame.evaluate("viewer.animator.playing")
        assert scene.frame.get_by_role("button", name="Play").count() == 1


# ---- touch and wheel --------------------------------------------------------------------------------


def test_a_swipe_scrolls_until_the_scene_is_tapped(opened: Opened) -> None:
    with opened(with_sliders(), phone=True) as (scene, page):
        camera, start = scene.camera(), scrolled(page)
        assert scene.frame.locator("#hint").text_content() == "tap to turn"
        scene.swipe(up=150)
        assert soon(lambda: scrolled(page) > start + 75)
        assert scene.camera() == camera

        scene.element.scroll_into_view_if_needed()
        page.touchscreen.tap(*scene.middle())
        assert soon(lambda: scene.frame.evaluate("held"))
        start = scrolled(page)
        scene.swipe(up=60)
        assert soon(lambda: scene.camera() != pytest.approx(camera))
        assert scrolled(page) == start

        box = scene.element.bounding_box()
        assert box
        beside = box["y"] - 20 if box["y"] > 40 else box["y"] + box["height"] + 20
        page.touchscreen.tap(100, beside)
        assert soon(lambda: not scene.frame.evaluate("held"))
        scene.swipe(up=100)
        assert soon(lambda: scrolled(page) > start + 50)


def test_the_wheel_scrolls_until_the_scene_is_pressed(opened: Opened) -> None:
    with opened(with_sliders()) as (scene, page):
        camera, start = scene.camera(), scrolled(page)
        page.mouse.move(*scene.middle())
        page.mouse.wheel(0, 100)
        assert soon(lambda: scrolled(page) > start)
        assert scene.camera() == camera
        page.mouse.move(*scene.middle())
        page.mouse.down()
        page.mouse.up()
        start = scrolled(page)
        page.mouse.wheel(0, 100)
        assert soon(lambda: scene.camera() != pytest.approx(camera))
        assert scrolled(page) == start


# ---- what is drawn ----------------------------------------------------------------------------------


@pytest.mark.parametrize("corner", range(4))
def test_a_square_has_its_corners(opened: Opened, corner: int) -> None:
    scene = Scene("A square", view_from=(0.0, 0.2, 1.0))
    scene.add_path(SQUARE[[0, 1, 2, 3, 0]], color="blue")
    with opened(scene) as (shown, _):
        at = 0.999 * SQUARE[corner]
        assert shown.frame.evaluate("at => checks.colorAt(...at)", at.tolist()) == [0x00, 0x72, 0xB2]
        inside = 0.9 * SQUARE[corner]
        assert shown.frame.evaluate("at => checks.colorAt(...at)", inside.tolist()) != [0x00, 0x72, 0xB2]


def test_the_scene_follows_the_theme_of_the_page(opened: Opened) -> None:
    scene = Scene("A black square", view_from=(0.0, 0.2, 1.0))
    scene.add_path(SQUARE[[0, 1, 2, 3, 0]], color="black")
    ground = "getComputedStyle(document.documentElement).getPropertyValue('--ground')"
    with opened(scene) as (shown, page):
        light = shown.frame.evaluate(ground)
        at = SQUARE[0].tolist()
        assert max(shown.frame.evaluate("at => checks.colorAt(...at)", at)) < 30
        page.evaluate("document.documentElement.dataset.theme = 'dark'")
        assert soon(lambda: shown.frame.evaluate(ground) != light)
        assert min(shown.frame.evaluate("at => checks.colorAt(...at)", at)) > 180
        page.evaluate("document.documentElement.dataset.theme = 'light'")
        assert soon(lambda: shown.frame.evaluate(ground) == light)


def test_a_scene_keeps_its_sliders_while_it_is_out_of_sight(opened: Opened) -> None:
    with opened(with_sliders()) as (scene, page):
        scene.frame.get_by_label("θm2", exact=True).press("PageUp")
        moved = scene.picture()["digest"]
        page.evaluate("scrollTo(0, 0)")
        assert soon(lambda: scene.frame.title() == "scene-idle")
        scene = open_scene("page", scene.element)
        assert soon(lambda: scene.picture()["digest"] == moved)


def test_a_scene_in_a_notebook_is_live(opened: Opened) -> None:
    with opened(with_sliders(), in_notebook=True) as (scene, _):
        before = scene.picture()["digest"]
        scene.frame.get_by_label("θm2", exact=True).press("PageUp")
        assert soon(lambda: scene.picture()["digest"] != before)
