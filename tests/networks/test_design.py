"""The design loop of feed-forward networks: what it tries, when it ends, and many at a time."""

import dataclasses
import math
from functools import cache

import joblib
import pytest
import torch
from design_problems import SMALL, small_problem
from distributed import Client, LocalCluster
from torch.testing import assert_close

from dexterity.networks import design, levenberg_marquardt
from dexterity.networks.design import End, FeedForwardOptions, design_all, design_feed_forward
from dexterity.networks.levenberg_marquardt import Stop
from dexterity.networks.problem import DesignProblem, largest_relative_error

PROBLEM = small_problem()


def design_anew(problem=PROBLEM, **change):
    return design_feed_forward(problem, dataclasses.replace(SMALL, **change), progress=False)


designed = cache(design_anew)


def sizes(outcome):
    return [trial.neurons for trial in outcome.trials if trial.restart == 0]


def test_neurons_are_added_until_a_network_passes():
    outcome = designed()
    assert outcome.end is End.PASSED
    assert outcome.success
    assert sizes(outcome) == list(range(1, outcome.network.neurons + 1))
    assert len(outcome.trials) == 2 * outcome.network.neurons
    best = {n: min(t.testing_error for t in outcome.trials if t.neurons == n) for n in sizes(outcome)}
    assert outcome.best.testing_error == best[outcome.network.neurons] <= SMALL.testing_error
    assert all(best[n] > SMALL.testing_error for n in sizes(outcome)[:-1])


def test_trials_tell_what_their_network_does():
    outcome = designed(restarts=1)
    data = PROBLEM.data
    assert outcome.best.testing_error == largest_relative_error(outcome.network, data.test)
    assert outcome.best.validation_error == largest_relative_error(outcome.network, data.validation)
    error = (outcome.network(data.train.q).detach() - data.train.values).square().mean().item()
    assert outcome.best.mean_square_error == pytest.approx(error, rel=1e-9)
    assert outcome.best.history[-1] == outcome.best.mean_square_error
    assert len(outcome.best.history) == outcome.best.epochs + 1


def test_a_goal_ends_trainings():
    outcome = designed(training_goal=1.0, neuron_limit=2)
    assert {trial.stop for trial in outcome.trials} == {Stop.GOAL}


def test_a_test_that_none_passes_is_told():
    outcome = designed(testing_error=0.0, neuron_limit=3)
    assert outcome.end is End.EXHAUSTED
    assert not outcome.success
    assert sizes(outcome) == [1, 2, 3]
    assert outcome.best.testing_error == min(trial.testing_error for trial in outcome.trials)
    assert_close(
        largest_relative_error(outcome.network, PROBLEM.data.test), outcome.best.testing_error, rtol=0, atol=0
    )


def test_a_full_sweep_keeps_the_smallest_size_that_passes():
    first, all_sizes = designed(), designed(sweep="all")
    assert sizes(all_sizes) == list(range(1, SMALL.neuron_limit + 1))
    assert all_sizes.best == first.best
    assert all_sizes.trials[: len(first.trials)] == first.trials


def test_sizes_may_be_left_out():
    some = designed(sweep="all", first_neurons=2, neuron_step=3)
    assert sizes(some) == [2, 5]
    every = designed(sweep="all")
    assert some.trials == tuple(trial for trial in every.trials if trial.neurons in (2, 5))


def test_seeds_decide():
    assert design_anew() == designed()
    assert designed(seed=1).trials != designed().trials
    seeds = [trial.seed for seed in range(3) for trial in designed(seed=seed).trials]
    assert len(set(seeds)) == len(seeds)


def test_values_with_a_goal_in_the_units_of_the_readout():
    outcome = designed(readout="logarithm", neuron_limit=4)
    assert outcome.network.readout == "logarithm"
    logarithms = (outcome.network(PROBLEM.data.train.q).log() - PROBLEM.data.train.values.log()).detach()
    assert outcome.best.mean_square_error == pytest.approx(logarithms.square().mean().item(), rel=1e-9)


# ---- interrupts ------------------------------------------------------------------------------------


def interrupt_after(monkeypatch, steps):
    step, calls = levenberg_marquardt._State.step, []

    def interrupted(state):
        calls.append(state)
        if len(calls) > steps:
            raise KeyboardInterrupt
        return step(state)

    monkeypatch.setattr(levenberg_marquardt._State, "step", interrupted)


def test_an_interrupt_returns_the_best_so_far(monkeypatch):
    interrupt_after(monkeypatch, 60)
    options = dataclasses.replace(SMALL, testing_error=0.0)
    outcome = design_feed_forward(PROBLEM, options, progress=False)
    assert outcome.end is End.INTERRUPTED
    assert sizes(outcome) == [1, 2, 3]
    assert {trial.stop for trial in outcome.trials if trial.neurons == 3} == {Stop.INTERRUPTED}
    assert outcome.best.testing_error == min(trial.testing_error for trial in outcome.trials)


