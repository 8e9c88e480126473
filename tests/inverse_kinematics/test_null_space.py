"""Pseudo-inverses against numpy, and steps that leave the tool where it is."""

import math
from math import pi

import numpy as np
import pytest
import torch
from arms import IIWA, PANDA, random_configurations
from torch.testing import assert_close

import dexterity as dx
from dexterity.inverse_kinematics import (
    damped_pseudo_inverse,
    null_space_projector,
    null_space_step,
    within_limits,
)

# ---- pseudo-inverses --------------------------------------------------------------------------------------


@pytest.mark.parametrize("shape", [(6, 7), (6, 6), (6, 4), (3, 7), (4, 2, 6, 7)])
def test_without_damping_it_is_moore_and_penroses(rng, shape):
    J = rng.normal(size=shape)
    assert_close(damped_pseudo_inverse(J), torch.from_numpy(np.linalg.pinv(J)), rtol=0, atol=1e-10)
    J[..., 1, :] = J[..., 0, :]
    assert_close(damped_pseudo_inverse(J), torch.from_numpy(np.linalg.pinv(J)), rtol=0, atol=1e-8)


def test_damping_and_weights_solve_their_least_squares_problem(rng):
    """Minimise qᵀWq + ‖x − Jq‖²/λ²: the normal equations, solved without the package."""
    J, x, weights = rng.normal(size=(6, 7)), rng.normal(size=6), rng.uniform(0.2, 5, 7)
    for damping in (1e-2, 0.3):
        expected = np.linalg.solve(np.diag(weights) + J.T @ J / damping**2, J.T @ x / damping**2)
        found = damped_pseudo_inverse(J, damping, weights) @ torch.from_numpy(x)
        assert_close(found, torch.from_numpy(expected), rtol=1e-8, atol=0)


def test_damping_bounds_rates_at_a_singularity():
    J = PANDA.body_jacobian(torch.zeros(7))
    assert damped_pseudo_inverse(J, 0.05).abs().max() <= 1 / (2 * 0.05) + 1e-9


def test_an_infinite_weight_locks_a_joint(rng):
    J = rng.normal(size=(6, 8))
    weights = np.ones(8)
    weights[[2, 5]] = math.inf
    for inverse in (damped_pseudo_inverse(J, 0.0, weights), damped_pseudo_inverse(J, 0.1, weights)):
        assert (inverse[[2, 5]] == 0).all()
    projector = null_space_projector(J[:4], weights)
    assert (projector[[2, 5]] == 0).all()
    assert (projector[:, [2, 5]] == 0).all()


@pytest.mark.parametrize("weighted", [False, True])
def test_the_projector(rng, weighted):
    J = rng.normal(size=(5, 6, 9))
    N = null_space_projector(J, rng.uniform(0.1, 3, 9) if weighted else None)
    assert_close(torch.from_numpy(J) @ N, torch.zeros(5, 6, 9, dtype=torch.float64), rtol=0, atol=1e-12)
    assert_close(N @ N, N, rtol=0, atol=1e-12)
    assert torch.linalg.matrix_rank(N, atol=1e-9).tolist() == [3] * 5


def test_a_damped_inverse_is_differentiable(rng):
    J = torch.from_numpy(rng.normal(size=(3, 4))).requires_grad_()
    torch.autograd.gradcheck(lambda J: damped_pseudo_inverse(J, 0.1), J)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((np.ones(6),), r"^J has shape \(6,\)"),
        ((np.full((6, 7), math.nan),), "^J is not finite"),
        ((np.ones((6, 7)), -1.0), "^damping is -1.0"),
        ((np.ones((6, 7)), math.nan), "^damping is nan"),
        ((np.ones((6, 7)), 0.0, np.ones(6)), r"^weights has shape \(6,\)"),
        ((np.ones((6, 7)), 0.0, np.zeros(7)), "^weights holds 0"),
    ],
    ids=str,
)
def test_bad_arguments_are_refused_by_name(arguments, message):
    with pytest.raises(ValueError, match=message):
        damped_pseudo_inverse(*arguments)


