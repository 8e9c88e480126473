"""Serial chains out of URDF files: the joints between two links, with their limits, rates and inertias.

Only the path from the base link to the tip link is read in detail. Whatever lies beside it may be of any
kind, since it does not change the kinematics of the path. Its mass counts: a link beside the path moves
with the path's link that carries it, all joints beside the path at zero.

Examples
--------
>>> from dexterity import urdf
>>> text = '''<robot name="slider"><link name="rail"/><link name="carriage"/>
...   <joint name="slide" type="prismatic"><parent link="rail"/><child link="carriage"/>
...     <axis xyz="2 0 0"/><limit lower="0" upper="0.5" velocity="0.2"/></joint></robot>'''
>>> path = urdf.read(text).path()
>>> path.joint_names, path.screws.tolist(), path.upper
(('slide',), [[1.0, 0.0, 0.0, 0.0, 0.0, 0.0]], (0.5,))
"""

from dexterity.urdf.model import Model, SerialPath, read

__all__ = ["Model", "SerialPath", "read"]
