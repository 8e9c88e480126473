"""Every end of every robot of a public collection of URDFs: poses, Jacobians and limits are pinocchio's."""

import importlib.metadata
import math
import warnings
from pathlib import Path

import pinocchio
import pytest
from numpy.testing import assert_allclose

import dexterity as dx
from dexterity import urdf

FOLDER = Path(
    importlib.metadata.distribution("example-robot-data").locate_file(
        "cmeel.prefix/share/example-robot-data/robots"
    )
)
NOT_ROBOTS = ("ur_description/urdf/ur3.urdf",)  # a document without links
FILES = {
    name: path
    for path in sorted(FOLDER.rglob("*.urdf"))
    if (name := path.relative_to(FOLDER).as_posix()) not in NOT_ROBOTS
}


def read_chain(robot: urdf.Model, tip: str) -> dx.Chain | None:
    """Chain to a tip, or None where a coupled joint stands on the way."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", ".*has velocity 0", UserWarning)
        try:
            return dx.Chain.from_urdf(robot, tip=tip)
        except ValueError as error:
            if "mimics joint" not in str(error):
                raise
            return None


def test_the_collection_is_large():
    assert len(FILES) >= 60


@pytest.mark.parametrize("file", FILES)
def test_all_ends_of_a_robot_move_as_in_pinocchio(rng, file):
    path = FILES[file]
    model = pinocchio.buildModelFromUrdf(str(path))
    data = model.createData()
    robot = urdf.read(path)
    for tip in robot.leaves():
        chain = read_chain(robot, tip)
        if chain is None:
            continue
        joints = [model.joints[model.getJointId(name)] for name in chain.joint_names]
        values = rng.uniform(-1, 1, chain.joints)
        q = pinocchio.neutral(model)
        for joint, value in zip(joints, values, strict=True):
            # A joint without limits is a point of the unit circle there.
            q[joint.idx_q : joint.idx_q + joint.nq] = (
                value if joint.nq == 1 else [math.cos(value), math.sin(value)]
            )
        columns = [joint.idx_v for joint in joints]
        pinocchio.computeJointJacobians(model, data, q)
        pinocchio.updateFramePlacements(model, data)
        frame = model.getFrameId(tip, pinocchio.FrameType.BODY)
        assert_allclose(chain.forward(values), data.oMf[frame].homogeneous, rtol=0, atol=1e-13)
        for ours, theirs in (
            (chain.geometric_jacobian, pinocchio.ReferenceFrame.LOCAL_WORLD_ALIGNED),
            (chain.body_jacobian, pinocchio.ReferenceFrame.LOCAL),
            (chain.spatial_jacobian, pinocchio.ReferenceFrame.WORLD),
        ):
            J = pinocchio.getFrameJacobian(model, data, frame, theirs)
            assert_allclose(ours(values), J[:, columns], rtol=0, atol=1e-13)
        for joint, lower, upper in zip(joints, chain.lower.tolist(), chain.upper.tolist(), strict=True):
            if joint.nq == 1:
                assert (lower, upper) == (
                    model.lowerPositionLimit[joint.idx_q],
                    model.upperPositionLimit[joint.idx_q],
                )
            else:
                assert (lower, upper) == (-math.inf, math.inf)
