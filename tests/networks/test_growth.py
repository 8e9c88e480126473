"""Growth, pruning and the design loop against what numpy's least squares and brute force say."""

import dataclasses
import itertools
import math
from functools import cache

import joblib
import numpy as np
import pytest
import torch
from torch.testing import assert_close

import dexterity as dx
from dexterity import sampling, store
from dexterity.indices import Index
from dexterity.networks import growth, pruning, radial_basis_design
from dexterity.networks.growth import RadialBasisOptions, Stop, fit, grow
from dexterity.networks.network import View
from dexterity.networks.problem import DesignProblem, End, largest_relative_error
from dexterity.networks.pruning import prune
from dexterity.networks.radial_basis_design import design_radial_basis
from dexterity.sampling import Box, DataSet

W = Index("manipulability").bind(dx.robots.uvms())
ALL_SIZES = RadialBasisOptions(testing_error=0.0, training_goal=0.0, neuron_limit=40)
ONE = torch.ones(1, dtype=torch.float64)


@cache
def w_problem(train=800):
    data = sampling.data_sets(W, sampling.uvms_space("manipulability"), train=train, test=200, validation=500)
    return DesignProblem(View(12, range(4, 11)), data)


def line_problem(f=lambda x: 2 + x.sin(), rows=200, data=None):
    """A problem with one input."""

    def of_q(q):
        return f(q[:, 0])

    sets = sampling.data_sets(of_q, Box([-3.0], [3.0]), train=rows, test=50, validation=50, method="uniform")
    return DesignProblem(View(1, [0]), dataclasses.replace(sets, **(data or {})))


def columns(problem, centres, spread, part="train"):
    """Columns of the least-squares problem, by numpy alone."""
    x = problem.view(getattr(problem.data, part).q).numpy()
    distances = np.linalg.norm(x[:, None] - np.asarray(centres)[None], axis=-1)
    return np.hstack([np.ones((len(x), 1)), np.exp(-((0.833 / spread * distances) ** 2))])


def numpy_growth(problem, spread, neurons):
    """Grow by Fig. 6b with a least-squares problem solved from the start for each size."""
    x, y = problem.view(problem.data.train.q).numpy(), problem.data.train.values.numpy()
    test = problem.data.test.values.numpy()
    rows, history, errors = [], [], np.abs(y - y.mean())
    for _ in range(neurons):
        errors[rows] = -1
        rows.append(int(errors.argmax()))
        A = columns(problem, x[rows], spread)
        weights = np.linalg.lstsq(A, y, rcond=None)[0]
        errors = np.abs(A @ weights - y)
        answers = columns(problem, x[rows], spread, "test") @ weights
        history.append(((errors**2).mean(), np.abs(answers / test - 1).max(), np.abs(weights[1:]).max()))
    return rows, np.array(history), weights


# ---- growth ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("spread", [0.2, 0.5, 1.0])
def test_growth_is_that_of_solving_from_the_start(spread):
    problem = w_problem()
    ours = grow(problem, spread, dataclasses.replace(ALL_SIZES, neuron_limit=25))
    rows, history, weights = numpy_growth(problem, spread, 25)
    assert list(ours.rows) == rows
    assert ours.stop is Stop.NEURONS
    assert ours.skipped == 0
    recorded = (ours.mean_square_errors, ours.testing_errors, ours.largest_weights)
    for mine, theirs in zip(recorded, history.T, strict=True):
        np.testing.assert_allclose(mine, theirs, rtol=1e-6)
    np.testing.assert_allclose(ours.network.output_weights.detach(), weights[1:], rtol=1e-6)
    A = columns(problem, ours.network.centres.detach(), spread)
    assert ours.condition == pytest.approx(np.linalg.cond(A), rel=1e-6)


