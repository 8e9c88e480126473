"""The docking problem's parts by hand, and its two solutions."""

import dataclasses
import math
from functools import cache

import numpy as np
import pytest
import torch
from scipy.optimize import differential_evolution
from torch.testing import assert_close

import dexterity as dx
from dexterity.docking import DockingProblem, genetic_docking, global_docking, square
from dexterity.search import ZoomOptions
from dexterity.search.genetic import Chromosome

ARM = dx.robots.docking_arm()
QUICK = ZoomOptions(starts=4, shrink=0.8, stages=80)
GOOD = (-0.4, -0.21, 0.21, 0.84)
PROBLEMS = {region: DockingProblem(ARM, region=region) for region in ("and", "or")}
AND, OR = PROBLEMS.values()


@cache
def optimum(region: str) -> dx.docking.Docking:
    return global_docking(PROBLEMS[region], options=QUICK)


@cache
def by_genes(seed: int) -> dx.docking.Docking:
    return genetic_docking(AND, seed)


def vector(*numbers: float) -> torch.Tensor:
    return torch.tensor(numbers, dtype=torch.float64)


# ---- parts -----------------------------------------------------------------------------------------


def test_the_edge_of_the_group_belongs_to_it_whatever_rounding_says():
    x = Chromosome.of(AND.lower, AND.upper, [0.01] * 4).decoded(torch.ones(1, 29, dtype=torch.bool))[0]
    assert AND.allows(x)
    step = 2.0 / 255
    for edge in (-1 + 102 * step, -1 + 153 * step):
        assert abs(edge) == pytest.approx(0.2, abs=1e-15)
        assert AND.allows([edge, edge, 0.2, 0.0])
    assert not AND.allows([0.2 - 1e-9, 0.3, 0.2, 0.0])


def test_distance_is_what_the_foot_covers():
    # Facing the block at the start and after, with the foot 0.3 m behind the base in its heading.
    assert AND.distance(vector(-2, -2, 2, math.pi / 4)) == 0.0
    assert AND.distance(vector(-1, -2, 2, math.pi / 4)) == pytest.approx(1.0)
    # Turning about the base alone carries the foot along a chord.
    assert AND.distance(vector(-2, -2, 2, math.pi / 4 + 0.5)) == pytest.approx(2 * 0.3 * math.sin(0.25))


@pytest.mark.parametrize(
    ("pose", "both", "either"),
    [
        ((-0.3, -0.3, 0.22, 0.8), True, True),
        ((-0.3, 0.1, 0.22, 0.8), False, True),
        ((0.1, 0.1, 0.22, 0.8), False, False),
        ((-0.3, -0.3, 0.26, 0.8), False, False),
        ((-1.1, -0.3, 0.22, 0.8), False, False),
        ((-0.3, -0.3, 0.22, 3.2), False, False),
    ],
)
def test_where_the_base_may_be(pose, both, either):
    assert AND.allows(pose).item() is both
    assert OR.allows(pose).item() is either


@pytest.mark.parametrize("problem", [AND, OR], ids=["and", "or"])
def test_the_boxes_are_the_group(problem):
    unit = torch.rand(20_000, 4, generator=torch.Generator().manual_seed(0), dtype=torch.float64)
    poses = problem.lower + (problem.upper - problem.lower) * unit
    within = torch.stack([((poses >= low) & (poses <= high)).all(-1) for low, high in problem.boxes])
    assert torch.equal(within.any(0), problem.allows(poses))


# The side of the block: the vehicle is before it in −x, upright as ever.
SIDE = DockingProblem(ARM, region="or", face="side", foot=(0.2, 0.0, -0.3))


@pytest.mark.parametrize(
    ("pose", "allowed"),
    [
        ((-0.22, 0.0, -0.4, 0.0), True),
        ((-0.22, -0.4, 0.0, 0.0), True),
        ((-0.22, 0.0, 0.0, 0.0), False),
        ((0.22, 0.0, -0.4, 0.0), False),
        ((-0.26, 0.0, -0.4, 0.0), False),
        ((-0.22, 0.0, -1.1, 0.0), False),
    ],
)
def test_where_the_base_may_be_at_a_side(pose, allowed):
    assert SIDE.allows(pose).item() is allowed
    within = [(low <= vector(*pose)).all() and (vector(*pose) <= high).all() for low, high in SIDE.boxes]
    assert any(within) is allowed


