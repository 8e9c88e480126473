"""Dexterity indices: closed forms, base invariance and its limits, singularities, ellipsoids."""

import dataclasses
import math

import jaxtyping
import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st
from torch.testing import assert_close

import dexterity as dx
from dexterity import indices
from dexterity.indices import Index
from serial_chains import random_robot

UVMS = dx.robots.uvms()
ARM = dx.robots.docking_arm()
FRAMES = ("spatial", "body", "geometric")
NAMES = ("manipulability", "kinematic_conditioning")

# Largest joint rates with the same limit for x, y and z: all 1, and those of a small ROV.
ISOTROPIC_RATES = {"unit": (1.0,) * 12, "rov": (0.5,) * 3 + (0.3,) * 3 + (1.0,) * 6}


def uvms_configurations(rng: np.random.Generator, count: int) -> torch.Tensor:
    return torch.from_numpy(rng.uniform(-2, 2, (count, 12)))


def jacobians(rng: np.random.Generator, shape: tuple[int, ...]) -> torch.Tensor:
    return torch.from_numpy(rng.normal(size=shape))


def moved(rng: np.random.Generator, q: torch.Tensor, joints: list[int]) -> torch.Tensor:
    """Return the configurations with some joints, counted from 1 as in the paper, elsewhere."""
    q = q.clone()
    columns = [joint - 1 for joint in joints]
    q[:, columns] = torch.from_numpy(rng.uniform(-2, 2, (len(q), len(columns))))
    return q


# ---- values ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("joints", [6, 7, 12])
def test_manipulability_is_the_root_of_the_gram_determinant(rng, batch_shape, joints):
    J = jacobians(rng, (*batch_shape, 6, joints))
    assert_close(indices.manipulability(J), torch.linalg.det(J @ J.mT).sqrt(), rtol=1e-11, atol=0)


def test_manipulability_and_conditioning_come_from_numpys_singular_values(rng, batch_shape):
    J = jacobians(rng, (*batch_shape, 6, 9))
    sigma = torch.from_numpy(np.linalg.svd(J.numpy(), compute_uv=False))
    assert_close(indices.manipulability(J), sigma.prod(-1), rtol=1e-13, atol=0)
    assert_close(indices.kinematic_conditioning(J), sigma[..., 5] / sigma[..., 0], rtol=1e-13, atol=0)


@pytest.mark.parametrize("rows", [1, 2, 3])
def test_rows_may_be_left_out(rng, rows):
    J = jacobians(rng, (rows, 4))
    assert_close(indices.manipulability(J), torch.linalg.det(J @ J.T).sqrt(), rtol=1e-12, atol=0)


@pytest.mark.parametrize("variant", ["stated", "fitted"])
@pytest.mark.parametrize("frame", FRAMES)
def test_manipulability_of_the_docking_arm_has_a_closed_form(rng, variant, frame):
    l1, l2 = {"stated": (0.4, 0.4), "fitted": (0.425, 0.425)}[variant]
    q = torch.from_numpy(rng.uniform(-3, 3, (200, 6)))
    _, q2, q3, _, q5, _ = q.unbind(-1)
    reach = (l1 * q2.cos() + l2 * (q2 + q3).cos()).abs()
    expected = l1 * l2 * q3.sin().abs() * reach * q5.sin().abs()
    w = Index("manipulability", frame).bind(dx.robots.docking_arm(variant))(q)
    assert_close(w, expected, rtol=0, atol=1e-15)
    assert_close(w / expected, torch.ones_like(w), rtol=0, atol=1e-12)


def test_an_orthogonal_jacobian_is_isotropic():
    J = 2 * torch.eye(6, 8)
    assert_close(indices.manipulability(J), torch.tensor(64.0, dtype=torch.float64))
    assert_close(indices.kinematic_conditioning(J), torch.tensor(1.0, dtype=torch.float64))


def test_conditioning_lies_between_zero_and_one_and_has_no_scale(rng):
    J = jacobians(rng, (50, 6, 8))
    kci = indices.kinematic_conditioning(J)
    assert ((kci > 0) & (kci < 1)).all()
    assert_close(indices.kinematic_conditioning(1e-3 * J), kci, rtol=1e-13, atol=0)