@pytest.mark.parametrize("spread", [0.3, 2.0, 9.0, 100.0])
def test_what_is_recorded_is_what_the_network_does(spread):
    problem = w_problem()
    ours = grow(problem, spread, ALL_SIZES)
    with torch.no_grad():
        residuals = ours.network(problem.data.train.q) - problem.data.train.values
    # Weights of 1e8 and more cancel: this much of their rounding is left.
    rounding = 1e-14 * ours.largest_weights[-1]
    assert residuals.square().mean().sqrt().item() == pytest.approx(
        ours.mean_square_errors[-1] ** 0.5, rel=1e-3, abs=rounding
    )
    tested = largest_relative_error(ours.network, problem.data.test)
    assert tested == pytest.approx(ours.testing_errors[-1], rel=1e-3, abs=rounding)
    assert all(after <= before for before, after in itertools.pairwise(ours.mean_square_errors))
    assert len(set(ours.rows)) == ours.neurons == len(ours.testing_errors)
    assert torch.equal(ours.network.centres, problem.view(problem.data.train.q)[list(ours.rows)])


def test_growth_ends_when_the_test_is_passed_below_the_threshold():
    problem = w_problem()
    everything = grow(problem, 0.5, ALL_SIZES)
    passed = grow(problem, 0.5, RadialBasisOptions(testing_error=0.02))
    assert passed.stop is Stop.TESTING_ERROR
    assert passed.success
    first = next(
        k for k in range(40)
        if everything.testing_errors[k] < 0.02 and everything.mean_square_errors[k] < 1e-2
    )  # fmt: skip
    assert passed.neurons == first + 1
    assert passed.testing_errors == everything.testing_errors[: first + 1]
    # A threshold below what was reached puts testing off.
    threshold = everything.mean_square_errors[first] * 0.9
    later = grow(problem, 0.5, RadialBasisOptions(testing_error=0.02, error_threshold=threshold))
    assert later.neurons > passed.neurons


def test_growth_ends_at_the_goal_and_at_the_neuron_limit():
    problem = w_problem()
    everything = grow(problem, 0.5, ALL_SIZES)
    goal = everything.mean_square_errors[10]
    ended = grow(problem, 0.5, dataclasses.replace(ALL_SIZES, training_goal=goal))
    assert (ended.stop, ended.neurons, ended.success) == (Stop.GOAL, 11, False)
    one = grow(problem, 0.5, dataclasses.replace(ALL_SIZES, neuron_limit=1))
    assert (one.stop, one.neurons, one.success) == (Stop.NEURONS, 1, False)


def test_growth_ends_where_bells_depend_on_each_other():
    # A few points, each taken once: no error is left, and no point either.
    few = grow(line_problem(rows=12), 1.0, ALL_SIZES)
    assert few.stop is Stop.CENTRES
    assert few.neurons <= 11
    assert few.mean_square_errors[-1] < 1e-8
    # Bells so wide that they are parabolas, to rounding.
    wide = grow(line_problem(), 1e5, ALL_SIZES)
    assert wide.stop is Stop.CENTRES
    assert wide.skipped > 0
    assert wide.neurons < 5
    assert math.isfinite(wide.condition)


def test_points_that_occur_twice_are_taken_once():
    plain = line_problem()
    twice = DataSet(plain.data.train.q.repeat(2, 1), plain.data.train.values.repeat(2))
    ours = grow(line_problem(data={"train": twice}), 0.3, dataclasses.replace(ALL_SIZES, neuron_limit=30))
    assert len(ours.network.centres.unique()) == ours.neurons
    once = grow(plain, 0.3, dataclasses.replace(ALL_SIZES, neuron_limit=30))
    assert_close(ours.network.centres, once.network.centres, rtol=0, atol=0)
    np.testing.assert_allclose(ours.mean_square_errors, once.mean_square_errors, rtol=1e-9)


