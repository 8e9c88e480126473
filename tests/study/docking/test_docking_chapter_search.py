"""What the chapter on the genetic search shows: its geometry, its weights, and the stored optima."""

import math

import numpy as np
import pytest
import torch
from torch.testing import assert_close

from coal_distances import coal_distances
from dexterity import docking, indices
from dexterity_study.docking import cases
from dexterity_study.docking.search import experiment, show, verdicts
from dexterity_study.engine.evidence import Evidence

STORED = Evidence("docking.search")
READINGS = list(cases.CASES.values())


def vector(*numbers: float) -> torch.Tensor:
    return torch.tensor(numbers, dtype=torch.float64)


def problem(reading: str) -> docking.DockingProblem:
    return experiment.problem_of(experiment.optimum.reading(reading))


def test_the_cases_are_the_arms_and_regions_that_they_name():
    for case, reading in cases.CASES.items():
        own = problem(reading)
        assert own.region == case.split(", ")[1]
        assert (
            own.arm.name == {"stated": "docking_arm", "fitted": "docking_arm (fitted)"}[case.split(", ")[0]]
        )
        assert problem(experiment.ALONE[reading]).distance_weight == 0
        assert own == docking.DockingProblem(own.arm, region=own.region)


def test_the_vehicle_s_joints_put_the_base_where_a_pose_has_it():
    pose = vector(-0.3, 0.4, 0.22, 0.8)
    assert_close(experiment.VEHICLE.forward(pose), docking.base_pose(pose), rtol=0, atol=1e-14)


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
    assert experiment.faces_area(vector(*pose)).item() is faces


def test_weights_are_found_again_where_there_are_some():
    random = np.random.default_rng(0)
    dexterity, distance = random.uniform(0.1, 0.2, 7), random.uniform(2.0, 4.0, 7)
    misfit, a, b = experiment.best_weights(20 * dexterity - 0.3 * distance, dexterity, distance)
    assert misfit == pytest.approx(0.0, abs=1e-9)
    assert np.abs((a - 20) * dexterity - (b - 0.3) * distance).max() < 0.05
    # Rounding explains half a per cent, not a run that is off by one.
    off = 20 * dexterity - 0.3 * distance + np.eye(7)[3]
    assert experiment.best_weights(off, dexterity, distance)[0] > 0.1


def test_no_weights_explain_the_printed_fitness():
    assert STORED["printed_fitness"].where()["misfit"].item() > 10 * 0.005


@pytest.mark.parametrize("reading", [*READINGS, *experiment.ALONE.values()])
def test_two_methods_found_the_stored_optimum(reading):
    best, own = verdicts.optima(STORED).loc[reading], problem(reading)
    pose = vector(*best[[*experiment.VARIABLES]])
    assert best["evolved"] == pytest.approx(best["fitness"], rel=1e-4)
    assert own.allows(pose)
    # Twelve digits are stored, and the best pose is at an edge of what the arm reaches.
    assert own.area_manipulability(pose).item() == pytest.approx(best["area_manipulability"], rel=1e-6)
    assert best["tied"] == 4


@pytest.mark.parametrize("bodies", ["block", "block and vehicle"])
@pytest.mark.parametrize("reading", READINGS)
def test_two_methods_found_the_stored_optimum_around_bodies(reading, bodies):
    best, own = verdicts.physical(STORED, bodies).loc[reading], problem(reading)
    assert best["evolved"] == pytest.approx(best["area_manipulability"], rel=1e-3)
    assert own.allows(vector(*best[[*experiment.VARIABLES]]))
    assert best["area_manipulability"] < verdicts.optima(STORED).loc[reading, "area_manipulability"]


def test_around_the_block_both_readings_of_the_group_have_one_optimum():
    worth = show.worth_by_bodies(STORED)["around block"]
    for arm in cases.ARMS:
        both, either = (worth[cases.CASES[f"{arm}, {region}"]] for region in ("and", "or"))
        assert both == pytest.approx(either, rel=1e-4)


@pytest.mark.parametrize("reading", READINGS)
def test_at_the_stored_optimum_no_arm_touches_block_or_vehicle_as_coal_has_it(reading):
    best, own = verdicts.physical(STORED, "block and vehicle").loc[reading], problem(reading)
    bodies, pose = experiment.bodies_about(own)["block and vehicle"], vector(*best[[*experiment.VARIABLES]])
    q, valid, within = docking.configurations(own.arm, pose, own.control_points)
    base = docking.base_pose(pose)
    w = indices.manipulability(own.arm.spatial_jacobian(q))
    # The numbers stored are rounded: a touch may have become a micrometre.
    free = valid & within & (bodies.clearance(q, base) > -1e-6)
    w, chosen = torch.where(free, w, 0.0).max(-1)
    arms = q[torch.arange(len(q)), chosen]
    assert coal_distances(bodies, arms, base.expand(len(arms), 4, 4)).min() > -1e-6
    assert float(w.min()) == pytest.approx(best["area_manipulability"], rel=1e-4)


def test_no_run_beats_the_optimum_and_some_find_the_best_of_the_lattice():
    best = verdicts.optima(STORED)
    assert (best["on_lattice"] <= best["fitness"] + 1e-9).all()
    highest = verdicts.found(STORED).groupby("reading")[["share", "of_lattice"]].max()
    assert (highest["share"] <= 1 + 1e-9).all()
    assert (highest["of_lattice"] > 0.99).all()


def test_the_pose_of_a_run_is_worth_its_fitness():
    for reading, rows in STORED["genetic"].where(None).groupby("reading"):
        poses = torch.tensor(rows[[*experiment.VARIABLES]].to_numpy())
        assert_close(
            problem(reading).fitness(poses), torch.tensor(rows["fitness"].to_numpy()), rtol=1e-6, atol=0
        )
        assert experiment.faces_area(poses).tolist() == rows["faces"].tolist()


def test_a_cheap_distance_leaves_the_arm_its_dexterity_and_a_dear_one_takes_it():
    for reading in READINGS:
        best = STORED["front"].where(reading).set_index("ratio")["area_manipulability"]
        assert best[0.032] > 0.99 * best[0.0]
        assert best[0.128] == 0


def test_scenes_show_the_vehicle_where_it_docks():
    page = show.docked_scene("At the optimum", vector(-0.542, 0.0, 0.203, 0.924))._repr_html_()
    for name in ("block", "vehicle", "hook", "task area", *(f"arm at {corner}" for corner in "KLMN")):
        assert name in page
    found = docking.genetic_docking(problem(cases.CASES["fitted, or"]), 0)
    assert "path of the best pose" in show.search_scene(found.search)._repr_html_()