# ---- steps -------------------------------------------------------------------------------------------------


def with_rates(chain: dx.Chain, rates) -> dx.Chain:
    return dx.Chain(chain.screws, chain.home, lower=chain.lower, upper=chain.upper, rates=rates)


ALPHA = dx.Chain.from_dh(
    [{"d": 0.0462, "a": 0.02, "alpha": pi / 2}, {"a": 0.15}, {"a": 0.02, "alpha": -pi / 2},
     {"d": 0.18, "alpha": pi / 2}, {"d": 0.05}],
    lower=[0, 0, 0, 0, -pi], upper=[6.1, 3.5, 3.5, 3.5, pi], rates=[0.5] * 5,
)  # fmt: skip
ROV = ALPHA.on_vehicle(dx.spatial.translation(0.2, 0, -0.1), rates=[1.5, 1.5, 1.0, 0, 0, 1.0])
# Name: chain, start, gain, w at the start and after fifty steps of a loop written by hand (a review).
RUNS = {
    "UVMS": (dx.robots.uvms(), [0, 0, 0, 0.05, -0.1, 0.2, 0.3, 0.6, -0.9, 0.4, 0.7, 0], 0.1, 10.96, 12.91),
    "Panda": (
        with_rates(PANDA, [2.175] * 4 + [2.61] * 3), [0.5, -0.7, 0.6, -2.3, 0.3, 1.7, 0.5],
        0.02, 13.33, 14.78,
    ),
    "ROV": (ROV, [0, 0, 0, 0, 0, 0.1, 0.3, 0.9, 1.1, 0.4, 0.2], 0.1, 0.992, 1.057),
}  # fmt: skip


@pytest.mark.parametrize("name", RUNS)
def test_fifty_steps_raise_w_at_a_fixed_pose(name):
    chain, q, gain, before, after = RUNS[name]
    w = dx.symbolic.compile_index(chain, dx.indices.Index("manipulability"))
    pose = chain.forward(q)
    weights = torch.where(chain.rates > 0, chain.rates**-2, torch.inf) if name == "ROV" else None
    assert w(q) == pytest.approx(before, rel=1e-3)
    for _ in range(50):
        q = null_space_step(chain, q, w, gain=gain, pose=pose, weights=weights)
        assert (chain.forward(q) - pose).abs().max() < 1e-9
        assert within_limits(chain, q, 0.0)
    assert w(q) == pytest.approx(after, rel=2e-3)
    assert (q[3:5] == 0).all() or name != "ROV"


def test_joints_stay_within_their_limits():
    """Starts at a limit, with a gradient that pushes against it."""
    q = random_configurations(IIWA, 40)
    q[:20, 1], q[20:, 3] = IIWA.upper[1], IIWA.lower[3]
    gradient = torch.zeros_like(q)
    gradient[:20, 1], gradient[20:, 3] = 1.0, -1.0
    gradient[:, 2] = 0.5
    moved = null_space_step(IIWA, q, gradient, gain=0.3)
    assert ((moved >= IIWA.lower) & (moved <= IIWA.upper)).all()
    assert (IIWA.forward(moved) - IIWA.forward(q)).abs().max() < 1e-8
    # The one motion that is left may be the one that the limit stops.
    assert 0.4 < ((moved - q).abs().amax(-1) > 1e-3).double().mean() < 0.9


def test_batches_equal_single_steps(batch_shape):
    q = random_configurations(PANDA, math.prod(batch_shape)).reshape(*batch_shape, 7)
    w = dx.indices.Index("manipulability").bind(PANDA)
    moved = null_space_step(PANDA, q, w, gain=0.05)
    assert moved.shape == q.shape
    for i in np.ndindex(*batch_shape):
        assert_close(moved[i], null_space_step(PANDA, q[i], w, gain=0.05), rtol=0, atol=1e-9)