def test_two_values_at_one_point_are_no_reason_to_fail():
    data = line_problem().data.train
    torn = DataSet(data.q.repeat(2, 1), torch.cat([data.values, data.values + 1]))
    ours = grow(line_problem(data={"train": torn}), 0.3, dataclasses.replace(ALL_SIZES, neuron_limit=30))
    # The values differ by 1 at each point, so that no function does better than a half.
    assert ours.mean_square_errors[-1] >= 0.25
    assert all(map(math.isfinite, ours.largest_weights))


def test_a_problem_with_no_bell_but_a_constant_is_refused():
    plain = line_problem()
    one_point = DataSet(torch.ones_like(plain.data.train.q), plain.data.train.values)
    for problem, spread in (line_problem(data={"train": one_point}), 1.0), (plain, 1e12):
        with pytest.raises(ValueError, match=r"^spread is .*; no bell about a training input differs"):
            grow(problem, spread, ALL_SIZES)


def test_degrees_need_a_spread_in_degrees():
    problem = w_problem()
    degrees = math.degrees(1)
    in_degrees = grow(problem, 0.5 * degrees, dataclasses.replace(ALL_SIZES, input_scale=degrees))
    in_radians = grow(problem, 0.5, ALL_SIZES)
    assert in_degrees.rows == in_radians.rows
    assert_close(
        in_degrees.network(problem.data.test.q), in_radians.network(problem.data.test.q), rtol=1e-8, atol=0
    )
    each = grow(problem, 0.5, dataclasses.replace(ALL_SIZES, input_scale=(1.0,) * 7))
    assert each.rows == in_radians.rows


# ---- least squares ---------------------------------------------------------------------------------


def test_fitted_weights_are_those_of_numpy(rng):
    problem = w_problem()
    train = problem.data.train
    centres = rng.uniform(-0.3, 0.3, (12, 7))
    ours = fit(problem.view, train, centres, 0.6, np.ones(7))
    expected = np.linalg.lstsq(columns(problem, centres, 0.6), train.values.numpy(), rcond=None)[0]
    np.testing.assert_allclose(ours.output_bias.item(), expected[0], rtol=1e-9)
    np.testing.assert_allclose(ours.output_weights.detach(), expected[1:], rtol=1e-8)


def test_centres_that_leave_weights_open_are_refused():
    problem = line_problem()
    train = problem.data.train
    for centres, spread in ([[0.1], [0.7], [0.1]], 0.5), ([[0.1], [0.2], [0.3], [0.4]], 1e6):
        with pytest.raises(ValueError, match=r"^centres do not determine the weights"):
            fit(problem.view, train, centres, spread, ONE)
    with pytest.raises(ValueError, match=r"^train has 3 rows; at least 5"):
        fit(problem.view, DataSet(train.q[:3], train.values[:3]), [[0.1], [0.2], [0.3], [0.4]], 0.5, ONE)


# ---- pruning ---------------------------------------------------------------------------------------


def brute_force_order(problem, centres, spread):
    """Remove neurons by trying each and solving from the start; also the error after each removal."""
    y = problem.data.train.values.numpy()
    kept, order, squares = list(range(len(centres))), [], []

    def error(neurons):
        A = columns(problem, centres[neurons], spread)
        return np.square(A @ np.linalg.lstsq(A, y, rcond=None)[0] - y).mean()

    squares.append(error(kept))
    while len(kept) > 1:
        errors = [error([k for k in kept if k != neuron]) for neuron in kept]
        squares.append(min(errors))
        order.append(kept.pop(int(np.argmin(errors))))
    return order, squares


@pytest.mark.parametrize("spread", [0.3, 1.0])
def test_the_least_useful_neuron_goes_first(spread):
    problem = w_problem()
    grown = grow(problem, spread, dataclasses.replace(ALL_SIZES, neuron_limit=14))
    ours = prune(problem, grown.network, 0.02)
    order, squares = brute_force_order(problem, grown.network.centres.detach().numpy(), spread)
    assert list(ours.order) == order
    np.testing.assert_allclose(ours.mean_square_errors, squares, rtol=1e-8)


