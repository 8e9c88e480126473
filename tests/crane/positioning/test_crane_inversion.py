"""Descent and damped Gauss–Newton, on networks and on the structure."""

import dataclasses
import math

import pytest
import torch
from torch.testing import assert_close

from dexterity import crane
from dexterity.crane.positioning import (
    DescentOptions,
    GaussNewtonOptions,
    descend,
    direct_network,
    errors,
    gauss_newton,
    linear_sag,
    network_tip,
    safe_rate,
    sagging_tip,
    thesis_task,
)
from dexterity.crane.positioning.inversion import _scaled_miss

TASK = thesis_task()


@pytest.fixture(scope="module")
def network():
    return direct_network(crane.training_set(), torch.Generator().manual_seed(0), epochs=25)


def told(network, placement):
    with torch.no_grad():
        return network(torch.cat([placement.strokes, TASK.payload[:, None]], dim=-1))


# ---- descent ---------------------------------------------------------------------------------------


def test_one_step_goes_down_the_gradient_of_eq_59(network):
    rate = 0.05
    one = descend(TASK, network, DescentOptions(tolerance=1e-12, rate=rate, iterations=1))
    centre, half = network.input_centre, network.input_half_range
    x = ((torch.cat([TASK.starts, TASK.payload[:, None]], dim=-1) - centre) / half).requires_grad_()
    miss = (TASK.targets - network.answer(x * half + centre)) / network.target_half_range
    (slope,) = torch.autograd.grad(miss.square().sum() / 2, x)
    expected = ((x - rate * slope) * half + centre).detach()[:, :3]
    assert_close(one.strokes, expected, rtol=0, atol=1e-12)
    assert (one.iterations == 1).all()


@pytest.mark.parametrize("tolerance", [1e-5, 1e-7])
def test_descent_ends_where_the_error_is_within_the_tolerance(network, tolerance):
    placement = descend(TASK, network, DescentOptions(tolerance))
    assert placement.converged.all()
    error = ((told(network, placement) - TASK.targets) / network.target_half_range).square().sum(-1) / 2
    assert (error <= tolerance * (1 + 1e-9)).all()


def test_a_smaller_tolerance_takes_more_steps_on_the_same_way(network):
    coarse, fine = (descend(TASK, network, DescentOptions(tolerance)) for tolerance in (1e-5, 1e-7))
    assert (fine.iterations >= coarse.iterations).all()
    assert fine.iterations.double().mean() > coarse.iterations.double().mean()


def test_descent_that_runs_out_of_steps_is_flagged(network):
    placement = descend(TASK, network, DescentOptions(1e-9, iterations=2))
    assert not placement.converged.all()
    assert placement.iterations.max() == 2


def test_the_safe_rate_lowers_the_error_at_every_step(network):
    before = descend(TASK, network, DescentOptions(1e-20, iterations=1))
    for steps in (2, 5, 20):
        after = descend(TASK, network, DescentOptions(1e-20, iterations=steps))
        errors_ = [(told(network, p) - TASK.targets).square().sum(-1) for p in (before, after)]
        assert (errors_[1] <= errors_[0]).all()
        before = after
    assert 0.01 < safe_rate(network, TASK) < 1.0


@pytest.mark.parametrize(
    "bad", [{"tolerance": 0.0}, {"rate": -1.0}, {"rate": math.inf}, {"iterations": 0}], ids=str
)
def test_bad_options_of_the_descent_are_named(bad):
    with pytest.raises(ValueError, match=next(iter(bad))):
        DescentOptions(**bad)


# ---- damped Gauss–Newton ---------------------------------------------------------------------------


def test_the_derivative_of_a_network_is_autograds(network):
    strokes = TASK.starts.clone().requires_grad_()
    answer = network(torch.cat([strokes, TASK.payload[:, None]], dim=-1))
    rows = [torch.autograd.grad(answer[:, i].sum(), strokes, retain_graph=True)[0] for i in range(2)]
    tip, slope = network_tip(network)(TASK.starts, TASK.payload)
    assert_close(tip, answer.detach(), rtol=0, atol=1e-12)
    assert_close(slope, torch.stack(rows, dim=1), rtol=1e-9, atol=1e-12)
    assert _scaled_miss(network, torch.zeros(3, 4).double(), torch.zeros(2).double())[1].shape == (3, 2, 4)


def test_it_inverts_the_structure_in_a_few_steps():
    placement = gauss_newton(TASK, sagging_tip(TASK, linear_sag()))
    assert placement.converged.all()
    assert placement.iterations.max() <= 10
    found = errors(TASK, placement)
    assert found.distance.max() < 1e-6
    assert not found.stopped.any()
    assert (placement.strokes - TASK.starts).abs().max() < 0.1


def test_it_inverts_a_network_within_the_limits(network):
    placement = gauss_newton(TASK, network_tip(network))
    assert TASK.allows(placement.strokes).all()
    miss = (told(network, placement) - TASK.targets).norm(dim=-1)
    assert torch.equal(placement.converged, miss <= 1e-6)
    assert placement.converged.double().mean() > 0.9


def test_damping_has_no_effect_at_the_target():
    there = dataclasses.replace(TASK, targets=crane.flexible_tip(TASK.starts, TASK.payload))
    for damping in (1e-6, 1e3):
        placement = gauss_newton(there, sagging_tip(there, linear_sag()), GaussNewtonOptions(damping=damping))
        assert torch.equal(placement.strokes, there.starts)
        assert (placement.iterations == 0).all()


def test_what_is_out_of_reach_is_flagged_and_does_not_leave_the_limits():
    far = dataclasses.replace(TASK, targets=TASK.targets + 9.0)
    placement = gauss_newton(far, sagging_tip(far, linear_sag()), GaussNewtonOptions(iterations=20))
    assert not placement.converged.any()
    assert far.allows(placement.strokes).all()


@pytest.mark.parametrize("bad", [{"tolerance": 0.0}, {"damping": -1.0}, {"iterations": 0}], ids=str)
def test_bad_options_of_gauss_newton_are_named(bad):
    with pytest.raises(ValueError, match=next(iter(bad))):
        GaussNewtonOptions(**bad)
