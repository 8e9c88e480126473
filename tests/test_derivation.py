"""Derivations: what they compute, what they leave out, and what they leave open."""

import dataclasses
import doctest
import math
from functools import cache

import numpy as np
import pytest
import sympy
import torch
from beartype.roar import BeartypeCallHintParamViolation
from numpy.testing import assert_allclose, assert_array_equal

import dexterity as dx
from dexterity import derivation as derivations
from dexterity import operations, robots
from dexterity.derivation import Derivation, SymbolicChain
from dexterity.indices import Frame, Index, normalise
from program_values import values_of
from serial_chains import random_robot

UVMS = dx.robots.uvms()
PUMA = dx.robots.puma560()
ARM = dx.robots.docking_arm()
FRAMES: tuple[Frame, ...] = ("spatial", "body", "geometric")
W, KCI = "manipulability", "kinematic_conditioning"

# Rates with the same limit within each block, and without.
ISOTROPIC = (0.5,) * 3 + (2.0,) * 3
UNEVEN = (0.5, 1.0, 0.7, 2.0, 1.0, 3.0)


derive = cache(derivations.derive)


@cache
def random_chain(joints: int, seed: int = 0) -> dx.Chain:
    return random_robot(np.random.default_rng([joints, seed]), joints).chain()


def configurations(rng: np.random.Generator, chain: dx.Chain, count: int = 20) -> np.ndarray:
    return rng.uniform(-3, 3, (count, chain.joints))


def at(derivation: Derivation, q: np.ndarray) -> dict[sympy.Symbol, np.ndarray]:
    return dict(zip(derivation.joint_values, q.T, strict=True))


def jacobian_of(derivation: Derivation, q: np.ndarray) -> np.ndarray:
    entries = values_of(derivation.jacobian, at(derivation, q))
    return entries.reshape(len(q), 6, -1)


def plain_jacobian(chain: dx.Chain, frame: Frame, q: np.ndarray) -> np.ndarray:
    return getattr(chain, f"{frame}_jacobian")(q).numpy()


# ---- Jacobians -------------------------------------------------------------------------------------

CHAINS = {
    "uvms": UVMS,
    "puma": PUMA,
    "docking arm": ARM,
    "fitted docking arm": dx.robots.docking_arm("fitted"),
    "four joints": random_chain(4),
    "five joints": random_chain(5),
    "six joints": random_chain(6),
}


@pytest.mark.parametrize("frame", FRAMES)
@pytest.mark.parametrize("chain", CHAINS.values(), ids=CHAINS)
def test_a_derived_jacobian_has_the_singular_values_of_the_one_it_stands_for(rng, frame, chain):
    q = configurations(rng, chain)
    derived = np.linalg.svd(jacobian_of(derive(chain, Index(KCI, frame)), q), compute_uv=False)
    plain = np.linalg.svd(plain_jacobian(chain, frame, q), compute_uv=False)
    assert_allclose(derived, plain, rtol=0, atol=2e-12)


@pytest.mark.parametrize("chain", CHAINS.values(), ids=CHAINS)
def test_turning_the_axes_and_moving_the_point_keeps_the_determinant(rng, chain):
    q = configurations(rng, chain)
    J, plain_J = jacobian_of(derive(chain, Index(W)), q), plain_jacobian(chain, "spatial", q)
    squares = [np.linalg.det(matrix @ matrix.swapaxes(-1, -2)) for matrix in (J, plain_J)]
    assert_allclose(*squares, rtol=1e-9, atol=1e-14)


@pytest.mark.parametrize("frame", FRAMES)
def test_rates_of_joints_weigh_the_columns(rng, frame):
    rates = tuple(rng.uniform(0.1, 2, 12))
    q = configurations(rng, UVMS)
    derived = np.linalg.svd(jacobian_of(derive(UVMS, Index(KCI, frame, rates)), q), compute_uv=False)
    plain = np.linalg.svd(plain_jacobian(UVMS, frame, q) * rates, compute_uv=False)
    assert_allclose(derived, plain, rtol=0, atol=2e-12)


@pytest.mark.parametrize("tool_rates", [ISOTROPIC, UNEVEN], ids=["isotropic", "uneven"])
@pytest.mark.parametrize("frame", FRAMES)
def test_the_triangle_has_the_singular_values_of_the_normalised_jacobian_up_to_a_factor(
    rng, frame, tool_rates
):
    q = configurations(rng, PUMA)
    derivation = derive(PUMA, Index(KCI, frame, tool_rates=tool_rates))
    L = np.zeros((len(q), 6, 6))
    L[:, *np.tril_indices(6)] = values_of(derivation.triangle, at(derivation, q))
    normalised = normalise(plain_jacobian(PUMA, frame, q), np.ones(6), tool_rates).numpy()
    derived, plain = (np.linalg.svd(J, compute_uv=False) for J in (L, normalised))
    assert_allclose(derived / derived[:, :1], plain / plain[:, :1], rtol=0, atol=1e-13)
    factors = derived[:, 0] / plain[:, 0]
    assert_allclose(factors, factors[0], rtol=1e-12)


