"""Poses and twists: axioms of SE(3), scipy's matrix exponential, digits near zero and near π, gradients."""

import itertools
import math

import numpy as np
import pytest
import scipy.linalg
import torch
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from torch.testing import assert_close

from dexterity import spatial

ANGLES = [
    0,
    1e-300,
    1e-160,
    1e-12,
    1e-8,
    1e-4,
    0.1,
    0.5 - 1e-12,
    0.5 + 1e-12,
    1,
    2,
    3,
    math.pi - 1e-6,
    math.pi - 1e-12,
]
AXES = [
    np.array(signs) / np.linalg.norm(signs) for signs in itertools.product([-1, 0, 1], repeat=3) if any(signs)
]

# Functions of one argument, the name that their errors give it, and the trailing shape that it must have.
FUNCTIONS_OF_POSES = [
    (spatial.log, "T"),
    (spatial.adjoint, "T"),
    (spatial.inverse_adjoint, "T"),
    (spatial.inverse, "T"),
    (spatial.compose, r"poses\[0\]"),
]
FUNCTIONS_OF_VECTORS = [(spatial.exp, "twist"), (spatial.hat, "vector"), (spatial.vee, "matrix")]


def random_twists(rng: np.random.Generator, shape: tuple[int, ...]) -> torch.Tensor:
    """Return twists (*shape, 6) whose angles stay below π."""
    v = rng.normal(size=(*shape, 3))
    omega = rng.normal(size=(*shape, 3))
    angle = rng.uniform(0, 3.1, size=(*shape, 1))
    return torch.from_numpy(
        np.concatenate([v, angle * omega / np.linalg.norm(omega, axis=-1, keepdims=True)], -1)
    )


def twists_about_all_axes(rng: np.random.Generator, angle: float) -> torch.Tensor:
    """Twists (26, 6) that turn by one angle about each axis with components 0 or of equal size."""
    return torch.from_numpy(np.concatenate([rng.normal(size=(len(AXES), 3)), angle * np.array(AXES)], axis=1))


def random_poses(rng: np.random.Generator, shape: tuple[int, ...]) -> torch.Tensor:
    return spatial.exp(random_twists(rng, shape))


def scipy_exponential(twist: NDArray[np.float64]) -> NDArray[np.float64]:
    """Matrix exponential of one twist, written without the package."""
    vx, vy, vz, x, y, z = twist
    return scipy.linalg.expm(np.array([[0, -z, y, vx], [z, 0, -x, vy], [-y, x, 0, vz], [0, 0, 0, 0]]))


# ---- the group --------------------------------------------------------------------------------------


def test_poses_form_a_group(rng, batch_shape):
    a, b, c = (random_poses(rng, batch_shape) for _ in range(3))
    identity = torch.eye(4, dtype=torch.float64).expand(*batch_shape, 4, 4)
    assert_close(spatial.compose(spatial.compose(a, b), c), spatial.compose(a, spatial.compose(b, c)))
    assert_close(spatial.compose(a, identity), a, rtol=0, atol=0)
    assert_close(spatial.compose(a, spatial.inverse(a)), identity, rtol=0, atol=1e-14)
    assert_close(spatial.compose(spatial.inverse(a), a), identity, rtol=0, atol=1e-14)
    spatial.require_rigid(spatial.compose(a, b, c), "the product")


def test_batch_axes_of_a_product_broadcast(rng):
    a, b = random_poses(rng, (3, 1)), random_poses(rng, (2,))
    product = spatial.compose(a, b)
    assert product.shape == (3, 2, 4, 4)
    assert_close(product[2, 1], a[2, 0] @ b[1])


def test_pose_joins_a_rotation_and_a_translation(rng, batch_shape):
    T = random_poses(rng, batch_shape)
    assert_close(spatial.pose(T[..., :3, :3], T[..., :3, 3]), T, rtol=0, atol=0)


def test_pose_broadcasts_one_rotation_over_many_translations(rng):
    R = random_poses(rng, ())[:3, :3]
    p = torch.from_numpy(rng.normal(size=(5, 3)))
    T = spatial.pose(R, p)
    assert T.shape == (5, 4, 4)
    assert_close(T[:, :3, 3], p, rtol=0, atol=0)


