"""The crane: equilibrium, energies, linear statics against a full solution and a co-rotational one."""

import dataclasses
import math

import pytest
import torch
from torch.testing import assert_close

from dexterity import crane
from dexterity.crane.equilibrium import NewtonOptions, _sag
from dexterity.crane.structure import Assembly

PATU = crane.patu655()
WHOLE = Assembly.of(PATU)


def strokes(*batch: int, seed: int = 0) -> torch.Tensor:
    unit = torch.rand(*batch, 3, generator=torch.Generator().manual_seed(seed), dtype=torch.float64)
    return unit * torch.tensor(PATU.upper, dtype=torch.float64)


def changed(**numbers: float) -> crane.Crane:
    return dataclasses.replace(PATU, structure=dataclasses.replace(PATU.structure, **numbers))


# ---- assembly --------------------------------------------------------------------------------------


def test_rest_satisfies_all_constraints_without_energy():
    pose = WHOLE.placed(strokes(50))
    q = torch.zeros(50, WHOLE.size, dtype=torch.float64)
    # The rocker of the linkage is 0.2581 long and the jib's pin 0.25812 off: rods keep the length they have.
    assert_close(WHOLE.constraints(pose, q), torch.zeros(50, 11, dtype=torch.float64), rtol=0, atol=1e-14)
    assert WHOLE.strain_energy(pose, q).abs().max() == 0
    assert_close(pose.nodes[:, -1], crane.tip_position(strokes(50)), rtol=0, atol=1e-14)
    assert_close(pose.nodes[:, 4], pose.nodes[:, 3], rtol=0, atol=1e-14)
    assert_close(pose.nodes[:, 10], pose.pins["G"], rtol=0, atol=1e-14)


def test_constraint_rows_are_the_derivatives_of_the_constraints():
    pose = WHOLE.placed(strokes(20))
    q = torch.zeros(20, WHOLE.size, dtype=torch.float64, requires_grad=True)
    gaps = WHOLE.constraints(pose, q)
    rows = torch.stack(
        [torch.autograd.grad(gap.sum(), q, retain_graph=True)[0] for gap in gaps.unbind(-1)], 1
    )
    assert_close(WHOLE.constraint_rows(pose), rows, rtol=0, atol=1e-12)


def test_every_member_is_in_equilibrium():
    pose = WHOLE.placed(strokes(20))
    forces = WHOLE.nodal_forces(pose)
    assert_close(WHOLE._rigid_modes(pose).mT @ forces, torch.zeros(20, 11, 3).double(), rtol=0, atol=1e-8)
    # The ground carries what is not carried elsewhere.
    ground = forces[:, : 3 * WHOLE.members[0].stop].unflatten(1, (-1, 3))[:, :, :2].sum(1)
    parts = PATU.structure
    mass = parts.lift_cylinder_mass + parts.jib_cylinder_mass + parts.linkage_mass
    for row in (parts.pillar, parts.lift, parts.jib, parts.extension):
        lengths = [math.dist(*pair) for pair in zip(row.nodes, row.nodes[1:], strict=False)]
        mass += parts.density * sum(a * length for a, length in zip(row.areas, lengths, strict=True))
    expected = torch.tensor([[0.0, 1.0, 0.0], [-mass * parts.gravity, 0.0, 1.0]], dtype=torch.float64)
    expected = expected.expand(20, 2, 3)
    assert_close(ground, expected, rtol=1e-9, atol=1e-8)


