"""The cost of an index: operations counted by the rules of paper A in several forms, and times on a ladder of code.

Source: Sotiropoulos & Aspragathos (2016), sections 4.3–4.5, Table 4 and Appendix A.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import sympy
import torch
from numpy.typing import NDArray
from sympy import Expr, Symbol
from sympy.polys.numberfields.galoisgroups import galois_group
from torch import Tensor

from dexterity import operations, robots, symbolic, timing
from dexterity.chain import Chain
from dexterity.elimination import LAGUERRE_TOLERANCE, laguerre_step
from dexterity.indices import Index
from dexterity.operations import Operations
from dexterity.program import Program
from dexterity.symbolic import SymbolicChain
from dexterity.timing import Way
from dexterity_study.engine.experiment import experiment

INDICES: Mapping[str, Index] = {"w": Index("manipulability"), "KCI": Index("kinematic_conditioning")}
"""The two indices of the paper, with unit limits, in the spatial frame."""

OF_DATA = {"data": ("robots/uvms.toml",)}
SIGMOIDS: tuple[operations.FeedForwardForm, ...] = ("printed", "shared", "folded")
GAUSSIANS: tuple[operations.RadialBasisForm, ...] = ("printed", "norm", "shared")
_exponent, _divisor, _a, _b = sympy.symbols("exponent divisor a b", positive=True)
# Eqs. 22 and 23, whose exponents ±ix and divisors 2i and 2 are given.
_SINE = (sympy.exp(_exponent) - sympy.exp(-_exponent)) / _divisor
_COSINE = (sympy.exp(_exponent) + sympy.exp(-_exponent)) / _divisor


@experiment(
    keys=("what", "form"),
    paper="sotiropoulos2016",
    assumes=("neurons-behind-the-count",),
    smoke={"expand": False},
    **OF_DATA,
)
def counts(  # nothing is drawn
    seed: int,  # noqa: ARG001
    reading: Mapping[str, Any],
    feed_forward: Sequence[int] = (8, 25),
    radial_basis_w: int = 149,
    expand: bool = True,
) -> Iterator[dict[str, Any]]:
    """Additions and multiplications of exact forms and of the printed networks."""
    symbols = _symbolic()
    derived = {name: symbolic.derive(symbols, index) for name, index in INDICES.items()}
    J = written_out(symbols).flat()
    m, n = 6, symbols.joints
    forms: dict[tuple[str, str], Operations] = {
        ("sine", "exponentials"): operations.count([_SINE]),
        ("cosine", "exponentials"): operations.count([_COSINE]),
        ("Jacobian", "written out, as printed in Eq. 6"): operations.count(
            written_out(symbols, home_in_adjoint=True).flat()
        ),
        ("Jacobian", "written out"): operations.count(J),
        ("Jacobian", "written out, terms shared"): operations.count_shared(J),
        ("gram", "all"): operations.gram(m, n),
        ("gram", "symmetric"): operations.gram(m, n, symmetric=True),
        ("bidiagonal", "dense"): operations.singular_values(m, n),
        ("bidiagonal", "reduced"): operations.count_program(derived["KCI"].bidiagonal),
        ("Laguerre", "step"): operations.count_program(laguerre_step(m)),
        ("root", "one"): operations.count([sympy.sqrt(_a)]),
        ("root", "of a ratio"): operations.count([sympy.sqrt(_a / _b)]),
        ("w", "closed form"): operations.count_program(derived["w"].squared_manipulability)
        + operations.count([sympy.sqrt(_a)]),
        ("w", "elimination"): operations.count_program(derived["w"].manipulability),
    }
    if expand:
        multiplied = [sympy.expand(entry) for entry in J]
        forms["Jacobian", "multiplied out"] = operations.count(multiplied)
        forms["Jacobian", "multiplied out, terms shared"] = operations.count_shared(multiplied)
    for name, derivation in derived.items():
        forms["Jacobian", f"reduced, for {name}"] = operations.count_program(derivation.jacobian)
    for method in ("terms", "minors", "elimination"):
        forms["determinant", method] = operations.determinant(m, method)
    for (what, form), counted in forms.items():
        yield {"what": what, "form": form, **_numbers(counted)}
    units = {"w": radial_basis_w, "KCI": reading["neurons-behind-the-count"]}
    for (name, derivation), neurons in zip(derived.items(), feed_forward, strict=True):
        inputs = len(derivation.matters)
        for sigmoid in SIGMOIDS:
            counted = operations.feed_forward(inputs, neurons, sigmoid)
            yield {
                "what": f"feed-forward {name}",
                "form": sigmoid,
                **_numbers(counted),
                "neurons": neurons,
                "inputs": inputs,
            }
        for gaussian in GAUSSIANS:
            counted = operations.radial_basis(inputs, units[name], gaussian)
            yield {
                "what": f"radial-basis {name}",
                "form": gaussian,
                **_numbers(counted),
                "neurons": units[name],
                "inputs": inputs,
            }


@experiment(**OF_DATA)
def algebra(seed: int) -> Iterator[dict[str, Any]]:  # noqa: ARG001 -- nothing is drawn
    """Whether Eqs. 22 and 23 are identities, and whether the singular values can be written with roots."""
    x = Symbol("x", real=True)
    sine = _SINE.subs({_exponent: sympy.I * x, _divisor: 2 * sympy.I}) - sympy.sin(x)
    cosine = _COSINE.subs({_exponent: sympy.I * x, _divisor: 2}) - sympy.cos(x)
    group, solvable = _galois_group(_symbolic())
    yield {
        "euler": all(sympy.simplify(difference.rewrite(sympy.cos)) == 0 for difference in (sine, cosine)),
        "group": group,
        "solvable": solvable,
    }


@experiment(seeds=10, smoke={"configurations": 20}, rtol=1e-6, atol=1e-6, **OF_DATA)
def checks(seed: int, configurations: int = 2000) -> Iterator[dict[str, Any]]:
    """Largest deviations of the forms that are counted, and the steps of the iteration for both singular values."""
    chain, symbols = robots.uvms(), _symbolic()
    q = _draw(chain, configurations, seed)
    written = Jacobians(symbols).at_once(q.numpy()) - chain.spatial_jacobian(q).numpy()
    (squared,) = _function(
        symbolic.derive(symbols, INDICES["w"]).squared_manipulability, lengths_of(symbols)
    )(*q.numpy().T)
    steps, kci = _laguerre(symbolic.derive(symbols, INDICES["KCI"]).bidiagonal, lengths_of(symbols), q)
    yield {
        "written": _largest(written),
        "closed": _largest(np.sqrt(squared) / INDICES["w"].bind(chain)(q).numpy() - 1),
        "laguerre": _largest(kci / INDICES["KCI"].bind(chain)(q).numpy() - 1),
        "steps": int(np.median(steps)),
        "most_steps": int(steps.max()),
    }


@experiment(
    keys=("index", "way"),
    timed=True,
    unsteady=("lower", "median", "upper"),
    smoke={"configurations": 20, "in_loops": 2, "rounds": 1, "seconds": 0.001},
    atol=1e-6,
    **OF_DATA,
)
def ladder(
    seed: int, configurations: int = 1000, in_loops: int = 50, rounds: int = 30, seconds: float = 0.3
) -> Iterator[dict[str, Any]]:
    """Time per configuration of the same exact index [s], from a Python loop to compiled code."""
    chain, jacobians = robots.uvms(), Jacobians(_symbolic())
    q = _draw(chain, configurations, seed)
    for name, index in INDICES.items():
        ways = _ways(chain, index, jacobians, q, in_loops)
        values = {way.name: np.asarray(way.compute()) for way in ways}
        first = values[ways[0].name]
        for own in timing.measure(ways, rounds, seconds):
            deviation = _largest(values[own.name][: len(first)] / first - 1)
            yield {
                "index": name,
                "way": own.name,
                "configurations": own.configurations,
                "deviation": deviation,
                "lower": own.lower,
                "median": own.median,
                "upper": own.upper,
            }


# ---- the Jacobian, written out ---------------------------------------------------------------------


def written_out(chain: SymbolicChain, *, home_in_adjoint: bool = False) -> sympy.Matrix:
    """Return the spatial Jacobian (6, n) in symbols q1 … qn, multiplied together as the formulas stand.

    Column i is the screw of joint i, carried by the exponentials of the joints before it. Zeros and ones vanish,
    as they do in any symbolic software; nothing else is simplified. With `home_in_adjoint` the tool pose at home
    stands in the adjoint too, as in Eq. 6 of the paper.
    """
    home = sympy.eye(4)
    home[:3, :3], home[:3, 3] = sympy.Matrix(chain.tool_axes), sympy.Matrix(chain.tool)
    T, columns = sympy.eye(4), []
    axes, points = (map(sympy.Matrix, vectors) for vectors in (chain.axes, chain.points))
    for kind, axis, point, q in zip(chain.kinds, axes, points, _joints(chain.joints), strict=True):
        moved = T * home if home_in_adjoint else T
        R, p = moved[:3, :3], moved[:3, 3]
        step = sympy.eye(4)
        if kind == "prismatic":
            linear, angular = R * axis, sympy.zeros(3, 1)
            step[:3, 3] = q * axis
        else:
            angular = R * axis
            linear = R * point.cross(axis) + p.cross(angular)
            across = axis.hat()
            step[:3, :3] = sympy.eye(3) + sympy.sin(q) * across + (1 - sympy.cos(q)) * across**2
            step[:3, 3] = (sympy.eye(3) - step[:3, :3]) * point
        columns.append(sympy.Matrix.vstack(linear, angular))
        T = T * step
    return sympy.Matrix.hstack(*columns)


class Jacobians:
    """Python functions of the Jacobian written out, its lengths in numbers.

    Attributes
    ----------
    written, shared
        Entries, row by row, of one configuration, term by term and with common terms named.
    """

    def __init__(self, chain: SymbolicChain) -> None:
        joints = _joints(chain.joints)
        entries = [entry.xreplace(lengths_of(chain)) for entry in written_out(chain).flat()]
        self.written = sympy.lambdify(joints, entries, "math")
        self.shared = sympy.lambdify(joints, entries, "math", cse=True)
        self._at_once = sympy.lambdify(joints, entries, "numpy", cse=True)

    def at_once(self, q: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return Jacobians (m, 6, n) of configurations (m, n), common terms named."""
        columns = [np.broadcast_to(entry, len(q)) for entry in self._at_once(*q.T)]
        return np.stack(columns, axis=-1).reshape(len(q), 6, -1)


