"""More control points, a hovering vehicle and a vertical surface: the stored optima, against the package."""

import math

import pytest
import torch

from dexterity import docking, robots
from dexterity.report.provenance import load_stored
from dexterity.studies.docking import beyond as study

CASES = [f"{arm}, {region}" for arm in ("stated", "fitted") for region in ("and", "or")]


def result():
    return load_stored("docking.beyond").run.result


def arm_of(case: str):
    return robots.docking_arm("fitted" if case.startswith("fitted") else "stated")


@pytest.mark.parametrize("case", CASES)
def test_what_is_stored_of_points_is_what_they_are_worth(case):
    for count, best in result().points[case].items():
        points = docking.square(0.2, round(int(count) ** 0.5))
        pose = torch.tensor(best.pose, dtype=torch.float64)
        worth = docking.area_manipulability(arm_of(case), pose, points).item()
        assert worth == pytest.approx(best.at_points, rel=1e-9)
        fine = docking.area_manipulability(arm_of(case), pose, docking.square(0.2, 21)).item()
        assert fine == pytest.approx(best.fine, rel=1e-9)


@pytest.mark.parametrize("case", ["stated, or", "fitted, or"])
def test_more_points_find_a_pose_with_a_stronger_weakest_spot(case):
    by_count = result().points[case]
    assert by_count["441"].fine > 1.02 * by_count["4"].fine
    assert by_count["9"].fine > 0.99 * by_count["441"].fine


@pytest.mark.parametrize("case", ["stated, and", "fitted, and"])
def test_four_points_are_enough_where_the_corners_are_weakest(case):
    by_count = result().points[case]
    assert by_count["4"].fine == pytest.approx(by_count["441"].fine, rel=1e-3)


def test_a_tilted_body_must_stay_off_the_block():
    level, rolled, raised = torch.tensor(
        [[-0.4, 0, 0.2, 0, 0, 0.5], [-0.4, 0, 0.2, 0.2, 0, 0.5], [-0.4, 0, 0.4, 0.2, 0, 0.5]],
        dtype=torch.float64,
    )
    assert study.lowest_point(level).item() == pytest.approx(0.0, abs=1e-15)
    assert study.lowest_point(rolled).item() == pytest.approx(0.2 - 0.2 * math.cos(0.2) - 0.6 * math.sin(0.2))
    problem = docking.DockingProblem(arm_of("stated"), region="or", tilt=0.3, height=(0.2, 0.5))
    assert study.hovering_worth(problem, rolled) == study.lowest_point(rolled)
    assert study.lowest_point(raised) > 0
    assert study.hovering_worth(problem, raised) == problem.objective(raised)


@pytest.mark.parametrize("case", CASES)
def test_more_tilt_is_never_worse(case):
    flat = result().points[case]["4"].at_points
    values = [flat, *(best.area_manipulability for best in result().hover[case].values())]
    assert values == sorted(values)


@pytest.mark.parametrize("case", CASES)
def test_two_methods_found_the_stored_pose_at_the_side(case):
    best = result().side[case]
    problem = study.at_side(arm_of(case), "or" if case.endswith("or") else "and")
    pose = torch.tensor(best.pose, dtype=torch.float64)
    assert problem.allows(pose)
    assert problem.objective(pose).item() == pytest.approx(best.value, rel=1e-9)
    assert best.evolved == pytest.approx(best.value, rel=1e-4)
