"""Screws, exponentials and adjoints written out with symbols, for the derivation that the chapter shows.

Entries are sympy's. The order of a twist is [v; ω], as in the library.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import sympy
from sympy import Expr, Matrix

from dexterity import robots
from dexterity.derivation.symbolic_chain import SymbolicChain

__all__ = [
    "adjoint",
    "column",
    "column_by_differentiation",
    "exponential",
    "hat",
    "miss_of_the_library",
    "screw",
    "unit_screw",
    "uvms",
    "vanishes",
    "vee",
]


def uvms() -> SymbolicChain:
    """Return the vehicle and its arm with their lengths as symbols, where the paper has them."""
    return SymbolicChain.from_description(robots.describe("uvms"))


def unit_screw() -> Matrix:
    """Return any screw (6, 1) with a unit vector ω: symbols for v, and two angles for the direction of ω."""
    azimuth, height = sympy.symbols("phi psi", real=True)
    across = sympy.cos(height)
    axis = (across * sympy.cos(azimuth), across * sympy.sin(azimuth), sympy.sin(height))
    return Matrix([*sympy.symbols("v_x v_y v_z", real=True), *axis])


def hat(screw: Matrix) -> Matrix:
    """Return the matrix (4, 4) that turns a point [p; 1] into its velocity [ṗ; 0] while a body follows a screw (6, 1)."""
    v, omega = screw[:3, :], screw[3:, :]
    return Matrix.vstack(Matrix.hstack(_cross(omega), v), sympy.zeros(1, 4))


def vee(matrix: Matrix) -> Matrix:
    """Return the screw (6, 1) of a matrix (4, 4) that :func:`hat` returns."""
    return Matrix([matrix[0, 3], matrix[1, 3], matrix[2, 3], matrix[2, 1], matrix[0, 2], matrix[1, 0]])


def exponential(screw: Matrix, q: Expr | float) -> Matrix:
    """Return the motion (4, 4) of a joint with a screw (6, 1): the sum of the power series of its hat times q.

    For a revolute joint the fourth power of the hat is minus the second, for a prismatic joint the second is zero, so
    that the series has four terms in both cases.

    Raises
    ------
    ValueError
        If the fourth power of the hat is not minus the second.
    """
    S = hat(screw)
    if not vanishes(S**4 + S**2):
        raise ValueError(f"screw is {list(screw)}; a revolute or a prismatic joint of unit axis is needed")
    return (sympy.eye(4) + q * S + (1 - sympy.cos(q)) * S**2 + (q - sympy.sin(q)) * S**3).expand()


def adjoint(T: Matrix) -> Matrix:
    """Return the matrix (6, 6) that moves a screw by the rigid motion T (4, 4), so that its hat becomes T Ŝ T⁻¹."""
    R, p = T[:3, :3], T[:3, 3]
    return Matrix.vstack(Matrix.hstack(R, _cross(p) * R), Matrix.hstack(sympy.zeros(3, 3), R))


def column(chain: SymbolicChain, q: Sequence[Expr | float], joint: int) -> Matrix:
    """Return a column (6, 1) of the spatial Jacobian: the screw of a joint after the motion of those before it.

    Parameters
    ----------
    chain
        The chain.
    q
        A value of each joint: a symbol, or a number for a joint that rests.
    joint
        The joint, counted from 0.
    """
    return (adjoint(_motion(chain, q, joint)) * screw(chain, joint)).applyfunc(sympy.trigsimp)


def column_by_differentiation(chain: SymbolicChain, q: Sequence[Expr | float], joint: int) -> Matrix:
    """Return the same column from the derivative of the tool pose, times the inverse pose.

    The arguments are those of :func:`column`; the value of the joint is a symbol. Joints behind it and the home pose
    cancel, and are left out.
    """
    T = _motion(chain, q, joint + 1)
    return vee(sympy.diff(T, q[joint]) * _inverse(T))


def screw(chain: SymbolicChain, joint: int) -> Matrix:
    """Return the screw (6, 1) of a joint at home, by Eqs. 1 and 2 of the paper."""
    axis, point = Matrix(chain.axes[joint]), Matrix(chain.points[joint])
    if chain.kinds[joint] == "prismatic":
        return Matrix.vstack(axis, sympy.zeros(3, 1))
    return Matrix.vstack(-axis.cross(point), axis)


def vanishes(matrix: Matrix) -> bool:
    """Return whether all entries are zero for all values of their symbols, sines and cosines being exponentials."""
    return bool(matrix.applyfunc(lambda entry: entry.rewrite(sympy.exp).expand()).is_zero_matrix)


def miss_of_the_library(seed: int) -> float:
    """Return the largest difference between all twelve columns and those of the library, at joint values within ±1."""
    chain = robots.uvms()
    q = np.random.default_rng(seed).uniform(-1, 1, chain.joints)
    symbolic = SymbolicChain.from_chain(chain)
    columns = [column(symbolic, [sympy.Float(x) for x in q], joint) for joint in range(chain.joints)]
    derived = np.array(Matrix.hstack(*columns).evalf().tolist(), dtype=float)
    return float(np.abs(derived - chain.spatial_jacobian(q).numpy()).max())


def _motion(chain: SymbolicChain, q: Sequence[Expr | float], joints: int) -> Matrix:
    """Return the product of the exponentials of the first joints."""
    T = sympy.eye(4)
    for joint in range(joints):
        if q[joint] != 0:
            T = T * exponential(screw(chain, joint), q[joint])
    return T


def _inverse(T: Matrix) -> Matrix:
    R, p = T[:3, :3], T[:3, 3]
    return Matrix.vstack(Matrix.hstack(R.T, -R.T * p), Matrix([[0, 0, 0, 1]]))


def _cross(omega: Matrix) -> Matrix:
    x, y, z = omega
    return Matrix([[0, -z, y], [z, 0, -x], [-y, x, 0]])
