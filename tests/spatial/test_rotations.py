"""Nearest rotations, quaternions and roll-pitch-yaw angles against scipy, and the policy of tolerances."""

import math

import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation
from torch.testing import assert_close

import dexterity as dx
from dexterity import spatial

angles = st.floats(-10, 10)


def rotations(rng, shape=(50,)) -> torch.Tensor:
    count = math.prod(shape)
    return torch.from_numpy(Rotation.random(count, rng).as_matrix().reshape(*shape, 3, 3))


PYPOSE_83 = [[0.33638, -0.01749, 0.94156], [-0.02078, -0.99972, -0.01114], [0.94150, -0.01582, -0.33665]]


# ---- rotations that are right to six digits (spatialmath#6, pyquaternion#33, transforms3d#3, pypose#83) ----


def six_digit_rotations() -> dict[str, np.ndarray]:
    R = spatial.exp([0, 0, 0, 0.3, 0.4, 0.5])[:3, :3].numpy()
    return {"float32": R.astype(np.float32), "rounded": R.round(6), "pypose#83": np.array(PYPOSE_83)}


@pytest.mark.parametrize("R", six_digit_rotations().values(), ids=six_digit_rotations())
def test_a_rotation_right_to_six_digits_is_taken_as_its_nearest_rotation(R):
    assert 1e-9 < spatial.rotation_miss(R) < 1e-5
    U, _, Vh = np.linalg.svd(R.astype(np.float64))
    T = spatial.pose(R, [1.0, 2.0, 3.0])
    assert_close(T[:3, :3], torch.from_numpy(U @ Vh), rtol=0, atol=1e-15)
    assert_close(spatial.nearest_rotation(R), torch.from_numpy(U @ Vh), rtol=0, atol=1e-15)
    raw = np.eye(4)
    raw[:3, :3] = R
    for function in (spatial.log, spatial.adjoint, spatial.inverse):
        assert_close(function(raw), function(spatial.nearest_rigid(raw)), rtol=0, atol=1e-15)


def test_only_the_poses_of_a_batch_that_miss_are_changed(rng):
    T = spatial.pose(rotations(rng), torch.zeros(50, 3))
    rough = T.clone()
    rough[7, :3, :3] = (rough[7, :3, :3] * 1e6).round() / 1e6
    taken = spatial.require_rigid(rough, "T")
    others = torch.arange(50) != 7
    assert_close(taken[others], T[others], rtol=0, atol=0)
    assert spatial.rotation_miss(taken).max() < 1e-14


@pytest.mark.parametrize("miss", [2e-5, 1e-3])
def test_larger_misses_are_refused_and_repaired_on_demand(miss):
    R = np.eye(3)
    R[0, 1] = miss
    with pytest.raises(ValueError, match=r"^rotation is not a rigid-body pose.*nearest_rigid"):
        spatial.pose(R, np.zeros(3))
    assert spatial.rotation_miss(spatial.nearest_rotation(R)) < 1e-15


@pytest.mark.parametrize(
    ("matrix", "message"),
    [
        (np.diag([1, 1, -1.0]), "reflection"),
        (np.diag([1, 1, 0.0]), "flat"),
        (np.diag([1.005, 1, 1]), "misses orthonormality by 1.0e-02"),
    ],
)
def test_what_no_rotation_is_near_is_refused(matrix, message):
    with pytest.raises(ValueError, match=f"^matrix .*{message}"):
        spatial.nearest_rotation(matrix)


def test_any_matrix_that_keeps_orientation_on_request(rng):
    M = torch.from_numpy(rng.normal(size=(200, 3, 3)))
    M = M[torch.linalg.det(M) > 1e-2]
    U, _, Vh = torch.linalg.svd(M)
    assert_close(spatial.nearest_rotation(M, largest_miss=math.inf), U @ Vh, rtol=0, atol=1e-12)
    with pytest.raises(ValueError, match=r"^largest_miss is nan"):
        spatial.nearest_rotation(np.eye(3), largest_miss=math.nan)


