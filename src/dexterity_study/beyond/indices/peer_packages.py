"""Dexterity indices by other packages: by numpy from the Jacobian of pinocchio, and by roboticstoolbox."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any, TypeAlias

import numpy as np

from dexterity.chain import Chain
from dexterity.indices import Index

PINOCCHIO, TOOLBOX = "pinocchio and numpy", "roboticstoolbox"
Function: TypeAlias = Callable[[np.ndarray], float]
"""Value of one configuration (n,)."""

_METHODS = {
    "manipulability": "yoshikawa",
    "smallest_singular_value": "minsingular",
    "kinematic_conditioning": "invcondition",
}
_AXES = {"full": "all", "translational": "trans", "rotational": "rot"}


def indices(chain: Chain, index: Index) -> dict[str, Function]:
    """Return the index by each package that has it, for joint rates of 1 and the geometric Jacobian."""
    if index.name not in _METHODS or index.frame != "geometric" or index.characteristic_length:
        return {}
    jacobian, rows, toolbox = _pinocchio_jacobian(chain), list(index.row_numbers), _toolbox_robot(chain)

    def by_pinocchio(q: np.ndarray) -> float:
        return _by_numpy(index.name, jacobian(q)[rows])

    def by_toolbox(q: np.ndarray) -> float:
        return float(toolbox.manipulability(q, method=_METHODS[index.name], axes=_AXES[str(index.rows)]))

    return {PINOCCHIO: by_pinocchio, TOOLBOX: by_toolbox}


def _by_numpy(name: str, J: np.ndarray) -> float:
    if name == "manipulability":
        return float(np.sqrt(np.linalg.det(J @ J.T)))
    sigma = np.linalg.svd(J, compute_uv=False)
    return float(sigma[-1] if name == "smallest_singular_value" else sigma[-1] / sigma[0])


def _pinocchio_jacobian(chain: Chain) -> Callable[[np.ndarray], np.ndarray]:
    import pinocchio

    kinds = {"revolute": pinocchio.JointModelRZ, "prismatic": pinocchio.JointModelPZ}
    model, last = pinocchio.Model(), 0
    links = chain.link_transforms.numpy()
    for i, kind in enumerate(chain.kinds):
        last = model.addJoint(last, kinds[kind](), pinocchio.SE3(links[i]), f"joint {i}")
    frame = pinocchio.Frame("tool", last, 0, pinocchio.SE3(links[-1]), pinocchio.FrameType.OP_FRAME)
    tool, data = model.addFrame(frame), model.createData()

    def jacobian(q: np.ndarray) -> np.ndarray:
        return pinocchio.computeFrameJacobian(model, data, q, tool, pinocchio.LOCAL_WORLD_ALIGNED)

    return jacobian


def _toolbox_robot(chain: Chain) -> Any:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        from roboticstoolbox import ET, ETS, Robot
        from spatialmath import SE3

    links = chain.link_transforms.numpy()
    motions = {"revolute": ET.Rz, "prismatic": ET.tz}
    transforms = [ET.SE3(SE3(links[0], check=False))]
    for kind, link in zip(chain.kinds, links[1:], strict=True):
        transforms += [motions[kind](), ET.SE3(SE3(link, check=False))]
    return Robot(ETS(transforms))  # type: ignore[operator]