def test_at_a_side_the_tool_points_at_it():
    pose = vector(-0.24, -0.5, -0.1, 0.13)
    corners = [[0.0, y, z] for y in (-0.2, 0.2) for z in (-0.2, 0.2)]
    assert_close(SIDE.control_points, torch.tensor(corners, dtype=torch.float64))
    assert_close(square(0.2, height=0.1, face="side")[:, 0], torch.full((4,), -0.1, dtype=torch.float64))
    q, valid, within = dx.docking.configurations(ARM, pose, corners, torch.eye(3))
    w = dx.indices.manipulability(ARM.geometric_jacobian(q))
    assert_close(SIDE.area_manipulability(pose), torch.where(valid & within, w, 0.0).amax(-1).amin())
    assert SIDE.area_manipulability(pose) > 0
    tool = dx.docking.on_base(ARM, pose).forward(q[0, valid[0]])
    assert_close(tool[:, :3, 0], vector(1, 0, 0).expand(len(tool), 3))


def test_fitness_is_the_objective_where_the_pose_is_allowed():
    poses = vector(*GOOD).repeat(2, 1)
    poses[1, 0] = 0.0
    gain, cost = 50 * AND.area_manipulability(poses), 0.1 * AND.distance(poses)
    assert_close(AND.objective(poses), gain - cost)
    assert_close(AND.fitness(poses), torch.stack([gain[0] - cost[0], torch.zeros_like(cost[1])]))
    assert AND.fitness(poses)[0] > 0


def test_weights():
    pose = vector(*GOOD)
    alone = dataclasses.replace(AND, manipulability_weight=1.0, distance_weight=0.0)
    assert_close(alone.fitness(pose), AND.area_manipulability(pose))


def test_a_tilted_vehicle_has_six_numbers():
    problem = dataclasses.replace(AND, tilt=0.3)
    assert problem.upper[-1] == math.pi
    assert dataclasses.replace(AND, yaw=(0.1, 0.2)).lower[-1] == 0.1
    assert problem.lower.tolist() == [-1, -1, 0.2, -0.3, -0.3, -math.pi]
    assert problem.allows([-0.3, -0.3, 0.2, 0.29, -0.29, 0.0])
    assert not problem.allows([-0.3, -0.3, 0.2, 0.31, 0.0, 0.0])
    flat, tilted = (
        AND.objective(vector(-0.3, -0.4, 0.2, 0.8)),
        problem.objective([-0.3, -0.4, 0.2, 0, 0, 0.8]),
    )
    assert_close(flat, tilted, rtol=0, atol=1e-12)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"height": (0.3, 0.2)}, "the lower limit is above the upper one"),
        ({"yaw": (1.0, 0.5)}, r"yaw is \(1\.0, 0\.5\); the lower limit"),
        ({"area": 2.5}, r"area is 2\.5; the block"),
        ({"area": 2.0}, "region is empty"),
        ({"area": 2.0, "region": "or"}, "region is empty"),
        ({"area": -0.4}, "area is -0.4"),
        ({"points": torch.zeros(0, 3, dtype=torch.float64)}, r"points has shape \(0, 3\)"),
        ({"points": square(1.2)}, "beyond the block"),
        ({"start": (math.nan, 0.0, 0.0)}, "start is nan"),
        ({"tilt": 2.0}, r"tilt is 2\.0"),
        ({"distance_weight": -1.0}, r"distance_weight is -1"),
        ({"manipulability_weight": math.inf}, "manipulability_weight is inf"),
    ],
)
def test_problems_that_make_no_sense(change, message):
    with pytest.raises(ValueError, match=message):
        DockingProblem(ARM, **change)


@pytest.mark.usefixtures("annotations_unchecked")
def test_an_unknown_region_or_face():
    with pytest.raises(ValueError, match="face is 'bottom'"):
        DockingProblem(ARM, face="bottom")
    with pytest.raises(ValueError, match="region is 'xor'"):
        DockingProblem(ARM, region="xor")


def test_a_pose_has_as_many_numbers_as_the_problem():
    with pytest.raises(ValueError, match=r"pose has shape \(6,\)"):
        AND.fitness(torch.zeros(6, dtype=torch.float64))


# ---- solutions -------------------------------------------------------------------------------------


@pytest.mark.parametrize("region", PROBLEMS)
def test_another_method_finds_the_same_global_optimum(region):
    problem, found = PROBLEMS[region], optimum(region)
    assert problem.allows(found.pose)
    assert found.fitness == pytest.approx(problem.objective(found.pose).item())
    bounds = list(zip(problem.lower.tolist(), problem.upper.tolist(), strict=True))
    other = differential_evolution(
        lambda pose: -problem.fitness(torch.tensor(pose.T)).numpy(), bounds,
        seed=0, popsize=60, maxiter=300, tol=1e-10, vectorized=True, updating="deferred", polish=False,
    )  # fmt: skip
    assert found.fitness == pytest.approx(-other.fun, abs=1e-4)


