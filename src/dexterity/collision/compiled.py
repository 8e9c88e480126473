"""Bodies compiled to C: clearances and collisions of many configurations, on one core.

The links' displacements are a program of the chain, and sixteen configurations of it are computed side by
side. The distances of the bodies are functions in C, with tables of the bodies and pairs.

Examples
--------
>>> import dexterity as dx
>>> from dexterity.collision import Bodies, Body, Sphere, capsules, in_c
>>> arm = dx.robots.docking_arm()
>>> bodies = Bodies(arm, [*capsules(arm, radius=0.04), Body(Sphere((0.6, 0, 0.4), 0.1), "world", "buoy")])
>>> q = [0.1, 0.4, 0.3, 0.0, 0.2, 0.0]
>>> bool((in_c(bodies).clearance(q) - bodies.clearance(q)).abs() < 1e-12)
True
"""

from __future__ import annotations

import ctypes
from collections.abc import Iterable

import numpy as np
import torch
from jaxtyping import Bool, Float64
from numpy.typing import NDArray
from torch import Tensor

from dexterity import checks, store
from dexterity.codegen.angles import needs_values, with_angles_apart
from dexterity.codegen.c_file import NOT_FINITE, CFile, table
from dexterity.codegen.heading import printable
from dexterity.codegen.library import compiled_library, plain_memory
from dexterity.codegen.names import words
from dexterity.codegen.pose import kinematics
from dexterity.codegen.reference import regular_rows
from dexterity.collision.bodies import TOUCH, Bodies, box_of, line_of
from dexterity.collision.distances import PARALLEL
from dexterity.collision.shapes import Body, Box
from dexterity.derivation import SymbolicChain
from dexterity.spatial import TensorLike

__all__ = ["CompiledBodies", "c_source", "in_c"]

_TOLERANCE = 1e-11  # [m] of the self-test