def test_the_place_of_the_jacobian_does_not_change_the_manipulability(rng):
    chain = random_chain(6)
    q = configurations(rng, chain)
    shortest = derive(chain, Index(W))
    w = values_of(shortest.manipulability, at(shortest, q))
    assert_allclose(w[:, 0], Index(W).bind(chain)(q), rtol=1e-11, atol=0)
    for link, reference in [(0, 0), (6, 7), (3, 1)]:
        elsewhere = dataclasses.replace(shortest, link=link, reference=reference)
        assert_allclose(values_of(elsewhere.manipulability, at(elsewhere, q)), w, rtol=1e-10, atol=0)


def test_the_place_of_the_jacobian_is_the_shortest_one():
    shortest = derive(PUMA, Index(KCI, "body"))
    assert shortest.reference == 7

    def cost(derivation: Derivation) -> int:
        return operations.count_program(derivation.jacobian).total

    others = [dataclasses.replace(shortest, link=link) for link in range(7)]
    assert cost(shortest) == min(cost(other) for other in others)


# ---- manipulability --------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "chain",
    [UVMS, PUMA, ARM, random_chain(6), random_chain(7)],
    ids=["uvms", "puma", "docking arm", "six joints", "seven joints"],
)
def test_the_closed_form_is_the_square_of_the_manipulability(rng, chain):
    q = configurations(rng, chain)
    derivation = derive(chain, Index(W))
    square = values_of(derivation.squared_manipulability, at(derivation, q))[:, 0]
    w = Index(W).bind(chain)(q).numpy()
    assert_allclose(square, w**2, rtol=1e-9, atol=1e-16)


def test_the_nested_closed_form_of_the_puma_is_the_square_of_the_determinant(rng):
    derivation = derive(PUMA, Index(W))
    (square,) = derivation.squared_manipulability.nested()
    assert square.free_symbols <= set(derivation.joint_values)
    value = sympy.lambdify(derivation.joint_values, square)
    for q in configurations(rng, PUMA):
        determinant = np.linalg.det(plain_jacobian(PUMA, "spatial", q))
        assert value(*q) == pytest.approx(determinant**2, rel=1e-9)


def test_the_closed_form_of_the_docking_arm_is_found_with_its_lengths_as_symbols():
    """w = l₁ l₂ |sin θ₃| |l₁ cos θ₂ + l₂ cos(θ₂ + θ₃)| |sin θ₅|, the arm's lateral offset cancelled."""
    chain = SymbolicChain.from_description(robots.describe("docking_arm"))
    (square,) = derive(chain, Index(W)).squared_manipulability.nested()
    _, q2, q3, _, q5, _ = sympy.symbols("q1:7", real=True)
    l1, l2 = sympy.symbols("l1 l2", real=True)
    expected = l1 * l2 * sympy.sin(q3) * sympy.sin(q5) * (l1 * sympy.cos(q2) + l2 * sympy.cos(q2 + q3))
    assert sympy.simplify(sympy.expand_trig(square - expected**2)) == 0


# ---- joints that matter ----------------------------------------------------------------------------

EVEN_ROV = (0.5,) * 3 + (0.3,) * 3 + (1.0,) * 6


def joints_that_move(rng: np.random.Generator, chain: dx.Chain, index: Index) -> set[int]:
    """Joints, counted from 1, by which the plain computation changes."""
    q = torch.from_numpy(configurations(rng, chain)).requires_grad_()
    (gradient,) = torch.autograd.grad(index.bind(chain)(q).log().sum(), q)
    return set((gradient.abs() > 1e-6).any(0).nonzero()[:, 0].add(1).tolist())


@pytest.mark.parametrize(
    ("index", "joints"),
    [
        (Index(W), range(5, 12)),
        (Index(W, "body"), range(5, 12)),
        (Index(W, joint_rates=EVEN_ROV), range(5, 12)),
        (Index(W, joint_rates=(1.0, 1.0, 0.5) + (1.0,) * 9), range(4, 12)),
        (Index(KCI), range(1, 12)),
        (Index(KCI, "body"), range(5, 12)),
        (Index(KCI, "geometric"), range(5, 12)),
        (Index(KCI, "body", EVEN_ROV, ISOTROPIC), range(5, 12)),
        (Index(KCI, "body", tool_rates=UNEVEN), range(5, 13)),
        (Index(KCI, "geometric", tool_rates=UNEVEN), range(4, 12)),
    ],
    ids=str,
)
def test_only_the_joints_that_matter_appear_in_an_index_of_the_uvms(rng, index, joints):
    """Found by deriving, and confirmed by the plain computation."""
    assert derive(UVMS, index).matters == tuple(joints)
    assert joints_that_move(rng, UVMS, index) == set(joints)


