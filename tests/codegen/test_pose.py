"""Kinematics in ECMAScript against those of the chain."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import dexterity as dx
from dexterity import robots, spatial
from dexterity.codegen import pose
from dexterity.symbolic import SymbolicChain
from run_in_node import called, needs_node
from serial_chains import random_robot

CHAINS = {
    "uvms": dx.robots.uvms(),
    "puma": dx.robots.puma560(),
    "docking arm": dx.robots.docking_arm(),
    "short": dx.Chain.from_dh([{"a": 0.5}, {"kind": "prismatic", "d": 0.2}, {"alpha": 0.7}], name="short"),
    "random": random_robot(np.random.default_rng(3), 7).chain(),
}
EVERY = pytest.mark.parametrize("name", CHAINS)


def configurations(rng, chain):
    q = rng.uniform(-3, 3, (50, chain.joints))
    q[0] = 0
    return q


def answers(folder, chain, name, q):
    return np.array(called(folder, pose.javascript_module(chain), name, [[row] for row in q.tolist()]))


@needs_node
@EVERY
def test_pose_and_jacobian_are_those_of_the_chain(tmp_path, rng, name):
    chain = CHAINS[name]
    q = configurations(rng, chain)
    assert_allclose(answers(tmp_path, chain, "pose", q), chain.forward(q), rtol=0, atol=1e-13)
    assert_allclose(answers(tmp_path, chain, "jacobian", q), chain.geometric_jacobian(q), rtol=0, atol=1e-12)


@needs_node
@EVERY
def test_links_are_the_products_of_exponentials(tmp_path, rng, name):
    chain = CHAINS[name]
    q = configurations(rng, chain)
    moved, links = np.eye(4), []
    for screw, values in zip(chain.screws.numpy(), q.T, strict=True):
        moved = moved @ spatial.exp(screw * values[:, None]).numpy()
        links.append(moved)
    assert_allclose(answers(tmp_path, chain, "links", q), np.stack(links, 1), rtol=0, atol=1e-13)


@needs_node
@EVERY
def test_points_lie_on_their_axes_and_the_last_is_the_tool(tmp_path, rng, name):
    chain = CHAINS[name]
    q = configurations(rng, chain)
    points = answers(tmp_path, chain, "points", q)
    assert_allclose(points[:, -1], chain.forward(q)[:, :3, 3], rtol=0, atol=1e-13)
    J = chain.spatial_jacobian(q).numpy()
    for i, kind in enumerate(chain.kinds):
        if kind == "revolute":  # a point of an axis has no velocity by its joint
            velocity = J[:, :3, i] + np.cross(J[:, 3:, i], points[:, i])
            assert_allclose(velocity, 0, atol=1e-12)


def test_a_chain_with_open_lengths_has_no_module():
    chain = SymbolicChain.from_description(robots.describe("docking_arm"))
    with pytest.raises(ValueError, match=r"^docking_arm has lengths without a value"):
        pose.kinematics(chain)
