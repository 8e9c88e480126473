r"""One branch of the family of paper C from a pose alone, with square roots and divisions and nothing else.

An angle is never needed, only its cosine and sine. With V ahead and z above the shoulder in the arm's plane,
ε at the elbow, L the forearm and h the sine between the forearm's axis and the tool's, the Jacobian falls
apart into two blocks of three, and

.. math:: w = |\det J| = a_2 L \, |\sin\varepsilon| \, |V| \, |\sin\theta_5|, \qquad |\sin\theta_5| = h .

Where a position is out of reach, a square root has a negative argument, and everything is NaN. The steps are
recorded once; torch runs them as they are, and :mod:`dexterity.workspace.compiled` prints them in C.

Examples
--------
>>> import torch
>>> from dexterity.workspace import closed_form, reachability
>>> links = torch.tensor([0.15, 0.43, 0.43, 0.02], dtype=torch.float64)
>>> T = reachability.arm(links).forward([0.0, 0.5, 0.25, 0.0, 0.5, 0.0])
>>> closed_form.in_torch(reachability.NAMED_BRANCH, "jacobian")(links, T).shape
torch.Size([36])
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping

import sympy
import torch
from sympy import Expr, Symbol
from torch import Tensor

from dexterity import checks
from dexterity.codegen.torch_code import TensorFunction, torch_function
from dexterity.program import Program, Recorder
from dexterity.workspace.reachability import LINK_NAMES, NAMED_BRANCH, Branch

__all__ = ["LINKS", "PARTS", "POSE", "derive", "in_torch", "part"]

LINKS: tuple[Symbol, ...] = sympy.symbols(LINK_NAMES, positive=True)
"""Symbols of d₃, d₄, a₂ and a₃, with which the inputs of a program begin."""

POSE: tuple[Symbol, ...] = sympy.symbols("t0:4(0:4)", real=True)
"""Symbols of the sixteen numbers of T_base_tool, row by row, the other inputs."""

_NOTHING = sympy.Float("1e-150")
"""Vanishes beside any length, and its square is still a number: gives angles a value where they have none."""


PARTS: Mapping[str, slice] = {
    "cosines": slice(0, 6),
    "sines": slice(6, 12),
    "jacobian": slice(12, 48),
    "manipulability": slice(48, 49),
    "defect": slice(49, 50),
}
"""Outputs of a program.

Cosines and sines are those of the joint angles, the geometric Jacobian comes row by row, w is in [m³], and
the defect is the sum of the squares of all that keeps the pose from being rigid.
"""


@checks.arguments(branch=checks.Instance(Branch))
@functools.cache
def derive(branch: Branch = NAMED_BRANCH) -> Program:
    """Record the steps from :data:`LINKS` and :data:`POSE` to a branch; the outputs are :data:`PARTS`.

    Where an angle may have any value, over the first axis and where the tool's axis is the forearm's, it has
    that of :func:`dexterity.workspace.reachability.inverse`.

    Parameters
    ----------
    branch
        Which of the eight configurations.
    """
    note = Recorder()
    c1, s1, ahead = _shoulder(note, branch)
    c2, s2, u, v, bent = _elbow(note, ahead, branch)
    _, d4, _, a3 = LINKS
    length = note(a3**2 + d4**2)
    c23, s23 = note(note(a3 * u + d4 * v) / length), note(note(a3 * v - d4 * u) / length)
    c3, s3 = note(c23 * c2 + s23 * s2), note(s23 * c2 - c23 * s2)
    rows = _seen_from_the_forearm(note, c1, s1, c23, s23)
    c4, s4, across = _wrist(note, rows[0][2], rows[1][2], branch)
    x, y, z = (POSE[4 * i + 3] for i in range(3))
    fifth = [
        note(s4 * along - c4 * beside)
        for along, beside in zip((note(c23 * c1), note(c23 * s1), s23), (-s1, c1, sympy.S.Zero), strict=True)
    ]
    zero, one = sympy.S.Zero, sympy.S.One
    columns = [
        [-y, x, zero, zero, zero, one],
        [-note(c1 * z), -note(s1 * z), ahead, s1, -c1, zero],
        [-note(c1 * v), -note(s1 * v), u, s1, -c1, zero],
        [zero, zero, zero, -note(s23 * c1), -note(s23 * s1), c23],
        [zero, zero, zero, *fifth],
        [zero, zero, zero, *(POSE[4 * i + 2] for i in range(3))],
    ]
    turned = [note(c4 * rows[1][i] - s4 * rows[0][i]) for i in range(2)]
    sign = 1 if branch.flip else -1
    cosines = [c1, c2, c3, c4, rows[2][2], turned[1]]
    sines = [s1, s2, s3, s4, sign * across, turned[0]]
    w = note(note(bent * note(sympy.Abs(ahead))) * across)

    whole = [column[i] for i in range(6) for column in columns]
    return note.program((*LINKS, *POSE), [*cosines, *sines, *whole, w, _defect(note)])


@checks.arguments(program=checks.Instance(Program), names=checks.Each(checks.Choice(tuple(PARTS))))
def part(program: Program, *names: str) -> Program:
    """Return what leads to some of :data:`PARTS`, in the order of the names."""
    return program.leading_to(output for name in names for output in program.outputs[PARTS[name]])


@checks.arguments(branch=checks.Instance(Branch), names=checks.Each(checks.Choice(tuple(PARTS))))
def in_torch(branch: Branch, *names: str) -> Callable[[Tensor, Tensor], Tensor]:
    """Return some of :data:`PARTS` as a function of tensors.

    Parameters
    ----------
    branch
        Which of the eight configurations.
    names
        Names of parts.

    Returns
    -------
    A function of links (..., 4) [m] and poses (..., 4, 4) whose batch axes are broadcast; (..., k) numbers of
    the parts, one after the other, NaN where a position is out of reach. It does not check what it is given.
    """
    compute = _torch_function(branch, names)

    def values(links: Tensor, T_base_tool: Tensor) -> Tensor:
        batch = torch.broadcast_shapes(links.shape[:-1], T_base_tool.shape[:-2])
        pose = T_base_tool.expand(*batch, 4, 4).flatten(-2)
        return torch.stack(compute([*links.expand(*batch, 4).unbind(-1), *pose.unbind(-1)]), -1)

    return values


@functools.cache
def _torch_function(branch: Branch, names: tuple[str, ...]) -> TensorFunction:
    return torch_function(part(derive(branch), *names))


def _shoulder(note: Recorder, branch: Branch) -> tuple[Expr, Expr, Expr]:
    """Cosine and sine of θ₁, and how far the target is ahead in the arm's plane, negative on the left."""
    d3 = LINKS[0]
    x, y = note(POSE[3] + _NOTHING), POSE[7]
    across = note(x**2 + y**2)
    ahead = (-1 if branch.left else 1) * note(sympy.sqrt(note(across - d3**2)))
    return note(note(x * ahead - y * d3) / across), note(note(y * ahead + x * d3) / across), ahead


