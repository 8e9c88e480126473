"""More control points, a hovering vehicle and a vertical surface: the stored optima, against the library."""

import math

import pytest
import torch

from dexterity import docking
from dexterity_study.docking import cases
from dexterity_study.docking.beyond import experiment, show
from dexterity_study.engine.evidence import Evidence

STORED = Evidence("docking.beyond")
FLAT = ["x", "y", "z", "psi"]
READINGS = list(cases.CASES.values())


def values(reading: str):
    return experiment.optimum.reading(reading)


@pytest.mark.parametrize("reading", READINGS)
def test_what_is_stored_of_points_is_what_they_are_worth(reading):
    arm = cases.arm_of(values(reading))
    for best in STORED["points"].where(reading).to_dict("records"):
        pose = torch.tensor([best[name] for name in FLAT], dtype=torch.float64)
        for count, stored in ((best["points"], best["at_points"]), (441, best["fine"])):
            points = docking.square(0.2, math.isqrt(count))
            assert docking.area_manipulability(arm, pose, points).item() == pytest.approx(stored, rel=1e-6)
        assert best["finest"] <= best["fine"] <= best["at_points"]


@pytest.mark.parametrize("reading", READINGS)
def test_more_points_matter_where_the_base_may_stand_before_a_side(reading):
    fine = STORED["points"].where(reading).set_index("points")["fine"]
    if reading.endswith("or"):
        assert fine[441] > 1.02 * fine[4]
        assert fine[9] > 0.99 * fine[441]
    else:
        assert fine[4] == pytest.approx(fine[441], rel=1e-3)


def test_a_tilted_body_must_stay_off_the_block():
    level, rolled, raised = torch.tensor(
        [[-0.4, 0, 0.2, 0, 0, 0.5], [-0.4, 0, 0.2, 0.2, 0, 0.5], [-0.4, 0, 0.4, 0.2, 0, 0.5]],
        dtype=torch.float64,
    )
    assert experiment.lowest_point(level).item() == pytest.approx(0.0, abs=1e-15)
    deepest = 0.2 - 0.2 * math.cos(0.2) - 0.6 * math.sin(0.2)
    assert experiment.lowest_point(rolled).item() == pytest.approx(deepest)
    problem = experiment.extended(values("reading-of-the-group=or"), "top", 0.3)
    assert experiment.worth(problem, rolled) == experiment.lowest_point(rolled)
    assert experiment.lowest_point(raised) > 0
    assert experiment.worth(problem, raised) == problem.objective(raised)


@pytest.mark.parametrize("reading", READINGS)
def test_more_tilt_is_never_worse(reading):
    flat = STORED["points"].where(reading, points=4)["at_points"].item()
    best = [flat, *STORED["optimum"].where(reading, face="top")["area_manipulability"]]
    assert best == sorted(best)


@pytest.mark.parametrize("reading", READINGS)
def test_two_methods_found_the_stored_pose_at_the_side(reading):
    (best,) = STORED["optimum"].where(reading, face="side").to_dict("records")
    problem = experiment.extended(values(reading), "side", 0.0)
    pose = torch.tensor([best[name] for name in FLAT], dtype=torch.float64)
    assert problem.allows(pose)
    assert problem.objective(pose).item() == pytest.approx(best["value"], rel=1e-6)
    assert best["evolved"] == pytest.approx(best["value"], rel=1e-4)


def test_the_arm_reaches_every_corner_in_both_scenes():
    for scene in (show.tilted_scene(STORED), show.wall_scene(STORED)):
        shown = scene._repr_html_()
        assert all(f"arm at {corner}<" in shown for corner in "KLMN")
