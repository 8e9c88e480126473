"""The exported JavaScript of docking problems, run by node, against the package."""

import math

import pytest
import torch
from numpy.testing import assert_allclose, assert_array_equal

from dexterity import docking, robots, spatial
from dexterity.docking import DockingProblem
from dexterity.docking.export import javascript_module
from run_in_node import called, needs_node

PROBLEMS = {
    "stated": DockingProblem(robots.docking_arm()),
    "fitted": DockingProblem(robots.docking_arm("fitted"), region="or", points=docking.square(0.2, 3)),
}
of_problems = pytest.mark.parametrize("name", PROBLEMS)


@pytest.fixture
def poses(rng) -> torch.Tensor:
    """Poses on the block and a little beyond it, at heights that are allowed and that are not."""
    wide = rng.uniform([-0.7, -0.7, 0.15, -math.pi], [0.7, 0.7, 0.3, math.pi], (200, 4))
    return torch.from_numpy(wide)


@needs_node
@of_problems
def test_values_are_those_of_the_problem(tmp_path, poses, name):
    problem, module = PROBLEMS[name], javascript_module(PROBLEMS[name])
    for function, expected in {
        "areaManipulability": problem.area_manipulability(poses),
        "distance": problem.distance(poses),
        "fitness": problem.fitness(poses),
    }.items():
        results = called(tmp_path, module, function, [[pose] for pose in poses.tolist()])
        assert_allclose(results, expected, rtol=1e-11, atol=1e-14)
    allowed = called(tmp_path, module, "allows", [[pose] for pose in poses.tolist()])
    assert_array_equal(allowed, problem.allows(poses))


@needs_node
@of_problems
def test_w_at_a_point_is_the_largest_of_the_branches(tmp_path, rng, poses, name):
    problem = PROBLEMS[name]
    points = torch.from_numpy(rng.uniform(-0.4, 0.4, (200, 3))) * torch.tensor([1.0, 1.0, 0.2])
    inputs = [[[pose, point]] for pose, point in zip(poses.tolist(), points.tolist(), strict=True)]
    results = called(tmp_path, javascript_module(problem), "manipulability", inputs)
    expected = torch.cat([
        docking.largest_manipulability(problem.arm, pose, point[None])
        for pose, point in zip(poses, points, strict=True)
    ])  # fmt: skip
    assert 0.1 < (expected == 0).double().mean() < 0.9
    assert_allclose(results, expected, rtol=1e-11, atol=1e-14)


@needs_node
def test_a_point_of_the_base_is_placed(tmp_path, rng, poses):
    points = torch.from_numpy(rng.standard_normal((200, 3)))
    inputs = [[[pose, point]] for pose, point in zip(poses.tolist(), points.tolist(), strict=True)]
    results = called(tmp_path, javascript_module(PROBLEMS["stated"]), "placed", inputs)
    assert_allclose(results, spatial.apply(docking.base_pose(poses), points), rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("settings", [{"face": "side"}, {"tilt": 0.1}])
def test_only_the_top_without_tilt_has_a_module(settings):
    with pytest.raises(ValueError, match="the top without tilt is needed"):
        javascript_module(DockingProblem(robots.docking_arm(), **settings))