def test_inference_mode_changes_nothing():
    q = torch.tensor([0.5, -0.7, 0.6, -2.3, 0.3, 1.7, 0.5], dtype=torch.float64)
    w = dx.indices.Index("manipulability").bind(PANDA)
    expected = null_space_step(PANDA, q, w, gain=0.05)
    with torch.inference_mode():
        assert_close(null_space_step(PANDA, q, w, gain=0.05), expected, rtol=0, atol=0)


def test_rows_that_are_free_move_the_tool():
    q = torch.tensor([0.5, -0.7, 0.6, -2.3, 0.3, 1.7, 0.5], dtype=torch.float64)
    w = dx.indices.Index("manipulability", rows="translational").bind(PANDA)
    moved = null_space_step(PANDA, q, w, rows="translational", gain=0.5)
    away = PANDA.forward(moved) - PANDA.forward(q)
    assert away[:3, 3].abs().max() < 1e-9
    assert away[:3, :3].abs().max() > 1e-3
    assert w(moved) > w(q)


def test_a_chain_without_redundancy_does_not_move():
    puma = dx.robots.puma560()
    q = torch.tensor([0.1, 0.5, 0.25, 0.3, 0.5, 0.2], dtype=torch.float64)
    assert_close(null_space_step(puma, q, torch.ones(6)), q, rtol=0, atol=1e-9)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"gain": 0.0}, "^gain is 0.0"),
        ({"gain": math.inf}, "^gain is inf"),
        ({"objective": torch.ones(6)}, r"^objective has a gradient of shape \(6,\)"),
        ({"objective": lambda q: torch.ones(())}, "^objective cannot be differentiated"),
        ({"q": [9.0] * 7}, "^q is beyond the limits"),
        ({"q": [0.0] * 6}, r"^q has shape \(6,\)"),
        ({"pose": np.ones((4, 4))}, "^pose is not a rigid-body pose"),
        ({"rows": "some"}, "^rows is 'some'"),
        ({"frame": "spatial"}, "^frame is 'spatial'"),
        ({"weights": [1.0] * 6}, r"^weights has shape \(6,\)"),
    ],
)
def test_bad_steps_are_refused_by_name(options, message, annotations_unchecked):
    q = options.pop("q", [0.5, -0.7, 0.6, -2.3, 0.3, 1.7, 0.5])
    objective = options.pop("objective", torch.ones(7))
    with pytest.raises(ValueError, match=message):
        null_space_step(PANDA, q, objective, **options)


def test_a_name_is_no_objective_and_the_error_says_what_is(annotations_unchecked):
    with pytest.raises(
        TypeError, match=r"^objective is 'w'; an index is needed, such as dexterity.Index\('w', "
    ):
        null_space_step(PANDA, [0, -0.8, 0, -2.4, 0, 1.6, 0.8], "w")


def test_a_start_beyond_the_limits_is_refused_by_its_joints():
    with pytest.raises(ValueError, match=r"beyond the limits of the chain at joint 2, joint 4; "):
        null_space_step(PANDA, [0, 3.0, 0, 0, 0, 1.6, 0.8], dx.Index("w", "geometric"))


def test_rows_are_held_along_the_axes_of_the_world():
    """A glass that is carried: its height and its tilt are held, and its heading and its place are free."""
    panda = dx.robots.panda()
    q = torch.tensor([0.5, -0.7, 0.6, -2.3, 0.3, 1.7, 0.5], dtype=torch.float64)
    T, w = panda.forward(q), dx.Index("manipulability", "geometric").bind(panda)
    moved = dx.inverse_kinematics.null_space_step(
        panda, q, w, gain=0.05, rows=("vz", "wx", "wy"), frame="geometric"
    )
    away = panda.forward(moved)
    assert w(moved) > w(q)
    assert (away[2] - T[2]).abs().max() < 1e-8
    assert (away[:2] - T[:2]).abs().max() > 1e-3