def full_solution(pose, loads):
    """Displacements by all coordinates and constraint forces at once."""
    n, count = len(loads), 11
    q = torch.zeros(1, WHOLE.size, dtype=torch.float64)
    matrices = []
    for i in range(n):
        one = WHOLE.placed(strokes(n)[i : i + 1])
        matrices.append(
            torch.autograd.functional.hessian(lambda q, one=one: WHOLE.strain_energy(one, q).sum(), q)[
                0, :, 0
            ]
        )
    rows = WHOLE.constraint_rows(pose)
    matrix = torch.zeros(n, WHOLE.size + count, WHOLE.size + count, dtype=torch.float64)
    matrix[:, : WHOLE.size, : WHOLE.size] = torch.stack(matrices)
    matrix[:, WHOLE.size :, : WHOLE.size], matrix[:, : WHOLE.size, WHOLE.size :] = rows * 1e9, rows.mT * 1e9
    moving = torch.cat([WHOLE.free, torch.ones(count, dtype=torch.bool)])
    solved = torch.zeros(n, WHOLE.size + count, 3, dtype=torch.float64)
    right = torch.cat([loads, torch.zeros(n, count, 3)], dim=1)[:, moving]
    solved[:, moving] = torch.linalg.solve(matrix[:, moving][:, :, moving], right)
    return solved[:, : WHOLE.size]


def test_linear_statics_is_the_full_solution():
    pose = WHOLE.placed(strokes(8))
    loads = WHOLE._loads(pose)
    q = full_solution(pose, loads)
    tip = 3 * (WHOLE.members[-1].stop - 1)
    compliance = WHOLE.compliance(pose)
    assert_close(q[:, tip : tip + 2], compliance[:, 1:], rtol=1e-7, atol=1e-13)
    # What the loads do as they are put on is what the structure stores.
    assert_close(loads.mT @ q, compliance, rtol=1e-7, atol=1e-12)


def test_compliance_is_symmetric_and_positive():
    compliance = WHOLE.compliance(WHOLE.placed(strokes(500)))
    assert_close(compliance, compliance.mT, rtol=1e-9, atol=1e-16)
    assert (torch.linalg.eigvalsh(compliance[:, 1:, 1:]) > 0).all()


# ---- deflection ------------------------------------------------------------------------------------


def test_deflection_is_affine_in_the_payload(batch_shape):
    s = strokes(*batch_shape)
    none, half, all_of_it = (
        crane.deflection(s, torch.full(batch_shape, mass)) for mass in (0.0, 250.0, 500.0)
    )
    assert none.shape == (*batch_shape, 2)
    assert_close(half, (none + all_of_it) / 2, rtol=0, atol=1e-14)
    response = crane.load_response(s)
    assert_close(response.own_weight, none)
    assert_close(none + 500 * response.per_kilogram, all_of_it)
    assert_close(crane.flexible_tip(s, 500.0), crane.tip_position(s) + all_of_it)


def test_the_tip_sags():
    s = strokes(2000)
    ahead = s[crane.tip_position(s)[:, 0] > 2]
    assert (crane.load_response(ahead).per_kilogram[:, 1] < 0).all()
    assert crane.deflection(ahead, 500.0).norm(dim=-1).max() < 0.3


def test_stiffer_parts_bend_less():
    s = strokes(100)
    own = crane.load_response(s).per_kilogram[:, 1].abs()
    stiff = crane.load_response(s, changed(bending_factor=2.0, ground_stiffness=1e7)).per_kilogram[:, 1].abs()
    assert (stiff < own).all()
    rigid = changed(youngs_modulus=2.1e17, ground_stiffness=3e12)
    assert crane.deflection(s, 500.0, rigid).abs().max() < 1e-6


def test_the_ground_alone_turns_the_crane_about_its_foot():
    soft, s = changed(youngs_modulus=2.1e17), strokes(100)
    per_kilogram = crane.load_response(s, soft).per_kilogram
    x, y = crane.tip_position(s).unbind(-1)
    turn = -x * PATU.structure.gravity / PATU.structure.ground_stiffness
    assert_close(per_kilogram, torch.stack([-y * turn, x * turn], dim=-1), rtol=1e-5, atol=1e-9)


def test_single_poses_are_those_of_a_batch():
    s = strokes(1100)
    whole = crane.deflection(s, 300.0)
    for i in (0, 511, 512, 1099):
        assert_close(crane.deflection(s[i], 300.0), whole[i], rtol=0, atol=1e-14)