# ---- what the indices depend on --------------------------------------------------------------------


@pytest.mark.parametrize("rates", ISOTROPIC_RATES.values(), ids=ISOTROPIC_RATES)
@pytest.mark.parametrize("frame", FRAMES)
def test_manipulability_is_free_of_the_base_and_of_the_last_joint(rng, rates, frame):
    w = Index("manipulability", frame, joint_rates=rates).bind(UVMS)
    q = uvms_configurations(rng, 100)
    for joints in ([1], [2], [3], [4], [12], [1, 2, 3, 4, 12]):
        assert_close(
            w(moved(rng, q, joints)) / w(q), torch.ones(100, dtype=torch.float64), rtol=0, atol=1e-12
        )
    for joint in range(5, 12):
        assert ((w(moved(rng, q, [joint])) / w(q) - 1).abs() > 1e-3).any()


def test_manipulability_depends_on_the_roll_where_the_translation_limits_differ(rng):
    """Base invariance needs equal limits for y and z; that of x may differ, and translations never matter."""
    w = Index("manipulability", joint_rates=(1.0, 1.0, 0.5) + (1.0,) * 9).bind(UVMS)
    q = uvms_configurations(rng, 100)
    change = (w(moved(rng, q, [4])) / w(q) - 1).abs()
    assert change.max() > 0.1
    assert change.median() > 0.03
    assert_close(w(moved(rng, q, [1, 2, 3, 12])), w(q), rtol=1e-12, atol=0)

    x_only = Index("manipulability", joint_rates=(0.5,) + (1.0,) * 11).bind(UVMS)
    assert_close(x_only(moved(rng, q, [1, 2, 3, 4, 12])), x_only(q), rtol=1e-12, atol=0)


@pytest.mark.parametrize("rates", ISOTROPIC_RATES.values(), ids=ISOTROPIC_RATES)
def test_conditioning_of_the_spatial_jacobian_depends_on_the_base_but_not_on_the_last_joint(rng, rates):
    kci = Index("kinematic_conditioning", "spatial", joint_rates=rates).bind(UVMS)
    q = uvms_configurations(rng, 100)
    assert_close(kci(moved(rng, q, [12])), kci(q), rtol=1e-12, atol=0)
    for joint in range(1, 12):
        assert ((kci(moved(rng, q, [joint])) / kci(q) - 1).abs() > 0.01).any()


@pytest.mark.parametrize("rates", ISOTROPIC_RATES.values(), ids=ISOTROPIC_RATES)
@pytest.mark.parametrize("frame", ["body", "geometric"])
def test_conditioning_at_the_tool_depends_on_joints_5_to_11_only(rng, rates, frame):
    tool_rates = (0.5,) * 3 + (2.0,) * 3
    kci = Index("kinematic_conditioning", frame, joint_rates=rates, tool_rates=tool_rates).bind(UVMS)
    q = uvms_configurations(rng, 100)
    assert_close(kci(moved(rng, q, [1, 2, 3, 4, 12])), kci(q), rtol=1e-12, atol=0)
    for joint in range(5, 12):
        assert ((kci(moved(rng, q, [joint])) / kci(q) - 1).abs() > 1e-3).any()


def test_conditioning_of_the_body_jacobian_depends_on_the_last_joint_where_tool_limits_differ_in_a_block(rng):
    tool_rates = (1.0, 1.0, 0.5) + (1.0,) * 3
    kci = Index("kinematic_conditioning", "body", tool_rates=tool_rates).bind(UVMS)
    q = uvms_configurations(rng, 100)
    assert ((kci(moved(rng, q, [12])) / kci(q) - 1).abs() > 0.01).any()


@pytest.mark.parametrize(
    "chain", [UVMS, random_robot(np.random.default_rng(3), 8).chain()], ids=["uvms", "random"]
)
def test_manipulability_is_the_same_in_all_frames_and_conditioning_is_not(rng, chain):
    q = torch.from_numpy(rng.uniform(-2, 2, (100, chain.joints)))
    w, kci = ([Index(name, frame).bind(chain)(q) for frame in FRAMES] for name in NAMES)
    for other in w[1:]:
        assert_close(other, w[0], rtol=1e-11, atol=0)
    spatial, body, geometric = kci
    assert_close(geometric, body, rtol=1e-11, atol=0)
    assert ((spatial / body - 1).abs() > 0.1).any()