class CompiledBodies:
    """Bodies whose clearances and collisions are computed by compiled C; :func:`in_c` makes it.

    Results are those of :class:`~dexterity.collision.bodies.Bodies` to rounding. Torch cannot differentiate
    them.

    Parameters
    ----------
    bodies
        The bodies.

    Raises
    ------
    CompilationFailed
        If a compiler is missing or fails, or what it made is wrong.
    OSError
        If the folder for compiled code cannot be written.
    TypeError
        If the bodies are none.
    """

    def __init__(self, bodies: Bodies) -> None:
        self._bodies = checks.instance(bodies, "bodies", Bodies)
        library = compiled_library(c_source(bodies, "bodies"))
        pointer, size = ctypes.c_void_p, ctypes.c_size_t
        self._clearance, self._collides = library.bodies_clearance_batch, library.bodies_collides_batch
        self._clearance.argtypes = [pointer, size, size, pointer, pointer]
        self._collides.argtypes = [pointer, size, size, pointer, ctypes.c_double, pointer]

    @property
    def bodies(self) -> Bodies:
        """The bodies, as torch computes them."""
        return self._bodies

    def clearance(self, q: TensorLike, T_world_base: TensorLike | None = None) -> Float64[Tensor, "*batch"]:
        """Smallest signed distance of all pairs [m]; see :meth:`dexterity.collision.bodies.Bodies.clearance`.

        Raises
        ------
        ValueError
            If a shape does not fit, something is not finite, or a pose is not rigid.
        """
        rows, poses, device = self._read(q, T_world_base)
        values = rows.new_empty(rows.shape[:-1])
        self._run(self._clearance, rows, poses, values)
        return values.to(device)

    def collides(
        self, q: TensorLike, T_world_base: TensorLike | None = None, margin: float = 0.0
    ) -> Bool[Tensor, "*batch"]:
        """Tell which configurations collide; see :meth:`dexterity.collision.bodies.Bodies.collides`.

        Raises
        ------
        ValueError
            As :meth:`clearance`, or if the margin is negative or not finite.
        """
        margin = checks.real(margin, "margin", least=0.0)
        rows, poses, device = self._read(q, T_world_base)
        flags = torch.empty(rows.shape[:-1], dtype=torch.uint8, device="cpu")
        self._run(self._collides, rows, poses, ctypes.c_double(margin), flags)
        return flags.to(device).bool()

    def _read(
        self, q: TensorLike, T_world_base: TensorLike | None
    ) -> tuple[Tensor, Tensor | None, torch.device]:
        checked, T = self._bodies.checked(q, T_world_base)
        return plain_memory(checked), None if T is None else plain_memory(T), checked.device

    def _run(
        self, function: ctypes._NamedFuncPointer, rows: Tensor, poses: Tensor | None, *rest: object
    ) -> None:
        joints = self._bodies.chain.joints
        addresses = [part.data_ptr() if isinstance(part, Tensor) else part for part in rest]
        where = None if poses is None else poses.data_ptr()
        error = function(rows.data_ptr(), rows.numel() // joints, joints, where, *addresses)
        if error == NOT_FINITE:
            raise ValueError("q is not finite: it holds NaN or an infinity")
        if error:
            raise RuntimeError(f"the compiled function returned error {error}")


def in_c(bodies: Bodies) -> CompiledBodies:
    """Return bodies compiled to C; the code is stored for the next time.

    Raises
    ------
    CompilationFailed
        If a compiler is missing or fails, or what it made is wrong.
    OSError
        If the folder for compiled code cannot be written.
    TypeError
        If the bodies are none.
    """
    return CompiledBodies(bodies)


def c_source(bodies: Bodies, name: str | None = None) -> str:
    """Return a C99 file of bodies on a chain, which needs nothing but the C library.

    Parameters
    ----------
    bodies
        The bodies.
    name
        What all names in the file begin with; by default that of the chain and eight digits of its content.

    Raises
    ------
    ValueError
        If the name cannot be used in C and C++.
    TypeError
        If an argument is of another type.
    """
    checks.instance(bodies, "bodies", Bodies)
    symbolic = SymbolicChain.of(bodies.chain)
    if name is None:
        key = store.content_key(symbolic.numbers(), bodies.bodies, bodies.pairs)
        name = words(bodies.chain.name, "bodies", key[:8])
    file, program = CFile(name), kinematics(symbolic).links
    turning = [kind == "revolute" for kind in bodies.chain.kinds]
    values_too = needs_values(program, turning)
    loop = file.loop("links", with_angles_apart(program, turning) if values_too else program)
    rows = regular_rows(bodies.chain)
    code = file.fill(
        "bodies.c.in",
        elementary=file.elementary(loop),
        lay_out=file.lay_out([int(turns) for turns in turning], values_too),
        loop=loop,
        shapes=shapes_in_c(file, bodies),
        inputs=f"{2 if values_too else 1}*{name.upper()}_JOINTS",
        touch=repr(TOUCH),
        tolerance=repr(_TOLERANCE * (1 + float(np.abs(_at_home(bodies.bodies)).max()))),
        rows=table(rows.numpy().ravel()),
        clearances=table(bodies.clearance(rows).numpy()),
    )
    lines = printable(
        [
            f"Bodies on {bodies.chain.name}, generated by dexterity: {', '.join(bodies.names)}.",
            f"{len(bodies.pairs)} pairs are looked at. Units: metres and radians.",
            "Distances are exact to a few rounding errors of the largest length.",
        ]
    )
    functions = file.fill("bodies_functions.h.in", joints=bodies.chain.joints, touch=repr(TOUCH))
    return file.standalone(file.header(lines, bodies.chain.joints, code, functions), code)


def shapes_in_c(file: CFile, bodies: Bodies) -> str:
    """Return the C functions of distances, and the tables of bodies and pairs, for a file."""
    given, pairs = bodies.bodies, bodies.numbered_pairs
    return file.fill(
        "shapes.c.in",
        parallel=repr(PARALLEL),
        bodies=len(given),
        pairs=len(pairs),
        is_box=_whole(int(isinstance(body.shape, Box)) for body in given),
        links=_whole(-1 if body.link == "world" else body.link for body in given),
        pair_numbers="{" + ", ".join(map(_whole, pairs)) + "}",
        at_home=table(_at_home(given)),
    )


def _whole(numbers: Iterable[object]) -> str:
    return "{" + ", ".join(map(str, numbers)) + "}"


def _at_home(bodies: tuple[Body, ...]) -> NDArray[np.float64]:
    """Return 16 numbers a body, as the C functions take them."""
    rows = np.zeros((len(bodies), 16))
    for row, body in zip(rows, bodies, strict=True):
        if isinstance(body.shape, Box):
            T = box_of(body).numpy()
            row[:15] = np.concatenate([T[:3, 3], T[:3, :3].ravel(), np.array(body.shape.size) / 2])
        else:
            start, end = line_of(body).numpy()
            row[:7] = np.concatenate([start, end - start, [body.shape.radius]])
    return rows
