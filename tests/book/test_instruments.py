"""Live instruments in the built pages: the package's numbers, drawn in time, by mouse, keyboard and touch."""

import math
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any

import numpy as np
import pytest
import torch
from built_book import PAGES, html_file
from instrument_cases import crane_cases, docking_cases
from numpy.testing import assert_allclose
from playwright.sync_api import Browser, Frame, Locator
from playwright.sync_api import TimeoutError as PlaywrightTimeout
from visit import Visit, visit

import dexterity as dx
from dexterity.indices import Index
from dexterity.workspace import closed_form, reachability
from dexterity_study.uvms.indices import instrument as uvms
from dexterity_study.workspace.puma import instrument as puma

SECONDS_TO_START = 60
CONFIGURATIONS = 200
DRAGS = 50
SECONDS_TO_DRAW = 0.050
TAB_STOPS = 10

FITS = "Math.abs(innerHeight - document.querySelector('main').getBoundingClientRect().height) <= 1"

SCROLL_HAS_ENDED = """async () => {
  for (let frames = 0, last = null; frames < 20; last = scrollY) {
    await new Promise(requestAnimationFrame);
    frames = scrollY === last ? frames + 1 : 0;
  }
}"""

Inputs = dict[str, Any]


def _has_instrument(page: str) -> bool:
    file = html_file(page)
    return file.is_file() and 'class="instrument"' in file.read_text(encoding="utf-8")


PAGES_WITH_INSTRUMENTS = [page for page in PAGES if _has_instrument(page)]
every_page = pytest.mark.parametrize("page", PAGES_WITH_INSTRUMENTS)


@contextmanager
def opened(browser: Browser, root: str, page: str) -> Iterator[tuple[Visit, Locator, Frame]]:
    """The first instrument of a page, started."""
    with visit(browser, root, page) as visited:
        element = visited.page.locator("iframe.instrument").first
        element.scroll_into_view_if_needed()
        handle = element.element_handle()
        frame = handle and handle.content_frame()
        assert frame, f"{page}: the instrument is no frame"
        try:
            frame.wait_for_function("document.title === 'instrument-ready'", timeout=1000 * SECONDS_TO_START)
        except PlaywrightTimeout:
            pytest.fail(f"{page}: the instrument has not started: {frame.inner_text('body')[-300:]}")
        yield visited, element, frame


def test_the_start_page_and_the_parts_have_instruments() -> None:
    assert {"index", *CASES} <= set(PAGES_WITH_INSTRUMENTS)


# ---- values ----