def test_the_genetic_algorithm_comes_near_it():
    best = optimum("and").fitness
    found = [by_genes(seed) for seed in range(3)]
    assert all(AND.allows(one.pose) for one in found)
    assert all(one.fitness <= best + 1e-9 for one in found)
    assert sorted(one.fitness for one in found)[1] > 0.85 * best
    assert found[0].area_manipulability == pytest.approx(AND.area_manipulability(found[0].pose).item())
    assert found[0].fitness == found[0].search.value


def test_the_same_seed_gives_the_same_pose():
    one, other, third = genetic_docking(AND, 1), by_genes(1), by_genes(2)
    assert torch.equal(one.pose, other.pose)
    assert not torch.equal(one.pose, third.pose)


# ---- what is refused when it is given, and what cannot be changed afterwards ---------------------------


@pytest.mark.parametrize("name", ["panda", "ur5e", "uvms"])
def test_arms_that_no_search_could_serve_are_refused_when_they_are_given(name):
    """DockingProblem(panda) was accepted, and the error came at the search."""
    with pytest.raises(ValueError, match=r"dexterity\.reach\.place"):
        DockingProblem(getattr(dx.robots, name)())


@pytest.mark.parametrize(
    ("change", "error", "message"),
    [
        ({"foot": (1, 2)}, ValueError, "foot is"),
        ({"block": (2.0,)}, ValueError, "block is"),
        ({"block": 2.0}, ValueError, "block is"),
        ({"height": (0.2, "0.3")}, TypeError, "height is '0.3'"),
        ({"yaw": "12"}, ValueError, "yaw is '12'"),
        ({"start": (1, 2)}, ValueError, "start is"),
        ({"start": (1, 2, 10**400)}, ValueError, "start is"),
        ({"heading": math.inf}, ValueError, "heading is inf"),
        ({"area": True}, TypeError, "area is True"),
        ({"tilt": "0.1"}, TypeError, "tilt is '0.1'"),
        ({"tool": torch.ones(3, 3)}, ValueError, "tool"),
        ({"tool": torch.eye(4)}, ValueError, "tool has shape"),
        ({"points": [[0.0, 0.0]]}, ValueError, "points has shape"),
        ({"arm": "puma"}, TypeError, "arm is 'puma'"),
        ({"manipulability_weight": math.nan}, ValueError, "manipulability_weight is nan"),
    ],
)
@pytest.mark.usefixtures("annotations_unchecked")
def test_each_field_is_looked_at_when_it_is_given(change, error, message):
    with pytest.raises(error, match=message):
        DockingProblem(**{"arm": ARM} | change)


@pytest.mark.usefixtures("annotations_unchecked")
def test_rows_of_numbers_may_be_arrays():
    problem = DockingProblem(ARM, height=np.array([0.2, 0.25]), foot=torch.tensor([-0.3, 0.0, -0.2]))
    assert problem.height == (0.2, 0.25)
    assert problem.foot == pytest.approx((-0.3, 0.0, -0.2))
    assert problem.allows(GOOD)


def test_a_problem_does_not_change_when_arrays_do():
    corners = AND.control_points.numpy().copy()
    problem = DockingProblem(ARM, points=corners)
    before = problem.area_manipulability(GOOD)
    corners[:] = 0.9
    for changed in (problem.lower, problem.upper, problem.control_points):
        changed.fill_(10.0)
    assert problem.area_manipulability(GOOD) == before > 0
    assert problem.allows(GOOD)


def test_a_docking_says_what_its_numbers_are():
    text = repr(optimum("and"))
    assert text.startswith("Docking(x -0.")
    assert "yaw" in text
    assert "area manipulability 0.0" in text


def test_how_many_poses_a_search_looks_at_is_known_before(capfd):
    coarse = ZoomOptions(starts=2, levels=3, stages=2)
    steps = (0.2, 0.2, 0.05, 1.0)
    found = global_docking(OR, steps, coarse, progress=True)
    count = dx.docking.evaluations(OR, steps, coarse)
    searches = [dx.search.zoom_search(OR.objective, *box, steps, coarse).evaluations for box in OR.boxes]
    assert count == sum(searches)
    assert found.search.evaluations in searches
    assert "docking poses: 100%" in capfd.readouterr().err
