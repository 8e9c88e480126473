"""Each end of each robot of a collection: poses, Jacobians, limits and masses are those of pinocchio."""

import importlib.metadata
import math
import warnings
from pathlib import Path

import numpy as np
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
        warnings.filterwarnings("ignore", ".*(has velocity 0|cannot move|no body has them)", UserWarning)
        try:
            return dx.Chain.from_urdf(robot, tip=tip)
        except ValueError as error:
            if "mimics joint" not in str(error):
                raise
            return None


def placed(model: pinocchio.Model, chain: dx.Chain, values: np.ndarray) -> tuple[np.ndarray, list[int]]:
    """Joint values of the whole robot, the chain's as given, and where the chain's rates stand among all."""
    q, columns = pinocchio.neutral(model), []
    for name, value in zip(chain.joint_names, values, strict=True):
        joint = model.joints[model.getJointId(name)]
        # A joint without limits is a point of the unit circle there.
        q[joint.idx_q : joint.idx_q + joint.nq] = (
            value if joint.nq == 1 else [math.cos(value), math.sin(value)]
        )
        columns.append(joint.idx_v)
    return q, columns


def test_the_collection_is_large():
    assert len(FILES) >= 60


def limits_of(model: pinocchio.Model, name: str) -> tuple[float, float]:
    joint = model.joints[model.getJointId(name)]
    if joint.nq == 2:
        return -math.inf, math.inf
    return model.lowerPositionLimit[joint.idx_q], model.upperPositionLimit[joint.idx_q]


@pytest.mark.parametrize("file", FILES)
def test_all_ends_of_a_robot_move_as_in_pinocchio(rng, file):
    path = FILES[file]
    model = pinocchio.buildModelFromUrdf(str(path))
    data = model.createData()
    robot = urdf.read(path)
    chain = None
    for tip in robot.leaves():
        chain = read_chain(robot, tip)
        if chain is None:
            continue
        values = rng.uniform(-1, 1, chain.joints)
        q, columns = placed(model, chain, values)
        pinocchio.computeJointJacobians(model, data, q)
        pinocchio.updateFramePlacements(model, data)
        frame = model.getFrameId(tip, pinocchio.FrameType.BODY)
        assert_allclose(chain.forward(values), data.oMf[frame].homogeneous, rtol=0, atol=1e-13)
        in_world_axes = pinocchio.ReferenceFrame.LOCAL_WORLD_ALIGNED
        J = pinocchio.getFrameJacobian(model, data, frame, in_world_axes)[:, columns]
        assert_allclose(chain.geometric_jacobian(values), J, rtol=0, atol=1e-13)
        limits = zip(chain.lower.tolist(), chain.upper.tolist(), strict=True)
        assert list(limits) == [limits_of(model, name) for name in chain.joint_names]
    if chain is not None and chain.inertias is not None:
        # What moves with a link counts, all joints beside the chain at zero and at rest.
        M = np.triu(pinocchio.crba(model, data, q))
        M = (M + np.triu(M, 1).T)[np.ix_(columns, columns)]
        assert_allclose(chain.mass_matrix(values), M, rtol=1e-9, atol=1e-12 * abs(M).max())