# ---- singularities and too few joints --------------------------------------------------------------


@pytest.mark.parametrize("joints", [1, 3, 5])
@pytest.mark.parametrize("measure", [indices.manipulability, indices.kinematic_conditioning])
def test_fewer_joints_than_rows_give_exactly_zero(rng, batch_shape, joints, measure):
    value = measure(jacobians(rng, (*batch_shape, 6, joints)))
    assert_close(value, torch.zeros(batch_shape, dtype=torch.float64), rtol=0, atol=0)


def singular_jacobians() -> dict[str, torch.Tensor]:
    straight, overhead = torch.zeros(6), torch.tensor([0.3, math.pi / 2, 0, 0.2, 0, 0.1])
    locked_uvms = indices.normalise(UVMS.spatial_jacobian(torch.ones(12)), [0.0] * 12, [1.0] * 6)
    repeated = ARM.spatial_jacobian([0.1, 0.5, 1.0, 0.3, 0.7, 0.2])
    repeated[:, 5] = repeated[:, 4]
    return {
        "straight arm": ARM.geometric_jacobian(straight),
        "wrist above the first axis": ARM.spatial_jacobian(overhead),
        "no motion": torch.zeros(6, 12, dtype=torch.float64),
        "all joints locked": locked_uvms,
        "two equal columns": repeated,
        "tiny": 1e-200 * ARM.geometric_jacobian(straight),
        "huge": 1e40 * ARM.geometric_jacobian(straight),
    }


@pytest.mark.parametrize("J", singular_jacobians().values(), ids=singular_jacobians())
def test_a_singular_jacobian_has_indices_zero_and_finite_gradients(J):
    J = J.clone().requires_grad_()
    scale = float(J.detach().abs().max())
    for measure, unit in ((indices.manipulability, scale**6), (indices.kinematic_conditioning, 1.0)):
        value = measure(J)
        assert 0 <= value.item() <= 1e-15 * unit
        (gradient,) = torch.autograd.grad(value, J)
        assert gradient.isfinite().all()


@pytest.mark.parametrize(
    "J", [torch.zeros(6, 12), torch.zeros(6, 4), torch.zeros(2, 6, 6)], ids=["12", "4", "batch"]
)
@pytest.mark.parametrize("measure", [indices.manipulability, indices.kinematic_conditioning])
def test_a_jacobian_that_moves_nothing_has_indices_of_exactly_zero(J, measure):
    assert_close(measure(J), torch.zeros(J.shape[:-2], dtype=torch.float64), rtol=0, atol=0)


@pytest.mark.parametrize("name", NAMES)
def test_locked_joints_count_as_left_out(rng, name):
    q = uvms_configurations(rng, 20)
    locked = Index(name, joint_rates=(1.0,) * 8 + (0.0,) * 4).bind(UVMS)(q)
    J = UVMS.spatial_jacobian(q)[..., :8]
    measure = getattr(indices, name)
    assert_close(locked, measure(J), rtol=1e-11, atol=0)
    arm_only = Index(name, joint_rates=(0.0,) * 12).bind(UVMS)(q)
    assert_close(arm_only, torch.zeros(20, dtype=torch.float64), rtol=0, atol=0)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("frame", FRAMES)
def test_gradients_of_an_index_are_its_finite_differences(rng, name, frame):
    q = uvms_configurations(rng, 2).requires_grad_()
    torch.autograd.gradcheck(Index(name, frame).bind(UVMS), q)


@pytest.mark.parametrize("name", NAMES)
def test_gradients_of_an_index_are_finite_at_a_singular_configuration(name):
    for q in ([0.0] * 6, [0, math.pi / 2, 0, 0, 0, 0]):
        q = torch.tensor(q, dtype=torch.float64, requires_grad=True)
        (gradient,) = torch.autograd.grad(Index(name).bind(ARM)(q), q)
        assert gradient.isfinite().all()


# ---- ellipsoids ------------------------------------------------------------------------------------

PARTS = {"full": slice(0, 6), "translational": slice(0, 3), "rotational": slice(3, 6)}


