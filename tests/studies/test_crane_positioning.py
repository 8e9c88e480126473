"""The four methods: what the study derives from errors, on errors that are known."""

import dataclasses

import numpy as np
import pytest

from dexterity.report.claims import Outcome
from dexterity.report.provenance import load_stored
from dexterity.report.study import load_study
from dexterity.studies.crane import positioning as study


@pytest.fixture(scope="module")
def result():
    return load_study("crane.positioning").run(dataclasses.replace(study.CONFIGS["smoke"], generations=5))


def outcomes(result):
    return {verdict.claim: verdict.outcome for verdict in study.verdicts(result)}


def with_errors(result, method, scale):
    """Replace what a method answered by its errors, larger by a factor."""
    own = result.answers[method]
    answers = {**result.answers, method: dataclasses.replace(own, errors=scale * own.errors)}
    return dataclasses.replace(result, answers=answers)


def test_every_method_answers_every_point_once_a_seed(result):
    assert result.answers.keys() == study.METHODS.keys()
    assert result.fresh.keys() == study.METHODS.keys() - {"1"}
    for own in result.answers.values():
        assert own.errors.shape == (2, 125, 2)
        assert np.isfinite(own.errors).all()
    for distance in result.fresh.values():
        assert distance.shape == (2, 40)


def test_the_printed_statistics_without_compensation_are_the_fitted_ones(result):
    distance = np.linalg.norm(result.uncompensated, axis=1)
    assert distance.mean() == pytest.approx(31.9331e-3, abs=1e-5)
    assert distance.max() == pytest.approx(129.6755e-3, abs=1e-4)


def test_cylinders_that_stop_matter_to_networks_that_ask_for_any_stroke(result):
    own = result.answers["4"]
    assert own.stopped.any()
    free = ~own.stopped & np.isfinite(own.unstopped)
    np.testing.assert_allclose(own.unstopped[free], own.distance[free], atol=1e-12)


def test_a_seed_gives_the_same_network_whatever_the_others_are(result):
    alone = study.run(dataclasses.replace(study.CONFIGS["smoke"], seeds=(1,), generations=1, fresh=5))
    for method in ("1, exact inverse", "2", "3", "4"):
        np.testing.assert_array_equal(
            alone.answers[method].errors[0], result.answers[method].errors[1], strict=True
        )


def test_the_order_is_judged_by_pairs_of_seeds(result):
    fine = with_errors(with_errors(result, "1", 1e-3), "3", 1e-2)
    assert outcomes(fine)["crane-order"] == Outcome.REPRODUCED
    assert outcomes(fine)["crane-modular-beats-direct"] == Outcome.REPRODUCED
    worse = with_errors(result, "3", 1e3)
    assert outcomes(worse)["crane-order"] == Outcome.CONTRADICTED
    assert outcomes(worse)["crane-modular-beats-direct"] == Outcome.CONTRADICTED
    assert outcomes(worse)["crane-modular-max-is-reasonable"] == Outcome.CONTRADICTED


def test_compensation_that_harms_is_seen(result):
    worse = with_errors(result, "1", 1e3)
    assert outcomes(worse)["crane-correction-helps-nearly-everywhere"] == Outcome.CONTRADICTED
    assert len(study.harm_table(worse, count=125)) == 125
    assert outcomes(worse)["crane-correction-mean"] == Outcome.NOT_REPRODUCED


def test_leaving_out_the_worst_points_lowers_the_largest_error(result):
    table = study.without_table(result)
    for method in ("2", "3"):
        whole = table[f"{method}, all points"]["largest"].split()[0]
        kept = table[f"{method}, without the two worst of each seed"]["largest"].split()[0]
        assert float(kept) < float(whole)
    point = study.worst_points(result, "2", 1)[0]
    here = (result.targets == point).all(1)
    by_point = np.median(result.answers["2"].distance.reshape(2, 25, 5).max(2), axis=0)
    assert by_point[here[::5]] == by_point.max()


def test_ten_seeds_are_stored_and_method_1_holds_with_an_exact_inverse():
    stored = load_stored("crane.positioning").run
    assert stored.config.seeds == tuple(range(10))
    for own in stored.result.answers.values():
        assert len(own.errors) == 10
    means = 1e3 * stored.result.answers["1, exact inverse"].mean[:, 2]
    assert np.median(means) <= 2.5
