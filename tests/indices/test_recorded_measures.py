"""Guaranteed speed and dynamic manipulability as programs, against their definitions and pinocchio."""

import numpy as np
import pinocchio
import pytest
import sympy
import torch
from numpy.testing import assert_allclose
from torch.testing import assert_close

import dexterity as dx
from dexterity import symbolic
from dexterity.derivation import SymbolicChain, derive
from dexterity.derivation.jacobian import joint_values
from dexterity.derivation.mass_matrix import mass_matrix
from dexterity.indices import Index
from dexterity.program import Program, Recorder
from program_values import values_of
from serial_chains import random_robot

SPEED, DYNAMIC = "guaranteed_speed", "dynamic_manipulability"
PUMA, UR5E = dx.robots.puma560(), dx.robots.ur5e()
PANDA, IIWA = dx.robots.panda(), dx.robots.iiwa14()
SELECTIONS = [("vy",), ("vx", "wz"), "rotational", ("vx", "vy", "vz", "wz")]
WITH_MASSES = pytest.mark.parametrize("chain", [PANDA, UR5E, IIWA], ids=lambda chain: chain.name)


def configurations(chain: dx.Chain, count: int = 20) -> torch.Tensor:
    low, high = chain.lower.clamp(min=-2.5), chain.upper.clamp(max=2.5)
    draws = torch.rand(count, chain.joints, generator=torch.Generator().manual_seed(4), dtype=torch.float64)
    return low + (high - low) * draws


def assert_same(chain: dx.Chain, index: Index, rtol: float = 1e-12) -> None:
    """Values and gradients of the program, run by torch, are those of the definition and of autograd."""
    assert derive(chain, index).kind == "closed"
    q = configurations(chain)
    value, gradient = symbolic.compile_index(chain, index).value_and_gradient(q)
    x = q.clone().requires_grad_()
    plain = index.bind(chain)(x)
    (expected,) = torch.autograd.grad(plain.sum(), x)
    assert plain.max() > 0
    assert_close(value, plain.detach(), rtol=rtol, atol=1e-14)
    assert_close(gradient, expected, rtol=0, atol=1e-9 * float(expected.abs().max()))


# ---- guaranteed speed ------------------------------------------------------------------------------


# The last joint of the Alpha moves no tool point: its column is rounding alone, and spans no facet.
@pytest.mark.parametrize(
    "chain", [PUMA, UR5E, PANDA, IIWA, dx.robots.reach_alpha5()], ids=lambda chain: chain.name
)
def test_guaranteed_speed_is_the_inradius_of_the_zonotope(chain):
    assert_same(chain, Index(SPEED, "geometric", rows="translational"))


@pytest.mark.parametrize("rows", SELECTIONS, ids=str)
def test_so_it_is_over_any_rows(rows):
    assert_same(UR5E, Index(SPEED, "geometric", rows=rows))


@pytest.mark.parametrize("frame", ["spatial", "body"])
def test_guaranteed_speed_over_all_six_rows(frame):
    assert_same(PUMA, Index(SPEED, frame), rtol=1e-11)


@pytest.mark.parametrize("rows", [("vz",), "translational"])
def test_locked_joints_span_no_facet(rows):
    assert_same(PANDA, Index(SPEED, "geometric", joint_rates=(1.0, 2.0, 0.0, 1.0, 0.5, 0.0, 1.0), rows=rows))


def test_slides_count_with_their_rates():
    slides = [
        {"kind": "prismatic"},
        {"a": 0.3, "alpha": 1.2},
        {"kind": "prismatic", "alpha": 0.4},
        {"a": 0.2},
    ]
    chain = dx.Chain.from_dh(slides, rates=[0.5, 1.0, 2.0, 3.0])
    assert_same(chain, Index(SPEED, "geometric", rows="translational"))


def test_columns_that_span_no_facet_are_skipped():
    """The folded arm: two of the three columns are parallel, and a third is not."""
    chain = dx.Chain.from_dh([{"a": 0.5}, {"a": 0.25}, {"alpha": np.pi / 2}, {"a": 0.1}])
    index = Index(SPEED, "geometric", rows="translational")
    q = torch.tensor([[0.3, 0.0, 0.4, 0.7], [0.3, np.pi, 0.4, 0.7], [0.0, 0.0, 0.0, 0.0]]).double()
    value = symbolic.compile_index(chain, index)(q)
    assert_close(value, index.bind(chain)(q), rtol=1e-12, atol=1e-15)
    assert value[0] > 0


def test_fewer_joints_than_rows_are_refused():
    with pytest.raises(ValueError, match=r"at most 2 of the 3 rows"):
        symbolic.compile_index(
            dx.Chain.from_dh([{"a": 0.5}, {"a": 0.25}]), Index(SPEED, "geometric", rows="translational")
        )


def test_too_many_facets_are_left_to_torch():
    uvms = dx.robots.uvms()
    derivation = derive(uvms, Index(SPEED))
    assert derivation.kind == "numeric"
    assert "792 facets" in derivation.not_recorded
    q = configurations(uvms, 3)
    assert_close(symbolic.compile_index(uvms, Index(SPEED))(q), Index(SPEED)(uvms, q), rtol=1e-12, atol=0)


