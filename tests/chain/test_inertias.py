"""Mass matrices: pinocchio's on arms with random links, kinetic energy, and a pendulum's closed form."""

import numpy as np
import pinocchio
import pytest
import torch
from numpy.testing import assert_allclose
from torch.testing import assert_close

import dexterity as dx
from peer_models import pinocchio_model
from serial_chains import random_pose, random_robot


def random_inertias(rng: np.random.Generator, n: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    factors = rng.normal(size=(n, 3, 3))
    return rng.uniform(0.5, 3, n), rng.normal(size=(n, 3)), factors @ factors.transpose(0, 2, 1)


def arm_and_model(rng: np.random.Generator, joints: int) -> tuple[dx.Chain, pinocchio.Model]:
    """A random robot with random links, here and in pinocchio."""
    robot = random_robot(rng, joints)
    plain = robot.chain()
    inertias = random_inertias(rng, joints)
    model, _ = pinocchio_model(robot)
    data = model.createData()
    pinocchio.forwardKinematics(model, data, np.zeros(joints))
    for i, (mass, centre, tensor) in enumerate(zip(*inertias, strict=True)):
        model.inertias[i + 1] = data.oMi[i + 1].inverse().act(pinocchio.Inertia(mass, centre, tensor))
    chain = dx.Chain(plain.screws, plain.home, inertias=inertias)
    return chain, model


@pytest.mark.parametrize("joints", [2, 4, 6, 7, 9])
def test_the_mass_matrix_is_pinocchios(rng, joints):
    chain, model = arm_and_model(rng, joints)
    data = model.createData()
    for q in rng.uniform(-2, 2, (5, joints)):
        theirs = np.triu(pinocchio.crba(model, data, q))
        theirs += np.triu(theirs, 1).T
        assert_allclose(chain.mass_matrix(q), theirs, rtol=1e-12, atol=1e-11 * abs(theirs).max())


def test_a_batch_is_its_configurations_and_gradients_flow(rng, batch_shape):
    chain, _ = arm_and_model(rng, 4)
    q = torch.from_numpy(rng.uniform(-2, 2, (*batch_shape, 4)))
    M = chain.mass_matrix(q)
    assert M.shape == (*batch_shape, 4, 4)
    for single, matrix in zip(q.reshape(-1, 4), M.reshape(-1, 4, 4), strict=True):
        assert_close(chain.mass_matrix(single), matrix, rtol=1e-13, atol=1e-13)
    if not batch_shape:
        torch.autograd.gradcheck(chain.mass_matrix, q.requires_grad_())


def test_where_the_chain_stands_does_not_matter_and_locked_links_move_with_the_joint_before(rng):
    chain, _ = arm_and_model(rng, 6)
    q = torch.from_numpy(rng.uniform(-2, 2, 6))
    M = chain.mass_matrix(q)
    moved = chain.with_base(random_pose(rng)).with_tool(random_pose(rng))
    assert_close(moved.mass_matrix(q), M, rtol=1e-11, atol=1e-11)
    names = chain.joint_names
    locked = chain.lock({names[0]: float(q[0]), names[3]: float(q[3])})
    free = [1, 2, 4, 5]
    assert_close(locked.mass_matrix(q[free]), M[free][:, free], rtol=1e-11, atol=1e-11)


def test_a_free_vehicle_with_an_arm_has_the_mass_of_both(rng):
    chain, _ = arm_and_model(rng, 3)
    vehicle = chain.on_vehicle(random_pose(rng), inertia=(20.0, [0.1, 0, -0.05], np.diag([1.0, 2, 3])))
    q = torch.from_numpy(rng.uniform(-1, 1, 9))
    M = vehicle.mass_matrix(q)
    whole = 20 + float(chain.inertias.masses.sum())
    assert_close(M[:3, :3], whole * torch.eye(3, dtype=torch.float64), rtol=0, atol=1e-11)
    # On a vehicle at rest the arm's own part is unchanged.
    assert_close(M[6:, 6:], chain.mass_matrix(q[6:]), rtol=1e-11, atol=1e-11)
    assert chain.on_vehicle(random_pose(rng)).inertias is None


def test_a_double_pendulum_has_the_textbooks_mass_matrix():
    """Point masses m1, m2 at the ends of l1, l2 (Craig 2005, section 6.7)."""
    m1, m2, l1, l2 = 2.0, 3.0, 0.7, 0.4
    arm = dx.Chain.from_dh(
        [{"a": l1}, {"a": l2}], inertias=([m1, m2], [[l1, 0, 0], [l1 + l2, 0, 0]], np.zeros((2, 3, 3)))
    )
    q2 = 0.9
    cross = m2 * l2**2 + m2 * l1 * l2 * np.cos(q2)
    expected = [[m2 * l2**2 + 2 * m2 * l1 * l2 * np.cos(q2) + (m1 + m2) * l1**2, cross], [cross, m2 * l2**2]]
    assert_allclose(arm.mass_matrix([0.3, q2]), expected, rtol=1e-14)


def test_inertias_are_copies(rng):
    masses, centres, tensors = random_inertias(rng, 2)
    chain = dx.Chain.from_dh([{}, {"a": 1}], inertias=(masses, centres, tensors))
    before = chain.mass_matrix([0.1, 0.2])
    masses[:] = 9
    chain.inertias.centres[...] = 7
    assert_close(chain.mass_matrix([0.1, 0.2]), before, rtol=0, atol=0)


@pytest.mark.usefixtures("annotations_unchecked")
@pytest.mark.parametrize(
    ("inertias", "error", "message"),
    [
        (3, TypeError, "inertias is 3; masses"),
        (([1.0], [[0, 0, 0]]), TypeError, "inertias is .*masses"),
        (([1.0, 2], [[0, 0, 0]], [np.eye(3)]), ValueError, r"inertias.masses has shape \(2,\); \(1,\)"),
        (([1.0], [0, 0, 0], [np.eye(3)]), ValueError, r"inertias.centres has shape \(3,\)"),
        (([-1.0], [[0, 0, 0]], [np.eye(3)]), ValueError, "inertias.masses is .*negative"),
        (([1.0], [[0, 0, np.nan]], [np.eye(3)]), ValueError, "inertias.centres is not finite"),
        (([1.0], [[0, 0, 0]], [np.triu(np.ones((3, 3)))]), ValueError, "inertias.tensors is not symmetric"),
        ((["heavy"], [[0, 0, 0]], [np.eye(3)]), TypeError, "inertias.masses "),
        (
            ([1.0], [[0, 0, 0]], [-np.eye(3)]),
            ValueError,
            r"inertias.tensors\[0\] has the principal moment -1",
        ),
        (
            ([1.0], [[0, 0, 0]], [[[1, 2, 0], [2, 1, 0], [0, 0, -1]]]),
            ValueError,
            r"inertias.tensors\[0\] has the principal moment -1",
        ),
    ],
)
def test_bad_inertias_are_refused(inertias, error, message):
    with pytest.raises(error, match=f"^{message}"):
        dx.Chain.from_dh([{}], inertias=inertias)


def test_a_chain_without_inertias_says_so():
    with pytest.raises(ValueError, match=r"^uvms has no inertias"):
        dx.robots.uvms().mass_matrix([0] * 12)
