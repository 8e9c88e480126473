"""Resolved-rate control: what its equation says about the error, and what ends a run."""

import math

import pytest
import torch
from torch.testing import assert_close

from dexterity import spatial
from dexterity.workspace import reachability
from dexterity.workspace.resolved_rate import Circle, Wanted, track

PUMA = (0.15, 0.4318, 0.4318, 0.0203)
ARM = reachability.arm(PUMA)
DOWN = ((1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.0, 0.0, -1.0))
CIRCLE = Circle((0.2, 0.2, 0.2), 0.1, 10.0, math.radians(20), DOWN)


def seconds(*times: float) -> torch.Tensor:
    return torch.tensor(times, dtype=torch.float64)


def start(circle: Circle = CIRCLE) -> torch.Tensor:
    q, reached = reachability.inverse(PUMA, circle(seconds(0.0)).T_world_tool)
    assert reached.all()
    return q[0]


def run(q=None, jacobian=ARM.geometric_jacobian, **options):
    options = {"duration": 1.0, "step": 0.05, "gain": 1.0} | options
    return track(CIRCLE, ARM.forward, jacobian, start() if q is None else q, **options)


def test_the_velocity_of_a_circle_is_its_slope():
    times, step = seconds(0.0, 1.3, 7.0), 1e-5
    ahead, here, behind = (CIRCLE(times + shift) for shift in (step, 0.0, -step))
    slope = (ahead.T_world_tool - behind.T_world_tool) / (2 * step)
    assert_close(here.velocity[:, :3], slope[:, :3, 3], rtol=0, atol=1e-9)
    omega = slope[:, :3, :3] @ here.T_world_tool[:, :3, :3].mT
    assert_close(here.velocity[:, 3:], omega_vector(omega), rtol=0, atol=1e-9)


def omega_vector(matrix: torch.Tensor) -> torch.Tensor:
    return torch.stack([matrix[:, 2, 1], matrix[:, 0, 2], matrix[:, 1, 0]], 1)


def test_a_circle_is_closed_and_leans_as_it_says():
    first, last = CIRCLE(seconds(0.0)), CIRCLE(seconds(10.0))
    assert_close(first.T_world_tool, last.T_world_tool, rtol=0, atol=1e-14)
    T = CIRCLE(torch.linspace(0, 10, 50, dtype=torch.float64)).T_world_tool
    assert_close(T[:, 2, 3], torch.full((50,), 0.2).double())
    assert_close((T[:, :2, 3] - 0.2).norm(dim=1), torch.full((50,), 0.1).double())
    assert_close(-T[:, 2, 2], torch.full((50,), math.cos(CIRCLE.lean)).double())


@pytest.mark.parametrize(("method", "order"), [("euler", 1), ("rk4", 4)])
def test_the_error_falls_with_the_step_as_the_method_says(method, order):
    coarse, fine = (run(method=method, step=step).position_error.max() for step in (0.1, 0.05))
    assert float(torch.log2(coarse / fine)) == pytest.approx(order, abs=0.6)


@pytest.mark.parametrize("gain", [1.0, 3.0])
def test_an_error_at_the_start_decays_with_the_gain(gain):
    off = start() + 0.01
    found = run(off, gain=gain, method="rk4", step=0.02)
    assert found.completed
    for error in (found.position_error, found.orientation_error):
        assert_close(error[-1] / error[0], torch.tensor(math.exp(-gain)).double(), rtol=2e-3, atol=0)


def test_without_gain_an_error_stays():
    found = run(start() + 0.01, gain=0.0, method="rk4")
    assert_close(found.position_error[-1], found.position_error[0], rtol=1e-3, atol=0)


def test_a_jacobian_that_is_a_little_wrong_leaves_an_error_that_the_gain_holds():
    def wrong(q):
        return 1.05 * ARM.geometric_jacobian(q)

    # The arm moves too slowly by a share of 0.05: that velocity over the gain is what is left.
    loose, tight = (run(jacobian=wrong, gain=gain, duration=6.0, step=0.02) for gain in (2.0, 8.0))
    speed = 0.1 * math.tau / 10
    for found, gain in ((loose, 2.0), (tight, 8.0)):
        assert float(found.position_error[-1]) == pytest.approx(0.05 * speed / gain, rel=0.2)


def test_the_result_says_what_was_done():
    found = run(duration=0.12, step=0.05)
    assert_close(found.time, seconds(0.0, 0.05, 0.1, 0.12))
    assert found.q.shape == (4, 6)
    assert found.message == ""
    assert torch.equal(found.q[0], start())
    w = torch.linalg.det(ARM.geometric_jacobian(found.q)).abs()
    assert_close(found.manipulability, w)
    assert_close(spatial.compose(ARM.forward(found.q[0])), CIRCLE(seconds(0.0)).T_world_tool[0])


def test_a_run_ends_where_the_arm_is_singular():
    straight = torch.tensor([0.0, 0.5, -math.atan2(PUMA[1], PUMA[3]), 0.2, 0.9, 0.1], dtype=torch.float64)
    T = ARM.forward(straight)

    def outwards(time: torch.Tensor) -> Wanted:
        pull = torch.zeros(*time.shape, 6, dtype=torch.float64)
        pull[..., :3] = 0.1 * T[:3, 3] / T[:3, 3].norm()
        return Wanted(T.expand(*time.shape, 4, 4), pull)

    found = track(outwards, ARM.forward, ARM.geometric_jacobian, straight, duration=1.0, step=0.1)
    assert not found.completed
    assert found.message.startswith("after 0 s a joint would turn at")
    assert len(found.time) == len(found.q) == 1


@pytest.mark.parametrize("entry", [math.nan, 0.0])
def test_a_run_ends_where_the_jacobian_is_none(entry):
    found = run(jacobian=lambda q: torch.full((*q.shape[:-1], 6, 6), entry, dtype=torch.float64))
    assert not found.completed
    assert found.position_error.isfinite().all()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"q": [[0.0] * 6]}, r"q has shape \(1, 6\)"),
        ({"q": [math.nan] * 6}, "q is not finite"),
        ({"duration": 0.0}, "duration is 0.0"),
        ({"step": -0.1}, "step is -0.1"),
        ({"gain": -1.0}, "gain is -1.0"),
        ({"largest_rate": math.inf}, "largest_rate is inf"),
        ({"method": "leapfrog"}, "method is 'leapfrog'"),
    ],
)
def test_bad_input_is_named(options, message, annotations_unchecked):
    with pytest.raises(ValueError, match=message):
        run(**options)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"radius": -0.1}, "radius is -0.1"),
        ({"period": 0.0}, "period is 0.0"),
        ({"orientation": ((2.0, 0, 0), (0, 1.0, 0), (0, 0, 1.0))}, "orthonormality"),
    ],
)
def test_a_circle_that_is_none_is_named(change, message):
    options = {"centre": (0.2, 0.2, 0.2), "radius": 0.1, "period": 10.0, "lean": 0.2, "orientation": DOWN}
    with pytest.raises(ValueError, match=message):
        Circle(**options | change)