# ---- exponential and logarithm ----------------------------------------------------------------------


def test_exponential_is_scipys(rng, batch_shape):
    twists = random_twists(rng, batch_shape)
    expected = [scipy_exponential(twist) for twist in twists.reshape(-1, 6).numpy()]
    expected = torch.from_numpy(np.array(expected).reshape(*batch_shape, 4, 4))
    assert_close(spatial.exp(twists), expected, rtol=0, atol=1e-14)


@pytest.mark.parametrize("angle", [*ANGLES, math.pi, 5, 2 * math.pi, 20])
def test_exponential_is_scipys_at_every_angle(rng, angle):
    twists = twists_about_all_axes(rng, angle)
    expected = torch.from_numpy(np.array([scipy_exponential(twist) for twist in twists.numpy()]))
    assert_close(spatial.exp(twists), expected, rtol=0, atol=2e-15 * max(8, angle**2))


@pytest.mark.parametrize("angle", ANGLES)
def test_logarithm_undoes_the_exponential(rng, angle):
    twists = twists_about_all_axes(rng, angle)
    recovered = spatial.log(spatial.exp(twists))
    assert_close(recovered[:, :3], twists[:, :3], rtol=0, atol=2e-14)
    # Relative to the angle, so that even 1e-300 is recovered with all its digits.
    assert_close(recovered[:, 3:], twists[:, 3:], rtol=0, atol=4e-15 * angle)


def test_logarithm_undoes_the_exponential_in_batches(rng, batch_shape):
    twists = random_twists(rng, batch_shape)
    assert_close(spatial.log(spatial.exp(twists)), twists, rtol=0, atol=2e-13)


@pytest.mark.parametrize("axis", AXES, ids=str)
def test_a_half_turn_has_the_axis_whose_first_component_is_positive(rng, axis):
    T = np.eye(4)
    T[:3, :3] = 2 * np.outer(axis, axis) - np.eye(3)
    T[:3, 3] = rng.normal(size=3)
    twist = spatial.log(T)
    towards = axis * np.sign(axis[np.flatnonzero(axis)[0]])
    assert_close(twist[3:], torch.from_numpy(math.pi * towards), rtol=4e-16, atol=4e-16)
    assert_close(spatial.exp(twist), torch.from_numpy(T), rtol=0, atol=2e-15)


@pytest.mark.parametrize(
    "angle", [math.pi, math.nextafter(math.pi, 4), math.pi + 1e-12, 4, 2 * math.pi, 7, -3.5]
)
def test_exponential_undoes_the_logarithm_beyond_a_half_turn(rng, angle):
    T = spatial.exp(twists_about_all_axes(rng, angle))
    shortest = spatial.log(T)
    assert shortest[:, 3:].norm(dim=1).max() <= math.pi * (1 + 1e-15)
    assert_close(spatial.exp(shortest), T, rtol=0, atol=2e-14)


def test_logarithm_of_the_identity_is_zero():
    assert_close(spatial.log(torch.eye(4)), torch.zeros(6, dtype=torch.float64), rtol=0, atol=0)


def test_logarithm_of_a_translation_is_that_translation(rng):
    T = np.eye(4)
    T[:3, 3] = p = rng.normal(size=3)
    assert_close(spatial.log(T), torch.from_numpy(np.concatenate([p, np.zeros(3)])), rtol=0, atol=0)


# ---- adjoint, hat and vee ---------------------------------------------------------------------------


def test_adjoint_of_a_product_is_the_product_of_adjoints(rng, batch_shape):
    a, b = random_poses(rng, batch_shape), random_poses(rng, batch_shape)
    assert_close(spatial.adjoint(spatial.compose(a, b)), spatial.adjoint(a) @ spatial.adjoint(b))


def test_inverse_adjoint_undoes_the_adjoint(rng, batch_shape):
    T = random_poses(rng, batch_shape)
    product = spatial.inverse_adjoint(T) @ spatial.adjoint(T)
    assert_close(product, torch.eye(6, dtype=torch.float64).expand(*batch_shape, 6, 6), rtol=0, atol=1e-13)
    assert_close(spatial.inverse_adjoint(T), spatial.adjoint(spatial.inverse(T)))