@pytest.mark.parametrize(
    ("chain", "index"),
    [
        (PUMA, Index(W)),
        (ARM, Index(W)),
        (ARM, Index(KCI, "body")),
        (UVMS, Index(W, joint_rates=(0.5,) + (1.0,) * 11)),
    ],
    ids=["puma", "docking arm", "conditioning", "uvms"],
)
def test_no_joint_that_matters_is_left_out(rng, chain, index):
    """The Jacobian may name one more, which cancels in the index: the roll of a wrist, or of this vehicle."""
    found = derive(chain, index).matters
    assert joints_that_move(rng, chain, index) <= set(found)
    assert not {1, chain.joints} & set(found)


def test_a_locked_tool_joint_leaves_out_what_only_it_needed():
    all_move, last_locked = (derive(ARM, Index(KCI, "body", rates)) for rates in (None, (1.0,) * 5 + (0.0,)))
    assert set(last_locked.matters) <= set(all_move.matters)
    assert len(last_locked.jacobian.outputs) == 6 * 5


# ---- too few columns -------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("chain", "rates"),
    [(random_chain(4), None), (random_chain(5), None), (UVMS, (0.0,) * 7 + (1.0,) * 5), (UVMS, (0.0,) * 12)],
    ids=["four joints", "five joints", "seven locked", "all locked"],
)
def test_with_fewer_than_six_columns_all_is_zero(rng, chain, rates):
    q = configurations(rng, chain)
    w, kci = derive(chain, Index(W, joint_rates=rates)), derive(chain, Index(KCI, joint_rates=rates))
    assert w.squared_manipulability.nested() == w.manipulability.nested() == (0,)
    assert set(w.value_and_gradient.nested()) == {sympy.S.Zero}
    assert set(kci.triangle.outputs) == {sympy.S.Zero}
    assert_array_equal(values_of(kci.bidiagonal, at(kci, q)), 0)
    assert set(kci.spectral_gradient.outputs) == {sympy.S.Zero}


def test_chains_of_fewer_than_six_joints_still_have_a_jacobian(rng):
    chain = random_chain(5)
    derivation = derive(chain, Index(W, joint_rates=(1.0, 1.0, 0.0, 1.0, 2.0)))
    assert len(derivation.jacobian.outputs) == 6 * 4
    with pytest.raises(ValueError, match=r"^chain has 5 joints; with fewer than 6 the manipulability"):
        derivation.require_computable()


# ---- lengths as symbols ----------------------------------------------------------------------------

LENGTHS = {
    "uvms": {"l1": 0.1, "l2": 0.5, "l3": 0.45, "y_MB": 0.8},
    "docking_arm": {"l0": 0.2, "l1": 0.35, "l2": 0.5, "sideways": 0.07},
}


@pytest.mark.parametrize("name", LENGTHS)
def test_lengths_are_symbols_of_their_names(name):
    chain = SymbolicChain.from_description(robots.describe(name))
    numbers = SymbolicChain.from_chain(robots.build(robots.describe(name)))
    assert {str(length) for length in chain.lengths} == set(LENGTHS[name])
    assert numbers.lengths == ()
    assert (chain.joints, chain.kinds, chain.joint_names) == (
        numbers.joints,
        numbers.kinds,
        numbers.joint_names,
    )
    assert (chain.axes, chain.tool_axes) == (numbers.axes, numbers.tool_axes)


@pytest.mark.parametrize("frame", FRAMES)
@pytest.mark.parametrize("name", LENGTHS)
def test_numbers_put_in_for_the_lengths_give_the_numbers_of_that_chain(rng, name, frame):
    description, lengths = robots.describe(name), LENGTHS[name]
    numeric = robots.build(description, lengths)
    q = configurations(rng, numeric)
    symbolic = derive(SymbolicChain.from_description(description), Index(KCI, frame))
    values = {symbol: lengths[str(symbol)] for symbol in symbolic.chain.lengths}
    entries = values_of(symbolic.jacobian, at(symbolic, q) | values).reshape(len(q), 6, -1)
    assert_allclose(
        np.linalg.svd(entries, compute_uv=False),
        np.linalg.svd(plain_jacobian(numeric, frame, q), compute_uv=False),
        rtol=0,
        atol=1e-13,
    )


