"""The design of readings: what it covers, and what a reading changes."""

import pytest
import torch
from torch.testing import assert_close

from dexterity.networks.levenberg_marquardt import Stop
from dexterity_study.claims.ledger import load_paper
from dexterity_study.uvms.feed_forward.experiment import GOALS, LIMIT
from dexterity_study.uvms.reconstruction import experiment
from dexterity_study.uvms.reconstruction.experiment import CHOSEN, FACTORS, Case, FeedForwardLearning, reading
from dexterity_study.uvms.unprinted import whole_loops


def case(name, **changed):
    return Case({**CHOSEN, **changed}, name, seed=0, tested=50, rows=300)


def test_the_design_covers_every_factor():
    readings = [reading(number) for number in range(256)]
    for factor in FACTORS:
        values = [one[factor.name] for one in readings]
        if factor.scale is None:
            counts = [values.count(level) for level in factor.levels]
            assert sum(counts) == 256
            assert max(counts) - min(counts) <= 1
        else:
            low, high = min(factor.levels), max(factor.levels)
            assert all(low <= value <= high for value in values)
            # The middle half of a range that is filled evenly holds half of the readings.
            quarters = [factor.at(0.25), factor.at(0.75)]
            assert sum(quarters[0] <= value <= quarters[1] for value in values) == 128
        assert factor.chosen in factor.levels


def test_goals_and_limit_are_those_of_the_table():
    assert experiment.GOALS == GOALS
    assert experiment.LIMIT == LIMIT


def test_a_moved_task_point_moves_the_vehicle_alone():
    near, far = (case("KCI", ahead=ahead).problem.data.train.q for ahead in (0.0, 2.0))
    assert_close(far[:, 1] - near[:, 1], torch.full((300,), 2.0, dtype=torch.float64))
    assert_close(far[:, [0, *range(2, 12)]], near[:, [0, *range(2, 12)]])


def test_an_upright_vehicle_leaves_fewer_inputs():
    assert case("w", vehicle_angle=0.0).problem.view.inputs == (6, 7, 8, 9, 10)
    assert case("KCI", vehicle_angle=0.0, elevation=0.0).problem.view.inputs == (0, 1, 6, 7, 8, 9, 10)


@pytest.mark.parametrize("scaling", ["range", "none"])
def test_scaling_is_undone_without_a_change_of_the_hidden_units(scaling):
    learning = FeedForwardLearning(case("w", scaling=scaling), epochs=30)
    trained = learning.trained(3, goal=0.0)
    assert trained.mean_square_error < 0.05
    assert (trained.network.input_half_range == 1).all() == (scaling == "none")


def test_validation_ends_a_training_early():
    ended = FeedForwardLearning(case("w", stopping="validation"), epochs=300).trained(25, goal=0.0)
    assert ended.stop is Stop.RISES


def test_radial_basis_loops_end_later_where_they_begin_later():
    found = experiment._bells(case("w"), (0.3, 1.0, 8.9), bells=60)
    for first in experiment.FIRST:
        spread = found[f"rb_spread_from_{first:g}"]
        assert not spread < first
    assert found["rb_fewest"] <= found["rb_neurons_from_1"]


def test_alone_changes_one_factor_at_a_time():
    changed = [{name for name in CHOSEN if values[name] != CHOSEN[name]} for _, values in experiment.ALONE]
    assert changed[0] == set()
    assert all(len(names) == 1 for names in changed[1:])
    assert set().union(*changed) == set(CHOSEN)
    assert len({name for name, _ in experiment.ALONE}) == len(experiment.ALONE)


def test_a_loop_goes_on_until_a_network_passes():
    rows = experiment.loops(0, **{**experiment.loops.smoke, "neurons": 4}).where()
    for _, steps in rows.groupby(["index", "case", "kind"]):
        assert steps["step"].tolist() == list(range(1, len(steps) + 1))
        assert not steps["passes"].iloc[:-1].any()
        assert (steps["passes"] == (steps["testing_error"] <= LIMIT)).all()
        at_the_limit = len(steps) == 4 or steps["spread"].iloc[-1] == 10.0
        assert steps["passes"].iloc[-1] or at_the_limit


@pytest.mark.parametrize("index", ["w", "KCI"])
def test_a_loop_that_counts_has_passed_or_has_gone_to_the_printed_limit(index):
    ends, limit = (
        whole_loops(index, "feed-forward"),
        load_paper("sotiropoulos2016").printed("feed-forward-neuron-limit"),
    )
    assert (ends["passes"] | (ends["neurons"] == max(limit))).all()
    assert len(ends.loc[["chosen"]]) == 10
    assert set(ends.index.unique("reading")) > {"chosen"}
