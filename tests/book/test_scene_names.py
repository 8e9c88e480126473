"""Names in a scene are text, whatever they hold: none runs as script in it or in the page around it."""

from pathlib import Path

import numpy as np
import pytest
from open_scene import open_scene
from playwright.sync_api import Browser
from visit import visit

from dexterity import indices, robots, scenes
from dexterity.chain import Chain
from dexterity.scenes import Body, Scene, Slider

RUN = "parent.document.body.dataset.ran=1"
WITHOUT_SLASH = (
    f'<img src=x onerror="{RUN}">',
    f"'\"><svg onload={RUN}>",
    f"</title><script>{RUN}</script>".replace("/", "\\"),
    f"${{{RUN}}}",
    f"javascript:{RUN}",
    f"`);{RUN}(`",
    "__proto__",
    "constructor",
    "<object>",
    "$x_1$ & <b>",
)
WITH_SLASH = (f"<script>{RUN}</script>", f"</script><script>{RUN}</script>", f"--><script>{RUN}</script>")
EVERYWHERE = (*WITH_SLASH, *WITHOUT_SLASH)


def hostile(name: str) -> Scene:
    """Return a scene with a name in each place that has one."""
    inner = name.replace("/", "\\")
    scene = Scene(name)
    puma = robots.puma560()
    joints = [f"{name} {i}" for i in range(6)]
    chain = Chain(puma.screws, puma.home, name=inner, joint_names=joints, lower=[-1] * 6, upper=[1] * 6)
    scene.add_chain(chain, np.zeros(6))
    scene.add_sliders(inner)
    scene.add_chain(chain, np.zeros(6), name=f"{inner} two")
    scene.add_sliders(f"{inner} two")
    scene.add_chain(chain, np.zeros(6), name=f"{inner} three")
    scene.animate(f"{inner} three", np.linspace(0, 1, 12).reshape(2, 6))
    values = np.array([0.0, 1.0])
    body = Body(f"{inner} body", slider=name, poses=np.stack([np.eye(4)] * 2), letters={name: np.zeros(3)})
    scene.add_mechanism([body], [Slider(name, values, 0.0)], name=f"{inner} mechanism")
    scene.add_box([0.1] * 3, name=f"{inner} box")
    scene.add_path(np.eye(3), name=f"{inner} path")
    scene.add_points(np.eye(3), name=f"{inner} points")
    scene.add_bars(f"{inner} bars", np.arange(6.0).reshape(1, 2, 3))
    scene.add_letters({name: np.zeros(3)}, name=f"{inner} letters")
    ellipsoid = indices.velocity_ellipsoid(puma.geometric_jacobian([0.1] * 6), "translational")
    scene.add_ellipsoid(ellipsoid, np.zeros(3), name=f"{inner} ellipsoid")
    scene.add_remark(name)
    return scene


@pytest.mark.parametrize(
    ("name", "in_notebook"), [*((name, False) for name in EVERYWHERE), (WITH_SLASH[1], True)]
)
def test_no_name_becomes_script(browser: Browser, tmp_path: Path, name: str, in_notebook: bool):
    html, root = scenes.side_by_side(hostile(name)).text, 'data-content_root="./"'
    if in_notebook:
        html, root = scenes.standalone(html), ""
    else:
        scenes.copy_viewer(tmp_path / "_static" / "meshcat")
    text = f'<!DOCTYPE html><html lang="en" {root}><meta charset="utf-8"><body>{html}</body></html>'
    (tmp_path / "page.html").write_text(text, encoding="utf-8")
    with visit(browser, f"{tmp_path.as_uri()}/", "page") as visited:
        frame = open_scene("page", visited.page.locator("iframe")).frame
        shown = frame.evaluate("document.getElementById('still').alt")
        assert shown.startswith(f"{name}: ")
        assert frame.evaluate("document.getElementById('still').naturalWidth") > 0
        assert name in frame.evaluate("document.getElementById('legend').textContent")
        assert frame.evaluate("document.querySelectorAll('script').length") == 4
        assert not frame.evaluate("document.querySelectorAll('img:not(#still), svg').length")
        assert visited.page.evaluate("document.body.dataset.ran") is None
    assert not visited.problems


def test_the_page_runs_no_script_of_a_name_even_where_a_name_is_not_escaped(browser: Browser, tmp_path: Path):
    html = scenes.side_by_side(hostile("arm")).text
    spoiled = html.replace("<ul id=", f'<img src=x onerror="{RUN}"><script>{RUN}</script><ul id=', 1)
    assert spoiled != html
    scenes.copy_viewer(tmp_path / "_static" / "meshcat")
    text = f'<!DOCTYPE html><html lang="en" data-content_root="./"><body>{spoiled}</body></html>'
    (tmp_path / "page.html").write_text(text, encoding="utf-8")
    page = browser.new_page()
    page.goto(f"{tmp_path.as_uri()}/page.html")
    open_scene("page", page.locator("iframe"))
    assert page.evaluate("document.body.dataset.ran") is None
    page.close()
