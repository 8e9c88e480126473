import math

import pytest
import sympy
from hypothesis import given
from hypothesis import strategies as st
from sympy import cos, exp, sin, sqrt

from dexterity import operations
from dexterity.operations import Operations, count
from dexterity.program import Recorder

a, b, c, d = sympy.symbols("a b c d", positive=True)

sizes = st.integers(1, 12)


# ---- expressions -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("expression", "additions", "multiplications"),
    [
        (a, 0, 0),
        (-a, 0, 0),
        (sympy.Integer(7), 0, 0),
        (a + b - c, 2, 0),
        (a * b * c, 0, 2),
        (-a * b, 0, 1),
        (a / b, 0, 1),
        (1 / a, 0, 1),
        (a / (b * c), 0, 2),
        (a * b / c, 0, 2),
        (a**2, 0, 1),
        (a**3, 0, 2),
        (1 / a**2, 0, 2),
        (sqrt(a), 0, 1),
        (sin(a), 1, 3),
        (cos(a), 1, 3),
        (sin(a + b), 2, 3),
        (exp(a), 0, 1),
        (exp(-a), 0, 1),
        ((exp(a) - exp(-a)) / (exp(a) + exp(-a)), 2, 5),
        (a * cos(b) - c * sin(d), 3, 8),
        (sympy.Abs(a - b), 1, 0),
    ],
    ids=str,
)
def test_counts_of_small_expressions(expression, additions, multiplications):
    assert count([expression]) == Operations(additions, multiplications)


def test_nothing_costs_nothing():
    assert count([]) == Operations() == Operations(0, 0)


def test_nothing_is_shared_between_expressions_or_within_one():
    product = a * b
    assert count([product, product]) == 2 * count([product])
    assert count([sin(product) + cos(product)]).multiplications == 2 * (3 + 1)


def test_the_total_is_additions_and_multiplications():
    assert Operations(2, 3).total == 5
    assert Operations(1, 2) + Operations(10, 20) == Operations(11, 22)
    assert 3 * Operations(1, 2) == Operations(3, 6)


def test_shared_terms_are_counted_once():
    expressions = [sin(a) * b, sin(a) * c, cos(sin(a) * b)]
    assert operations.count_shared(expressions) == Operations(2, 3 + 1 + 1 + 3)
    assert operations.count_shared([a + b, c * d]) == count([a + b, c * d])


def test_a_program_costs_its_steps():
    record = Recorder()
    product = record(a * b)
    program = record.program((a, b), [record(product + 1), -product])
    assert operations.count_program(program) == Operations(1, 1)
    assert count(program.nested()) == Operations(1, 2)


# ---- networks --------------------------------------------------------------------------------------


@given(sizes, sizes)
def test_a_feed_forward_network_by_hand(inputs, neurons):
    """Neuron: weighted sum and bias, the sigmoid, its part of the output."""
    by_form = {
        "printed": Operations(inputs + 2 + 1, inputs + 4 + 1 + 1),
        "shared": Operations(inputs + 2 + 1, inputs + 2 + 1 + 1),
        "folded": Operations(inputs + 1 + 1, inputs + 1 + 1),
    }
    for form, neuron in by_form.items():
        assert operations.feed_forward(inputs, neurons, form) == neurons * neuron


@given(st.integers(2, 12), sizes)  # of a single input the norm is the absolute value, without a root
def test_a_radial_basis_network_by_hand(inputs, neurons):
    """Neuron: differences and their sum, the bias, the Gaussian, its part of the output."""
    additions = inputs + (inputs - 1) + 1
    by_form = {
        "printed": Operations(additions, 1 + 1 + 1 + 1),
        "norm": Operations(additions, inputs + 1 + 1 + 1 + 1 + 1),
        "shared": Operations(additions, inputs + 1 + 1 + 1),
    }
    for form, neuron in by_form.items():
        assert operations.radial_basis(inputs, neurons, form) == neurons * neuron


@pytest.mark.parametrize(("inputs", "neurons", "total"), [(7, 8, 184), (11, 25, 775)])
def test_feed_forward_networks_of_table_4_of_paper_a(inputs, neurons, total):
    assert operations.feed_forward(inputs, neurons).total == total


def test_no_number_of_inputs_gives_the_radial_basis_neuron_of_paper_a():
    for form in ("printed", "norm", "shared"):
        neurons = [operations.radial_basis(inputs, 1, form) for inputs in range(1, 30)]
        assert Operations(12, 16) not in neurons


# ---- dense matrices --------------------------------------------------------------------------------


@given(st.integers(1, 6), st.integers(1, 8))
def test_a_product_with_its_transpose_by_hand(rows, columns):
    all_of_it = operations.gram(rows, columns)
    assert all_of_it == rows**2 * Operations(columns - 1, columns)
    half = operations.gram(rows, columns, symmetric=True)
    assert half == math.comb(rows + 1, 2) * Operations(columns - 1, columns)


@given(st.integers(1, 6))
def test_a_determinant_by_hand(size):
    n = size
    by_method = {
        "terms": Operations(math.factorial(n) - 1, math.factorial(n) * (n - 1)),
        "minors": sum(
            (math.comb(n, k) * Operations(k - 1, k) for k in range(2, n + 1)),
            Operations(),
        ),
        "elimination": sum(
            (Operations(k**2, k**2 + k) for k in range(1, n)), Operations(multiplications=n - 1)
        ),
    }
    for method, counted in by_method.items():
        assert operations.determinant(n, method) == counted


def test_the_determinant_and_the_product_of_paper_a():
    assert operations.gram(6, 12) == Operations(396, 432)
    assert operations.determinant(6) == Operations(719, 3600)


def test_a_reduction_to_bidiagonal_form_costs_more_than_half_a_product_and_grows_with_the_matrix():
    one = operations.singular_values(6, 12).total
    assert operations.gram(6, 12, symmetric=True).total < one
    assert operations.singular_values(5, 12).total < one < operations.singular_values(6, 13).total


def test_a_single_row_has_its_norm_as_singular_value():
    # The program returns the square: four products, three sums, and one that keeps a root finite.
    assert operations.singular_values(1, 1) == Operations(0, 1)
    assert operations.singular_values(1, 4).multiplications >= 4


# ---- errors ----------------------------------------------------------------------------------------


@pytest.mark.usefixtures("annotations_unchecked")
class TestErrors:
    @pytest.mark.parametrize("network", [operations.feed_forward, operations.radial_basis])
    def test_sizes_must_be_positive(self, network):
        with pytest.raises(ValueError, match="inputs is 0"):
            network(0, 3)
        with pytest.raises(ValueError, match="neurons is -1"):
            network(3, -1)

    @pytest.mark.parametrize("network", [operations.feed_forward, operations.radial_basis])
    def test_forms_must_be_known(self, network):
        with pytest.raises(ValueError, match="form is 'cheap'; one of printed"):
            network(3, 3, "cheap")

    def test_matrices_must_have_entries(self):
        with pytest.raises(ValueError, match="rows is 0"):
            operations.gram(0, 3)
        with pytest.raises(ValueError, match="columns is 0"):
            operations.gram(3, 0)
        with pytest.raises(ValueError, match="size is 0"):
            operations.determinant(0)

    def test_methods_must_be_known(self):
        with pytest.raises(ValueError, match="method is 'luck'; one of terms"):
            operations.determinant(3, "luck")

    def test_a_matrix_to_decompose_must_be_wide(self):
        with pytest.raises(ValueError, match="columns is 5; at least as many as rows, 6"):
            operations.singular_values(6, 5)
