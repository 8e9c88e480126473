"""The same robot as a model of pinocchio, of roboticstoolbox and of pytorch_kinematics, joint by joint."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pinocchio
import pytorch_kinematics
import torch
from pytorch_kinematics.transforms import Transform3d
from roboticstoolbox import ET, ETS
from scipy.spatial.transform import Rotation
from spatialmath import SE3

from serial_chains import SerialRobot


def pinocchio_model(robot: SerialRobot) -> tuple[pinocchio.Model, int]:
    """Model, and the number of its tool frame."""
    kinds = {
        "revolute": pinocchio.JointModelRevoluteUnaligned,
        "prismatic": pinocchio.JointModelPrismaticUnaligned,
    }
    model, last = pinocchio.Model(), 0
    for i, joint in enumerate(robot.joints):
        placement = pinocchio.SE3(joint.placement)
        last = model.addJoint(last, kinds[joint.kind](joint.axis), placement, f"joint {i}")
    tool = pinocchio.Frame("tool", last, 0, pinocchio.SE3(robot.tool), pinocchio.FrameType.OP_FRAME)
    return model, model.addFrame(tool)


def roboticstoolbox_transforms(robot: SerialRobot) -> ETS:
    """Elementary transforms; joints move about and along z, so z is turned into the joint's axis and back."""
    transforms = []
    for joint in robot.joints:
        z_to_axis = np.eye(4)
        z_to_axis[:3, :3] = Rotation.align_vectors(joint.axis, [0, 0, 1])[0].as_matrix()
        motion = ET.Rz() if joint.kind == "revolute" else ET.tz()
        transforms += [ET.SE3(SE3(joint.placement @ z_to_axis)), motion, ET.SE3(SE3(z_to_axis.T))]
    return ETS([*transforms, ET.SE3(SE3(robot.tool))])


def pytorch_kinematics_chain(robot: SerialRobot) -> pytorch_kinematics.SerialChain:
    """Chain in float64, put together from frames: the URDF reader rounds poses to float32."""
    frames = [pytorch_kinematics.Frame("base")]
    for i, joint in enumerate(robot.joints):
        axis = torch.from_numpy(joint.axis)
        motion = pytorch_kinematics.Joint(
            f"joint {i}", _offset(joint.placement), joint.kind, axis, dtype=torch.float64
        )
        frames.append(pytorch_kinematics.Frame(f"link {i}", joint=motion))
    fixed = pytorch_kinematics.Joint("tool joint", _offset(robot.tool), "fixed", dtype=torch.float64)
    frames.append(pytorch_kinematics.Frame("tool", joint=fixed))
    for parent, child in pairwise(frames):
        parent.add_child(child)
    tree = pytorch_kinematics.Chain(frames[0], dtype=torch.float64)
    return pytorch_kinematics.SerialChain(tree, "tool", dtype=torch.float64)


def _offset(pose: np.ndarray) -> Transform3d:
    return Transform3d(matrix=torch.from_numpy(pose), dtype=torch.float64)
