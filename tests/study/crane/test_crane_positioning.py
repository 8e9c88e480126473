"""Four ways to position: test points in arrays, the halves of a network, and how orders are judged."""

import inspect

import numpy as np
import pytest
import torch

from dexterity.crane import TEST_PAYLOADS, TEST_POINTS, positioning
from dexterity_study.claims.ledger import load_paper
from dexterity_study.claims.outcome import Outcome
from dexterity_study.crane.positioning import experiment, show, verdicts
from dexterity_study.engine.evidence import Evidence
from dexterity_study.engine.table import Table

CHAPTER, EPOCHS = "crane.positioning", 3


def test_the_statistics_without_compensation_are_the_fitted_ones():
    task = positioning.thesis_task()
    found = experiment.facts(task, positioning.uncompensated(task), experiment.NONE)
    assert found["mean"] == pytest.approx(31.9331, abs=1e-2)
    assert found["max"] == pytest.approx(129.6755, abs=1e-1)


def test_test_points_lie_in_arrays_by_point_and_load():
    task = positioning.thesis_task()
    shape = len(TEST_POINTS), len(TEST_PAYLOADS)
    np.testing.assert_array_equal(task.targets.reshape(*shape, 2)[:, 3], TEST_POINTS)
    np.testing.assert_array_equal(task.payload.reshape(shape)[7], TEST_PAYLOADS)


def test_halves_of_a_network_keep_their_neurons_and_add_up():
    both = experiment.trained(experiment.MODULAR, 0, EPOCHS)
    x = experiment.training_data().rows[::50, :4]
    first, second = experiment.half(both, first=True), experiment.half(both, first=False)
    with torch.no_grad():
        np.testing.assert_allclose(first(x) + second(x), both(x), atol=1e-12)
        # The first half is of the rigid crane and sees no payload.
        np.testing.assert_array_equal(first(x), first(x * torch.tensor([1, 1, 1, 0])))
    assert both.output_weights.detach().count_nonzero() == both.output_weights.numel()


def test_networks_ask_for_strokes_beyond_the_ends():
    row = experiment.methods(0, epochs=EPOCHS, generations=2).where(method=experiment.FREE).iloc[0]
    assert 0 < row["stopped"] <= 1


def test_operations_are_counted_for_the_printed_networks():
    parameters = inspect.signature(experiment.operations.function).parameters
    paper = load_paper("rouvinen1999")
    assert parameters["inverse"].default == paper.printed("crane-inverse-neurons")
    assert parameters["direct"].default == paper.printed("crane-direct-neurons")[0]
    plain, full = experiment.operations(), experiment.operations(reading="crane-what-counts=five")
    added = full.rows["answer"] - plain.rows["answer"]
    assert added.item() == 4 * parameters["inverse"].default


def changed(method, factor):
    """Stored evidence with a method's errors larger by a factor."""
    stored = Evidence(CHAPTER)["methods"]
    rows, place = stored.rows.copy(), experiment.METHODS.index(method)
    metrics = [name for name in rows if name.startswith(("mean", "max"))]
    rows.loc[rows["method"] == method, metrics] *= factor
    scale = np.ones((len(experiment.METHODS), 1))
    scale[place] = factor
    arrays = {run: {**held, "distance": scale * held["distance"]} for run, held in stored.arrays.items()}
    table = Table(rows, stored.keys, arrays)
    return {one.claim: one.outcome for one in verdicts.verdicts(Evidence(CHAPTER, {"methods": table}))}


def test_orders_follow_from_errors():
    better = changed(experiment.DIRECT, 3)
    assert better["crane-order"] == better["crane-modular-beats-direct"] == Outcome.REPRODUCED
    worse = changed(experiment.MODULAR, 1e3)
    assert worse["crane-modular-beats-direct"] == Outcome.NOT_REPRODUCED
    assert worse["crane-modular-max-is-reasonable"] == Outcome.NOT_REPRODUCED


def test_compensation_that_never_harms_is_seen():
    fine = changed(experiment.GENETIC, 1e-3)
    assert fine["crane-correction-helps-nearly-everywhere"] == Outcome.REPRODUCED
    assert fine["crane-correction-mean"] == Outcome.NOT_REPRODUCED


def test_the_two_worst_points_are_left_out():
    stored = Evidence(CHAPTER)
    for method, points in verdicts.LEFT_OUT.items():
        kept = verdicts.distance(stored, method)[:, ~verdicts.at(*points)]
        assert kept.shape[1:] == (len(TEST_POINTS) - 2, len(TEST_PAYLOADS))
    assert verdicts.named(np.flatnonzero(verdicts.at((1, 6)))) == "(1, 6)"


def test_the_scene_states_how_far_each_method_is_off():
    task = positioning.thesis_task([(6.0, 2.0)], [310.0])
    placements = {experiment.NONE: positioning.uncompensated(task), **experiment.answers(task, 0, EPOCHS)}
    shown = show.four_tips(epochs=EPOCHS)._repr_html_()
    for method in show.TIP_COLORS:
        off = 1e3 * positioning.errors(task, placements[method]).distance.item()
        assert f"{method}, {off:.1f} mm off" in shown
    assert f"errors drawn {show.MAGNIFIED:g} : 1" in shown


def test_clouds_have_a_dot_for_each_seed_and_a_cross_for_each_printed_pair():
    stored, paper = Evidence(CHAPTER), load_paper("rouvinen1999")
    (ax,) = show.clouds(stored).axes
    dots = [line for line in ax.lines if line.get_marker() == "o"]
    assert [len(line.get_xdata()) for line in dots] == [10] * len(show.COLORS)
    crosses = {
        tuple(line.get_xydata()[0]) for line in ax.lines if line.get_marker() == "x" and len(line.get_xdata())
    }
    assert crosses == {
        tuple(paper.printed(f"crane-{name}-{kind}")[2] for kind in ("mean", "max"))
        for name in verdicts.NAMES.values()
    }
