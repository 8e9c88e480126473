"""The closed form of the family of paper C in C99: reach, angles, Jacobian and w of a branch, for one arm.

Sixteen poses are worked on side by side, as in the files of ``dexterity.codegen.c99``. There is no branch
and no call of a trigonometric function: what is out of reach comes out as NaN by itself.

Examples
--------
>>> from dexterity.workspace.compiled import c_source
>>> "solution_batch" in c_source()
True
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Sequence
from functools import cached_property
from typing import NamedTuple, TypeAlias

import torch
from jaxtyping import Float64
from torch import Tensor

from dexterity import checks, spatial
from dexterity.codegen.c_file import CFile, commented
from dexterity.codegen.library import compiled_library, plain_memory
from dexterity.spatial import TensorLike
from dexterity.spatial.values import on_cpu, require_values
from dexterity.workspace.closed_form import LINKS, PARTS, POSE, derive, part
from dexterity.workspace.reachability import LINK_NAMES, NAMED_BRANCH, Branch, one_arm

__all__ = ["CompiledArm", "PoseFunction", "Solution", "c_source", "in_c"]

_NOT_RIGID = 2
_LARGEST_DEFECT = 1e-17  # some ten numbers that are off by 1e-9, squared
_SOLUTION = ("cosines", "sines", "jacobian", "manipulability")
_LAYOUT = {
    "cosines": "cosines of the 6 joint angles",
    "sines": "sines of the 6 joint angles",
    "jacobian": "geometric Jacobian, 6 rows of 6, linear rows first",
    "manipulability": "w, the size of its determinant [m^3]",
}


class Solution(NamedTuple):
    """A branch at poses. All numbers of a pose that is out of reach are NaN.

    Attributes
    ----------
    cosines, sines
        (..., 6) of the joint angles.
    jacobian
        (..., 6, 6) geometric Jacobian of the tool point.
    manipulability
        (...) w [m³].
    """

    cosines: Tensor
    sines: Tensor
    jacobian: Tensor
    manipulability: Tensor

    @property
    def reached(self) -> Tensor:
        """Whether a pose (...) is in reach."""
        return ~self.manipulability.isnan()

    @property
    def q(self) -> Tensor:
        """Joint angles (..., 6) from −π to π [rad]."""
        return torch.atan2(self.sines, self.cosines)


class CompiledArm:
    """One manipulator of the family, compiled at the first call; the C code is the same for all of them.

    Parameters
    ----------
    links
        (4,) d₃, d₄, a₂, a₃ [m].
    branch
        Which of the eight configurations.

    Raises
    ------
    ValueError
        If there are not four numbers, one is negative or not finite, or the upper arm a₂ or the forearm has
        no length, with which the arm reaches a surface alone.
    """

    def __init__(self, links: TensorLike, branch: Branch = NAMED_BRANCH) -> None:
        links = on_cpu(one_arm(links), "links")
        _, d4, a2, a3 = links.tolist()
        if a2 == 0 or d4 == a3 == 0:
            raise ValueError(f"links is {links.tolist()}; an upper arm and a forearm with lengths are needed")
        self._links = links.detach().contiguous()
        self._branch = checks.instance(branch, "branch", Branch)

    @cached_property
    def _solve(self) -> PoseFunction:
        return in_c(self._branch, *_SOLUTION)

    @cached_property
    def _value(self) -> PoseFunction:
        return in_c(self._branch, "manipulability")

    def solve(self, T_base_tool: TensorLike) -> Solution:
        """Return the branch at poses (..., 4, 4) of the tool in the base.

        Near the border of what is in reach, rounding decides.

        Raises
        ------
        ValueError
            If a shape does not fit, a pose is not rigid, or something is not finite.
        CompilationFailed
            If a compiler is missing or fails.
        OSError
            If the folder for compiled code cannot be written.
        """
        values = self._solve(self._links, T_base_tool)
        parts = {name: values[..., PARTS[name]] for name in _SOLUTION}
        return Solution(
            parts["cosines"],
            parts["sines"],
            parts["jacobian"].unflatten(-1, (6, 6)),
            parts["manipulability"][..., 0],
        )

    def manipulability(self, T_base_tool: TensorLike) -> Float64[Tensor, "*batch"]:
        """Return w of the branch [m³], NaN out of reach; the argument and errors are those of `solve`."""
        return self._value(self._links, T_base_tool)[..., 0]


PoseFunction: TypeAlias = Callable[[Tensor, TensorLike], Tensor]
"""Takes one arm (4,) and poses (..., 4, 4), and returns a row of numbers for each pose."""


@checks.arguments(branch=checks.Instance(Branch), names=checks.Each(checks.Choice(tuple(PARTS))))
def in_c(branch: Branch, *names: str) -> PoseFunction:
    """Return some of the parts of the closed form as a compiled function.

    Parameters
    ----------
    branch
        Which of the eight configurations.
    names
        Some of cosines, sines, jacobian and manipulability.

    Returns
    -------
    A function of the links (4,) [m] of one arm, which it does not check, and of poses (..., 4, 4); numbers
    (..., k) of the parts, one after the other. It raises ValueError where a pose is not rigid or not finite.

    Raises
    ------
    ValueError
        If a name is unknown.
    CompilationFailed
        If a compiler is missing or fails.
    OSError
        If the folder for compiled code cannot be written.
    """
    width = len(part(derive(branch), *names).outputs)
    function = compiled_library(c_source("arm", branch, names)).arm_batch
    pointer = ctypes.c_void_p
    function.argtypes = [pointer, pointer, ctypes.c_size_t, pointer]

    def values(links: Tensor, T_base_tool: TensorLike) -> Tensor:
        T = _poses(T_base_tool).detach()
        arm, poses = plain_memory(links), plain_memory(T)
        found = poses.new_empty(*poses.shape[:-2], width)
        error = function(arm.data_ptr(), poses.data_ptr(), poses.numel() // len(POSE), found.data_ptr())
        if error == _NOT_RIGID:
            spatial.require_rigid(T, "T_base_tool")
            raise ValueError("T_base_tool is not a rigid-body pose")
        return found if T.is_cpu else found.to(T.device)

    return values


def _poses(T_base_tool: TensorLike) -> Tensor:
    # NaN and infinities are no rigid poses for the C function; a look at them here would cost as much again.
    if not (
        isinstance(T_base_tool, Tensor)
        and T_base_tool.dtype is torch.float64
        and T_base_tool.layout is torch.strided
    ):
        T_base_tool = spatial.to_float64(T_base_tool, "T_base_tool")
    require_values(T_base_tool, "T_base_tool")
    if T_base_tool.shape[-2:] != (4, 4):
        raise ValueError(f"T_base_tool has shape {tuple(T_base_tool.shape)}; (..., 4, 4) is needed")
    return T_base_tool


def c_source(
    name: str = "solution", branch: Branch = NAMED_BRANCH, outputs: Sequence[str] = _SOLUTION
) -> str:
    """Return a C99 file that solves a branch of an arm at poses.

    Parameters
    ----------
    name
        What all its names begin with: letters, digits and underscores, a letter first, no word of C or C++.
    branch
        Which of the eight configurations.
    outputs
        Some of cosines, sines, jacobian and manipulability.

    Raises
    ------
    ValueError
        If an output is unknown, or the name is none.
    """
    checks.identifier(name, "name")
    checks.instance(branch, "branch", Branch)
    outputs = checks.Each(checks.Choice(tuple(_LAYOUT)))(outputs, "outputs")
    if not outputs:
        raise ValueError(f"outputs is empty; one or more of {', '.join(_LAYOUT)} are needed")
    program = part(derive(branch), *outputs, "defect")
    file = CFile(name)
    header = file.fill(
        "arm.h.in",
        heading=commented(_heading(branch)),
        numbers=len(POSE),
        outputs=len(program.outputs) - 1,
        layout=commented(f"  {_LAYOUT[output]}" for output in outputs),
        not_rigid=_NOT_RIGID,
    )
    code = file.fill(
        "arm.c.in",
        links=len(LINKS),
        numbers=len(POSE),
        outputs=len(program.outputs) - 1,
        largest_defect=_LARGEST_DEFECT,
        computation=file.loop("branch", program),
    )
    return file.standalone(header, code)


def _heading(branch: Branch) -> list[str]:
    side, elbow = "left" if branch.left else "right", "up" if branch.up else "down"
    return [
        f"Six joints with a spherical wrist: {', '.join(LINK_NAMES)} [m], all other lengths 0, twists of",
        "90, 0, -90, 90, -90, 0 degrees. What is reached by the "
        f"{side} arm, its elbow {elbow}, its wrist {'flipped' if branch.flip else 'not flipped'}.",
    ]