def lengths_of(chain: SymbolicChain) -> dict[Symbol, float]:
    """Return the lengths of a described robot by their symbols, [m]."""
    lengths = robots.describe(chain.name).lengths
    return {length: lengths[str(length)] for length in chain.lengths}


def _symbolic() -> SymbolicChain:
    return SymbolicChain.from_description(robots.describe("uvms"))


def _joints(joints: int) -> tuple[Symbol, ...]:
    return sympy.symbols(f"q1:{joints + 1}", real=True)


def _numbers(counted: Operations) -> dict[str, int]:
    return {
        "additions": counted.additions,
        "multiplications": counted.multiplications,
        "operations": counted.total,
    }


def _galois_group(chain: SymbolicChain) -> tuple[str, bool]:
    """Return the Galois group of det(JJᵀ − λI) at one configuration, and whether it is solvable.

    The tangents of half the joint angles are 1/2, 1/3, …, so that sines and cosines are rational. If the group
    were solvable the singular values there could be written with roots. The ratio of two of them generates, with
    its conjugates, all of them, if the group is the symmetric one.
    """
    values: dict[Expr, Expr] = {length: sympy.Rational(str(m)) for length, m in lengths_of(chain).items()}
    for i, q in enumerate(_joints(chain.joints)):
        half = sympy.Rational(1, i + 2)
        values[sympy.sin(q)] = 2 * half / (1 + half**2)
        values[sympy.cos(q)] = (1 - half**2) / (1 + half**2)
        values[q] = half
    J = written_out(chain).xreplace(values)
    group, _ = galois_group((J * J.T).charpoly(Symbol("λ")).as_expr(), by_name=True)
    return str(group.value), bool(group.get_perm_group().is_solvable)


