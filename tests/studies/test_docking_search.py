"""What the chapter on the genetic search shows: its geometry, its weights, and the stored optima."""

import math

import numpy as np
import pytest
import torch
from torch.testing import assert_close

from dexterity import docking, robots
from dexterity.report.provenance import load_stored
from dexterity.studies.docking import search as study


def vector(*numbers: float) -> torch.Tensor:
    return torch.tensor(numbers, dtype=torch.float64)


def test_the_chain_with_the_vehicle_is_the_arm_on_its_base():
    arm = robots.docking_arm("fitted")
    pose, q = vector(-0.3, 0.4, 0.22, 0.8), torch.linspace(-0.5, 0.6, 6, dtype=torch.float64)
    assert_close(
        study.with_vehicle(arm).forward(torch.cat([pose, q])),
        docking.on_base(arm, pose).forward(q),
        rtol=0,
        atol=1e-14,
    )


@pytest.mark.parametrize(
    ("pose", "faces"),
    [
        ((-0.5, 0.0, 0.2, 0.0), True),
        ((-0.5, 0.0, 0.2, 0.5), True),
        ((-0.5, 0.0, 0.2, 0.7), False),
        ((-0.5, 0.0, 0.2, math.pi), False),
        ((0.5, 0.0, 0.2, math.pi), True),
        ((0.5, 0.0, 0.2, -math.pi), True),
        ((-0.5, -0.5, 0.2, math.pi / 4), True),
        ((-0.5, -0.5, 0.2, -math.pi / 4), False),
        ((-0.5, -0.5, 0.2, -3 * math.pi / 4), False),
    ],
)
def test_facing_means_that_the_ray_ahead_meets_the_area(pose, faces):
    assert study.faces_area(vector(*pose)).item() is faces


def test_weights_are_found_again_where_there_are_some():
    random = np.random.default_rng(0)
    dexterity, distance = random.uniform(0.1, 0.2, 7), random.uniform(2.0, 4.0, 7)
    misfit, (a, b) = study.best_weights(20 * dexterity - 0.3 * distance, dexterity, distance)
    assert misfit == pytest.approx(0.0, abs=1e-9)
    assert np.abs((a - 20) * dexterity - (b - 0.3) * distance).max() < 0.05
    # Rounding explains half a per cent, not a run that is off by one.
    off = 20 * dexterity - 0.3 * distance + np.eye(7)[3]
    assert study.best_weights(off, dexterity, distance)[0] > 0.1


def test_no_weights_explain_the_printed_fitness():
    printed = load_stored("docking.search").run.result.printed
    assert printed.misfit > 10 * 0.005
    assert printed.same_order


@pytest.mark.parametrize("case", study.problems())
@pytest.mark.parametrize("weights", ["optimum", "alone"])
def test_two_methods_found_the_stored_optimum(case, weights):
    problem = study.problems()[case]
    best = getattr(load_stored("docking.search").run.result.cases[case], weights)
    assert best.disagreement < 1e-4
    pose = vector(*best.pose)
    assert problem.allows(pose)
    assert problem.area_manipulability(pose).item() == pytest.approx(best.area_manipulability, rel=1e-9)
    # A quarter turn about the middle of the area changes nothing for the arm.
    assert np.ptp([dexterity for dexterity, _ in best.images]) < 1e-12


@pytest.mark.parametrize("case", study.problems())
def test_no_run_beats_the_optimum_and_some_find_the_best_of_the_lattice(case):
    found = load_stored("docking.search").run.result.cases[case]
    assert found.share(found.runs).max() <= 1 + 1e-9
    assert found.optimum.on_lattice <= found.optimum.fitness + 1e-9
    assert found.lattice_share(found.runs).max() > 0.99


def test_scenes_show_the_vehicle_where_it_docks():
    arm = robots.docking_arm("fitted")
    pose = vector(-0.542, 0.0, 0.203, 0.924)
    page = study.docked_scene("At the optimum", arm, pose)._repr_html_()
    for name in ("block", "vehicle", "hook", "task area", *"KLMN"):
        assert name in page
    found = docking.genetic_docking(study.problems()["fitted, or"], 0)
    assert "way of the best pose" in study.search_scene("The search", found.search)._repr_html_()
