"""Arguments of any type and value: a chain, or a ValueError or TypeError that names the argument."""

import math
from collections.abc import Callable
from typing import TypeVar

import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st

import dexterity as dx

PUMA = dx.robots.puma560()
Result = TypeVar("Result")
NUMBERS = st.one_of(
    st.floats(allow_nan=True, allow_infinity=True),
    st.integers(-3, 3),
    st.sampled_from([10**400, True, None, "1", 1j, b"1", np.float32(0.5), np.int64(2), torch.tensor(0.25)]),
)
ANYTHING = st.recursive(
    st.one_of(NUMBERS, st.text(max_size=3)),
    lambda inside: st.one_of(
        st.lists(inside, max_size=6),
        st.dictionaries(st.sampled_from(["theta", "d", "a", "alpha", "kind", "x"]), inside, max_size=3),
        st.tuples(inside, inside),
    ),
    max_leaves=8,
)
pytestmark = pytest.mark.usefixtures("annotations_unchecked")


def chain_or_refused(make: Callable[[], Result], *names: str) -> Result | None:
    """Return what is made, or None if it is refused in words that begin with one of the names."""
    try:
        return make()
    except (TypeError, ValueError) as error:
        if not str(error).startswith(names):
            raise
        return None


@given(argument=st.sampled_from(["screws", "home", "lower", "upper", "rates", "inertias"]), value=ANYTHING)
def test_any_value_of_an_array(argument, value):
    arguments = {"screws": PUMA.screws, "home": PUMA.home, argument: value}
    chain_or_refused(lambda: dx.Chain(**arguments), argument)


@given(argument=st.sampled_from(["name", "joint_names"]), value=ANYTHING)
def test_any_name(argument, value):
    chain = chain_or_refused(lambda: dx.Chain.from_dh([{}, {}], **{argument: value}), argument)
    if chain is not None:
        assert all(name.isprintable() and name.strip() for name in (chain.name, *chain.joint_names))


@given(rows=ANYTHING)
def test_any_rows(rows):
    chain_or_refused(lambda: dx.Chain.from_dh(rows), "rows")


@given(key=st.sampled_from(["theta", "d", "a", "alpha", "kind"]), value=ANYTHING)
def test_any_value_of_a_row(key, value):
    chain = chain_or_refused(lambda: dx.Chain.from_dh([{}, {key: value}]), "rows[1]", "screws")
    if chain is not None and key in ("theta", "alpha"):
        assert abs(float(value)) <= 2 * math.pi + 1e-9


@given(
    method=st.sampled_from(["on_vehicle", "on_planar_base", "on_wheels"]),
    argument=st.sampled_from(["rates", "lower", "upper", "prefix", "name", "inertia"]),
    value=ANYTHING,
)
def test_any_option_of_a_mount(method, argument, value):
    names = (argument, "lower exceeds upper", "joint_names") if argument != "name" else ("name",)
    chain_or_refused(lambda: getattr(PUMA, method)(np.eye(4), **{argument: value}), *names)


@given(method=st.sampled_from(["on_vehicle", "with_base", "with_tool"]), value=ANYTHING)
def test_any_pose(method, value):
    chain_or_refused(lambda: getattr(PUMA, method)(value), "T_")


@given(value=ANYTHING)
def test_any_joints_of_a_vehicle_and_any_locked_joints(value):
    chain_or_refused(lambda: PUMA.on_vehicle(np.eye(4), joints=value), "joints")
    chain_or_refused(lambda: PUMA.lock(value), "joints")


@given(
    method=st.sampled_from(
        ["forward", "joint_frames", "spatial_jacobian", "body_jacobian", "geometric_jacobian"]
    ),
    value=ANYTHING,
)
def test_any_joint_values(method, value):
    result = chain_or_refused(lambda: getattr(PUMA, method)(value), "q ")
    assert result is None or torch.isfinite(result).all()