def test_adjoint_moves_a_twist_as_conjugation_does(rng, batch_shape):
    T, twist = random_poses(rng, batch_shape), random_twists(rng, batch_shape)
    moved = (spatial.adjoint(T) @ twist[..., None])[..., 0]
    assert_close(spatial.hat(moved), T @ spatial.hat(twist) @ spatial.inverse(T))
    conjugated = spatial.compose(T, spatial.exp(twist), spatial.inverse(T))
    assert_close(spatial.exp(moved), conjugated, rtol=0, atol=1e-13)


def test_adjoint_is_the_derivative_of_conjugation(rng):
    T = random_poses(rng, ())
    h = 1e-3
    columns = []
    for twist in torch.eye(6, dtype=torch.float64):
        steps = [spatial.compose(T, spatial.exp(k * h * twist), spatial.inverse(T)) for k in (-2, -1, 1, 2)]
        derivative = (steps[0] - 8 * steps[1] + 8 * steps[2] - steps[3]) / (12 * h)
        columns.append([*derivative[:3, 3], derivative[2, 1], derivative[0, 2], derivative[1, 0]])
    assert_close(spatial.adjoint(T), torch.tensor(columns, dtype=torch.float64).T, rtol=0, atol=1e-11)


@pytest.mark.parametrize("size", [3, 6])
def test_vee_undoes_hat(rng, batch_shape, size):
    vector = torch.from_numpy(rng.normal(size=(*batch_shape, size)))
    assert_close(spatial.vee(spatial.hat(vector)), vector, rtol=0, atol=0)


def test_hat_is_the_cross_product(rng):
    a, b = torch.from_numpy(rng.normal(size=(2, 5, 3)))
    assert_close((spatial.hat(a) @ b[..., None])[..., 0], torch.linalg.cross(a, b))


# ---- gradients --------------------------------------------------------------------------------------


@pytest.mark.parametrize("angle", [0, 1e-300, 1e-8, 0.5, 0.5 - 5e-7, 1, 3, math.pi, 7])
def test_exponential_has_the_right_gradient(rng, angle):
    for axis in AXES[::9]:
        twist = torch.from_numpy(np.concatenate([rng.normal(size=3), angle * axis])).requires_grad_()
        torch.autograd.gradcheck(spatial.exp, twist)


@pytest.mark.parametrize(
    "angle", [0, 1e-300, 1e-12, 1e-6, 1e-4, 0.01, 0.5 - 1e-12, 0.5 + 1e-12, 1, 3, math.pi]
)
def test_the_gradient_of_the_exponential_keeps_its_digits(rng, angle):
    """Against dT T⁻¹ = ∫₀¹ exp(s ad) ds, which is the corner of a matrix exponential."""
    for twist in twists_about_all_axes(rng, angle)[::5]:
        W, V = spatial.hat(twist[3:]), spatial.hat(twist[:3])
        ad = torch.cat([torch.cat([W, V], dim=1), torch.cat([0 * W, W], dim=1)])
        block = np.zeros((12, 12))
        block[:6, :6], block[:6, 6:] = ad, np.eye(6)
        expected = torch.from_numpy(scipy.linalg.expm(block)[:6, 6:])
        dT = torch.func.jacrev(spatial.exp)(twist).permute(2, 0, 1)
        columns = dT @ spatial.inverse(spatial.exp(twist))
        linear, angular = columns[:, :3, 3], columns[:, [2, 0, 1], [1, 2, 0]]
        assert_close(torch.cat([linear, angular], dim=1).T, expected, rtol=0, atol=2e-14)


@pytest.mark.parametrize("angle", [0, 0.5])
def test_exponential_has_the_right_second_gradient(angle):
    twist = torch.tensor(
        [0.3, -0.2, 0.5, 0, 0.6 * angle, 0.8 * angle], dtype=torch.float64, requires_grad=True
    )
    torch.autograd.gradgradcheck(spatial.exp, twist)


