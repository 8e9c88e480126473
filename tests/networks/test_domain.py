"""Guards against the spaces that they guard."""

import dataclasses
from functools import cache

import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st

import dexterity as dx
from dexterity import sampling
from dexterity.networks.domain import Guarded, OutsideTrainedSpace
from dexterity.networks.feed_forward import FeedForward
from dexterity.networks.network import View
from dexterity.sampling import Box

UVMS = dx.robots.uvms()
INPUTS = {"manipulability": range(4, 11), "kinematic_conditioning": range(11)}

trained_space = cache(sampling.uvms_space)


@cache
def guard(name="manipulability", space=None, view=None):
    space = space or trained_space(name)
    q = sampling.sobol(trained_space(name), 64, 0)
    view = view or View(12, INPUTS[name])
    random = torch.Generator().manual_seed(0)
    return Guarded(FeedForward.untrained(view, 2, q, torch.linspace(1, 2, 64), random), space)


def inside(name, *batch):
    count = torch.Size(batch).numel()
    return sampling.uniform(trained_space(name), count, torch.Generator().manual_seed(1)).reshape(*batch, 12)


@pytest.mark.parametrize("name", INPUTS)
def test_inside_it_answers_as_the_network_does(name):
    guarded, q = guard(name), inside(name, 3, 4)
    assert torch.equal(guarded(q), guarded.network(q))
    answer = guarded.ask(q)
    assert answer.inside.shape == (3, 4)
    assert answer.inside.all()


@given(joint=st.integers(4, 10), beyond=st.floats(1e-6, 10), above=st.booleans())
def test_the_joint_that_leaves_is_named(joint, beyond, above):
    guarded, q = guard(), inside("manipulability", 5)
    limit = (trained_space("manipulability").upper if above else trained_space("manipulability").lower)[joint]
    q[3, joint] = limit + (beyond if above else -beyond)
    with pytest.raises(OutsideTrainedSpace, match=rf"^q has 1 of 5 .* joint {joint + 1} \(") as caught:
        guarded(q)
    assert caught.value.joints == (joint,)
    assert caught.value.inside.tolist() == [True, True, True, False, True]
    answer = guarded.ask(q)
    assert torch.equal(answer.inside, caught.value.inside)
    assert torch.equal(answer.values, guarded.network(q))


def test_the_base_out_of_its_sector_is_put_down_to_the_translations():
    guarded, q = guard("kinematic_conditioning"), inside("kinematic_conditioning", 2)
    q[0, 0] += 2.0
    with pytest.raises(OutsideTrainedSpace, match=r"joints 1, 2, 3 \("):
        guarded(q)
    q[1, 7] = 3.0
    with pytest.raises(OutsideTrainedSpace, match=r"^q has 2 of 2 .* joints 1, 2, 3, 8 \("):
        guarded(q)


@pytest.mark.parametrize("name", INPUTS)
def test_joints_without_influence_are_free(name):
    guarded, q = guard(name), inside(name, 4)
    moved = q.clone()
    free = sorted(set(range(12)) - set(INPUTS[name]))
    moved[:, free] = 100.0
    assert guarded.ask(moved).inside.all()
    assert torch.equal(guarded(moved), guarded(q))


def test_a_held_joint_that_the_network_sees_must_stay():
    lower, upper = (
        list(x) for x in (trained_space("manipulability").lower, trained_space("manipulability").upper)
    )
    lower[5] = upper[5] = 0.1
    guarded = guard(space=Box(lower, upper))
    q = inside("manipulability", 3)
    q[:, 5] = 0.1
    assert guarded.contains(q).all()
    q[1, 5] = 0.2
    with pytest.raises(OutsideTrainedSpace, match=r"joint 6 \("):
        guarded(q)


def test_joints_that_carry_the_view_are_seen():
    space = trained_space("kinematic_conditioning")
    guarded = guard("kinematic_conditioning", view=View(12, range(4, 11), UVMS.screws[:6]))
    q = sampling.uniform(space, 10, torch.Generator().manual_seed(2))
    assert guarded.contains(q).all()
    q[:, 1] -= 5.0
    assert not guarded.contains(q).any()


def test_limits_belong_to_the_space():
    corners = torch.stack([torch.zeros(7), torch.ones(7)])
    assert guard().contains(trained_space("manipulability").from_unit(corners)).all()


def test_nothing_is_asked_of_an_empty_batch():
    assert guard()(torch.zeros(0, 12)).shape == (0,)


@pytest.mark.parametrize("wrong", [torch.zeros(3, 11), torch.tensor(1.0), torch.full((12,), float("nan"))])
def test_bad_input_is_refused_as_everywhere(wrong):
    guarded = guard()
    for function in (guarded, guarded.ask, guarded.contains):
        with pytest.raises(ValueError, match=r"^q (has shape|is not finite)") as caught:
            function(wrong)
        assert not isinstance(caught.value, OutsideTrainedSpace)


def test_a_space_of_another_chain_is_refused():
    with pytest.raises(ValueError, match=r"^network has 12 joints and space 2"):
        guard(space=Box([0, 0], [1, 1]))


def test_a_guard_cannot_be_changed():
    with pytest.raises(dataclasses.FrozenInstanceError):
        guard().space = trained_space("kinematic_conditioning")
