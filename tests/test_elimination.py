"""Recorded linear algebra against numpy's, on matrices with and without zeros in them."""

import numpy as np
import pytest
import sympy
from numpy.linalg import det, eigvalsh, svd
from numpy.testing import assert_allclose, assert_array_equal
from sympy import S

from dexterity import elimination
from dexterity.elimination import LAGUERRE_STEPS, LAGUERRE_TOLERANCE
from dexterity.program import Recorder
from program_values import values_of

# Where a matrix may differ from zero. A Jacobian has blocks, a locked row or column, and single entries.
PATTERNS = {
    "one entry": np.ones((1, 1)),
    "one row": np.ones((1, 4)),
    "dense": np.ones((6, 8)),
    "square": np.ones((6, 6)),
    "block of translations": np.block([[np.ones((3, 5)), np.eye(3)], [np.ones((3, 5)), np.zeros((3, 3))]]),
    "lower triangle": np.tril(np.ones((5, 5))),
    "diagonal": np.eye(4),
    "permuted diagonal": np.eye(6)[[3, 1, 5, 0, 2, 4]],
    "sparse": np.array([[0, 0, 1, 0, 1], [1, 0, 0, 0, 0], [0, 1, 1, 0, 0], [0, 0, 0, 1, 1.0]]),
    "row of zeros": np.array([[1, 1, 1, 1], [0, 0, 0, 0], [0, 1, 0, 1], [1, 1, 0, 0.0]]),
    "first row of zeros": np.array([[0, 0, 0], [1, 1, 0], [0, 1, 1.0]]),
    "only zeros": np.zeros((3, 4)),
}
SQUARE = {name: pattern for name, pattern in PATTERNS.items() if len(pattern) == len(pattern[0])}
by_pattern = pytest.mark.parametrize("pattern", PATTERNS.values(), ids=PATTERNS)
by_square_pattern = pytest.mark.parametrize("pattern", SQUARE.values(), ids=SQUARE)


class Trial:
    """A matrix of symbols and zeros, with values for the symbols."""

    def __init__(self, rng: np.random.Generator, pattern: np.ndarray, count: int = 20) -> None:
        self.values = rng.normal(size=(count, *pattern.shape)) * pattern
        self._symbols = sympy.symbols(f"J:{pattern.size}", real=True)
        entries = [
            symbol if there else S.Zero for symbol, there in zip(self._symbols, pattern.flat, strict=True)
        ]
        self.rows = np.array(entries, dtype=object).reshape(pattern.shape).tolist()

    def compute(self, record: Recorder, outputs: list[sympy.Expr]) -> np.ndarray:
        program = record.program(self._symbols, outputs)
        columns = self.values.reshape(len(self.values), -1).T
        return values_of(program, dict(zip(self._symbols, columns, strict=True)))

    def matrix(self, record: Recorder, rows: elimination.Matrix) -> np.ndarray:
        entries = self.compute(record, [x for row in rows for x in row])
        return entries.reshape(-1, len(rows), len(rows[0]))


def bidiagonal(squares: np.ndarray) -> np.ndarray:
    """Upper bidiagonal matrices with the roots of d₁², e₁², d₂², … as entries."""
    m = (squares.shape[-1] + 1) // 2
    B = np.zeros((*squares.shape[:-1], m, m))
    B[..., range(m), range(m)] = np.sqrt(squares[..., ::2])
    B[..., range(m - 1), range(1, m)] = np.sqrt(squares[..., 1::2])
    return B


# ---- reflections -----------------------------------------------------------------------------------


@by_pattern
def test_a_triangle_has_the_gram_matrix_of_its_rows(rng, pattern):
    trial, record = Trial(rng, pattern), Recorder()
    L, squares = elimination.triangularise(record, trial.rows)
    T, J = trial.matrix(record, L), trial.values
    assert_allclose(T @ T.swapaxes(-1, -2), J @ J.swapaxes(-1, -2), rtol=0, atol=1e-13)
    diagonal = np.diagonal(T, axis1=-2, axis2=-1)
    assert_allclose(trial.compute(record, squares), diagonal**2, rtol=1e-13, atol=1e-200)
    assert all(L[i][j] == 0 for i in range(len(L)) for j in range(i + 1, len(L)))


