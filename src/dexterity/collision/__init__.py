"""Bodies on a robot and around it: distances, and whether a configuration brings them into collision.

Shapes are spheres, capsules and boxes. They stand on links of a chain, on its base, or in the world.

Examples
--------
>>> import dexterity as dx
>>> arm = dx.robots.panda()
>>> table = dx.collision.Body(dx.collision.Box((1, 1, 0.1), centre=(0.6, 0, -0.05)), "world", "table")
>>> bodies = dx.collision.Bodies(arm, [*dx.collision.capsules(arm, radius=0.03), table])
>>> q = [[0, 0, 0, -1.5, 0, 1.5, 0], [0, 1.9, 0, -0.5, 0, 1.5, 0]]
>>> bodies.collides(q).tolist()
[False, True]
>>> dx.collision.in_c(bodies).collides(q).tolist()
[False, True]
"""

from dexterity.collision.bodies import TOUCH, Bodies
from dexterity.collision.compiled import CompiledBodies, c_source, in_c
from dexterity.collision.shapes import Body, Box, Capsule, Link, Shape, Sphere, capsules

__all__ = [
    "TOUCH",
    "Bodies",
    "Body",
    "Box",
    "Capsule",
    "CompiledBodies",
    "Link",
    "Shape",
    "Sphere",
    "c_source",
    "capsules",
    "in_c",
]