@pytest.mark.parametrize("finished", [0, 2])
def test_an_interrupt_between_trainings(monkeypatch, finished):
    size, calls = design._Loop.size, []

    def interrupted(*arguments):
        calls.append(arguments)
        if len(calls) > finished:
            raise KeyboardInterrupt
        return size(*arguments)

    monkeypatch.setattr(design._Loop, "size", interrupted)
    if finished:
        assert sizes(design_anew(testing_error=0.0)) == [1, 2]
    else:
        with pytest.raises(KeyboardInterrupt):
            design_anew()


# ---- many at a time --------------------------------------------------------------------------------

RUNS = [
    (PROBLEM, SMALL),
    (small_problem(1), dataclasses.replace(SMALL, seed=1, sweep="all", neuron_limit=4)),
    (small_problem(2), dataclasses.replace(SMALL, testing_error=0.0, neuron_limit=3)),
]


@cache
def one_by_one():
    return tuple(design_feed_forward(*run, progress=False) for run in RUNS)


def bytes_of(designs):
    return [
        tensor.numpy().tobytes() for outcome in designs for tensor in outcome.network.state_dict().values()
    ]


def test_many_are_as_one_by_one_in_every_backend(capsys):
    alone = one_by_one()
    assert design_all(RUNS, progress=False) == alone
    with joblib.parallel_config(backend="threading"):
        in_threads = design_all(RUNS, n_jobs=3, progress=False)
    assert in_threads == alone
    assert bytes_of(in_threads) == bytes_of(alone)
    assert not capsys.readouterr().err
    design_all(RUNS[:1])
    assert "1/1" in capsys.readouterr().err


def test_many_on_a_local_cluster_of_dask():
    """Its workers are threads here, so that they need not import everything again."""
    alone = one_by_one()
    cluster = LocalCluster(n_workers=2, threads_per_worker=1, processes=False, dashboard_address=":0")
    with cluster, Client(cluster), joblib.parallel_config(backend="dask"):
        on_the_cluster = design_all(RUNS, n_jobs=-1, progress=False)
    assert on_the_cluster == alone
    assert bytes_of(on_the_cluster) == bytes_of(alone)


def test_many_in_processes():
    assert design_all(RUNS[1:], n_jobs=2, progress=False) == one_by_one()[1:]
    joblib.externals.loky.get_reusable_executor().shutdown(wait=True)


def test_threads_are_as_before():
    before = torch.get_num_threads()
    design_anew(neuron_limit=1)
    assert torch.get_num_threads() == before


# ---- bad input -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"testing_error": -0.1}, "testing_error is -0.1"),
        ({"testing_error": math.nan}, "testing_error is nan"),
        ({"training_goal": -1.0}, "goal is -1.0"),
        ({"first_neurons": 0}, "first_neurons is 0"),
        ({"neuron_step": 0}, "neuron_step is 0"),
        ({"first_neurons": 5, "neuron_limit": 4}, "neuron_limit is 4"),
        ({"restarts": 0}, "restarts is 0"),
        ({"epoch_limit": 0}, "epoch_limit is 0"),
        ({"seed": -1}, "seed is -1"),
        ({"readout": "square"}, "readout is 'square'"),
        ({"damping": "none"}, "damping is 'none'"),
        ({"sweep": "some"}, "sweep is 'some'"),
    ],
)
def test_options_out_of_range(change, message, annotations_unchecked):
    with pytest.raises(ValueError, match=message):
        FeedForwardOptions(**change)


def test_problems_that_cannot_be_learned():
    data = PROBLEM.data
    negative = dataclasses.replace(data, train=dataclasses.replace(data.train, values=-data.train.values))
    with pytest.raises(ValueError, match="needs positive"):
        designed(DesignProblem(PROBLEM.view, negative), readout="logarithm")
    q = data.train.q.clone()
    q[:, 1] = 0
    still = dataclasses.replace(data, train=dataclasses.replace(data.train, q=q))
    with pytest.raises(ValueError, match="do not vary"):
        designed(DesignProblem(PROBLEM.view, still))


def test_the_defaults_are_the_printed_ones():
    paper = {
        setting: getattr(FeedForwardOptions(), setting)
        for setting in ("testing_error", "training_goal", "neuron_limit", "epoch_limit", "restarts", "sweep")
    }
    assert list(paper.values()) == [0.02, 1e-3, 100, 100, 1, "first"]