# ---- checks and ways -------------------------------------------------------------------------------


def _draw(chain: Chain, configurations: int, seed: int) -> Tensor:
    """Draw translations within ±1 m and rotations within ±15°."""
    random = torch.Generator().manual_seed(seed)
    half_range = torch.full((chain.joints,), np.radians(15.0), dtype=torch.float64)
    half_range[:3] = 1.0
    return (
        2 * torch.rand(configurations, chain.joints, generator=random, dtype=torch.float64) - 1
    ) * half_range


def _largest(deviation: NDArray[np.float64]) -> float:
    return float(np.abs(deviation).max())


def _function(program: Program, values: Mapping[Symbol, float] | None = None) -> Callable[..., list[Any]]:
    """Return a program as a Python function on numpy's arrays; symbols that have values are replaced."""
    steps = [(symbol, expression.xreplace(values or {})) for symbol, expression in program.steps]
    outputs = [output.xreplace(values or {}) for output in program.outputs]
    return sympy.lambdify(program.inputs, outputs, ["numpy"], cse=lambda _: (steps, outputs))


def _laguerre(
    bidiagonal: Program, lengths: Mapping[Symbol, float], q: Tensor
) -> tuple[NDArray[np.int64], Any]:
    """Return the steps of both iterations together, and KCI, for each configuration.

    Each starts from a bound of its singular value and ends with a step that changes nothing any more.
    """
    squares = _function(bidiagonal, lengths)(*q.numpy().T)
    step = _function(laguerre_step(len(squares) // 2 + 1))
    steps = np.zeros(len(q), dtype=np.int64)
    ends = []
    for start, side in ((0.0, -1.0), (1.0, 1.0)):
        y, moving = np.full(len(q), start), np.ones(len(q), dtype=bool)
        while moving.any():
            (change,) = step(y, side, *squares)
            steps += moving
            y = np.where(moving, y - change, y)
            moving &= np.abs(change) > LAGUERRE_TOLERANCE * y
        ends.append(y)
    return steps, np.sqrt(ends[0] / ends[1])


def _ways(chain: Chain, index: Index, jacobians: Jacobians, q: Tensor, in_loops: int) -> tuple[Way, ...]:
    few = q[:in_loops]
    measure = MEASURES[index.name]
    bound, screws = index.bind(chain), chain.screws.numpy()
    in_torch, in_c = (symbolic.compile_index(chain, index, backend) for backend in ("torch", "c"))

    def each(jacobian: Callable[[NDArray[np.float64]], Any]) -> Callable[[], object]:
        return lambda: [measure(np.reshape(jacobian(row), (6, -1))) for row in few.numpy()]

    loops = {
        "Python loop, product of exponentials": each(lambda row: plain_jacobian(screws, row)),
        "Python loop, Jacobian written out": each(lambda row: jacobians.written(*row)),
        "Python loop, terms shared": each(lambda row: jacobians.shared(*row)),
        "Python loop, generated C": lambda: [float(in_c(one)) for one in few],
    }
    batches = {
        "numpy at once, terms shared": lambda: measure(jacobians.at_once(q.numpy())),
        "torch at once, singular values": lambda: bound(q),
        "torch at once, generated": lambda: in_torch(q),
        "C at once, generated": lambda: in_c(q),
    }
    sizes = ((loops, len(few)), (batches, len(q)))
    return tuple(Way(name, compute, size) for ways, size in sizes for name, compute in ways.items())


def plain_jacobian(screws: NDArray[np.float64], q: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the Jacobian (6, n) of one configuration, as one would write it in numpy."""
    T, columns = np.eye(4), []
    for screw, value in zip(screws, q, strict=True):
        v, omega = screw[:3], screw[3:]
        angular = T[:3, :3] @ omega
        columns.append(np.concatenate([T[:3, :3] @ v + np.cross(T[:3, 3], angular), angular]))
        step = np.eye(4)
        if omega.any():
            across = np.cross(np.eye(3), omega)
            step[:3, :3] += np.sin(value) * across + (1 - np.cos(value)) * across @ across
            step[:3, 3] = (np.eye(3) - step[:3, :3]) @ np.cross(omega, v)
        else:
            step[:3, 3] = value * v
        T = T @ step
    return np.stack(columns, axis=-1)


def _by_determinant(J: NDArray[np.float64]) -> Any:
    return np.sqrt(np.linalg.det(J @ np.swapaxes(J, -1, -2)))


def _by_singular_values(J: NDArray[np.float64]) -> Any:
    sigma = np.linalg.svd(J, compute_uv=False)
    return sigma[..., -1] / sigma[..., 0]


MEASURES: Mapping[str, Callable[[NDArray[np.float64]], Any]] = {
    "manipulability": _by_determinant,
    "kinematic_conditioning": _by_singular_values,
}
"""The indices of Jacobians (..., 6, n) in numpy, w by LU and KCI by singular values."""
