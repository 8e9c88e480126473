"""Descriptions of chains: right to six digits, of any kind of array, with printable names; torch's tools."""

import math

import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st
from torch.testing import assert_close

import dexterity as dx
from dexterity import spatial
from warm_process import WarmProcess

PUMA = dx.robots.puma560()
KINEMATICS = ("forward", "joint_frames", "spatial_jacobian", "body_jacobian", "geometric_jacobian")
Q = torch.linspace(-0.9, 1.1, 6, dtype=torch.float64)


def turned(seed: int) -> dx.Chain:
    """The PUMA on a base whose axes are no coordinate axes."""
    return PUMA.with_base(spatial.exp(torch.from_numpy(np.random.default_rng(seed).normal(size=6))))


# ---- right to six digits (spatialmath#6, pyquaternion#33, transforms3d#3, pypose#83) -----------------


def test_a_description_in_single_precision_is_taken_and_says_by_how_much_it_missed():
    exact = turned(0)
    chain = dx.Chain(exact.screws.float(), exact.home.float())
    assert 1e-9 < chain.adjusted < 3e-7
    assert exact.adjusted == 0
    assert_close(chain.forward(Q), exact.forward(Q), rtol=0, atol=2e-6)
    assert_close(chain.screws[:, 3:].norm(dim=1), torch.ones(6, dtype=torch.float64), rtol=0, atol=1e-15)
    T = chain.forward(Q)
    assert_close(T[:3, :3].mT @ T[:3, :3], torch.eye(3, dtype=torch.float64), rtol=0, atol=1e-14)


@given(seed=st.integers(0, 1000))
def test_a_description_with_six_printed_digits_is_taken(seed):
    exact = turned(seed)
    chain = dx.Chain(exact.screws.numpy().round(6), exact.home.numpy().round(6))
    assert 0 < chain.adjusted < 1e-5
    assert_close(chain.forward(Q), exact.forward(Q), rtol=0, atol=2e-5)
    assert (chain.screws[:, :3] * chain.screws[:, 3:]).sum(1).abs().max() < 1e-14


def test_a_prismatic_axis_with_rounding_in_its_rotation_is_prismatic():
    chain = dx.Chain([[0, 0.6, 0.8000001, 1e-9, 0, 0]], np.eye(4))
    assert chain.kinds == ("prismatic",)
    assert_close(chain.screws[0, :3].norm(), torch.ones((), dtype=torch.float64), rtol=0, atol=1e-15)


def test_a_right_description_is_taken_as_it_is():
    assert PUMA.adjusted == 0
    assert_close(dx.Chain(PUMA.screws, PUMA.home).screws, PUMA.screws, rtol=0, atol=0)


def test_the_message_about_an_axis_prints_the_miss():
    with pytest.raises(
        ValueError, match=r"of length 1.00002, which misses 1 by 2.0e-05; 1 is needed, to 1e-05"
    ):
        dx.Chain([[0, 0, 0, 0, 0, 1.00002]], np.eye(4))


# ---- every kind of array -----------------------------------------------------------------------------


@pytest.mark.parametrize(
    "as_given",
    [
        lambda x: x.tolist(),
        lambda x: x.numpy(),
        lambda x: x.numpy()[::-1][::-1],
        lambda x: np.asfortranarray(x.numpy()),
        lambda x: tuple(x),
        lambda x: x.clone().requires_grad_(),
    ],
    ids=["list", "numpy", "negative strides", "column order", "tuple of rows", "with a gradient"],
)
def test_a_chain_is_made_of_any_array(as_given):
    chain = dx.Chain(
        as_given(PUMA.screws), as_given(PUMA.home), lower=as_given(PUMA.lower), rates=as_given(PUMA.rates)
    )
    assert_close(chain.forward(Q), PUMA.forward(Q), rtol=0, atol=0)
    assert not chain.forward(Q).requires_grad


@pytest.mark.usefixtures("annotations_unchecked")
@pytest.mark.parametrize("argument", ["screws", "home", "lower", "upper", "rates"])
@pytest.mark.parametrize(
    "value",
    [None, "text", {}, object(), [[1, 2], [3]], [True] * 6, 1j, np.ma.masked_array([1.0], [True])],
)
def test_a_wrong_type_is_refused_by_the_name_of_the_argument(argument, value):
    arguments = {"screws": PUMA.screws, "home": PUMA.home, argument: value}
    if value is None and argument not in ("screws", "home"):
        dx.Chain(**arguments)
        return
    with pytest.raises((TypeError, ValueError), match=f"^{argument} "):
        dx.Chain(**arguments)


# ---- names -------------------------------------------------------------------------------------------