def _elbow(note: Recorder, ahead: Expr, branch: Branch) -> tuple[Expr, Expr, Expr, Expr, Expr]:
    """Cosine and sine of θ₂, the wrist ahead of and above the elbow, and a₂ L times the sine at the elbow."""
    d3, d4, a2, a3 = LINKS
    z = POSE[11]
    forearm = note(sympy.sqrt(note(a3**2 + d4**2)))
    far = note(note(note(note(POSE[3] + _NOTHING) ** 2 + POSE[7] ** 2) - d3**2) + z**2)
    folded, straight = note(a2 - forearm), note(a2 + forearm)
    twice = note(sympy.sqrt(note(note(far - folded**2) * note(straight**2 - far))))
    bend = 1 if branch.left == branch.up else -1
    along, off = note(note(far + note(folded * straight)) / (2 * a2)), bend * note(twice / (2 * a2))
    c2, s2 = note(note(ahead * along + z * off) / far), note(note(z * along - ahead * off) / far)
    return c2, s2, note(ahead - a2 * c2), note(z - a2 * s2), note(twice / 2)


def _seen_from_the_forearm(note: Recorder, c1: Expr, s1: Expr, c23: Expr, s23: Expr) -> list[list[Expr]]:
    """Rotation of the tool in frame 3, at the end of the forearm."""
    rows: list[list[Expr]] = [[], [], []]
    for column in range(3):
        x, y, z = (POSE[4 * i + column] for i in range(3))
        ahead = note(c1 * x + s1 * y)
        rows[0].append(note(c23 * ahead + s23 * z))
        rows[1].append(note(c1 * y - s1 * x))
        rows[2].append(note(c23 * z - s23 * ahead))
    return rows


def _wrist(note: Recorder, first: Expr, second: Expr, branch: Branch) -> tuple[Expr, Expr, Expr]:
    """Cosine and sine of θ₄, and the size of the sine of θ₅."""
    first = note(first + _NOTHING)
    across = note(sympy.sqrt(note(first**2 + second**2)))
    sign = -1 if branch.flip else 1
    return sign * note(first / across), sign * note(second / across), across


def _defect(note: Recorder) -> Expr:
    R = sympy.Matrix(3, 3, lambda i, j: POSE[4 * i + j])
    wrong = [note(R[:, i].dot(R[:, j]) - int(i == j)) for i in range(3) for j in range(i, 3)]
    wrong.append(note(R[:, 0].dot(R[:, 1].cross(R[:, 2])) - 1))
    wrong += [POSE[12], POSE[13], POSE[14], note(POSE[15] - 1)]
    return note(sympy.Add(*(part**2 for part in wrong)))