@pytest.mark.parametrize("largest_miss", [1e-2, math.inf])
def test_the_nearest_rotation_has_the_right_derivatives(rng, largest_miss):
    R = rotations(rng, ()) + (1e-4 if largest_miss < 1 else 0.1) * torch.from_numpy(rng.normal(size=(3, 3)))

    def function(R):
        return spatial.nearest_rotation(R, largest_miss=largest_miss)

    R.requires_grad_()
    torch.autograd.gradcheck(function, R)
    torch.autograd.gradgradcheck(function, R)
    torch.autograd.gradcheck(function, torch.eye(3, dtype=torch.float64, requires_grad=True))


def test_the_last_row_of_a_nearest_pose():
    T = np.eye(4)
    T[3, 3] = 1.001
    assert spatial.nearest_rigid(T)[3].tolist() == [0, 0, 0, 1]
    T[3, 0] = 0.5
    with pytest.raises(ValueError, match=r"^T is not a rigid-body pose: its last row"):
        spatial.nearest_rigid(T)


# ---- roll, pitch and yaw ----------------------------------------------------------------------------


def test_roll_pitch_yaw_is_scipys(rng, batch_shape):
    angles = rng.uniform(-4, 4, size=(*batch_shape, 3))
    flat = angles.reshape(-1, 3)
    expected = Rotation.from_euler("xyz", flat).as_matrix() if len(flat) else np.zeros((0, 3, 3))
    T = spatial.from_rpy(angles, [1, 2, 3])
    assert_close(T[..., :3, :3], torch.from_numpy(expected.reshape(*batch_shape, 3, 3)), rtol=0, atol=1e-15)
    assert_close(T[..., :3, 3], torch.tensor([1.0, 2, 3], dtype=torch.float64).expand(*batch_shape, 3))


@given(angles, angles, angles)
def test_roll_pitch_yaw_and_back_is_the_same_rotation(roll, pitch, yaw):
    T = spatial.from_rpy([roll, pitch, yaw])
    found = spatial.rpy(T)
    assert found[1].abs() <= math.pi / 2
    assert_close(spatial.from_rpy(found), T, rtol=0, atol=1e-14)


@pytest.mark.parametrize("pitch", [math.pi / 2, -math.pi / 2])
@pytest.mark.parametrize("off", [0.0, 1e-16, 1e-12, 1e-9])
def test_roll_pitch_yaw_where_only_a_sum_is_defined(pitch, off):
    T = spatial.from_rpy([0.3, pitch - off, 0.7])
    assert_close(spatial.from_rpy(spatial.rpy(T)), T, rtol=0, atol=1e-14)


def test_exact_lock_has_a_finite_gradient():
    R = torch.tensor([[0, 0, 1.0], [0, 1, 0], [-1, 0, 0]], dtype=torch.float64, requires_grad=True)
    found = spatial.rpy(R)
    assert_close(found.detach(), torch.tensor([0, math.pi / 2, 0], dtype=torch.float64))
    (gradient,) = torch.autograd.grad(found.sum(), R)
    assert torch.isfinite(gradient).all()


# ---- quaternions ------------------------------------------------------------------------------------


@pytest.mark.parametrize("order", ["xyzw", "wxyz"])
def test_quaternions_are_scipys(rng, order):
    R = Rotation.random(100, rng)
    q = R.as_quat(canonical=True, scalar_first=order == "wxyz")
    T = spatial.from_quaternion(q, order=order)
    assert_close(T[:, :3, :3], torch.from_numpy(R.as_matrix()), rtol=0, atol=1e-15)
    assert_close(spatial.quaternion(T, order=order), torch.from_numpy(q), rtol=0, atol=2e-15)


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_half_turns(axis):
    q = np.zeros(4)
    q[axis] = -1.0
    T = spatial.from_quaternion(q, order="xyzw")
    assert_close(spatial.quaternion(T, order="xyzw"), torch.from_numpy(-q), rtol=0, atol=0)


