"""What beats the thesis's methods: rivals that are what they say, remedies that change one thing, rules."""

import dataclasses
import itertools

import numpy as np
import pytest
import torch
from torch.testing import assert_close

from dexterity import crane
from dexterity.crane import positioning
from dexterity.report.claims import Outcome
from dexterity.report.runs import run_study
from dexterity.studies.crane import beyond as study
from dexterity.timing import Timing

DATA = crane.training_set()


@pytest.fixture(scope="module")
def result():
    return run_study("crane.beyond", study.CONFIGS["smoke"]).result


def outcome(result, claim):
    (found,) = (verdict for verdict in study.verdicts(result) if verdict.claim == claim)
    return found.outcome


# ---- what is compared ------------------------------------------------------------------------------


def test_errors_by_correction_are_those_of_compensation():
    task, sag = positioning.thesis_task(), positioning.linear_sag()
    misses = study.approach(task, sag, 3)
    for corrections in (1, 2, 3):
        placement = positioning.compensate(task, sag, corrections=corrections)
        assert_close(
            misses[corrections], positioning.errors(task, placement, sag).distance, rtol=0, atol=1e-12
        )


def test_fresh_points_are_reached_with_their_load_and_come_again():
    task = study.fresh_task(300)
    assert len(task) == 300
    assert (task.targets[:, 0] >= 0).all()
    assert task.payload.min() >= 50
    assert task.payload.max() <= 500
    placement = positioning.gauss_newton(task, positioning.sagging_tip(task, positioning.linear_sag()))
    assert placement.converged.all()
    assert crane.within_limits(placement.strokes).all()
    assert torch.equal(task.targets, study.fresh_task(300).targets)
    assert not torch.equal(task.targets, study.fresh_task(300, seed=1).targets)
    # All over the area: each quarter of the plane ahead of the pillar has some.
    ahead, up = task.targets[:, 0] > 3, task.targets[:, 1] > 1
    for far, high in itertools.product((True, False), repeat=2):
        assert ((ahead == far) & (up == high)).sum() > 20


def test_held_out_poses_are_not_learned_from():
    held = [set(map(tuple, part.strokes.tolist())) for _, part in study._fifths(DATA)]
    assert len(set.union(*held)) == sum(map(len, held)) == len(DATA) // 10
    for rest, part in study._fifths(DATA):
        assert not set(map(tuple, rest.strokes.tolist())) & set(map(tuple, part.strokes.tolist()))
        assert len(rest) + len(part) == len(DATA)


def test_the_data_of_variants_is_the_training_data_where_nothing_varies():
    model = crane.patu655()
    own = study._data(study._poses((9, 9, 5), model), range(50, 501, 50), model)
    assert_close(own.rows, DATA.rows, rtol=0, atol=1e-14)


def test_farthest_points_are_spread_more_evenly_than_the_first_ones():
    points = torch.rand(500, 2, generator=torch.Generator().manual_seed(0))
    chosen = study._farthest(points, 40)
    assert len(set(chosen.tolist())) == 40
    nearest = [(torch.cdist(some, some) + 9 * torch.eye(40)).min() for some in (points[chosen], points[:40])]
    assert nearest[0] > 3 * nearest[1]


# ---- what comes out --------------------------------------------------------------------------------


def test_the_loops_bring_it_nearer_each_time(result):
    for loop in (result.loop, result.corotational_loop):
        assert (loop[1:] < loop[:-1] / 3).all()


def test_gauss_newton_on_the_structure_is_exact_everywhere(result):
    """Where the jib is folded the loop does not settle; this does."""
    assert result.methods[study.STRUCTURE_NEWTON].fresh[0, -1] <= 1e-6


def test_a_sag_learned_in_angles_beats_the_thesis_data_read_as_a_table(result):
    assert result.methods[study.REGRESSION].fresh[0, 0] < result.methods[study.TABLE].fresh[0, 0] / 5


def test_every_learned_method_is_judged_on_both_structures(result):
    for judged in result.methods.values():
        assert np.isfinite(judged.corotational).all()
    linear, turned = (
        result.methods[name].corotational[0, 1] for name in (study.STRUCTURE, study.COROTATIONAL)
    )
    assert turned < linear / 10


def test_plain_gauss_newton_fails_where_damping_does_not(result):
    for by_start in result.inverted.values():
        for found in by_start.values():
            assert found.damped <= found.plain
        assert by_start["anywhere"].plain > 0.1
    assert result.inverted["structure"]["rigid solution, rounded"].plain == 0


