"""Kinematics and indices against pinocchio, roboticstoolbox and pytorch_kinematics, on the same robots.

Each library builds its own model from the description of a robot, joint by joint; nothing of the package
goes into it. Their Jacobians come in these frames and are compared in those:

- pinocchio: WORLD is the spatial Jacobian, LOCAL the body one, LOCAL_WORLD_ALIGNED the geometric one;
- roboticstoolbox: ``jacob0`` is geometric, ``jacobe`` is the body one;
- pytorch_kinematics: ``jacobian`` is geometric.

A geometric Jacobian becomes the spatial one by moving the velocity of the tool point p to the world's
origin, v + p × ω, and the body one by turning both blocks into the axes of the tool.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pinocchio
import pytest
import roboticstoolbox
import torch
from numpy.testing import assert_allclose
from numpy.typing import NDArray

import dexterity as dx
from peer_models import pinocchio_model, pytorch_kinematics_chain, roboticstoolbox_transforms
from serial_chains import SerialRobot, paper_uvms, random_robot

Array = NDArray[np.float64]
ROBOTS = {"uvms": paper_uvms()} | {
    f"random robot {seed}": random_robot(np.random.default_rng(seed), joints=4 + seed % 9)
    for seed in range(54)
}
CONFIGURATIONS = 3


@dataclass(frozen=True)
class Kinematics:
    """Tool pose (4, 4) and the three Jacobians (6, n) at one configuration."""

    pose: Array
    spatial: Array
    body: Array
    geometric: Array


def by_pinocchio(robot: SerialRobot) -> Callable[[Array], Kinematics]:
    model, tool = pinocchio_model(robot)
    data = model.createData()
    frames = (
        pinocchio.ReferenceFrame.WORLD,
        pinocchio.ReferenceFrame.LOCAL,
        pinocchio.ReferenceFrame.LOCAL_WORLD_ALIGNED,
    )

    def kinematics(q: Array) -> Kinematics:
        jacobians = [pinocchio.computeFrameJacobian(model, data, q, tool, frame).copy() for frame in frames]
        pinocchio.framesForwardKinematics(model, data, q)
        return Kinematics(data.oMf[tool].homogeneous.copy(), *jacobians)

    return kinematics


def by_roboticstoolbox(robot: SerialRobot) -> Callable[[Array], Kinematics]:
    transforms = roboticstoolbox_transforms(robot)

    def kinematics(q: Array) -> Kinematics:
        T, geometric = transforms.fkine(q).A, transforms.jacob0(q)
        return Kinematics(T, spatial_from_geometric(geometric, T), transforms.jacobe(q), geometric)

    return kinematics


def by_pytorch_kinematics(robot: SerialRobot) -> Callable[[Array], Kinematics]:
    chain = pytorch_kinematics_chain(robot)

    def kinematics(q: Array) -> Kinematics:
        J, poses = chain.jacobian(torch.from_numpy(q), ret_eef_pose=True)
        T, geometric = poses[0].numpy(), J[0].numpy()
        R = T[:3, :3]
        body = np.concatenate([R.T @ geometric[:3], R.T @ geometric[3:]])
        return Kinematics(T, spatial_from_geometric(geometric, T), body, geometric)

    return kinematics


def spatial_from_geometric(geometric: Array, T: Array) -> Array:
    v, omega = geometric[:3], geometric[3:]
    return np.concatenate([v + np.cross(T[:3, 3], omega, axisb=0).T, omega])


@pytest.fixture(
    params=[by_pinocchio, by_roboticstoolbox, by_pytorch_kinematics], ids=lambda library: library.__name__
)
def library(request: pytest.FixtureRequest) -> Callable[[SerialRobot], Callable[[Array], Kinematics]]:
    return request.param


@pytest.mark.parametrize("robot", ROBOTS.values(), ids=ROBOTS)
def test_kinematics_and_indices_are_those_of_other_libraries(rng, library, robot):
    chain = robot.chain()
    kinematics = library(robot)
    q = rng.uniform(-np.pi, np.pi, (CONFIGURATIONS, chain.joints))
    theirs = [kinematics(one) for one in q]
    assert_allclose(chain.forward(q), [each.pose for each in theirs], rtol=0, atol=1e-10)
    for frame in ("spatial", "body", "geometric"):
        J = getattr(chain, f"{frame}_jacobian")(q)
        their_J = np.array([getattr(each, frame) for each in theirs])
        assert_allclose(J, their_J, rtol=0, atol=1e-10)
        # With fewer joints than rows numpy gives min(6, n) values: the others are zero.
        sigma = np.zeros((len(q), 6))
        sigma[:, : chain.joints] = np.linalg.svd(their_J, compute_uv=False)
        assert_allclose(dx.indices.manipulability(J), sigma.prod(-1), rtol=1e-9, atol=1e-12)
        assert_allclose(
            dx.indices.kinematic_conditioning(J), sigma[:, -1] / sigma[:, 0], rtol=1e-9, atol=1e-12
        )


def test_the_random_robots_are_at_least_fifty_of_four_to_twelve_mixed_joints():
    robots = [robot for name, robot in ROBOTS.items() if name != "uvms"]
    assert len(robots) >= 50
    assert {len(robot.joints) for robot in robots} == set(range(4, 13))
    assert all({joint.kind for joint in robot.joints} == {"revolute", "prismatic"} for robot in robots)


def test_the_uvms_of_the_paper_is_the_robot_file():
    paper, file = paper_uvms().chain(), dx.robots.uvms()
    assert_allclose(file.screws, paper.screws, rtol=0, atol=1e-15)
    assert_allclose(file.home, paper.home, rtol=0, atol=1e-15)


@pytest.mark.parametrize("modified", [False, True], ids=["standard", "modified"])
@pytest.mark.parametrize("kinds", ["RRRRRR", "RPRPRP", "PPPR"])
def test_denavit_hartenberg_rows_are_those_of_roboticstoolbox(rng, modified, kinds):
    links, rows = [], []
    for kind in kinds:
        theta, d, a, alpha = rng.normal(size=4)
        rows.append({"theta": theta, "d": d, "a": a, "alpha": alpha})
        convention = "MDH" if modified else "DH"
        if kind == "R":
            link = getattr(roboticstoolbox, f"Revolute{convention}")(d=d, a=a, alpha=alpha, offset=theta)
        else:
            rows[-1]["kind"] = "prismatic"
            link = getattr(roboticstoolbox, f"Prismatic{convention}")(theta=theta, a=a, alpha=alpha, offset=d)
        links.append(link)
    theirs = roboticstoolbox.DHRobot(links)
    chain = dx.Chain.from_dh(rows, modified)
    for q in rng.uniform(-2, 2, (5, len(kinds))):
        assert_allclose(chain.forward(q), theirs.fkine(q).A, rtol=0, atol=1e-13)
        assert_allclose(chain.geometric_jacobian(q), theirs.jacob0(q), rtol=0, atol=1e-13)
        assert_allclose(chain.body_jacobian(q), theirs.jacobe(q), rtol=0, atol=1e-13)


def test_the_puma_is_that_of_roboticstoolbox_from_its_shoulder_on(rng):
    """Theirs stands on a base of 0.672 m and its forearm is 0.05 mm further out: 0.15005 m for our 0.15 m."""
    theirs = roboticstoolbox.models.DH.Puma560()
    theirs.links[0].d = 0
    assert theirs.links[2].d == pytest.approx(0.15, abs=1e-4)
    theirs.links[2].d = 0.15
    puma = dx.robots.puma560()
    for q in rng.uniform(puma.lower, puma.upper, (5, 6)):
        assert_allclose(puma.forward(q), theirs.fkine(q).A, rtol=0, atol=1e-13)
        assert_allclose(puma.geometric_jacobian(q), theirs.jacob0(q), rtol=0, atol=1e-13)
        assert_allclose(
            dx.indices.manipulability(puma.geometric_jacobian(q)), theirs.manipulability(q), rtol=1e-9
        )
    assert_allclose(np.array([puma.lower, puma.upper]), theirs.qlim, rtol=0, atol=1e-13)
