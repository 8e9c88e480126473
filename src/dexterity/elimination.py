"""Linear algebra on matrices of expressions, recorded step by step, zeros left out.

Orthogonal elimination works on the matrix itself and not on its square, and keeps full accuracy near a
singularity. The determinant and the Schur complement give the formulas that a reader wants to see. Matrices
are lists of rows.

Examples
--------
A planar arm of two joints, in the axes of its first link: l is the length of that link, (x, y) the vector
from the second joint to the tool. The determinant of its Jacobian takes one step per minor:

>>> import sympy
>>> from dexterity.elimination import VANISHING, determinant, triangularise
>>> from dexterity.program import Recorder
>>> l, x, y = sympy.symbols("l x y", real=True)
>>> J = [[-y, -y], [l + x, x]]
>>> record = Recorder("t")
>>> program = record.program((l, x, y), [determinant(record, J)])
>>> program.steps, program.outputs
(((t0, x*y + y*(-l - x)),), (-t0,))

It is l·y, and w is its magnitude. A Householder reflection from the right gives the same w without a square:

>>> record = Recorder("t")
>>> L, squares = triangularise(record, J)
>>> program = record.program((l, x, y), [L[0][0], L[1][0], L[1][1]])
>>> for name, expression in program.steps[:5]:
...     print(name, "=", expression.xreplace({VANISHING: sympy.Symbol("vanishing")}))
t0 = y**2
t1 = t0 + vanishing + y**2
t2 = sqrt(t1)
t3 = y - copysign(t2, -y)
t4 = t0 + t3**2

Here t2 is the length of the first row, (−t3, −y) the normal of the reflection and t4 its square. The
remaining steps reflect the second row. The product of the diagonal of L is w up to its sign:

>>> w = L[0][0] * L[1][1]
>>> for name, expression in reversed(program.steps):
...     w = w.xreplace({name: expression})
>>> float(abs(w.subs({l: 0.5, x: 0.25, y: -0.1, VANISHING: 0}))) - 0.5 * 0.1 < 1e-15
True
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import TypeAlias

import sympy
from sympy import Expr, S

from dexterity.program import Program, Recorder, copysign

__all__ = [
    "LAGUERRE_STEPS",
    "LAGUERRE_TOLERANCE",
    "VANISHING",
    "Matrix",
    "bidiagonal_squares",
    "determinant",
    "dot",
    "gram",
    "in_columns_of_rows",
    "laguerre_step",
    "schur_determinant",
    "triangularise",
]

Matrix: TypeAlias = list[list[Expr]]
"""Rows of expressions."""


VANISHING = sympy.Float(1e-60)
"""Square of a length that counts as none; added to squares, it keeps roots and their derivatives finite."""

LAGUERRE_STEPS = 60
"""Steps after which the iteration ends at the latest; a root that repeats four times takes 35."""

LAGUERRE_TOLERANCE = 1e-13
"""Steps that are smaller than this part of the root are the last."""


def dot(a: Sequence[Expr], b: Sequence[Expr]) -> Expr:
    """Sum of products, not yet recorded."""
    return sympy.Add(*(x * y for x, y in zip(a, b, strict=True)))


def triangularise(record: Recorder, rows: Matrix) -> tuple[Matrix, list[Expr]]:
    """Turn m rows of n ≥ m entries into a lower triangle by Householder reflections from the right.

    Returns
    -------
    The m × m lower triangle L with rows·rowsᵀ = L·Lᵀ, and the squares of its diagonal.

    References
    ----------
    Golub & Van Loan (2013), section 5.2.
    """
    L, squares, _ = _triangularise(record, rows)
    return L, squares


def in_columns_of_rows(record: Recorder, rows: Matrix, vectors: Sequence[Sequence[Expr]]) -> Matrix:
    """Carry vectors of m entries from the columns of the triangle L to the n columns of the rows.

    With the orthogonal Q of rows = L·Qᵀ these are Q·vector: a right singular vector of L becomes one of the
    rows, with all its digits.
    """
    _, _, reflections = _triangularise(record, rows)
    carried = [[*vector, *[S.Zero] * (len(rows[0]) - len(vector))] for vector in vectors]
    for i, reflection in reversed(list(enumerate(reflections))):
        for vector in carried:
            tail = vector[i:]
            reflection.apply(record, tail)
            vector[i:] = tail
    return carried


def _triangularise(record: Recorder, rows: Matrix) -> tuple[Matrix, list[Expr], list[_Reflection]]:
    rows = [list(row) for row in rows]
    squares, reflections = [], []
    for i in range(len(rows)):
        tails = [row[i:] for row in rows[i:]]
        square, reflection = _reflect(record, tails[0], tails[1:])
        squares.append(square)
        reflections.append(reflection)
        for row, tail in zip(rows[i:], tails, strict=True):
            row[i:] = tail
    return [row[: len(rows)] for row in rows], squares, reflections


def bidiagonal_squares(record: Recorder, square_matrix: Matrix) -> list[Expr]:
    """Squares of the entries d₁, e₁, d₂, e₂, … of a bidiagonal matrix with the same singular values.

    References
    ----------
    Golub & Kahan (1965), section 2.
    """
    rows = [list(row) for row in square_matrix]
    squares = []
    for k in range(len(rows)):
        tails = [row[k:] for row in rows[k:]]
        squares.append(_reflect(record, tails[0], tails[1:])[0])
        # The same from the left: the first column below the diagonal is reflected onto one entry.
        if len(tails) > 1:
            columns = [list(column) for column in zip(*tails[1:], strict=True)]
            squares.append(_reflect(record, columns[0], columns[1:])[0])
            tails[1:] = [list(row) for row in zip(*columns, strict=True)]
        for row, tail in zip(rows[k:], tails, strict=True):
            row[k:] = tail
    return squares


@dataclass(frozen=True)
class _Reflection:
    """Reflection along a normal of a few entries, after the first entry was swapped with another."""

    swapped: int = 0
    entries: Sequence[int] = ()
    normal: Sequence[Expr] = ()
    scale: Expr = S.Zero

    def apply(self, record: Recorder, vector: list[Expr]) -> None:
        """Reflect a vector in place, then undo the swap: the inverse of what was done to the rows."""
        if any(vector[i] != 0 for i in self.entries):
            along = record(self.scale * record(dot(self.normal, [vector[i] for i in self.entries])))
            for i, component in zip(self.entries, self.normal, strict=True):
                vector[i] = record(vector[i] - along * component)
        vector[0], vector[self.swapped] = vector[self.swapped], vector[0]


def _reflect(record: Recorder, x: list[Expr], others: Matrix) -> tuple[Expr, _Reflection]:
    """Reflect `x` onto its first axis, and the others with it, all in place.

    Entries that are zero take no part; a single one that is not is swapped to the front.

    Returns
    -------
    The square of the length of `x`, and the reflection.
    """
    entries = [i for i, entry in enumerate(x) if entry != 0]
    if not entries:
        return S.Zero, _Reflection()
    swapped = entries[0]
    for row in (x, *others):
        row[0], row[swapped] = row[swapped], row[0]
    entries[0] = 0
    if len(entries) == 1:
        return record(x[0] ** 2), _Reflection(swapped)
    # The normal is x plus its length along the first axis, with the sign that makes no difference of equals.
    rest = record(sympy.Add(*(x[i] ** 2 for i in entries[1:])))
    square = record(x[0] ** 2 + rest + VANISHING)
    length = record(sympy.sqrt(square))
    normal = [record(x[0] + copysign(length, x[0])), *(x[i] for i in entries[1:])]
    # Divided by the square of the normal as computed, it is a reflection even where x vanishes.
    scale = record(2 * record(1 / record(normal[0] ** 2 + rest)))
    for row in others:
        if any(row[i] != 0 for i in entries):
            along = record(scale * record(dot(normal, [row[i] for i in entries])))
            for i, component in zip(entries, normal, strict=True):
                row[i] = record(row[i] - along * component)
    x[:] = [record(-copysign(length, x[0])), *[S.Zero] * (len(x) - 1)]
    return square, _Reflection(swapped, entries, normal, scale)


def determinant(record: Recorder, square_matrix: Matrix) -> Expr:
    """Expand a determinant without divisions, by minors of the first rows, each computed once.

    Rows with many zeros are taken first.
    """
    order = sorted(range(len(square_matrix)), key=lambda i: sum(entry != 0 for entry in square_matrix[i]))
    rows = [square_matrix[i] for i in order]
    sign = sympy.combinatorics.Permutation(order).signature()

    # Of the first len(columns) rows and these columns, expanded along the last of these rows.
    @cache
    def minor(columns: tuple[int, ...]) -> Expr:
        if not columns:
            return S.One
        entries = rows[len(columns) - 1]
        terms = [
            (-1) ** (len(columns) - 1 + k) * entries[j] * minor(columns[:k] + columns[k + 1 :])
            for k, j in enumerate(columns)
            if entries[j] != 0
        ]
        return record(sympy.Add(*terms))

    return record(sign * minor(tuple(range(len(rows)))))


def schur_determinant(record: Recorder, gram: Matrix) -> Expr:
    """Expand the determinant of a symmetric 6×6 matrix by the Schur complement of its regular first block."""
    A = [row[:3] for row in gram[:3]]
    C = [row[3:] for row in gram[:3]]
    adjugate = _symmetric_adjugate(record, A)
    det_A = record(dot(A[0], adjugate[0]))
    scale = record(1 / det_A)
    X = [[record(scale * record(dot(row, column))) for row in adjugate] for column in zip(*C, strict=True)]
    complement = [[S.Zero] * 3 for _ in range(3)]
    for i, j in _LOWER:
        through = dot(X[i], [row[j] for row in C])
        complement[i][j] = complement[j][i] = record(gram[3 + i][3 + j] - through)
    return record(det_A * determinant(record, complement))


_LOWER = ((0, 0), (1, 0), (1, 1), (2, 0), (2, 1), (2, 2))


def _symmetric_adjugate(record: Recorder, A: Matrix) -> Matrix:
    adjugate = [[S.Zero] * 3 for _ in range(3)]
    for i, j in _LOWER:
        (a, b), (c, d) = [[A[r][s] for s in range(3) if s != j] for r in range(3) if r != i]
        adjugate[i][j] = adjugate[j][i] = record((-1) ** (i + j) * (a * d - b * c))
    return adjugate


def laguerre_step(size: int) -> Program:
    r"""One step of Laguerre's iteration towards an extreme root of a bidiagonal matrix' polynomial.

    The polynomial :math:`P(y) = \det(y I - B B^\top)` is evaluated by the three-term recurrence of the
    Golub–Kahan matrix, whose diagonal is zero: rounding then changes the entries of B, and so its singular
    values, by a relative few ε only. From outside the roots the iteration approaches the nearest one
    monotonically, at third order where it is simple and linearly where it repeats.

    Parameters
    ----------
    size
        Number m of singular values.

    Returns
    -------
    Program with inputs y, s (−1 for y below all roots, +1 for y above them) and the 2m − 1 squares of
    :func:`bidiagonal_squares`, and the step as output, to be subtracted from y.

    References
    ----------
    Parlett (1964), Laguerre's method applied to the matrix eigenvalue problem; Golub & Kahan (1965).
    """
    record = Recorder("t")
    y, side = sympy.symbols("y side", real=True)
    squares = sympy.symbols(f"b:{2 * size - 1}", real=True)
    # Value, first derivative and half the second of P_k for even k and of P_k/√y for odd k.
    even, odd = [S.One, S.Zero, S.Zero], [S.One, S.Zero, S.Zero]
    for k, square in enumerate(squares, start=1):
        if k % 2:
            up = (y * odd[0], odd[0] + y * odd[1], odd[1] + y * odd[2])
            even = record.all(a - square * b for a, b in zip(up, even, strict=True))
        else:
            odd = record.all(a - square * b for a, b in zip(even, odd, strict=True))
    P, slope, half_curvature = even
    under_root = (size - 1) ** 2 * slope**2 - 2 * size * (size - 1) * P * half_curvature
    root = record(sympy.sqrt(record(sympy.Abs(record(under_root)))))
    # The root takes the sign of the slope: that of y's side for an even size, always plus for an odd one.
    sign = S.One if size % 2 else side
    step = record(sign * size * P / record(sign * slope + root + sympy.Float(1e-300)))
    return record.program((y, side, *squares), [step])


def gram(record: Recorder, rows: Matrix) -> Matrix:
    """Multiply a matrix by its own transpose."""
    product = [[S.Zero] * len(rows) for _ in rows]
    for i, row in enumerate(rows):
        for j, other in enumerate(rows[: i + 1]):
            product[i][j] = product[j][i] = record(dot(row, other))
    return product