def unit_vectors(rng: np.random.Generator, count: int, size: int) -> torch.Tensor:
    vectors = rng.normal(size=(count, size))
    return torch.from_numpy(vectors / np.linalg.norm(vectors, axis=1, keepdims=True))


@pytest.mark.parametrize("part", PARTS)
def test_the_velocity_ellipsoid_is_what_unit_joint_rates_reach(rng, part):
    J = UVMS.geometric_jacobian(torch.ones(12))
    ellipsoid = indices.velocity_ellipsoid(J, part)
    axes, semi_axes, J = ellipsoid.axes, ellipsoid.semi_axes, J[PARTS[part]]
    inside = unit_vectors(rng, 500, 12) @ J.T @ axes / semi_axes
    assert inside.norm(dim=1).max() <= 1 + 1e-12
    # Each point of its surface is reached, by the joint rates of least norm.
    surface = unit_vectors(rng, 500, len(semi_axes)) * semi_axes @ axes.T
    least_rates = surface @ torch.linalg.pinv(J).T
    assert_close(least_rates @ J.T, surface, rtol=0, atol=1e-12)
    assert_close(least_rates.norm(dim=1), torch.ones(500, dtype=torch.float64), rtol=0, atol=1e-12)


@pytest.mark.parametrize("part", PARTS)
def test_the_force_ellipsoid_is_what_unit_joint_efforts_balance(rng, part):
    J = UVMS.geometric_jacobian(torch.ones(12))
    ellipsoid = indices.force_ellipsoid(J, part)
    surface = unit_vectors(rng, 500, ellipsoid.semi_axes.shape[-1]) * ellipsoid.semi_axes @ ellipsoid.axes.T
    efforts = surface @ J[PARTS[part]]
    assert_close(efforts.norm(dim=1), torch.ones(500, dtype=torch.float64), rtol=0, atol=1e-12)


@pytest.mark.parametrize("part", PARTS)
def test_the_force_ellipsoid_is_reciprocal_to_the_velocity_ellipsoid(rng, batch_shape, part):
    J = jacobians(rng, (*batch_shape, 6, 9))
    velocity, force = indices.velocity_ellipsoid(J, part), indices.force_ellipsoid(J, part)
    assert_close(force.axes, velocity.axes, rtol=0, atol=0)
    assert_close(force.semi_axes * velocity.semi_axes, torch.ones_like(force.semi_axes))


@pytest.mark.parametrize("part", PARTS)
def test_axes_are_orthonormal_and_semi_axes_descend(rng, batch_shape, part):
    ellipsoid = indices.velocity_ellipsoid(jacobians(rng, (*batch_shape, 6, 5)), part)
    k = 6 if part == "full" else 3
    assert ellipsoid.semi_axes.shape == (*batch_shape, k)
    identity = torch.eye(k, dtype=torch.float64).expand(*batch_shape, k, k)
    assert_close(ellipsoid.axes.mT @ ellipsoid.axes, identity, rtol=0, atol=1e-14)
    assert (ellipsoid.semi_axes.diff(dim=-1) <= 0).all()


def test_the_volume_is_proportional_to_the_manipulability(rng, batch_shape):
    J = jacobians(rng, (*batch_shape, 6, 9))
    full = indices.velocity_ellipsoid(J).volume
    assert_close(full, math.pi**3 / 6 * indices.manipulability(J), rtol=1e-12, atol=0)
    translational = indices.velocity_ellipsoid(J, "translational").volume
    assert_close(translational, 4 / 3 * math.pi * indices.manipulability(J[..., :3, :]), rtol=1e-12, atol=0)


def test_a_planar_arm_has_a_flat_velocity_ellipsoid_and_carries_any_force_across_its_plane():
    arm = dx.Chain.from_dh([{"a": 1}, {"a": 1}])
    J = arm.geometric_jacobian([0, math.pi / 2])
    velocity, force = (
        indices.velocity_ellipsoid(J, "translational"),
        indices.force_ellipsoid(J, "translational"),
    )
    assert velocity.semi_axes[2] == 0
    assert force.semi_axes[2] == math.inf
    assert_close(velocity.axes[:, 2].abs(), torch.tensor([0.0, 0, 1], dtype=torch.float64))
    assert velocity.volume == 0
    assert force.volume == math.inf