@pytest.mark.parametrize("angle", [0, 1e-300, 1e-8, 0.02, 0.5, 1, 3, math.pi - 1e-4])
def test_logarithm_has_the_right_gradient(rng, angle):
    # Steps are taken on the group, because a pose with one entry moved is none.
    step = torch.zeros(6, dtype=torch.float64, requires_grad=True)
    for axis in AXES[::9]:
        T = spatial.exp(np.concatenate([rng.normal(size=3), angle * axis]))
        torch.autograd.gradcheck(lambda step, T=T: spatial.log(T @ spatial.exp(step)), step)


def test_adjoint_and_inverse_have_the_right_gradient(rng):
    twist = random_twists(rng, (2,)).requires_grad_()
    torch.autograd.gradcheck(lambda twist: spatial.inverse_adjoint(spatial.exp(twist)), twist)


# ---- what goes in -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "value",
    [
        [0, 1, 0, 0, 0, 2],
        (0, 1, 0, 0, 0, 2.0),
        np.array([0, 1, 0, 0, 0, 2]),
        np.array([0, 1, 0, 0, 0, 2], dtype=np.float32),
        np.array([2, 0, 0, 0, 1, 0])[::-1],
        torch.tensor([0, 1, 0, 0, 0, 2]),
        torch.tensor([0, 1, 0, 0, 0, 2], dtype=torch.float32),
        torch.tensor([0, 1, 0, 0, 0, 2], dtype=torch.float16),
    ],
    ids=["list", "tuple", "numpy int64", "numpy float32", "reversed view", "int64", "float32", "float16"],
)
def test_real_numbers_are_raised_to_float64(value):
    expected = spatial.exp(torch.tensor([0, 1, 0, 0, 0, 2], dtype=torch.float64))
    assert_close(spatial.exp(value), expected, rtol=0, atol=0)


def test_python_floats_keep_all_their_digits():
    assert spatial.to_float64(0.1, "x").item() == 0.1
    assert spatial.to_float64([0.1, 1e300], "x").tolist() == [0.1, 1e300]


def test_a_read_only_array_is_taken_without_a_warning():
    array = np.arange(6.0)
    array.flags.writeable = False
    assert_close(spatial.to_float64(array, "x"), torch.arange(6, dtype=torch.float64))


def test_a_float64_tensor_is_not_copied():
    tensor = torch.zeros(6, dtype=torch.float64)
    assert spatial.to_float64(tensor, "x") is tensor


def test_extended_numbers_may_be_infinite_but_not_nan():
    assert spatial.to_extended_float64([1, math.inf], "limit").tolist() == [1, math.inf]
    with pytest.raises(ValueError, match=r"^limit holds NaN"):
        spatial.to_extended_float64([1, math.nan], "limit")
    with pytest.raises(TypeError, match=r"^limit holds torch.bool"):
        spatial.to_extended_float64([True], "limit")


@pytest.mark.parametrize(
    "value",
    [
        [True, False],
        np.array([True]),
        torch.tensor([True]),
        [1j, 0],
        np.array([1j]),
        torch.tensor([1 + 0j]),
        [[1.0], [1.0, 2.0]],
        np.array(["1.0"]),
        np.array([None]),
    ],
    ids=str,
)
def test_what_is_no_real_number_is_refused(value):
    with pytest.raises(TypeError, match=r"^speed "):
        spatial.to_float64(value, "speed")


