"""Jacobians and dexterity indices of a chain, derived in sines and cosines of its joints.

The lengths of the chain are numbers or symbols. A rotation of the axes changes neither index, and w does
not depend on the reference point either. The Jacobian is therefore written in the axes of the link, and for
w about the point, that give the fewest operations. Neighbouring parallel axes become one rotation by the sum
of their angles. Joints on which the Jacobian does not depend appear in no step. Joints that cancel only by
an identity of sines and cosines are not recognised.

Examples
--------
A planar arm with links of 0.5 m and 0.25 m. Its Jacobian about the tool is shortest in the axes of link 1,
which turn with q1, so that q1 is not needed:

>>> from dexterity.chain import Chain
>>> from dexterity.derivation import derive
>>> from dexterity.indices import Index
>>> arm = Chain.from_dh([{"a": 0.5}, {"a": 0.25}])
>>> derivation = derive(arm, Index("kinematic_conditioning", "geometric"))
>>> derivation.link, derivation.reference, derivation.matters
(1, 3, (2,))

The recorded program names each expression once. The vector from joint 2 to the tool is (x4, x5), from
joint 1 it is (x6, x5). x2 and x3 named expressions that no output needs:

>>> for name, expression in derivation.jacobian.steps:
...     print(name, "=", expression.evalf(3))
x0 = sin(q2)
x1 = cos(q2)
x4 = 0.25*x1
x5 = 0.25*x0
x6 = x4 + 0.5

Its outputs are the 6 × 2 Jacobian [v; ω] row by row. Both joints turn about z:

>>> for i in range(0, 12, 2):
...     print(derivation.jacobian.outputs[i : i + 2])
(-x5, -x5)
(x6, x4)
(0, 0)
(0, 0)
(0, 0)
(1, 1)

References
----------
Murray, Li & Sastry (1994), section 3.4; Golub & Van Loan (2013), sections 5.2 and 8.6.
"""

from dexterity.derivation.programs import Derivation, derive
from dexterity.derivation.symbolic_chain import SymbolicChain, exact

__all__ = ["Derivation", "SymbolicChain", "derive", "exact"]
