"""Inertia of the arms against the robotics toolbox and against kinetic energy."""

import numpy as np
import pytest
import roboticstoolbox
import torch
from torch.testing import assert_close

from dexterity import spatial
from dexterity.workspace import dataset, dynamics, reachability

DATA = dataset.jacobian_data(40, seed=5, threshold=0.0)
LINKS = DATA.samples.links
PARAMETERS = DATA.samples.dynamics
T = spatial.pose(DATA.samples.rotation(), DATA.samples.position)
Q, _ = reachability.inverse(LINKS, T)


def peer(i: int) -> roboticstoolbox.DHRobot:
    d3, d4, a2, a3 = LINKS[i].tolist()
    return roboticstoolbox.DHRobot(
        [
            roboticstoolbox.RevoluteDH(
                d=(0, 0, d3, d4, 0, 0)[k],
                a=(0, a2, a3, 0, 0, 0)[k],
                alpha=reachability.TWISTS[k],
                m=float(PARAMETERS.mass[i, k]),
                r=PARAMETERS.centre[i, k].numpy(),
                I=PARAMETERS.inertia[i, k].numpy(),
                G=float(PARAMETERS.gear[i, k]),
                Jm=float(PARAMETERS.motor[i, k]),
            )
            for k in range(6)
        ]
    )


@pytest.mark.parametrize("i", range(4))
@pytest.mark.filterwarnings("ignore:__array_wrap__:DeprecationWarning")
def test_inertia_is_the_robotics_toolboxs(i):
    robot, q = peer(i), Q[i].numpy()
    M = dynamics.joint_inertia(LINKS, PARAMETERS, Q)[i]
    assert_close(M, torch.as_tensor(robot.inertia(q)), atol=1e-12, rtol=1e-12)
    theirs = robot.inertia_x(q)[:3, :3]
    ours = dynamics.cartesian_inertia(LINKS, PARAMETERS, Q)[i].numpy()
    np.testing.assert_allclose(ours, theirs, rtol=1e-9, atol=1e-9 * np.abs(theirs).max())
    ratio = dynamics.asada_ratio(LINKS, PARAMETERS, Q)[i]
    assert float(ratio) == pytest.approx(robot.manipulability(q, method="asada", axes="trans"), rel=1e-6)


def test_inertia_is_positive_and_symmetric():
    M = dynamics.joint_inertia(LINKS, PARAMETERS, Q)
    assert_close(M, M.mT)
    assert (torch.linalg.eigvalsh(M) > 0).all()


def test_a_singular_arm_has_no_ratio():
    straight = torch.zeros(1, 6, dtype=torch.float64)
    one = PARAMETERS.rows(torch.tensor([0]))
    assert dynamics.asada_ratio(LINKS[:1], one, straight).tolist() == [0.0]
    assert dynamics.cartesian_inertia(LINKS[:1], one, straight).abs().max() == 0


def test_friction_plays_no_part():
    other = PARAMETERS._replace(viscous=2 * PARAMETERS.viscous, coulomb=0 * PARAMETERS.coulomb)
    assert_close(
        dynamics.joint_inertia(LINKS, other, Q), dynamics.joint_inertia(LINKS, PARAMETERS, Q), rtol=0, atol=0
    )


def test_parameters_that_do_not_fit_are_named():
    for name in ("mass", "centre", "coulomb"):
        part = getattr(PARAMETERS, name)
        with pytest.raises(ValueError, match=f"^{name} has shape"):
            dynamics.joint_inertia(LINKS, PARAMETERS._replace(**{name: part[..., :1]}), Q)
        with pytest.raises(ValueError, match=f"^{name} is not finite"):
            dynamics.joint_inertia(LINKS, PARAMETERS._replace(**{name: part * float("nan")}), Q)
    with pytest.raises(ValueError, match="do not broadcast"):
        dynamics.joint_inertia(LINKS, PARAMETERS.rows(torch.arange(3)), Q)