@pytest.mark.parametrize("poison", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize(
    ("function", "name", "good"),
    [(function, name, np.eye(4)) for function, name in FUNCTIONS_OF_POSES]
    + [(function, name, np.zeros(6)) for function, name in FUNCTIONS_OF_VECTORS[:2]]
    + [(spatial.vee, "matrix", np.zeros((4, 4)))],
)
def test_what_is_not_finite_is_refused(function, name, good, poison):
    for position in range(good.size):
        bad = good.copy()
        bad.flat[position] = poison
        with pytest.raises(ValueError, match=f"^{name} is not finite"):
            function(bad)


shapes = st.lists(st.integers(0, 7), max_size=3).map(tuple)


@pytest.mark.parametrize(("function", "name"), FUNCTIONS_OF_POSES)
@given(shape=shapes.filter(lambda shape: shape[-2:] != (4, 4)))
def test_a_pose_of_the_wrong_shape_is_refused(function, name, shape):
    with pytest.raises(ValueError, match=rf"^{name} has shape .*4, 4\) is needed"):
        function(np.zeros(shape))


@given(shape=shapes.filter(lambda shape: shape[-1:] != (6,)))
def test_a_twist_of_the_wrong_shape_is_refused(shape):
    with pytest.raises(ValueError, match=r"^twist has shape .*\(\.\.\., 6\) is needed"):
        spatial.exp(np.zeros(shape))


@given(shape=shapes.filter(lambda shape: shape[-1:] not in ((3,), (6,))))
def test_hat_refuses_the_wrong_shape(shape):
    with pytest.raises(ValueError, match=r"^vector has shape"):
        spatial.hat(np.zeros(shape))


@given(shape=shapes.filter(lambda shape: shape[-2:] not in ((3, 3), (4, 4))))
def test_vee_refuses_the_wrong_shape(shape):
    with pytest.raises(ValueError, match=r"^matrix has shape"):
        spatial.vee(np.zeros(shape))


@pytest.mark.parametrize("matrix", [np.eye(3), np.eye(4), np.ones((3, 3)), np.diag([0, 0, 0, 1.0])], ids=str)
def test_vee_refuses_what_is_no_hat(matrix):
    with pytest.raises(ValueError, match=r"^matrix is not the hat of a vector"):
        spatial.vee(matrix)


BAD_POSES = [
    (np.diag([1, 1, 1, 2.0]), "last row"),
    (np.eye(4) + 0.1 * np.eye(4)[:, [1, 2, 3, 0]].T, "last row"),
    (np.diag([1.001, 1, 1, 1]), "orthonormality"),
    (np.diag([0, 0, 0, 1.0]), "orthonormality"),
    (np.diag([-1, 1, 1, 1.0]), "reflection"),
    (-np.diag([1, 1, 1, -1.0]), "reflection"),
]


@pytest.mark.parametrize(("T", "reason"), BAD_POSES, ids=[reason for _, reason in BAD_POSES])
def test_a_matrix_that_is_no_rigid_pose_is_refused(T, reason):
    with pytest.raises(ValueError, match=f"^home is not a rigid-body pose.*{reason}"):
        spatial.require_rigid(T, "home")
    for function in (spatial.log, spatial.adjoint, spatial.inverse, spatial.inverse_adjoint):
        with pytest.raises(ValueError, match=f"^T is not a rigid-body pose.*{reason}"):
            function(T)


def test_one_bad_pose_in_a_batch_is_refused(rng):
    T = random_poses(rng, (5,))
    T[3, 0, 0] += 1e-3
    with pytest.raises(ValueError, match=r"^T is not a rigid-body pose"):
        spatial.log(T)


def test_pose_refuses_a_bad_rotation_or_shape():
    with pytest.raises(ValueError, match=r"^rotation is not a rigid-body pose"):
        spatial.pose(2 * np.eye(3), np.zeros(3))
    with pytest.raises(ValueError, match=r"^rotation has shape"):
        spatial.pose(np.eye(4), np.zeros(3))
    with pytest.raises(ValueError, match=r"^translation has shape"):
        spatial.pose(np.eye(3), np.zeros(4))


def test_pose_refuses_batch_axes_that_do_not_broadcast():
    with pytest.raises(ValueError, match=r"^rotation and translation have batch axes \(2,\) and \(5,\)"):
        spatial.pose(np.broadcast_to(np.eye(3), (2, 3, 3)), np.zeros((5, 3)))


def test_a_product_of_nothing_is_refused():
    with pytest.raises(ValueError, match=r"^poses is empty"):
        spatial.compose()


def test_a_product_of_batches_that_do_not_broadcast_is_refused():
    with pytest.raises(ValueError, match=r"^poses\[0\] and poses\[1\] have batch axes \(2,\) and \(3,\)"):
        spatial.compose(np.zeros((2, 4, 4)), np.zeros((3, 4, 4)))