@by_square_pattern
def test_a_bidiagonal_form_has_the_singular_values_of_its_matrix(rng, pattern):
    trial, record = Trial(rng, pattern), Recorder()
    squares = trial.compute(record, elimination.bidiagonal_squares(record, trial.rows))
    assert squares.shape[-1] == 2 * len(pattern) - 1
    expected = svd(trial.values, compute_uv=False)
    assert_allclose(svd(bidiagonal(squares), compute_uv=False), expected, rtol=0, atol=2e-13)


def test_the_determinant_keeps_its_digits_near_a_singularity(rng):
    """On J itself, not on its square: J·Jᵀ would lose twice as many digits."""
    trial, record = Trial(rng, np.ones((4, 4))), Recorder()
    U, _, Vt = svd(trial.values)
    sigma = np.array([1.0, 0.7, 0.3, 1e-7])
    trial.values = U * sigma @ Vt
    _, squares = elimination.triangularise(record, trial.rows)
    w = np.sqrt(trial.compute(record, squares).prod(-1))
    assert_allclose(w, sigma.prod(), rtol=1e-16 / 1e-7 * 10, atol=0)


def test_matrices_of_lower_rank_keep_it(rng):
    trial, record = Trial(rng, np.ones((6, 7))), Recorder()
    trial.values[:, 5] = trial.values[:, 1] + trial.values[:, 2]
    trial.values[:, 3] = 0
    L, _ = elimination.triangularise(record, trial.rows)
    T = trial.matrix(record, L)
    assert_allclose(svd(T, compute_uv=False), svd(trial.values, compute_uv=False), rtol=0, atol=2e-13)
    squares = trial.compute(record, elimination.bidiagonal_squares(record, L))
    assert_allclose(
        svd(bidiagonal(squares), compute_uv=False), svd(trial.values, compute_uv=False), rtol=0, atol=2e-13
    )
    assert np.isfinite(squares).all()


def test_a_diagonal_matrix_costs_its_squares_only():
    record = Recorder()
    d = sympy.symbols("d:3", real=True)
    rows = [[d[i] * int(i == j) for j in range(3)] for i in range(3)]
    L, squares = elimination.triangularise(record, rows)
    assert all(L[i][j] == rows[i][j] for i in range(3) for j in range(3))
    assert len(record.program(d, squares).steps) == 3


# ---- determinants and products ---------------------------------------------------------------------


@by_square_pattern
def test_a_determinant_is_that_of_numpy(rng, pattern):
    trial, record = Trial(rng, pattern), Recorder()
    value = elimination.determinant(record, trial.rows)
    assert_allclose(trial.compute(record, [value])[:, 0], det(trial.values), rtol=1e-11, atol=1e-14)


@pytest.mark.parametrize("name", ["row of zeros", "first row of zeros"])
def test_a_determinant_that_vanishes_by_its_zeros_is_zero(rng, name):
    assert elimination.determinant(Recorder(), Trial(rng, SQUARE[name]).rows) == 0


def test_a_determinant_is_expanded_without_divisions(rng):
    trial, record = Trial(rng, np.ones((4, 4))), Recorder()
    program = record.program((), [elimination.determinant(record, trial.rows)])
    assert not any(expression.atoms(sympy.Pow) for _, expression in program.steps)
    assert sympy.expand(program.nested()[0] - sympy.Matrix(trial.rows).det()) == 0


@by_pattern
def test_a_gram_matrix_is_the_product_with_the_transpose(rng, pattern):
    trial, record = Trial(rng, pattern), Recorder()
    G, J = trial.matrix(record, elimination.gram(record, trial.rows)), trial.values
    assert_allclose(G, J @ J.swapaxes(-1, -2), rtol=0, atol=1e-14)
    assert_array_equal(G, G.swapaxes(-1, -2))


@pytest.mark.parametrize("name", ["dense", "square", "block of translations"])
def test_the_schur_complement_gives_the_determinant_of_a_gram_matrix(rng, name):
    trial, record = Trial(rng, PATTERNS[name]), Recorder()
    value = elimination.schur_determinant(record, elimination.gram(record, trial.rows))
    expected = svd(trial.values, compute_uv=False).prod(-1) ** 2
    assert_allclose(trial.compute(record, [value])[:, 0], expected, rtol=1e-8, atol=0)


def test_a_dot_product_is_a_sum_of_products():
    a, b, c = sympy.symbols("a b c", real=True)
    assert elimination.dot([a, b, S.Zero], [c, b, a]) == a * c + b**2
    assert elimination.dot([], []) == 0


