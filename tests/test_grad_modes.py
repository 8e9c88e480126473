"""Functions that differentiate inside work without gradients, and poison nothing for later."""

import gc

import pytest
import torch

import dexterity as dx
from dexterity.networks.worst_case import Search, worst_case

PANDA = [0.5, -0.7, 0.6, -2.3, 0.3, 1.7, 0.5]


@pytest.mark.parametrize("mode", [torch.no_grad, torch.inference_mode])
def test_functions_that_differentiate_inside_answer_in_every_mode(mode):
    index = dx.indices.Index("w", "geometric")
    with mode():
        # Built here: what load returns may have been built before.
        puma, panda = (dx.robots.build(dx.robots.describe(name)) for name in ("puma560", "panda"))
        assert dx.sampling.relevant_joints(puma, index) == (1, 2, 3, 4)
        along = dx.indices.Index("velocity_ratio", "geometric", rows="translational", direction="vz")
        value, gradient = dx.symbolic.compile_index(puma, along).value_and_gradient([0.1] * 6)
        assert value > 0
        assert gradient.abs().max() > 0
        moved = dx.inverse_kinematics.null_space_step(panda, PANDA, index)
        assert index(panda, moved) > index(panda, PANDA)
        space = dx.sampling.Box([-0.5] * 6, [0.5] * 6)
        extremes = dx.search.extremes(index.bind(puma), space)
        assert extremes.highest.value > extremes.lowest.value
        target = panda.forward(PANDA)
        assert dx.inverse_kinematics.solve(panda, target, seeds=8, secondary=index).reached
        network, w = dx.networks.load_shipped("uvms-manipulability-feed-forward"), dx.indices.Index("w")
        found = worst_case(
            network,
            w.bind(dx.robots.uvms()),
            dx.sampling.uvms_space("manipulability"),
            Search(256, 16, 8, steps=5),
        )
        assert 0 < found.error < 1
        speed = index.bind(puma)
    q = torch.full((6,), 0.2, dtype=torch.float64, requires_grad=True)
    for f in (speed, lambda q: puma.forward(q).sum(), lambda q: network(torch.cat([q, q]))):
        (slope,) = torch.autograd.grad(f(q), q)
        assert slope.isfinite().all()


def tensors_of_inference_mode() -> list[torch.Tensor]:
    gc.collect()
    # By the type alone: whatever else lives in a process may not like to be asked.
    tensors = [each for each in gc.get_objects() if issubclass(type(each), torch.Tensor)]
    return [each for each in tensors if each.is_inference()]


def test_nothing_that_is_kept_is_of_the_mode_in_which_it_was_made():
    """Tensors of inference mode would break differentiation until the process ends."""
    earlier = {id(each) for each in tensors_of_inference_mode()}
    with torch.inference_mode():
        problem = dx.docking.DockingProblem(dx.robots.load("docking_arm"))
        pose = (problem.lower + problem.upper) / 2
        problem.allows(pose)
        problem.fitness(pose)
        dx.reach.rotations(24)
        arm = dx.robots.load("ur5e")
        dx.inverse_kinematics.solve(arm, arm.forward([0.1] * 6))
        dx.crane.structure.Assembly.of(dx.crane.patu655())
        panda = dx.robots.load("panda")
        dx.inverse_kinematics.solve(panda, panda.forward(PANDA), seeds=4)
    del pose
    kept = [each for each in tensors_of_inference_mode() if id(each) not in earlier]
    assert not [tuple(each.shape) for each in kept]
    lower = problem.lower.requires_grad_()
    (slope,) = torch.autograd.grad(problem.distance(lower) ** 2, lower)
    assert slope.isfinite().all()