def test_half_the_size_amplifies_alike_and_sags_a_quarter(result):
    whole, half = result.amplification.values()
    assert half == pytest.approx(whole, rel=1e-9)
    errors = [rows[:, 1] for rows in result.tables.values()]
    np.testing.assert_allclose(errors[0], 4 * errors[1], rtol=1e-9)


def test_nothing_bad_passes_without_a_word():
    said = study.refusals()
    names = {"point": "points", "load": "payload", "lift": "lift", "jib": "jib", "extension": "s3"}
    for what, answer in said.items():
        assert "no objection" not in answer
        if answer.startswith("ValueError"):
            expected = next((name for word, name in names.items() if word in what), "strokes")
            assert expected in answer
        elif "stopped" in answer:
            assert answer.endswith("True")
        else:
            assert "False" in answer


# ---- rules -----------------------------------------------------------------------------------------


def test_a_remedy_works_in_most_seeds_or_not():
    assert study._worked(np.array([True, True, True, False])) is Outcome.REPRODUCED
    assert study._worked(np.array([True, True, False, False])) is Outcome.NOT_REPRODUCED
    assert study._worked(np.array([True, False, False, False])) is Outcome.CONTRADICTED
    assert study._all_of([Outcome.REPRODUCED, Outcome.CONTRADICTED]) is Outcome.IN_SHAPE
    assert study._all_of([Outcome.CONTRADICTED] * 2) is Outcome.CONTRADICTED
    assert study._all_of([Outcome.NOT_REPRODUCED, Outcome.CONTRADICTED]) is Outcome.NOT_REPRODUCED


def test_a_smaller_crane_helps_by_its_size_or_more():
    assert study._by_share(0.5, 0.25) is Outcome.REPRODUCED
    assert study._by_share(1.0, 0.5) is Outcome.IN_SHAPE
    assert study._by_share(2.2, 1.1) is Outcome.NOT_REPRODUCED


def test_entries_grow_by_the_power_that_they_are_made_with():
    entries = np.array([1e3, 1e4, 1e5])
    rows = np.stack([entries, 5 * entries**-0.5], axis=1)
    assert study._power(rows) == pytest.approx(2)
    assert study._needed(rows, 5e-3) == pytest.approx(1e6)


def test_verdicts_follow_the_numbers(result):
    claim = "crane-analytical-impossible"
    assert outcome(result, claim) is Outcome.CONTRADICTED
    assert outcome(dataclasses.replace(result, loop=1e2 * result.loop), claim) is Outcome.REPRODUCED
    assert outcome(result, "crane-iterative-is-expensive") is Outcome.UNDERSPECIFIED
    assert outcome(result, "crane-simulation-suffices") is Outcome.UNDERSPECIFIED


@pytest.mark.parametrize(
    ("at_once", "alone", "expected"),
    [(1e-4, 1e-3, "contradicted"), (1e-4, 1e-1, "not reproduced"), (1e-1, 1e-1, "reproduced")],
)
def test_real_time_is_told_by_both_ways_to_ask(result, at_once, alone, expected):
    names = {"thesis's network": 0.01, "structure": 1, study.STRUCTURE: 6, study.COROTATIONAL: 600}
    times = {
        kind: tuple(
            Timing(name, 1, *(share * factor * unit / 6 for share in (0.9, 1.0, 1.1)))
            for name, factor in names.items()
        )
        for kind, unit in (
            (study.SAG_SINGLE, alone), (study.POINT_SINGLE, alone),
            (study.SAG_BATCH, at_once), (study.POINT_BATCH, at_once),
        )
    }  # fmt: skip
    timed = dataclasses.replace(result, times=times, data_seconds=1.0)
    assert outcome(timed, "crane-iterative-is-expensive") == expected
    assert outcome(timed, "crane-networks-are-cheaper") is Outcome.REPRODUCED
    assert outcome(timed, "crane-simulation-suffices") is Outcome.IN_SHAPE
    assert len(study.acceptance(timed)) == len(study.acceptance(result)) + 1
    assert set(study.speed_table(timed, "point")) == set(names)


def test_tables_have_a_row_for_each_method(result):
    assert set(study.method_table(result)) == set(result.methods) - {study.COROTATIONAL}
    assert set(study.corotational_table(result)) == set(result.methods)
    assert len(study.loop_table(result)) == len(result.loop)
    assert study.speed_table(result, "sag") == study.speed_table(result, "point") == study.trade(result) == {}
    for rows in (study.remedy_table(result), study.size_table(result), study.table_table(result)):
        assert len({tuple(row) for row in rows.values()}) == 1
