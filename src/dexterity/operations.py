"""Arithmetic operations of formulas, counted by the rules of Sotiropoulos & Aspragathos (2016), Appendix A.

A sine or a cosine costs three multiplications and an addition, an exponential one multiplication;
subtractions count as additions and divisions as multiplications; a change of sign costs nothing. The paper
is silent on square roots, which count as one multiplication here.

Every count is that of an expression. Those of networks and of dense matrices are no exception: the
expressions are built for the size that is asked for, and counted.

Examples
--------
>>> from dexterity import operations
>>> operations.feed_forward(inputs=5, neurons=8)
Operations(additions=64, multiplications=88)
>>> operations.determinant(6, "minors").total
315
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import permutations
from typing import Literal, TypeAlias, get_args

import sympy
from sympy import Expr, Symbol

from dexterity import checks, elimination
from dexterity.elimination import Matrix
from dexterity.program import Program, Recorder

__all__ = [
    "DeterminantMethod",
    "FeedForwardForm",
    "Operations",
    "RadialBasisForm",
    "count",
    "count_program",
    "count_shared",
    "determinant",
    "feed_forward",
    "gram",
    "radial_basis",
    "singular_values",
]

FeedForwardForm: TypeAlias = Literal["printed", "shared", "folded"]
"""How the sigmoid of a feed-forward network is computed, see `feed_forward`."""

RadialBasisForm: TypeAlias = Literal["printed", "norm", "shared"]
"""How the distance in a radial-basis network is computed, see `radial_basis`."""

DeterminantMethod: TypeAlias = Literal["terms", "minors", "elimination"]
"""How a determinant is computed, see `determinant`."""


@dataclass(frozen=True)
class Operations:
    """Numbers of additions and of multiplications."""

    additions: int = 0
    multiplications: int = 0

    @property
    def total(self) -> int:
        """Additions and multiplications together, as the paper counts them."""
        return self.additions + self.multiplications

    def __add__(self, other: Operations) -> Operations:
        return Operations(self.additions + other.additions, self.multiplications + other.multiplications)

    def __rmul__(self, times: int) -> Operations:
        return Operations(times * self.additions, times * self.multiplications)


# ---- expressions -----------------------------------------------------------------------------------


@checks.arguments(expressions=checks.Each(checks.Instance(Expr)))
def count(expressions: Iterable[Expr]) -> Operations:
    """Operations that it takes to work the expressions out one by one, nothing shared between them."""
    additions = multiplications = 0
    waiting = list(expressions)
    while waiting:
        expression = waiting.pop()
        waiting.extend(expression.args)
        own_additions, own_multiplications = _own(expression)
        additions += own_additions
        multiplications += own_multiplications
    return Operations(additions, multiplications)


@checks.arguments(expressions=checks.Each(checks.Instance(Expr)))
def count_shared(expressions: Iterable[Expr]) -> Operations:
    """Operations that it takes when `sympy.cse`, with its defaults, has named what occurs more than once."""
    steps, outputs = sympy.cse(list(expressions))
    return count([expression for _, expression in steps] + list(outputs))


@checks.arguments(program=checks.Instance(Program))
def count_program(program: Program) -> Operations:
    """Operations of a program, each of its steps worked out once."""
    return count(expression for _, expression in program.steps)


def _own(expression: Expr) -> tuple[int, int]:
    """Additions and multiplications of the outermost step of an expression."""
    if expression.is_Add:
        return len(expression.args) - 1, 0
    if expression.is_Mul:
        factors = [factor for factor in expression.args if factor != -1]
        # A quotient is one division: its reciprocal factor, counted below, is part of it.
        reciprocals = sum(factor.is_Pow and factor.exp == -1 for factor in factors)
        return 0, len(factors) - 1 - min(reciprocals, len(factors) - 1)
    if expression.is_Pow:
        return 0, _multiplications_of_power(expression.exp)
    if isinstance(expression, sympy.sin | sympy.cos):
        return 1, 3
    return 0, int(isinstance(expression, sympy.exp))


def _multiplications_of_power(exponent: Expr) -> int:
    if exponent == sympy.S.Half:
        return 1
    return abs(int(exponent)) - 1 + bool(exponent < 0)


# ---- networks --------------------------------------------------------------------------------------


def feed_forward(inputs: int, neurons: int, form: FeedForwardForm = "printed") -> Operations:
    """Operations of a network with one hidden layer of sigmoids and a linear output, Eqs. 13–16.

    The argument of a sigmoid is computed once. One neuron is counted for all, then the output. Scaling of
    inputs and outputs is not counted.

    Parameters
    ----------
    inputs, neurons
        Numbers of inputs and of hidden neurons.
    form
        ``"printed"``: Eq. 13 as it stands, four exponentials a neuron. ``"shared"``: each of its two
        exponentials once. ``"folded"``: tanh γ = 1 − 2/(exp 2γ + 1), with the constants worked into the
        weights beforehand.

    Raises
    ------
    ValueError
        If a number is not positive or above 10 000, or the form is unknown.
    """
    checks.choice(form, "form", get_args(FeedForwardForm))
    inputs, neurons = _sizes(inputs, neurons)
    gamma, E, e = sympy.symbols("γ E e", real=True)
    argument = elimination.dot(_symbols("W", inputs), _symbols("x", inputs)) + Symbol("b")
    grow, shrink = sympy.exp(gamma), sympy.exp(-gamma)
    if form == "printed":
        neuron, hidden = [argument, (grow - shrink) / (grow + shrink)], _symbols("X", neurons)
    elif form == "shared":
        neuron, hidden = [argument, grow, shrink, (E - e) / (E + e)], _symbols("X", neurons)
    else:
        neuron, hidden = [argument, grow], [1 / (E + 1) for E in _symbols("E", neurons)]
    return neurons * count(neuron) + count([_output(hidden)])


def radial_basis(inputs: int, neurons: int, form: RadialBasisForm = "norm") -> Operations:
    """Operations of a network with one hidden layer of Gaussians and a linear output, Eqs. 16–18.

    The argument of a Gaussian is computed once. One neuron is counted for all, then the output. Scaling of
    inputs and outputs is not counted.

    Parameters
    ----------
    inputs, neurons
        Numbers of inputs and of hidden neurons.
    form
        ``"printed"``: Eq. 18 as it stands, the plain sum of the differences times the bias. ``"norm"``:
        the Euclidean norm of the differences times the bias. ``"shared"``: the square of that product
        without the root, and without the square that undoes it.

    Raises
    ------
    ValueError
        If a number is not positive or above 10 000, or the form is unknown.
    """
    checks.choice(form, "form", get_args(RadialBasisForm))
    inputs, neurons = _sizes(inputs, neurons)
    differences = [a - b for a, b in zip(_symbols("x", inputs), _symbols("W", inputs), strict=True)]
    parts, bias, gamma = _symbols("d", inputs), Symbol("b", real=True), Symbol("γ", real=True)
    squares = sympy.Add(*(part**2 for part in parts))
    if form == "printed":
        neuron = [sympy.Add(*parts) * bias, sympy.exp(-(gamma**2))]
    elif form == "norm":
        neuron = [sympy.sqrt(squares) * bias, sympy.exp(-(gamma**2))]
    else:
        neuron = [squares * bias, sympy.exp(-gamma)]
    return neurons * count([*differences, *neuron]) + count([_output(_symbols("X", neurons))])


def _sizes(inputs: int, neurons: int) -> tuple[int, int]:
    """Return checked sizes of a network, whose expressions are built and counted."""
    return (
        checks.whole(inputs, "inputs", least=1, most=10_000),
        checks.whole(neurons, "neurons", least=1, most=10_000),
    )


def _output(hidden: Sequence[Expr]) -> Expr:
    return sympy.Add(*(v * X for v, X in zip(_symbols("v", len(hidden)), hidden, strict=True)), Symbol("c"))


# ---- dense matrices --------------------------------------------------------------------------------


@checks.arguments(symmetric=checks.Flag())
def gram(rows: int, columns: int, symmetric: bool = False) -> Operations:
    """Operations of JJᵀ for a matrix without zeros.

    Parameters
    ----------
    rows, columns
        Size of J.
    symmetric
        Whether entries that are equal by symmetry are computed once; the paper computes both.

    Raises
    ------
    ValueError
        If a number is not positive or above 100.
    """
    J = _matrix(rows, columns)
    transposed = _matrix(rows, columns, "K")  # of other symbols, as sympy would write a square for x·x
    pairs = ((i, j) for i in range(rows) for j in range(rows) if not symmetric or j <= i)
    return count(elimination.dot(J[i], transposed[j]) for i, j in pairs)


def determinant(size: int, method: DeterminantMethod = "terms") -> Operations:
    """Operations of the determinant of a matrix without zeros and without symmetry.

    Parameters
    ----------
    size
        Number of rows.
    method
        ``"terms"``: the sum over all permutations, as the definition has it. ``"minors"``: expansion by
        rows, each minor once. ``"elimination"``: the product of the pivots of Gauss' elimination.

    Raises
    ------
    ValueError
        If the size is not positive, or above 8 by terms, 12 by minors or 30 by elimination, or the method is
        unknown.

    References
    ----------
    Golub & Van Loan (2013), section 3.2.
    """
    checks.choice(method, "method", tuple(_LARGEST))
    # A size of which the method writes some ten thousand operations; each more is several times as many.
    size = checks.whole(size, "size", least=1, most=_LARGEST[method])
    rows = _matrix(size, size)
    if method == "terms":
        terms = (
            sympy.Mul(*(rows[i][j] for i, j in enumerate(columns))) for columns in permutations(range(size))
        )
        return count([sympy.Add(*terms)])
    record = Recorder()
    if method == "minors":
        value = elimination.determinant(record, rows)
    else:
        value = record(sympy.Mul(*_pivots(record, rows)))
    return count_program(record.program((), [value]))


_LARGEST: Mapping[DeterminantMethod, int] = {"terms": 8, "minors": 12, "elimination": 30}


def singular_values(rows: int, columns: int) -> Operations:
    """Operations of the part of a singular value decomposition that needs no iteration.

    That is Householder's reduction of a matrix without zeros to bidiagonal form, by way of a triangle;
    the squares of its entries are what an iteration for the singular values starts from.

    Parameters
    ----------
    rows, columns
        Size of the matrix; no fewer columns than rows.

    Raises
    ------
    ValueError
        If a number is not positive or above 30, or there are fewer columns than rows.

    References
    ----------
    Golub & Van Loan (2013), sections 5.4 and 8.6.
    """
    J = _matrix(rows, columns, most=30)
    if columns < rows:
        raise ValueError(f"columns is {columns}; at least as many as rows, {rows}, are needed")
    record = Recorder()
    L, _ = elimination.triangularise(record, J)
    return count_program(record.program((), elimination.bidiagonal_squares(record, L)))


def _pivots(record: Recorder, rows: Matrix) -> list[Expr]:
    """Pivots of Gauss' elimination without exchange of rows, the entries below them replaced in place."""
    pivots = []
    while rows:
        first, *others = rows
        pivots.append(first[0])
        rows = []
        for row in others:
            factor = record(row[0] / first[0])
            rows.append([record(x - factor * y) for x, y in zip(row[1:], first[1:], strict=True)])
    return pivots


def _matrix(rows: int, columns: int, name: str = "J", most: int = 100) -> Matrix:
    rows, columns = (
        checks.whole(number, called, least=1, most=most)
        for called, number in (("rows", rows), ("columns", columns))
    )
    return [_symbols(f"{name}{i}_", columns) for i in range(rows)]


def _symbols(name: str, number: int) -> list[Symbol]:
    return [Symbol(f"{name}{i}", real=True) for i in range(number)]
