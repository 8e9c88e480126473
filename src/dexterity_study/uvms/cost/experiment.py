"""The cost of an index: operations counted by the rules of paper A in several forms.

Source: Sotiropoulos & Aspragathos (2016), sections 4.3–4.5, Table 4 and Appendix A.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, replace
from itertools import product
from typing import Any, TypeAlias

import numpy as np
import sympy
import torch
from sympy import Expr, Symbol
from sympy.polys.numberfields.galoisgroups import galois_group
from torch import Tensor

from dexterity import operations, robots, symbolic
from dexterity.codegen.torch_code import torch_function
from dexterity.elimination import LAGUERRE_TOLERANCE, laguerre_step
from dexterity.indices import Index
from dexterity.operations import Operations
from dexterity.symbolic import SymbolicChain
from dexterity_study.engine.experiment import experiment
from dexterity_study.engine.table import Row
from dexterity_study.uvms.kinematics.experiment import OF_DATA, PAPER, ROUNDING, draws, largest

Function: TypeAlias = Callable[[Any], Any]
INDICES: Mapping[str, Index] = {"w": Index("manipulability"), "KCI": Index("kinematic_conditioning")}
"""The two indices of the paper, with unit limits, in the spatial frame."""

_exponent, _divisor, _a, _b = sympy.symbols("exponent divisor a b", positive=True)
# Eqs. 22 and 23, whose exponents ±ix and divisors 2i and 2 are given.
_SINE = (sympy.exp(_exponent) - sympy.exp(-_exponent)) / _divisor
_COSINE = (sympy.exp(_exponent) + sympy.exp(-_exponent)) / _divisor


@experiment(keys=("what", "form"), assumes=("neurons-behind-the-count",), smoke={"expand": False}, **PAPER)
def counts(reading: Mapping[str, Any], expand: bool = True) -> Iterator[Row]:
    """Additions and multiplications of exact forms and of the printed networks."""
    chain = symbolic_uvms()
    derived = {name: symbolic.derive(chain, index) for name, index in INDICES.items()}
    J, J_as_printed = written_out(chain), written_out(chain, home_in_adjoint=True)
    m, n = J.shape
    root = operations.count([sympy.sqrt(_a)])
    closed_form = operations.count_program(derived["w"].squared_manipulability)
    forms: dict[tuple[str, str], Operations] = {
        ("sine", "exponentials"): operations.count([_SINE]),
        ("cosine", "exponentials"): operations.count([_COSINE]),
        ("Jacobian", "written out, as printed in Eq. 6"): operations.count(J_as_printed.flat()),
        ("Jacobian", "written out"): operations.count(J.flat()),
        ("Jacobian", "written out, terms shared"): operations.count_shared(J.flat()),
        ("gram", "all"): operations.gram(m, n),
        ("gram", "symmetric"): operations.gram(m, n, symmetric=True),
        ("bidiagonal", "dense"): operations.singular_values(m, n),
        ("bidiagonal", "reduced"): operations.count_program(derived["KCI"].bidiagonal),
        ("Laguerre", "step"): operations.count_program(laguerre_step(m)),
        ("root", "one"): root,
        ("root", "of a ratio"): operations.count([sympy.sqrt(_a / _b)]),
        ("w", "closed form"): closed_form + root,
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
    flat = {symbol: 0 for symbol in chain.lengths if str(symbol) == "l1"}
    for form, full in (("written out", J), ("written out, as printed in Eq. 6", J_as_printed)):
        forms["Jacobian", f"{form}, l1 = 0"] = operations.count(full.xreplace(flat).flat())
    forms["Jacobian", "written out, terms shared, l1 = 0"] = operations.count_shared(J.xreplace(flat).flat())
    for (what, form), counted in forms.items():
        yield {"what": what, "form": form, **asdict(counted), "operations": counted.total}
    neurons = {
        "feed-forward": {"w": 8, "KCI": 25},
        "radial-basis": {"w": 149, "KCI": reading["neurons-behind-the-count"]},
    }
    ways: Mapping[str, tuple[Any, Sequence[str]]] = {
        "feed-forward": (operations.feed_forward, ("printed", "shared", "folded")),
        "radial-basis": (operations.radial_basis, ("printed", "norm", "shared")),
    }
    for name, derivation in derived.items():
        for kind, (count, network_forms) in ways.items():
            size = {"neurons": neurons[kind][name], "inputs": len(derivation.matters)}
            for form in network_forms:
                counted = count(form=form, **size)
                row = {"what": f"{kind} {name}", "form": form, **asdict(counted)}
                yield {**row, "operations": counted.total, **size}
    for name, count in neurons["radial-basis"].items():
        counted = without_sum_of_norm(EVERY_INPUT, count)
        row = {"what": f"radial-basis {name}", "form": "norm without its sum, eleven inputs"}
        size = {"neurons": count, "inputs": EVERY_INPUT}
        yield {**row, **asdict(counted), "operations": counted.total, **size}


EVERY_INPUT = 11
"""Inputs that the paper counts for both radial-basis networks; the last joint is none of them."""


def without_sum_of_norm(inputs: int, neurons: int) -> Operations:
    """Count a radial-basis network with Eq. 18's norm, but without the d - 1 additions of the norm's sum.

    That leaves d + 1 additions and d + 5 multiplications per neuron for d inputs.
    """
    counted = operations.radial_basis(inputs, neurons, "norm")
    return Operations(counted.additions - neurons * (inputs - 1), counted.multiplications)


@experiment(keys=("link", "point"), smoke={"links": (7,), "points": (8, 10)}, **OF_DATA)
def places(
    links: Sequence[int] = (0, *range(4, 13)), points: Sequence[int] = (0, 4, 8, 9, 10)
) -> Iterator[Row]:
    """Operations of w by the link whose axes the Jacobian is written in and by the point that it is taken about.

    Link 0 is the world, links 7 to 12 are the arm's. Point 0 is the world's origin, point i lies on the axis of
    joint i: 4 the vehicle's middle, 8 the shoulder, 9 the elbow, 10 the wrist. Of the entries it has the number
    that are zero, and the largest number of joint values in one of them.
    """
    taken = symbolic.derive(symbolic_uvms(), INDICES["w"])
    for link, point in product(links, points):
        moved = replace(taken, link=link, reference=point)
        root = operations.count([sympy.sqrt(_a)])
        entries = moved.jacobian.nested()
        yield {
            "link": link,
            "point": point,
            "taken": (link, point) == (taken.link, taken.reference),
            "operations": (operations.count_program(moved.squared_manipulability) + root).total,
            "jacobian": operations.count_program(moved.jacobian).total,
            "zeros": sum(entry == 0 for entry in entries),
            "joints": max(len(entry.free_symbols & set(moved.joint_values)) for entry in entries),
        }


@experiment(**OF_DATA)
def algebra() -> Iterator[Row]:
    """Whether Eqs. 22 and 23 are identities, and whether the singular values can be written with roots.

    The Galois group is that of det(JJᵀ − λI) at one configuration, where the tangents of half the joint angles are
    1/2, 1/3, …, so that sines and cosines are rational. If it were solvable the singular values there could be
    written with roots. The ratio of two of them generates, with its conjugates, all of them, if the group is the
    symmetric one.
    """
    x = Symbol("x", real=True)
    sine = _SINE.subs({_exponent: sympy.I * x, _divisor: 2 * sympy.I}) - sympy.sin(x)
    cosine = _COSINE.subs({_exponent: sympy.I * x, _divisor: 2}) - sympy.cos(x)
    chain = symbolic_uvms()
    values: dict[Expr, Expr] = {length: sympy.Rational(str(m)) for length, m in lengths_of(chain).items()}
    for i, q in enumerate(joint_symbols(chain)):
        half = sympy.Rational(1, i + 2)
        values[sympy.sin(q)] = 2 * half / (1 + half**2)
        values[sympy.cos(q)] = (1 - half**2) / (1 + half**2)
        values[q] = half
    J = written_out(chain).xreplace(values)
    group, _ = galois_group((J * J.T).charpoly(Symbol("λ")).as_expr(), by_name=True)
    yield {
        "euler": all(sympy.simplify(difference.rewrite(sympy.cos)) == 0 for difference in (sine, cosine)),
        "group": str(group.value),
        "solvable": bool(group.get_perm_group().is_solvable),
    }


@experiment(seeds=10, smoke={"configurations": 20}, **ROUNDING, **OF_DATA)
def checks(seed: int, configurations: int = 2000) -> Iterator[Row]:
    """Largest deviations of the forms that are counted, and the steps of the iteration for both singular values."""
    chain = robots.uvms()
    q, _ = draws(chain, seed, configurations, range_deg=15.0)
    w, kci = (index.bind(chain)(q) for index in INDICES.values())
    of_w, of_kci = (symbolic.derive(SymbolicChain.from_chain(chain), index) for index in INDICES.values())
    (squared,) = torch_function(of_w.squared_manipulability)(q.unbind(-1))
    steps, iterated = _laguerre(torch_function(of_kci.bidiagonal)(q.unbind(-1)))
    written = torch.as_tensor(Jacobians().at_once(q.numpy()))
    yield {
        "written": largest(written - chain.spatial_jacobian(q)),
        "closed": largest(squared.sqrt() / w - 1),
        "laguerre": largest(iterated / kci - 1),
        "steps": int(np.median(steps)),
        "most_steps": int(steps.max()),
    }


def symbolic_uvms() -> SymbolicChain:
    """Return the UVMS with symbols for its lengths."""
    return SymbolicChain.from_description(robots.describe("uvms"))


def written_out(chain: SymbolicChain, *, home_in_adjoint: bool = False) -> sympy.Matrix:
    """Return the spatial Jacobian (6, n) in symbols q1 … qn, multiplied together as the formulas stand.

    Column i is the screw of joint i, carried by the exponentials of the joints before it. Zeros and ones vanish,
    as they do in any symbolic software; nothing else is simplified. With `home_in_adjoint` the tool pose at home
    stands in the adjoint too, as in Eq. 6 of the paper.
    """
    last_row = sympy.Matrix([[0, 0, 0, 1]])
    home = sympy.Matrix(chain.tool_axes).row_join(sympy.Matrix(chain.tool)).col_join(last_row)
    T, columns = sympy.eye(4), []
    axes, points = (map(sympy.Matrix, vectors) for vectors in (chain.axes, chain.points))
    for kind, axis, point, q in zip(chain.kinds, axes, points, joint_symbols(chain), strict=True):
        slides = kind == "prismatic"
        v, omega = (axis, sympy.zeros(3, 1)) if slides else (point.cross(axis), axis)
        moved = T * home if home_in_adjoint else T
        R, p = moved[:3, :3], moved[:3, 3]
        columns.append((R * v + p.cross(R * omega)).col_join(R * omega))
        across = omega.hat()
        rotation = sympy.eye(3) + sympy.sin(q) * across + (1 - sympy.cos(q)) * across**2
        shift = q * v if slides else (sympy.eye(3) - rotation) * point
        T = T * rotation.row_join(shift).col_join(last_row)
    return sympy.Matrix.hstack(*columns)


class Jacobians:
    """Functions of the joint values that return the Jacobian written out, its lengths in numbers.

    `written` and `shared` take one configuration (n): term by term, and with common terms named. `at_once` takes
    many (m, n), with common terms named.
    """

    def __init__(self) -> None:
        chain = symbolic_uvms()
        joints, entries = joint_symbols(chain), written_out(chain).xreplace(lengths_of(chain)).flat()
        written, shared = (sympy.lambdify(joints, entries, "math", cse=named) for named in (False, True))
        at_once = sympy.lambdify(joints, entries, "numpy", cse=True)
        self.written: Function = lambda q: np.reshape(written(*q), (6, -1))
        self.shared: Function = lambda q: np.reshape(shared(*q), (6, -1))
        self.at_once: Function = lambda q: np.stack(np.broadcast_arrays(*at_once(*q.T)), axis=-1).reshape(
            len(q), 6, -1
        )


def joint_symbols(chain: SymbolicChain) -> tuple[Symbol, ...]:
    """Return the symbols q1 … qn of the joint values."""
    return sympy.symbols(f"q1:{chain.joints + 1}", real=True)


def lengths_of(chain: SymbolicChain) -> dict[Symbol, float]:
    """Return the lengths [m] of the robot by their symbols."""
    numbers = robots.describe(chain.name).lengths
    return {length: numbers[str(length)] for length in chain.lengths}


def _laguerre(squares: Sequence[Tensor]) -> tuple[Tensor, Tensor]:
    """Return the steps of both iterations together, and KCI, from squares of bidiagonal forms.

    Each starts from a bound of its singular value and ends with a step that changes nothing any more.
    """
    step = torch_function(laguerre_step(len(squares) // 2 + 1))
    steps, ends = torch.zeros(len(squares[0]), dtype=torch.int64), []
    for start, side in ((0.0, -1.0), (1.0, 1.0)):
        y = torch.full_like(squares[0], start)
        moving = torch.ones_like(y, dtype=torch.bool)
        while moving.any():
            (change,) = step([y, torch.full_like(y, side), *squares])
            steps += moving
            y = torch.where(moving, y - change, y)
            moving &= change.abs() > LAGUERRE_TOLERANCE * y
        ends.append(y)
    return steps, (ends[0] / ends[1]).sqrt()