def test_a_pruned_network_is_the_last_that_passes():
    problem = w_problem()
    grown = grow(problem, 1.5, ALL_SIZES)
    limit = 0.015
    ours = prune(problem, grown.network, limit)
    passes = [error < limit for error in ours.testing_errors]
    assert ours.success
    assert passes[0]
    assert ours.neurons == 40 - (passes.index(False) - 1) < 40
    assert largest_relative_error(ours.network, problem.data.test) < limit
    kept = [k for k in range(40) if k not in ours.order[: 40 - ours.neurons]]
    centres = grown.network.centres.detach()[kept]
    assert torch.equal(ours.network.centres.detach(), centres)
    again = fit(problem.view, problem.data.train, centres, 1.5, np.ones(7))
    q = problem.data.validation.q
    assert_close(ours.network(q), again(q), rtol=1e-7, atol=0)


def test_a_network_that_does_not_pass_is_left_whole():
    problem = w_problem()
    grown = grow(problem, 0.2, dataclasses.replace(ALL_SIZES, neuron_limit=10))
    ours = prune(problem, grown.network, 1e-4)
    assert not ours.success
    assert ours.neurons == 10
    assert len(ours.testing_errors) == 10
    assert_close(ours.network.output_weights, grown.network.output_weights, rtol=1e-8, atol=0)


def test_one_neuron_is_not_pruned():
    problem = w_problem()
    one = grow(problem, 0.5, dataclasses.replace(ALL_SIZES, neuron_limit=1)).network
    assert prune(problem, one, 0.5).order == ()
    assert prune(problem, one, 0.5).neurons == 1


def test_impossible_limits_of_pruning_are_refused():
    problem = w_problem()
    network = grow(problem, 0.5, dataclasses.replace(ALL_SIZES, neuron_limit=2)).network
    for limit in (0.0, -1.0, math.inf, math.nan):
        with pytest.raises(ValueError, match=r"^testing_error is "):
            prune(problem, network, limit)


# ---- the design loop -------------------------------------------------------------------------------

LOOP = RadialBasisOptions(
    testing_error=0.015, first_spread=0.2, spread_step=0.2, spread_limit=1.0, neuron_limit=30
)


def key(design):
    arrays = {name: tensor.detach() for name, tensor in design.network.state_dict().items()}
    growths = [(g.spread, g.stop, g.rows, g.mean_square_errors, g.testing_errors) for g in design.growths]
    return store.content_key(arrays, growths, design.end)


def test_spreads_go_in_steps_to_the_limit_itself():
    printed = RadialBasisOptions()
    assert len(printed.spreads) == 100
    np.testing.assert_allclose(printed.spreads, np.arange(1, 101) / 10, rtol=1e-12)
    np.testing.assert_allclose(LOOP.spreads, [0.2, 0.4, 0.6, 0.8, 1.0], rtol=1e-12)
    assert dataclasses.replace(LOOP, first_spread=1.0).spreads == (1.0,)


def test_the_printed_loop_ends_at_the_first_spread_that_passes():
    problem = w_problem()
    first = design_radial_basis(problem, LOOP, progress=False)
    everything = design_radial_basis(problem, dataclasses.replace(LOOP, sweep="all"), progress=False)
    passing = [growth.success for growth in everything.growths]
    assert first.success
    assert everything.success
    assert len(everything.growths) == 5
    assert not passing[0]
    assert len(first.growths) == passing.index(True) + 1
    assert first.best is first.growths[-1]
    fewest = min(growth.neurons for growth in everything.growths if growth.success)
    assert everything.network.neurons == everything.best.neurons == fewest < first.network.neurons
    assert largest_relative_error(everything.network, problem.data.test) < LOOP.testing_error


