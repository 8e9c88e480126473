"""The page that runs the pipeline at a glance: its cells within a minute, its pictures, and each decision."""

import shutil
import time
from pathlib import Path
from typing import Any

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pytest
import torch

from dexterity import robots, sampling
from dexterity.codegen import library
from dexterity.indices import Index
from dexterity_study.page.notebooks import Layout, read_pages
from dexterity_study.uvms.glance import show

ROOT = Path(__file__).parents[3]
PAGE = "uvms/glance"
MOST_SECONDS = 60.0

GOOD = show.Figures(
    neurons=8, testing=0.01, sampled=0.012, worst=0.015, exact=5e-5, network=1e-8, distinguishable=True
)


@pytest.fixture(scope="module")
def run() -> dict[str, Any]:
    """Names that the cells of the page leave, and the seconds that the processor spent on them."""
    if not any(map(shutil.which, ("cc", "gcc", "clang"))):
        pytest.skip("there is no C compiler")
    (page,) = read_pages(Layout(ROOT / "book", ROOT / "_config.yml", ROOT / "_build"), [PAGE])
    names: dict[str, Any] = {}
    # As for a reader: other tests compile without optimisation.
    flags = tuple("-O3" if flag == "-O0" else flag for flag in library.FLAGS)
    start = time.process_time()
    with mpl.rc_context({"backend": "agg"}), pytest.MonkeyPatch.context() as patch:
        patch.setattr(library, "FLAGS", flags)
        for cell in page.notebook.cells:
            if cell.cell_type == "code":
                exec(compile(cell.source, PAGE, "exec"), names)
        # A figure is computed when it is drawn.
        for number in plt.get_fignums():
            plt.figure(number).canvas.draw()
        plt.close("all")
    return names | {"seconds": time.process_time() - start}


def test_the_whole_page_takes_less_than_a_minute_of_one_core(run: dict[str, Any]) -> None:
    assert run["seconds"] < MOST_SECONDS


def test_the_loop_ends_at_its_first_network_that_passes(run: dict[str, Any]) -> None:
    *before, last = run["design"].trials
    assert last.testing_error <= 0.02 < min(trial.testing_error for trial in before)
    assert run["design"].network.neurons == last.neurons == run["run"].neurons


def test_compiled_functions_are_the_ones_they_stand_for(run: dict[str, Any]) -> None:
    data = run["data"].validation
    in_numpy, exact, network = (
        np.asarray(way.compute()) for way in show.ways(run["w"], run["network_in_c"], data.q)
    )
    torch_w = Index("manipulability").bind(robots.uvms())(data.q).numpy()
    np.testing.assert_allclose(in_numpy, torch_w, rtol=1e-9)
    np.testing.assert_allclose(exact, torch_w, rtol=1e-9)
    with torch.no_grad():
        np.testing.assert_allclose(network, run["design"].network(data.q).numpy(), rtol=1e-9)


def test_the_exact_index_in_numpy_is_slower_than_in_c(run: dict[str, Any]) -> None:
    # The page says that most of the time is saved there.
    in_numpy, exact, network = (one.median for one in run["timings"])
    assert in_numpy / exact > exact / network


def test_an_arm_is_drawn_with_its_lengths() -> None:
    chain, length = robots.uvms(), robots.describe("uvms").lengths
    q = sampling.uniform(sampling.uvms_space("kinematic_conditioning"), 20, torch.Generator().manual_seed(1))
    base, elbow, tool = show.arm_points(chain, q).unbind(1)
    ends = torch.linalg.norm(elbow - base, dim=-1), torch.linalg.norm(tool - elbow, dim=-1)
    for distance, name in zip(ends, ("l2", "l3"), strict=True):
        torch.testing.assert_close(distance, torch.full_like(distance, length[name]))


def test_the_surface_is_w_over_the_joints_that_it_names() -> None:
    w = Index("manipulability").bind(robots.uvms())
    q = torch.zeros(12, dtype=torch.float64)
    q[8], q[10] = np.radians(40.0), np.radians(-25.0)
    drawn = show.over_two_joints(w, np.array([40.0]), np.array([-25.0]))
    np.testing.assert_allclose(drawn, [w(q)])


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({}, "Use the network"),
        ({"network": 6e-5}, "it saves no time"),
        ({"network": 6e-5}, "the network is not faster"),
        ({"distinguishable": False}, "overlap, so that neither is faster"),
        ({"distinguishable": False}, "the network is not faster"),
        ({"worst": 0.021}, "breaks the limit elsewhere"),
        ({"exact": 4e-8}, "saves no time that a planner notices"),
    ],
)
def test_the_decision_follows_the_numbers(changed: dict[str, float], words: str) -> None:
    assert words in show.decision(GOOD._replace(**changed))
