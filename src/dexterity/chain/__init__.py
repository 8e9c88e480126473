"""Serial chains of revolute and prismatic joints: forward kinematics, the three Jacobians, the mass matrix.

A chain is given by its screws and its tool pose at home (product of exponentials, Murray, Li & Sastry 1994,
section 3.2), by Denavit–Hartenberg rows, or by a URDF. A chain can be mounted on a vehicle or on a wheeled
base, moved, given another tool, and have joints locked; each of these returns a new chain.

Examples
--------
>>> import dexterity as dx
>>> arm = dx.Chain.from_dh([{"a": 0.5}, {"a": 0.25}], name="arm")
>>> arm.forward([0, 0])[:3, 3].tolist()
[0.75, 0.0, 0.0]
>>> arm.geometric_jacobian([[0, 0], [0, 1], [1, 0]]).shape
torch.Size([3, 6, 2])
>>> arm.on_vehicle(dx.spatial.translation(0.3, 0, 0), joints=("x", "y", "rz"))
Chain('arm on a vehicle', 5 joints, tool at (1.05, 0, 0) m)
  x        prismatic  without limits                       1 m/s
  y        prismatic  without limits                       1 m/s
  rz       revolute   without limits                     1 rad/s
  joint 1  revolute   without limits                     1 rad/s
  joint 2  revolute   without limits                     1 rad/s
"""

from dexterity.chain.geometry import JointKind
from dexterity.chain.inertias import Inertias
from dexterity.chain.serial import Chain

__all__ = ["Chain", "Inertias", "JointKind"]