def test_a_design_that_never_passes_says_so():
    problem = w_problem()
    ours = design_radial_basis(problem, dataclasses.replace(LOOP, testing_error=1e-5), progress=False)
    assert ours.end is End.EXHAUSTED
    assert not ours.success
    assert len(ours.growths) == 5
    smallest = min(min(growth.testing_errors) for growth in ours.growths)
    assert largest_relative_error(ours.network, problem.data.test) == pytest.approx(smallest, rel=1e-6)


@pytest.mark.parametrize("sweep", ["first", "all"])
def test_jobs_do_not_change_the_result(sweep):
    problem, options = w_problem(), dataclasses.replace(LOOP, sweep=sweep)
    alone = design_radial_basis(problem, options, progress=False)
    with joblib.parallel_config(backend="threading"):
        together = design_radial_basis(problem, options, n_jobs=3, progress=False)
    assert key(together) == key(alone)


@pytest.mark.parametrize("finished", [0, 2])
def test_an_interrupt_returns_what_there_is(monkeypatch, finished):
    begun = []

    def interrupted(*run):
        begun.append(run)
        if len(begun) == finished + 1:
            raise KeyboardInterrupt
        return grow(*run)

    monkeypatch.setattr(radial_basis_design, "grow", interrupted)
    options = dataclasses.replace(LOOP, testing_error=1e-5)
    if finished:
        design = design_radial_basis(w_problem(), options, progress=False)
        assert design.end is End.INTERRUPTED
        assert [growth.spread for growth in design.growths] == pytest.approx([0.2, 0.4])
    else:
        with pytest.raises(KeyboardInterrupt):
            design_radial_basis(w_problem(), options, progress=False)


def test_progress_is_shown_on_request(capsys):
    options = dataclasses.replace(LOOP, first_spread=1.0)
    design_radial_basis(w_problem(), options, progress=True)
    captured = capsys.readouterr()
    assert "1/1" in captured.err
    design_radial_basis(w_problem(), options, progress=False)
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize("name", ["first_spread", "spread_step", "spread_limit", "input_scale"])
@pytest.mark.parametrize("number", [0.0, -0.1, math.inf, math.nan])
def test_numbers_that_must_be_positive_are_refused_otherwise(name, number):
    with pytest.raises(ValueError, match=f"^{name} is {number}"):
        RadialBasisOptions(**{name: number})


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"testing_error": -0.1}, "testing_error is -0.1"),
        ({"training_goal": math.nan}, "training_goal is nan"),
        ({"error_threshold": 1e-7}, "error_threshold is 1e-07; at least the training goal"),
        ({"first_spread": 11.0}, "first_spread is 11.0; the limit is 10.0"),
        ({"neuron_limit": 0}, "neuron_limit is 0; a whole number of at least 1"),
        ({"input_scale": (1.0, 0.0)}, "input_scale is 0.0"),
    ],
)
def test_impossible_options_are_refused(change, message):
    with pytest.raises(ValueError, match=f"^{message}"):
        RadialBasisOptions(**change)


def test_an_unknown_sweep_is_refused(annotations_unchecked):
    with pytest.raises(ValueError, match=r"^sweep is 'some'"):
        RadialBasisOptions(sweep="some")


def test_options_that_do_not_fit_the_view_are_refused():
    with pytest.raises(ValueError, match=r"^input_scale has 2 factors; the view has 7 inputs"):
        grow(w_problem(), 0.5, RadialBasisOptions(input_scale=(1.0, 2.0)))


@pytest.mark.parametrize("spread", [0.0, -1.0, math.inf, math.nan])
def test_impossible_spreads_are_refused(spread):
    with pytest.raises(ValueError, match=f"^spread is {spread}"):
        grow(w_problem(), spread)
    with pytest.raises(ValueError, match=f"^spread is {spread}"):
        fit(w_problem().view, w_problem().data.train, np.zeros((1, 7)), spread, np.ones(7))


def test_public_names_are_sorted():
    for module in (growth, pruning):
        assert list(module.__all__) == sorted(module.__all__)