@pytest.mark.usefixtures("annotations_unchecked")
@pytest.mark.parametrize(
    ("names", "error", "message"),
    [
        ({"name": None}, TypeError, "name is None"),
        ({"name": 3}, TypeError, "name is 3"),
        ({"name": ""}, ValueError, "name is ''"),
        ({"name": " "}, ValueError, "name is ' '"),
        ({"name": "a\x00b"}, ValueError, "name is 'a"),
        ({"joint_names": "ab"}, TypeError, "joint_names is 'ab'; a sequence"),
        ({"joint_names": range(2)}, TypeError, r"joint_names\[0\] is 0"),
        ({"joint_names": [None, "b"]}, TypeError, r"joint_names\[0\] is None"),
        ({"joint_names": [b"a", "b"]}, TypeError, r"joint_names\[0\] is b'a'"),
        ({"joint_names": ["a", ""]}, ValueError, r"joint_names\[1\] is ''"),
        ({"joint_names": ["a", "\x07"]}, ValueError, r"joint_names\[1\] is '.x07'"),
        ({"joint_names": ["a", "\ud800"]}, ValueError, r"joint_names\[1\] is "),
        ({"joint_names": ["a", "\uffff"]}, ValueError, r"joint_names\[1\] is "),
        ({"joint_names": ["a"]}, ValueError, "joint_names holds 1 names; 2 are needed"),
        ({"joint_names": ["a", "a"]}, ValueError, "joint_names holds 'a' more than once"),
        ({"joint_names": 3}, TypeError, "joint_names is 3"),
    ],
)
def test_names_are_printable_and_different(names, error, message):
    with pytest.raises(error, match=f"^{message}"):
        dx.Chain.from_dh([{}, {}], **names)


def test_limits_that_leave_no_value_are_refused():
    for limits in ({"lower": [math.inf]}, {"upper": [-math.inf]}):
        with pytest.raises(ValueError, match=r"^lower exceeds upper at joint 1: .* leave no value"):
            dx.Chain.from_dh([{}], **limits)


# ---- torch's tools (pytorch_kinematics PR #26, #39, #66) ----------------------------------------------

METHODS = (*KINEMATICS, "mass_matrix")
HEAVY = dx.Chain(
    PUMA.screws, PUMA.home, inertias=(np.ones(6), np.full((6, 3), 0.1), np.stack([np.eye(3)] * 6))
)


TRACED = """
import numpy as np, torch, dexterity as dx
puma = dx.robots.puma560()
chain = dx.Chain(puma.screws, puma.home, inertias=(np.ones(6), np.zeros((6, 3)), np.stack([np.eye(3)] * 6)))
q = torch.rand(5, 6, dtype=torch.float64)
for function in (chain.body_jacobian, chain.mass_matrix):
    compiled = torch.compile(function, fullgraph=True, backend="eager")
    torch.testing.assert_close(compiled(q), function(q), rtol=0, atol=1e-13)
    torch.testing.assert_close(torch.func.vmap(function)(q), function(q), rtol=0, atol=1e-13)
    tangent = torch.func.jvp(function, (q[0],), (torch.ones(6, dtype=torch.float64),))[1]
    torch.testing.assert_close(tangent, torch.func.jacrev(function)(q[0]).sum(-1), rtol=0, atol=1e-12)
"""


def test_kinematics_can_be_compiled_mapped_and_differentiated_forwards():
    """In a process of its own: the run-time checks of annotations in the tests cannot be traced."""
    ended, printed = WarmProcess(TRACED).end()
    assert ended == 0, printed


def test_torchs_default_device_does_not_move_a_chain():
    torch.set_default_device("meta")
    try:
        chain = dx.Chain.from_dh([{"a": 1}, {"a": 0.5, "kind": "prismatic"}], lower=[-1, -1])
        on_wheels = chain.on_wheels(np.eye(4)).lock(["yaw"])
        panda = dx.robots.build(dx.robots.describe("panda"))
    finally:
        torch.set_default_device(None)
    assert chain.forward([0.1, 0.2]).device.type == "cpu"
    assert on_wheels.forward([0, 0, 0, 0.1, 0.2]).device.type == "cpu"
    assert_close(panda.screws, dx.robots.panda().screws, rtol=0, atol=0)


@pytest.mark.parametrize("method", METHODS)
def test_kinematics_stay_on_the_device_of_the_joint_values(method):
    q = torch.zeros(3, 6, dtype=torch.float64, device="meta")
    result = getattr(HEAVY, method)(q)
    assert result.device.type == "meta"
    assert result.shape == getattr(HEAVY, method)(torch.zeros(3, 6)).shape
