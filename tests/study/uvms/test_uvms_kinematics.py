"""The derivation with symbols and the scenes of the chapter, against the library's numbers."""

import numpy as np
import pytest
import sympy
import torch
from numpy.testing import assert_allclose
from scipy.linalg import expm

from dexterity import robots, spatial
from dexterity.indices import Index
from dexterity.scenes import Scene
from dexterity_study.uvms.kinematics import derivation, show

UVMS = robots.uvms()
ANGLE = sympy.Symbol("q", real=True)


def numbers(matrix: sympy.Matrix) -> np.ndarray:
    return np.array(matrix.evalf().tolist(), dtype=float)


# ---- derivation -------------------------------------------------------------------------------------


def test_the_fourth_power_of_a_hat_is_minus_the_second():
    S = derivation.hat(derivation.unit_screw())
    assert derivation.vanishes(S**4 + S**2)
    assert not derivation.vanishes(S**4 - S**2)
    assert not derivation.vanishes(S**3 + S**2)


@pytest.mark.parametrize("screw", [(1, 2, 3, 0, 0, 1), (0.6, 0.8, 0, 0, 0, 0), (0, 0.5, -0.7, -1, 0, 0)])
def test_the_four_terms_are_the_matrix_exponential(screw):
    motion = derivation.exponential(sympy.Matrix(screw), ANGLE)
    S = spatial.hat(np.array(screw, dtype=float)).numpy()
    for value in (-2.0, 0.3, 5.0):
        assert_allclose(numbers(motion.subs(ANGLE, value)), expm(value * S), atol=1e-12)


def test_a_screw_whose_axis_is_no_unit_vector_is_refused():
    with pytest.raises(ValueError, match=r"screw is \[0, 0, 0, 0, 0, 2\]"):
        derivation.exponential(sympy.Matrix([0, 0, 0, 0, 0, 2]), ANGLE)


def test_the_adjoint_moves_a_screw_as_the_library_does():
    T = spatial.exp([0.1, 0.2, 0.3, 0.4, -0.5, 0.6])
    symbolic = sympy.Matrix(T.tolist())
    assert_allclose(numbers(derivation.adjoint(symbolic)), spatial.adjoint(T).numpy(), atol=1e-14)
    screw = sympy.Matrix([0.3, -0.2, 0.5, 0.7, 1.1, -0.4])
    hat = symbolic * derivation.hat(screw) * sympy.Matrix(torch.linalg.inv(T).tolist())
    assert_allclose(numbers(derivation.vee(hat) - derivation.adjoint(symbolic) * screw), 0, atol=1e-12)


def test_the_screws_of_the_paper_are_the_library_s():
    lengths = {"l1": 0.0, "l2": 0.6, "l3": 0.4, "y_MB": 0.75}
    chain = derivation.uvms()
    screws = [derivation.screw(chain, joint) for joint in range(chain.joints)]
    named = [{s: lengths[s.name] for s in screw.free_symbols} for screw in screws]
    written = np.hstack([numbers(screw.subs(at)) for screw, at in zip(screws, named, strict=True)]).T
    assert_allclose(written, UVMS.screws.numpy(), atol=1e-12)


def test_the_column_is_the_derivative_of_the_pose_and_has_no_later_joint():
    chain = derivation.uvms()
    q = [0] * 6 + list(sympy.symbols("q_7:13", real=True))
    column = derivation.column(chain, q, 7)
    assert derivation.vanishes(column - derivation.column_by_differentiation(chain, q, 7))
    assert column.free_symbols <= {q[6], *derivation.screw(chain, 7).free_symbols}
    assert q[6] in column.free_symbols


def test_all_columns_are_the_library_s():
    assert derivation.miss_of_the_library(seed=3) < 1e-13


# ---- pictures ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("draw", [show.screw_scene, show.lever_scene, show.column_scene, show.origin_scene])
def test_each_scene_has_one_slider_that_moves_it(draw):
    scene = draw()
    assert isinstance(scene, Scene)
    ((mechanism,),) = [scene._mechanisms.values()]
    assert len(mechanism.sliders) == 1
    assert any(np.ptp(drive.positions, axis=0).max() > 0.1 for drive in mechanism.drives.values())
    assert scene._repr_html_().startswith("<iframe")


def test_the_lever_arm_gives_the_velocity_at_the_origin():
    drives = show.lever_scene()._mechanisms["mechanism"].drives
    (axis,) = [drive for path, drive in drives.items() if path.endswith("axis ω")]
    (arrow,) = [drive for path, drive in drives.items() if path.endswith("v = t × ω")]
    for length in (0.1, 0.7):
        moved = spatial.adjoint(axis.at(np.array(length))).numpy() @ [0, 0, 0, 0, 0, 1]
        head = arrow.at(np.array(length))[:3, :3] @ [0, -1, 0]
        assert_allclose(head, moved[:3], atol=1e-12)


def test_the_ellipsoids_are_those_of_the_point_at_each_place():
    tool = UVMS.forward(show.POSTURE)[:3, 3].numpy()
    axes, semi_axes = show.ellipsoids_at(np.stack([np.zeros(3), tool]))
    for J, R, lengths in (
        (UVMS.spatial_jacobian(show.POSTURE)[:3], axes[0], semi_axes[0]),
        (UVMS.geometric_jacobian(show.POSTURE)[:3], axes[1], semi_axes[1]),
    ):
        assert_allclose(R @ np.diag(lengths**2) @ R.T, (J @ J.T).numpy(), atol=1e-12)
        assert np.linalg.det(R) == pytest.approx(1)
    assert abs(semi_axes[0] - semi_axes[1]).max() > 0.1


def test_the_axes_of_the_ellipsoids_do_not_jump():
    points = np.outer(np.linspace(-1.6, 1.2, 57), [0.0, 1.0, 0.0])
    axes, _ = show.ellipsoids_at(points)
    turns = np.einsum("kij,kij->k", axes[1:], axes[:-1])
    assert turns.min() > 1 + 2 * np.cos(np.pi / 2)


def test_roll_changes_w_with_the_range_and_not_with_equal_limits():
    slow_heave = Index("manipulability", joint_rates=(1.0, 1.0, 0.2) + (1.0,) * 9).bind(UVMS)
    narrow, wide = (show.change_under_theta_x(slow_heave, 0, deg, 300) for deg in (15.0, 60.0))
    assert 0.01 < narrow < 0.5 * wide
    assert show.change_under_theta_x(Index("manipulability").bind(UVMS), 0, 60.0, 300) < 1e-12