def _uvms_cases() -> tuple[list[Inputs], Mapping[str, Any]]:
    """Configurations, half of them in the trained space, and what the package says of them."""
    random = torch.Generator().manual_seed(1)
    space = uvms.guarded("kci", "RadialBasis").space
    inside = dx.sampling.uniform(space, CONFIGURATIONS // 2, random)
    anywhere = math.pi * (2 * torch.rand(CONFIGURATIONS // 2, 12, generator=random, dtype=torch.float64) - 1)
    q, chain = torch.cat([inside, anywhere]), dx.robots.uvms()
    wanted: dict[str, Any] = {"kciTool": Index("kinematic_conditioning", "geometric").bind(chain)(q).tolist()}
    for name, index in uvms.INDICES.items():
        exact = Index(index).bind(chain)(q)
        wanted[name] = exact.tolist()
        for kind in uvms.KINDS:
            guarded = uvms.guarded(name, kind)
            with torch.no_grad():
                value = guarded.network(q)
            wanted[f"{name}{kind}"] = value.tolist()
            wanted[f"{name}{kind}Error"] = (value / exact - 1).abs().tolist()
            wanted[f"{name}Inside"] = ["yes" if x else "no" for x in guarded.contains(q)]
    names = [f"q{joint}" for joint in range(1, 13)]
    return [dict(zip(names, row, strict=True)) for row in q.tolist()], wanted


def _puma_cases() -> tuple[list[Inputs], Mapping[str, Any]]:
    """Arms and poses, and what the package says of them."""
    random = np.random.default_rng(1)
    inputs = [
        {
            **dict(zip(reachability.LINK_NAMES, random.uniform(0, 0.6, 4).tolist(), strict=True)),
            "radius": random.uniform(0, 0.6),
            "height": random.uniform(-0.6, 0.6),
            **{name: random.uniform(-math.pi, math.pi) for name in ("azimuth", "turnx", "turny", "turnz")},
        }
        for _ in range(CONFIGURATIONS)
    ]
    links = torch.from_numpy(np.array([[row[name] for name in reachability.LINK_NAMES] for row in inputs]))
    across, azimuth, height = (
        np.array([row[name] for row in inputs]) for name in ("radius", "azimuth", "height")
    )
    position = np.stack([across * np.cos(azimuth), across * np.sin(azimuth), height], -1)
    angles = np.array([[row[f"turn{axis}"] for axis in "xyz"] for row in inputs])
    T = puma.free_body().forward(np.concatenate([position, angles], -1))
    reach = reachability.reachable(links, position)
    return inputs, {
        "reach": ["yes" if x else "no" for x in reach],
        "w": closed_form.in_torch(reachability.NAMED_BRANCH, "manipulability")(links, T)[..., 0].tolist(),
        "trained": [
            "yes" if x else "no" for x in puma.trained_space().contains(torch.cat([links, T[:, :3, 3]], -1))
        ],
        **{
            inputs: puma.confidence(title)(links, T).tolist()
            for title, (inputs, _, _) in puma.NETWORKS.items()
        },
    }


CASES: Mapping[str, Callable[[], tuple[list[Inputs], Mapping[str, Any]]]] = {
    "index": _uvms_cases,
    "uvms/indices": _uvms_cases,
    "workspace/puma": _puma_cases,
    "docking/area": docking_cases,
    "crane/positioning": crane_cases,
}
ROUNDING: Mapping[str, float] = {"compensation": 1e-9}
"""Largest differences where inputs vary as the root of a rounding error; else 1e-13.

With the least extension the crane's arms are folded or stretched, and aiming off varies by a nanometre [m].
"""


@pytest.mark.parametrize("page", CASES)
def test_values_are_those_of_the_package(browser: Browser, root: str, page: str) -> None:
    inputs, wanted = CASES[page]()
    names = list(wanted)
    with opened(browser, root, page) as (visited, _, frame):
        shown = frame.evaluate(
            "([inputs, names]) => inputs.map(row => { const outputs = instrument.values(row);"
            " return names.map(name => outputs[name]); })",
            [inputs, names],
        )
        problems = visited.problems
    assert not problems
    for name, values in zip(names, zip(*shown, strict=True), strict=True):
        if isinstance(wanted[name][0], str):
            assert list(values) == wanted[name], name
            assert 0 < wanted[name].count("yes") < len(values), f"{name} is the same everywhere"
        elif name.endswith("Error"):
            # The error is a difference: that of the values is compared, relative to them.
            assert_allclose(values, wanted[name], rtol=1e-9, atol=1e-9, err_msg=name)
        else:
            atol = ROUNDING.get(name, 1e-13)
            assert_allclose(values, wanted[name], rtol=1e-9, atol=atol, err_msg=name)


# ---- reading and handling ----


@every_page
def test_a_drag_is_drawn_in_time(browser: Browser, root: str, page: str) -> None:
    # Layout is included; painting is not, which depends on the graphics card, and here there is none.
    with opened(browser, root, page) as (_, _, frame):
        times = frame.evaluate(
            """async count => {
              const sliders = [...document.querySelectorAll("input[type=range]")], times = [];
              for (let i = 0; i < count; i++) {
                const slider = sliders[i % sliders.length], span = slider.max - slider.min;
                await new Promise(requestAnimationFrame);
                await new Promise(requestAnimationFrame);
                const before = performance.now();
                slider.valueAsNumber = Number(slider.min) + span * (0.3 + 0.4 * Math.sin(i) ** 2);
                slider.dispatchEvent(new Event("input", { bubbles: true }));
                await instrument.settled();
                document.querySelector("main").getBoundingClientRect();
                times.push((performance.now() - before) / 1000);
              }
              return times;
            }""",
            DRAGS,
        )
    median = float(np.median(times))
    assert median <= SECONDS_TO_DRAW, f"{page}: drawn after {1000 * median:.0f} ms"


@every_page
def test_arrow_keys_move_a_slider(browser: Browser, root: str, page: str) -> None:
    with opened(browser, root, page) as (_, _, frame):
        slider = frame.locator("input[type=range]").first
        slider.focus()
        before = _drawn(frame)
        value = float(slider.input_value())
        slider.press("ArrowRight")
        after = _drawn(frame)
        moved = float(slider.input_value())
    assert moved == pytest.approx(value + before["step"], abs=1e-9)
    assert after["picture"] != before["picture"], f"{page}: the drawing stays"


@every_page
def test_presets_set_inputs_and_readouts(browser: Browser, root: str, page: str) -> None:
    with opened(browser, root, page) as (_, _, frame):
        seen = []
        for button in frame.locator("#presets button").all():
            button.click()
            seen.append(_drawn(frame))
            assert button.get_attribute("aria-pressed") == "true"
    assert len(seen) > 1
    assert len({state["readouts"] for state in seen}) == len(seen), f"{page}: presets that read the same"


@every_page
def test_the_keyboard_passes_in_few_stops(browser: Browser, root: str, page: str) -> None:
    with opened(browser, root, page) as (_, _, frame):
        stops = frame.evaluate(
            "[...document.querySelectorAll('button, input, select, [tabindex]')]"
            ".filter(element => element.tabIndex >= 0 && element.offsetParent).length"
        )
    assert 0 < stops <= TAB_STOPS


@every_page
def test_a_handle_is_dragged(browser: Browser, root: str, page: str) -> None:
    with opened(browser, root, page) as (visited, _, frame):
        handle = frame.locator(".handle").last
        handle.scroll_into_view_if_needed()
        box = handle.bounding_box()
        assert box, f"{page}: no handle"
        before = _drawn(frame)
        mouse = visited.page.mouse
        x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
        mouse.move(x, y)
        mouse.down()
        mouse.move(x + 15, y - 25, steps=4)
        mouse.up()
        after = _drawn(frame)
        end = handle.bounding_box()
    assert after["inputs"] != before["inputs"], f"{page}: a handle moves nothing"
    assert end
    assert (end["x"], end["y"]) != (box["x"], box["y"])


@every_page
def test_it_fits_a_phone_in_the_dark(browser: Browser, root: str, page: str) -> None:
    with opened(browser, root, page) as (visited, _, frame):
        visited.resize((360, 800))
        visited.page.emulate_media(color_scheme="dark")
        _drawn(frame)
        try:
            frame.wait_for_function(FITS)
        except PlaywrightTimeout:
            pytest.fail(f"{page}: the frame does not take the height of what is in it")
        wide = frame.evaluate("document.documentElement.scrollWidth - document.documentElement.clientWidth")
    assert wide <= 0, f"{page}: the instrument is {wide} px too wide"


@every_page
def test_a_finger_scrolls_the_page_unless_it_drags_a_handle(
    browser: Browser, served_root: str, page: str
) -> None:
    with opened(browser, served_root, page) as (visited, _, frame):
        visited.resize((360, 800))
        devtools = visited.page.context.new_cdp_session(visited.page)
        devtools.send("Emulation.setTouchEmulationEnabled", {"enabled": True})

        def swiped(locator: Locator, x: float, y: float) -> tuple[bool, bool]:
            """Move a finger upwards; return whether the page has scrolled, and whether an input changed."""
            locator.scroll_into_view_if_needed()
            visited.page.evaluate(SCROLL_HAS_ENDED)
            box = locator.bounding_box()
            assert box
            before, start = _drawn(frame)["inputs"], visited.page.evaluate("scrollY")
            at = {"x": box["x"] + x * box["width"], "y": box["y"] + y * box["height"]}
            for kind, way in [("touchStart", 0), *(("touchMove", 10 * i) for i in range(1, 11))]:
                points = [{"x": at["x"], "y": at["y"] - way}]
                devtools.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})
            devtools.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})
            after = _drawn(frame)["inputs"]
            return visited.page.evaluate("scrollY") != start, after != before

        assert swiped(frame.locator("svg").first, 0.04, 0.6) == (True, False)
        assert swiped(frame.locator("input[type=range]").nth(2), 0.2, 0.5) == (True, False)
        assert swiped(frame.locator(".handle").last, 0.5, 0.5) == (False, True)


def _drawn(frame: Frame) -> dict[str, Any]:
    """State of an instrument after the next drawing."""
    return frame.evaluate(
        """async () => {
          await instrument.settled();
          return {
            inputs: JSON.stringify(instrument.inputs),
            readouts: document.getElementById("readouts").innerText,
            picture: document.getElementById("drawings").innerHTML,
            step: Number(document.querySelector("input[type=range]").step),
          };
        }"""
    )