def test_an_arm_without_motion_has_a_point_and_all_of_space():
    velocity, force = (
        make(torch.zeros(6, 3)) for make in (indices.velocity_ellipsoid, indices.force_ellipsoid)
    )
    assert velocity.semi_axes.tolist() == [0] * 6
    assert force.semi_axes.tolist() == [math.inf] * 6
    assert velocity.volume == 0
    assert force.volume == math.inf


def test_an_ellipsoid_of_the_wrong_shape_is_refused_in_tests():
    """Guards the switch in conftest: without it nothing checks the annotations."""
    with pytest.raises(jaxtyping.TypeCheckError):
        indices.Ellipsoid(torch.zeros(3, 3, dtype=torch.float64), torch.zeros(2, dtype=torch.float64))


# ---- normalisation ---------------------------------------------------------------------------------


def test_normalisation_is_equation_7(rng, batch_shape):
    J = jacobians(rng, (*batch_shape, 6, 12))
    joint_rates, tool_rates = rng.uniform(0.1, 2, 12), rng.uniform(0.1, 2, 6)
    G, U = torch.diag(1 / torch.from_numpy(joint_rates)), torch.diag(1 / torch.from_numpy(tool_rates))
    assert_close(
        indices.normalise(J, joint_rates, tool_rates), U @ J @ torch.linalg.inv(G), rtol=1e-13, atol=0
    )


def test_unit_rates_change_nothing(rng):
    J = jacobians(rng, (4, 6, 7))
    assert_close(indices.normalise(J, [1] * 7, [1] * 6), J, rtol=0, atol=0)


@pytest.mark.parametrize(
    ("joint_rates", "tool_rates", "message"),
    [
        ([1] * 5, [1] * 6, r"joint_rates has shape \(5,\); \(7,\) is needed"),
        ([[1] * 7], [1] * 6, r"joint_rates has shape \(1, 7\)"),
        (1.0, [1] * 6, r"joint_rates has shape \(\)"),
        ([1] * 7, [1] * 7, r"tool_rates has shape \(7,\); \(6,\) is needed"),
        ([1] * 6 + [-1], [1] * 6, "joint_rates holds a negative rate"),
        ([1] * 6 + [math.nan], [1] * 6, "joint_rates is not finite"),
        ([1] * 7, [1] * 5 + [0], "tool_rates must be positive"),
        ([1] * 7, [1] * 5 + [-2], "tool_rates must be positive"),
        ([1] * 7, [1] * 5 + [math.inf], "tool_rates is not finite"),
    ],
)
def test_bad_rates_are_refused(joint_rates, tool_rates, message):
    with pytest.raises(ValueError, match=f"^{message}"):
        indices.normalise(torch.ones(6, 7), joint_rates, tool_rates)


# ---- Index -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("frame", FRAMES)
def test_a_bound_index_is_the_measure_of_the_normalised_jacobian(rng, batch_shape, name, frame):
    joint_rates, tool_rates = tuple(rng.uniform(0.1, 2, 12)), tuple(rng.uniform(0.1, 2, 6))
    q = torch.from_numpy(rng.uniform(-2, 2, (*batch_shape, 12)))
    J = getattr(UVMS, f"{frame}_jacobian")(q)
    expected = getattr(indices, name)(indices.normalise(J, joint_rates, tool_rates))
    assert_close(Index(name, frame, joint_rates, tool_rates).bind(UVMS)(q), expected, rtol=0, atol=0)


def test_a_bound_index_takes_the_rates_of_the_chain(rng):
    rates = ISOTROPIC_RATES["rov"]
    chain = dx.robots.uvms(rates=rates)
    q = uvms_configurations(rng, 10)
    for name in NAMES:
        assert_close(Index(name).bind(chain)(q), Index(name, joint_rates=rates).bind(UVMS)(q), rtol=0, atol=0)


def test_an_index_is_a_value():
    index = Index("manipulability", joint_rates=(1, 2))
    assert index == Index("manipulability", "spatial", (1.0, 2.0), None)
    assert hash(index) == hash(Index("manipulability", joint_rates=(1.0, 2.0)))
    with pytest.raises(dataclasses.FrozenInstanceError):
        index.name = "kinematic_conditioning"


