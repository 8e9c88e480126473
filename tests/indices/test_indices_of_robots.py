"""At least twelve indices of at least eight robots: compiled values and gradients, and other libraries."""

from functools import cache

import numpy as np
import pytest
import torch
from numpy.testing import assert_allclose
from torch.testing import assert_close

import dexterity as dx
from dexterity import indices, symbolic
from dexterity.derivation import programs
from dexterity.indices import Index
from peer_models import roboticstoolbox_transforms
from serial_chains import random_robot

ROBOTS = (*("panda", "ur5e", "iiwa14", "oberon7", "reach_alpha5", "reach_bravo7", "bluerov2", "girona500"),)


@cache
def robot(name: str) -> dx.Chain:
    return dx.robots.load(name)


@pytest.fixture(autouse=True)
def _in_the_middle_link(monkeypatch) -> None:
    """Derive in the middle link: the search for the shortest formulas changes no value and takes longest."""
    monkeypatch.setattr(programs, "_shortest", lambda chain, index, weights, places: places[len(places) // 2])


def within_limits(chain: dx.Chain, count: int) -> torch.Tensor:
    """Configurations in the middle of the limits, and no farther than a radian or a metre from there."""
    low, high = chain.lower.clamp(min=-3), chain.upper.clamp(max=3)
    draws = torch.rand(count, chain.joints, generator=torch.Generator().manual_seed(2), dtype=torch.float64)
    return (low + high) / 2 + (draws - 0.5) * (high - low).clamp(max=2) * 0.8


def index_of(name: str, rows: object) -> Index:
    along = {"direction": "vz"} if "direction" in indices.describe(name).needs else {}
    return Index(name, "geometric", rows=rows, **along)


def assert_compiled_is_plain(chain: dx.Chain, index: Index) -> None:
    """Against autograd of the plain index: both within 1e-9, relative to the largest of the batch."""
    q = within_limits(chain, 10)
    value, gradient = symbolic.compile_index(chain, index).value_and_gradient(q)
    x = q.clone().requires_grad_()
    plain = index.bind(chain)(x)
    (expected,) = torch.autograd.grad(plain.sum(), x)
    assert_close(value, plain.detach(), rtol=1e-9, atol=1e-13)
    assert_close(gradient, expected, rtol=1e-9, atol=1e-9 * float(expected.abs().max()))


@pytest.mark.parametrize("name", indices.names())
@pytest.mark.parametrize("of", ROBOTS)
def test_a_compiled_index_of_a_robot_is_the_plain_one(of, name):
    chain = robot(of)
    if "inertias" in indices.describe(name).needs and chain.inertias is None:
        with pytest.raises(ValueError, match="has no inertias"):
            symbolic.compile_index(chain, Index(name, "geometric", rows="translational"))
        return
    assert_compiled_is_plain(chain, index_of(name, "translational"))


@pytest.mark.parametrize("name", ["manipulability", "kinematic_conditioning", "isotropy", "velocity_ratio"])
@pytest.mark.parametrize("of", ["panda", "ur5e"])
def test_over_all_six_rows_too(of, name):
    assert_compiled_is_plain(robot(of), index_of(name, "full"))


@pytest.mark.parametrize("name", [name for name in indices.names() if name != "dynamic_manipulability"])
def test_an_arm_of_four_joints_over_the_rows_it_serves(name):
    rows = indices.reach_of_rows.rows_of_full_rank(Index("w", "geometric"), robot("reach_alpha5"))
    assert rows == "translational"
    assert_compiled_is_plain(robot("reach_alpha5"), index_of(name, ("vx", "vz")))


# ---- other libraries -------------------------------------------------------------------------------

METHODS = {
    "manipulability": "yoshikawa",
    "smallest_singular_value": "minsingular",
    "kinematic_conditioning": "invcondition",
}
AXES = {"full": "all", "translational": "trans", "rotational": "rot"}


@pytest.mark.parametrize("rows", AXES)
@pytest.mark.parametrize("name", METHODS)
def test_roboticstoolbox_has_the_same_indices(rng, name, rows):
    robot = random_robot(np.random.default_rng(8), 7)
    peer, q = roboticstoolbox_transforms(robot), rng.uniform(-2, 2, (5, 7))
    theirs = [peer.manipulability(row, method=METHODS[name], axes=AXES[rows]) for row in q]
    assert_allclose(Index(name, "geometric", rows=rows)(robot.chain(), q), theirs, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("of", ["panda", "ur5e", "iiwa14"])
def test_dynamic_manipulability_is_the_volume_of_accelerations(of):
    """Yoshikawa (1985): √det(J (MᵀM)⁻¹ Jᵀ); a locked joint keeps its torque to itself."""
    chain = robot(of)
    q = within_limits(chain, 5)
    J, M = chain.geometric_jacobian(q), chain.mass_matrix(q)
    expected = torch.linalg.det(J @ torch.linalg.inv(M.mT @ M) @ J.mT).sqrt()
    assert_close(Index("dynamic_manipulability", "geometric")(chain, q), expected, rtol=1e-9, atol=0)
    free = [0, 1, 3]
    locked = tuple(float(i in free) for i in range(chain.joints))
    J, M = J[:, :3, free], M[:, free][:, :, free]
    expected = torch.linalg.det(J @ torch.linalg.inv(M.mT @ M) @ J.mT).sqrt()
    index = Index("dynamic_manipulability", "geometric", joint_rates=locked, rows="translational")
    assert_close(index(chain, q), expected, rtol=1e-8, atol=0)
