"""Devices other than the CPU, for which ``meta`` stands: answers lie where inputs are, or errors say why."""

import numpy as np
import pytest
import torch

import dexterity as dx
from dexterity import inverse_kinematics, sampling, spatial, workspace
from dexterity.spatial.values import beside, on_cpu, on_one_device, require_values

LINE = (0.0, 0.0, 0.0, 0.0, 0.0, 1.0)
LINKS = (0.15, 0.43, 0.43, 0.02)


def elsewhere(*shape):
    return torch.empty(*shape, dtype=torch.float64, device="meta")


@pytest.mark.parametrize(
    "call",
    [
        lambda: spatial.pose(elsewhere(5, 3, 3), [0, 0, 0]),
        lambda: spatial.pose(np.eye(3), elsewhere(5, 3)),
        lambda: spatial.from_rpy(elsewhere(5, 3)),
        lambda: spatial.from_quaternion(elsewhere(5, 4), order="wxyz"),
        lambda: spatial.translation(elsewhere(5), 0.0, [0.1]),
        lambda: spatial.apply(elsewhere(5, 4, 4), [1, 2, 3]),
        lambda: spatial.compose(np.eye(4), elsewhere(5, 4, 4)),
        lambda: inverse_kinematics.subproblem_1(LINE, elsewhere(5, 3), [1, 2, 3]),
        lambda: inverse_kinematics.subproblem_3(LINE, [1, 2, 3], elsewhere(5, 3), 1.0),
        lambda: inverse_kinematics.subproblem_4(LINE, elsewhere(5, 3), [0, 0, 1], 1.0),
        lambda: inverse_kinematics.nearest_copy(dx.robots.puma560(), elsewhere(5, 6), [0.0] * 6)[0],
        lambda: workspace.reachable(LINKS, elsewhere(5, 3)),
        lambda: workspace.reachability.geometric_jacobian(LINKS, elsewhere(5, 6)),
        lambda: workspace.reachability.inverse(LINKS, elsewhere(5, 4, 4))[0],
        lambda: sampling.Box([0.0] * 6, [1.0] * 6).from_unit(elsewhere(5, 6)),
    ],
)
def test_numbers_follow_the_tensor_beside_them(call):
    assert call().device.type == "meta"


@pytest.mark.usefixtures("annotations_unchecked")
@pytest.mark.parametrize(
    ("call", "error", "said"),
    [
        (lambda: sampling.Box(elsewhere(2), [1.0, 1.0]), ValueError, "lower is on the device meta"),
        (lambda: dx.Index("w", joint_rates=elsewhere(6)), ValueError, "joint_rates is on the device meta"),
        (lambda: dx.reach.box(elsewhere(3), [1, 1, 1], 0.5), ValueError, "lower is on the device meta"),
        (lambda: dx.search.zoom_search(torch.sum, elsewhere(2), [1, 1], [1, 1]), ValueError, "lower is on"),
        (
            lambda: inverse_kinematics.nearest_copy(dx.robots.puma560(), [0.0] * 6, elsewhere(6)),
            ValueError,
            "near is on the device meta",
        ),
        (
            lambda: inverse_kinematics.null_space_step(dx.robots.panda(), elsewhere(7), np.ones(7)),
            TypeError,
            "q has no values here",
        ),
        (lambda: dx.crane.deflection(elsewhere(3), 100.0), TypeError, "strokes has no values here"),
        (lambda: dx.sampling.Box([0.0], [1.0], elsewhere(1)[0]), TypeError, "levels is"),
    ],
)
def test_what_needs_values_says_so_by_name(call, error, said):
    with pytest.raises(error, match=f"^{said}"):
        call()


def test_numbers_on_the_cpu_go_where_the_others_are():
    here, there = torch.ones(2, dtype=torch.float64), elsewhere(2)
    assert [x.device.type for x in on_one_device(a=here, b=there)] == ["meta", "meta"]
    assert on_one_device(a=here)[0] is here
    assert beside([1.0], "a", there).device.type == "meta"
    assert on_cpu(here.requires_grad_(), "a").requires_grad
    with pytest.raises(ValueError, match=r"^a is on the device meta, which holds no values"):
        beside(there, "a", here)


def test_two_devices_are_named():
    class Elsewhere:
        """A tensor of a device that this machine lacks."""

        is_cpu, device = False, "cuda:0"

    with pytest.raises(ValueError, match=r"^a is on the device meta and b on cuda:0; bring them together"):
        on_one_device.__wrapped__(a=elsewhere(2), b=Elsewhere())


def test_derivatives_have_values_and_maps_over_a_batch_have_none():
    x = torch.ones(3, dtype=torch.float64)
    assert torch.func.grad(lambda x: require_values(x, "x").sum())(x).tolist() == [1, 1, 1]
    with pytest.raises(TypeError, match=r"^x has no values here"):
        torch.func.vmap(lambda x: require_values(x, "x"))(x)