# ---- Laguerre's iteration --------------------------------------------------------------------------

SPECTRA = {
    "simple": [1.0, 0.8, 0.5, 0.3, 0.1, 0.01],
    "clustered": [1.0, 1 - 1e-9, 0.5, 0.1 + 1e-9, 0.1, 0.1 - 1e-9],
    "doubled ends": [1.0, 1.0, 0.5, 0.3, 0.2, 0.2],
    "tripled ends": [1.0, 1.0, 1.0, 0.2, 0.2, 0.2],
    "four times the smallest": [1.0, 0.9, 0.2, 0.2, 0.2, 0.2],
    "four times the largest": [1.0, 1.0, 1.0, 1.0, 0.9, 0.2],
    "all but one equal": [1.0, 0.3, 0.3, 0.3, 0.3, 0.3],
    "all equal": [0.4] * 6,
    "graded": [1.0, 1e-2, 1e-4, 1e-6, 1e-8, 1e-10],
    "one zero": [1.0, 0.8, 0.5, 0.3, 0.1, 0.0],
    "two zeros": [1.0, 0.8, 0.5, 0.3, 0.0, 0.0],
    "only zeros": [0.0] * 6,
    "one singular value": [0.7],
    "two singular values": [0.7, 0.2],
}


def approach(squares: np.ndarray, side: int) -> list[float]:
    """Iterates towards the smallest (side -1) or the largest (side 1) squared singular value."""
    step = elimination.laguerre_step((len(squares) + 1) // 2)
    iterates = [0.0 if side < 0 else float(squares.sum())]
    for _ in range(LAGUERRE_STEPS):
        (moved,) = values_of(step, dict(zip(step.inputs, [iterates[-1], side, *squares], strict=True)))
        iterates.append(iterates[-1] - moved)
        if not abs(moved) > LAGUERRE_TOLERANCE * iterates[-1]:
            return iterates
    pytest.fail(f"the iteration did not end: {iterates}")


def squares_with(rng: np.random.Generator, sigma: list[float]) -> np.ndarray:
    """Squares of a bidiagonal form with these singular values; a diagonal one where nothing mixes them."""
    m = len(sigma)
    U, V = (np.linalg.qr(rng.normal(size=(m, m)))[0] for _ in range(2))
    trial, record = Trial(rng, np.ones((m, m)), count=1), Recorder()
    trial.values[0] = U * sigma @ V
    return trial.compute(record, elimination.bidiagonal_squares(record, trial.rows))[0]


@pytest.mark.parametrize("mixed", [True, False], ids=["mixed", "diagonal"])
@pytest.mark.parametrize("sigma", SPECTRA.values(), ids=SPECTRA)
def test_laguerres_iteration_ends_at_the_extreme_singular_values(rng, sigma, mixed):
    squares = np.zeros(2 * len(sigma) - 1)
    squares[::2] = np.square(sigma)
    if mixed:
        squares = squares_with(rng, sigma)
    smallest, largest = (np.sqrt(max(approach(squares, side)[-1], 0)) for side in (-1, 1))
    exact = svd(bidiagonal(squares), compute_uv=False)
    assert_allclose(largest, exact[0], rtol=1e-13, atol=1e-29)
    assert_allclose(smallest, exact[-1], rtol=1e-13, atol=1e-15)


@pytest.mark.parametrize("name", ["simple", "graded", "one zero", "doubled ends"])
def test_laguerres_iteration_never_oversteps_a_root(rng, name):
    squares = squares_with(rng, SPECTRA[name])
    eigenvalues = eigvalsh(bidiagonal(squares) @ bidiagonal(squares).T)
    rounding = 1e-14 * eigenvalues[-1]
    up, down = approach(squares, -1), approach(squares, 1)
    assert (np.diff(up) >= -rounding).all()
    assert max(up) <= eigenvalues[0] + rounding
    assert (np.diff(down) <= rounding).all()
    assert min(down) >= eigenvalues[-1] - rounding


def test_laguerres_iteration_takes_few_steps_to_a_simple_root_and_tens_to_a_quadruple_one(rng):
    assert len(approach(squares_with(rng, SPECTRA["simple"]), -1)) <= 8
    assert 20 <= len(approach(squares_with(rng, SPECTRA["four times the smallest"]), -1)) <= 40