@pytest.mark.parametrize("name", LENGTHS)
def test_indices_can_be_derived_before_the_lengths_are_known(rng, name):
    description, lengths = robots.describe(name), LENGTHS[name]
    numeric = robots.build(description, lengths)
    q = configurations(rng, numeric)
    w = derive(SymbolicChain.from_description(description), Index(W))
    values = {symbol: lengths[str(symbol)] for symbol in w.chain.lengths}
    for program, power in ((w.manipulability, 1), (w.squared_manipulability, 2)):
        assert_allclose(
            values_of(program, at(w, q) | values)[:, 0],
            Index(W).bind(numeric)(q) ** power,
            rtol=1e-10,
            atol=1e-16,
        )


def test_the_base_of_the_uvms_does_not_appear_in_its_symbolic_manipulability():
    """Neither do the lengths before the first joint that matters."""
    chain = SymbolicChain.from_description(robots.describe("uvms"))
    derivation = derive(chain, Index(W))
    assert derivation.matters == tuple(range(5, 12))


def test_lengths_without_a_value_are_named():
    chain = SymbolicChain.from_description(robots.describe("docking_arm"))
    with pytest.raises(ValueError, match=r"^docking_arm has lengths without a value: l0, l1, l2, sideways$"):
        chain.require_numbers()


# ---- chains ----------------------------------------------------------------------------------------


def test_a_symbolic_chain_of_numbers_is_that_chain():
    chain = SymbolicChain.from_chain(UVMS)
    assert (chain.name, chain.joints, chain.kinds) == (UVMS.name, 12, UVMS.kinds)
    assert chain.rates == tuple(UVMS.rates.tolist())
    for axis, point, kind, screw in zip(chain.axes, chain.points, chain.kinds, UVMS.screws, strict=True):
        axis, point = np.array(axis, dtype=float), np.array(point, dtype=float)
        expected = [*np.cross(point, axis), *axis] if kind == "revolute" else [*axis, 0, 0, 0]
        assert_allclose(screw, expected, rtol=0, atol=1e-15)
    assert_allclose(np.array(chain.tool, dtype=float), UVMS.home[:3, 3], rtol=0, atol=0)


def test_rounding_is_taken_off_what_is_meant_to_be_an_integer():
    """cos(π/2) of a Denavit–Hartenberg row is 6e-17; as an entry it would keep joints that do not matter."""
    chain = SymbolicChain.from_chain(PUMA)
    assert {entry for axis in chain.axes for entry in axis} <= {-1, 0, 1}
    slanted = dx.Chain.from_dh([{"alpha": math.pi / 6}] * 2)
    assert sympy.Float(0.5) not in SymbolicChain.from_chain(slanted).axes[1]


def test_equal_chains_have_equal_numbers_and_others_have_not():
    numbers = SymbolicChain.from_chain(PUMA).numbers()
    assert numbers == SymbolicChain.from_chain(dx.robots.puma560()).numbers()
    assert numbers != SymbolicChain.from_chain(ARM).numbers()
    moved = PUMA.home
    moved[0, 3] += 1e-15
    assert numbers != SymbolicChain.from_chain(dx.Chain(PUMA.screws, moved)).numbers()


@pytest.mark.parametrize(
    ("rates", "message"),
    [
        ({"joint_rates": (1.0,) * 5}, r"joint_rates has shape \(5,\); \(6,\) is needed"),
        ({"joint_rates": (1.0,) * 5 + (-1.0,)}, "joint_rates holds a negative rate"),
        ({"joint_rates": (1.0,) * 5 + (math.nan,)}, "joint_rates is not finite"),
        ({"tool_rates": (1.0,) * 5}, r"tool_rates has shape \(5,\); \(6,\) is needed"),
        ({"tool_rates": (1.0,) * 5 + (0.0,)}, "tool_rates must be positive"),
        ({"tool_rates": (1.0,) * 5 + (math.inf,)}, "tool_rates is not finite"),
    ],
    ids=str,
)
@pytest.mark.parametrize("name", [W, KCI])
def test_rates_that_do_not_fit_are_refused(name, rates, message):
    with pytest.raises(ValueError, match=f"^{message}"):
        derive(PUMA, Index(name, **rates))


def test_the_worked_example_is_what_it_prints():
    outcome = doctest.testmod(derivations)
    assert outcome.attempted > 5
    assert outcome.failed == 0


def test_annotations_of_expressions_are_checked_in_tests():
    """By the import hook of conftest.py, which leaves this module out of jaxtyping's."""
    with pytest.raises(BeartypeCallHintParamViolation):
        derivations.exact([0.5])