@pytest.mark.usefixtures("annotations_unchecked")
@pytest.mark.parametrize("rates", [[1, 2], np.array([1.0, 2.0]), torch.tensor([1.0, 2.0])], ids=type)
def test_rates_of_an_index_are_kept_as_a_tuple(rates):
    assert Index("manipulability", joint_rates=rates).joint_rates == (1.0, 2.0)


@pytest.mark.usefixtures("annotations_unchecked")
@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"name": "manipulabilty"}, "name is 'manipulabilty'; did you mean 'manipulability'"),
        ({"name": "condition"}, "name is 'condition'; .*kinematic_conditioning"),
        ({"name": "manipulability", "frame": "world"}, "frame is 'world'; .*spatial, body, geometric"),
    ],
)
def test_an_unknown_index_or_frame_is_refused(arguments, message):
    with pytest.raises(ValueError, match=f"^{message}"):
        Index(**arguments)


@given(joint_rates=st.integers(0, 20).filter(lambda n: n != 12))
def test_the_wrong_number_of_joint_rates_is_refused_when_an_index_is_bound(joint_rates):
    with pytest.raises(ValueError, match=r"^joint_rates has shape .*; \(12,\) is needed"):
        Index("manipulability", joint_rates=(1.0,) * joint_rates).bind(UVMS)


@given(tool_rates=st.integers(0, 20).filter(lambda n: n != 6))
def test_the_wrong_number_of_tool_rates_is_refused_when_an_index_is_bound(tool_rates):
    with pytest.raises(ValueError, match=r"^tool_rates has shape .*; \(6,\) is needed"):
        Index("manipulability", tool_rates=(1.0,) * tool_rates).bind(UVMS)


@given(joint=st.integers(0, 11), rate=st.floats(max_value=0, exclude_max=True, allow_infinity=False))
def test_a_negative_joint_rate_is_refused_when_an_index_is_bound(joint, rate):
    rates = [1.0] * 12
    rates[joint] = rate
    with pytest.raises(ValueError, match=r"^joint_rates holds a negative rate"):
        Index("manipulability", joint_rates=tuple(rates)).bind(UVMS)


@pytest.mark.parametrize("name", NAMES)
def test_a_bound_index_refuses_bad_joint_values(name):
    index = Index(name).bind(UVMS)
    with pytest.raises(ValueError, match=r"^q has shape \(11,\); the chain has 12 joints"):
        index(np.zeros(11))
    with pytest.raises(ValueError, match=r"^q is not finite"):
        index([math.nan] * 12)


# ---- bad Jacobians ---------------------------------------------------------------------------------

FUNCTIONS = [
    indices.manipulability,
    indices.kinematic_conditioning,
    indices.velocity_ellipsoid,
    indices.force_ellipsoid,
]


@pytest.mark.parametrize("function", FUNCTIONS)
@given(shape=st.sampled_from([(), (6,), (0, 6), (6, 0), (3, 6, 0), (0, 0)]))
def test_what_is_no_stack_of_matrices_is_refused(function, shape):
    with pytest.raises(ValueError, match=r"^J has shape .*\(\.\.\., rows, joints\) is needed"):
        function(np.zeros(shape))


@pytest.mark.parametrize("function", FUNCTIONS)
@given(
    row=st.integers(0, 5), column=st.integers(0, 6), poison=st.sampled_from([math.nan, math.inf, -math.inf])
)
def test_a_jacobian_that_is_not_finite_is_refused(function, row, column, poison):
    J = np.ones((6, 7))
    J[row, column] = poison
    with pytest.raises(ValueError, match=r"^J is not finite"):
        function(J)


@pytest.mark.usefixtures("annotations_unchecked")
@pytest.mark.parametrize("function", [indices.velocity_ellipsoid, indices.force_ellipsoid])
def test_an_ellipsoid_needs_six_rows_and_a_known_part(function):
    with pytest.raises(ValueError, match=r"^J has 3 rows; 6 are needed"):
        function(np.ones((3, 7)))
    with pytest.raises(ValueError, match=r"^part is 'linear'"):
        function(np.ones((6, 7)), "linear")