def test_a_quaternion_with_six_digits_is_taken_and_a_longer_one_is_refused(annotations_unchecked):
    q = np.array([0.182574, 0.365148, 0.547723, 0.730297])
    T = spatial.from_quaternion(q, order="wxyz")
    assert spatial.rotation_miss(T) < 1e-15
    with pytest.raises(ValueError, match=r"^quaternion has length 2; 1 is needed"):
        spatial.from_quaternion([0, 0, 0, 2], order="wxyz")
    with pytest.raises(ValueError, match=r"^order is 'wzyx'"):
        spatial.from_quaternion(q, order="wzyx")


def test_other_forms_are_differentiable(rng):
    angles = torch.from_numpy(rng.uniform(-1, 1, size=(4, 3))).requires_grad_()
    torch.autograd.gradcheck(lambda a: spatial.rpy(spatial.from_rpy(a)), angles)
    torch.autograd.gradcheck(lambda a: spatial.quaternion(spatial.from_rpy(a), order="xyzw"), angles)
    q = torch.nn.functional.normalize(torch.from_numpy(rng.normal(size=(4, 4))), dim=-1).requires_grad_()
    torch.autograd.gradcheck(
        lambda q: spatial.from_quaternion(torch.nn.functional.normalize(q, dim=-1), order="xyzw"), q
    )


def test_translations_broadcast():
    T = spatial.translation(1.0, [2.0, 3.0], torch.zeros(2))
    assert T[:, :3, 3].tolist() == [[1, 2, 0], [1, 3, 0]]
    assert_close(spatial.translation(0.1, 0.2, 0.3), spatial.exp([0.1, 0.2, 0.3, 0, 0, 0]))
    with pytest.raises(ValueError, match=r"^x, y and z have batch axes"):
        spatial.translation([1.0, 2.0], [1.0, 2.0, 3.0], 0.0)


# ---- the logarithm at π (jaxlie#9, pypose#172, pytransform3d#364, PointNetLK#21) -------------------------

S = math.pi / math.sqrt(2)


@pytest.mark.parametrize(
    "omega", [(math.pi, 0, 0), (0, math.pi, 0), (S, S, 0), (0, 0, 0), (1e-9, 0, 0), (math.pi - 1e-9, 0, 0)]
)
def test_the_logarithm_at_pi_and_its_jacobian(omega):
    x = torch.tensor([0.1, 0.2, 0.3, *omega], dtype=torch.float64)
    assert_close(spatial.log(spatial.exp(x)), x, rtol=0, atol=1e-12)
    J = torch.autograd.functional.jacobian(lambda x: spatial.log(spatial.exp(x)), x)
    assert_close(J, torch.eye(6, dtype=torch.float64), rtol=0, atol=1e-9)


def test_the_logarithm_of_a_half_turn_about_x():
    assert_close(
        spatial.log(np.diag([1.0, -1, -1, 1]))[3:], torch.tensor([math.pi, 0, 0], dtype=torch.float64)
    )


# ---- values that overflow ---------------------------------------------------------------------------


def test_finite_values_never_become_nan():
    huge = np.eye(4)
    huge[:3, 3] = 1e308
    for call, name in [
        (lambda: spatial.exp([1e154] * 6), "twist"),
        (lambda: spatial.compose(huge, huge), "T"),
        (lambda: spatial.adjoint(dx.spatial.pose(spatial.from_rpy([0, 0, 0.8])[:3, :3], [1.7e308] * 3)), "T"),
    ]:
        with pytest.raises(ValueError, match=f"^{name} is so large that the result overflows"):
            call()


def test_a_product_of_one_pose_is_a_copy():
    T = np.eye(4)
    product = spatial.compose(T)
    T[0, 3] = 5.0
    assert product[0, 3] == 0