@pytest.mark.parametrize("payload", [-1.0, 501.0, [10.0, 600.0], math.nan])
def test_a_load_beyond_the_rating_is_refused(payload):
    for function in (crane.deflection, crane.flexible_tip, crane.corotational_deflection):
        with pytest.raises(ValueError, match="payload"):
            function([[0.1, 0.1, 0.1]] * 2, payload)


@pytest.mark.parametrize(
    ("s", "named"),
    [
        ([0.1, 0.1, -0.1], "s3 = -0.1"),
        ([0.1, 0.1, 1.95], "s3 = 1.95"),
        ([0.7, 0, 0], "lift"),
        ([0, 0.9, 0], "jib"),
    ],
)
def test_a_structure_that_cannot_be_is_refused(s, named):
    for function in (crane.deflection, crane.corotational_deflection):
        with pytest.raises(ValueError, match=f"strokes.*{named}"):
            function(s, 100.0)


# ---- the co-rotational judge -----------------------------------------------------------------------


def test_under_small_loads_both_agree():
    """The difference falls with the square of the loads."""
    s, differences = strokes(20), []
    for factor in (1e-3, 1e-2):
        light = changed(gravity=9.81 * factor)
        sag = crane.corotational_deflection(s, 400.0, light)
        assert sag.converged.all()
        differences.append((sag.deflection - crane.deflection(s, 400.0, light)).norm(dim=-1))
    assert differences[0].max() < 1e-8
    assert_close(differences[1] / differences[0], torch.full((20,), 100.0).double(), rtol=0.2, atol=0)


def test_under_its_rating_linear_statics_misses_a_few_millimetres():
    s = strokes(100)
    sag = crane.corotational_deflection(s, 500.0)
    assert sag.converged.all()
    miss = (sag.deflection - crane.deflection(s, 500.0)).norm(dim=-1)
    assert 1e-4 < miss.mean() < 1e-3
    assert miss.max() < 5e-3


def test_forces_and_gaps_vanish_where_it_comes_to_rest():
    s = strokes(5)
    pose, rest = WHOLE.placed(s), _sag(WHOLE, s, torch.full((5,), 500.0).double(), NewtonOptions())
    assert WHOLE.constraints(pose, rest.q).abs().max() < 1e-12
    q = rest.q.clone().requires_grad_()
    total = WHOLE.strain_energy(pose, q) + WHOLE.gravity_potential(pose, q)
    total = total + 500 * 9.81 * WHOLE.tip(q)[:, 1] + (rest.forces * WHOLE.constraints(pose, q)).sum(-1)
    (residual,) = torch.autograd.grad(total.sum(), q)
    assert residual[:, WHOLE.free].abs().max() < 1e-3  # [N], of tens of thousands
    steps = _sag(WHOLE, s, torch.full((5,), 500.0).double(), NewtonOptions(load_steps=3))
    assert_close(steps.q, rest.q, rtol=0, atol=1e-9)


def test_what_is_not_found_is_flagged():
    sag = crane.corotational_deflection(strokes(3), 500.0, options=NewtonOptions(iterations=1))
    assert not sag.converged.any()
    assert sag.deflection.isnan().all()


def test_batches_of_the_judge(batch_shape):
    sag = crane.corotational_deflection(strokes(*batch_shape), 100.0)
    assert sag.deflection.shape == (*batch_shape, 2)
    assert sag.converged.shape == batch_shape
    each = crane.corotational_deflection([0.3, 0.3, 0.5], [0.0, 500.0])
    assert each.deflection.shape == (2, 2)


# ---- fitted ----------------------------------------------------------------------------------------


def test_the_two_fitted_numbers_meet_their_two_targets():
    s = crane.inverse(crane.TEST_POINTS).strokes
    sag = crane.deflection(s[:, None], crane.TEST_PAYLOADS).norm(dim=-1) * 1e3
    assert sag.mean().item() == pytest.approx(31.9331, abs=0.01)
    assert sag.max().item() == pytest.approx(129.6755, abs=0.02)