# ---- mass matrix -----------------------------------------------------------------------------------


def recorded_mass_matrices(chain: dx.Chain, q: torch.Tensor) -> np.ndarray:
    symbolic_chain, record = SymbolicChain.from_chain(chain), Recorder()
    symbols = joint_values(symbolic_chain)
    rows = mass_matrix(record, symbolic_chain, symbols)
    program: Program = record.program(symbols, [sympy.sympify(x) for row in rows for x in row])
    values = values_of(program, dict(zip(symbols, q.T.numpy(), strict=True)))
    return values.reshape(len(q), chain.joints, chain.joints)


def crba(chain: dx.Chain, q: np.ndarray) -> np.ndarray:
    """Mass matrix by pinocchio, every link in the axes of the world at home and about its joint's point."""
    model, parts, before = pinocchio.Model(), SymbolicChain.from_chain(chain), np.zeros(3)
    for k, kind in enumerate(chain.kinds):
        axis, point = np.array(parts.axes[k], dtype=float), np.array(parts.points[k], dtype=float)
        turns = kind == "revolute"
        joint = (pinocchio.JointModelRevoluteUnaligned if turns else pinocchio.JointModelPrismaticUnaligned)(
            axis
        )
        model.addJoint(k, joint, pinocchio.SE3(np.eye(3), point - before), str(k))
        mass, centre, tensor = (np.asarray(part[k]) for part in chain.inertias)
        model.inertias[k + 1] = pinocchio.Inertia(float(mass), centre - point, tensor)
        before = point
    M = np.triu(pinocchio.crba(model, model.createData(), q))
    return M + np.triu(M, 1).T


@WITH_MASSES
def test_the_mass_matrix_is_that_of_the_chain_and_of_pinocchio(chain):
    q = configurations(chain, 5)
    recorded = recorded_mass_matrices(chain, q)
    assert_allclose(recorded, chain.mass_matrix(q), rtol=0, atol=1e-13 * abs(recorded).max())
    for M, row in zip(recorded, q.numpy(), strict=True):
        assert_allclose(M, crba(chain, row), rtol=0, atol=1e-13 * abs(M).max())


@pytest.mark.parametrize("joints", [2, 3, 6])
def test_so_is_that_of_a_random_robot_with_slides(rng, joints):
    chain = with_random_masses(rng, joints)
    q = torch.from_numpy(rng.uniform(-2, 2, (5, joints)))
    recorded = recorded_mass_matrices(chain, q)
    assert_allclose(recorded, chain.mass_matrix(q), rtol=0, atol=1e-12 * abs(recorded).max())


def with_random_masses(rng: np.random.Generator, joints: int) -> dx.Chain:
    """A random robot, some of whose joints slide."""
    plain = random_robot(rng, joints).chain()
    factors = rng.normal(size=(joints, 3, 3))
    tensors = factors @ factors.transpose(0, 2, 1)
    inertias = (rng.uniform(0.5, 3, joints), rng.normal(size=(joints, 3)), tensors)
    return dx.Chain(plain.screws, plain.home, inertias=inertias)


# ---- dynamic manipulability ------------------------------------------------------------------------


@pytest.mark.parametrize("rows", ["full", "translational", ("vx", "wz")], ids=str)
@WITH_MASSES
def test_dynamic_manipulability_is_the_volume_of_accelerations(chain, rows):
    assert_same(chain, Index(DYNAMIC, "geometric", rows=rows), rtol=1e-10)


@pytest.mark.parametrize("frame", ["spatial", "body"])
def test_in_all_frames_with_tool_rates_and_slides(rng, frame):
    chain = with_random_masses(rng, 8)
    assert len(set(chain.kinds)) == 2
    rates = (0.5, 0.4, 0.3, 2.0, 1.0, 3.0)
    assert_same(chain, Index(DYNAMIC, frame, tool_rates=rates), rtol=1e-9)
    assert_same(chain, Index(DYNAMIC, frame, tool_rates=rates, rows="translational"), rtol=1e-9)


def test_a_locked_joint_shapes_the_masses_that_the_others_move():
    """Its torque goes to the base; but its angle still matters."""
    index = Index(DYNAMIC, "geometric", joint_rates=(1, 1, 0, 1, 1, 0), rows="translational")
    assert_same(UR5E, index, rtol=1e-10)
    assert 3 in derive(UR5E, index).matters


def test_a_joint_that_moves_no_mass_is_refused():
    none = ([1.0, 0.0], [[0.1, 0, 0], [0.6, 0, 0]], np.zeros((2, 3, 3)))
    chain = dx.Chain.from_dh([{"a": 0.5}, {"a": 0.25}], inertias=none)
    with pytest.raises(ValueError, match="moves no mass"):
        symbolic.derive(chain, Index(DYNAMIC, "geometric", rows=("vx", "vy"))).value  # noqa: B018
