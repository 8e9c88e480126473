"""Verdicts on the times of paper C: what the study's docstring says, on made-up times."""

from dataclasses import replace

import numpy as np
import pytest

from dexterity.report.claims import Outcome, load_paper
from dexterity.report.runs import run_study
from dexterity.studies.workspace import timing
from dexterity.timing import Timing


@pytest.fixture(scope="module")
def untimed() -> timing.Result:
    return run_study("workspace.timing", timing.CONFIGS["smoke"]).result


def timed(name: str, seconds: float) -> Timing:
    return Timing(name, 1000, 0.99 * seconds, seconds, 1.01 * seconds)


SECONDS = {
    timing.NUMERICAL: 0.7583,
    timing.NUMERICAL_ANGLES_JACOBIAN: 0.6146,
    timing.NUMERICAL_JACOBIAN: 0.7,
    timing.ANALYTIC: 0.0598,
    timing.ANALYTIC_JACOBIAN: 0.0626,
    timing.ANGLES: 2e-3,
    timing.CLOSED: 1e-3,
    timing.REACH: 1e-8,
    timing.GENERAL: 1e-5,
    timing.PLANE: 1e-5,
    timing.PAPERS: 2e-4,
}


@pytest.fixture(scope="module")
def result(untimed) -> timing.Result:
    """The paper's own times, and exact ways in torch that are slower than its network."""
    names = {
        rung: [way.name for way in ways]
        for rung, ways in timing._Contest(timing.CONFIGS["smoke"]).rungs().items()
    }
    return replace(
        untimed,
        ladder={rung: tuple(timed(name, SECONDS[name]) for name in own) for rung, own in names.items()},
        others={claim: timed(claim, timing._seconds(claim)) for claim in untimed.rows},
        grids=tuple(timing.Scaled(side, side**6, 1e-7 * side**6) for side in (4, 6, 8)),
    )


def outcomes(result: timing.Result) -> dict[str, Outcome]:
    return {verdict.claim: verdict.outcome for verdict in timing.verdicts(result)}


def changed(result: timing.Result, name: str, seconds: float) -> timing.Result:
    ladder = {
        rung: tuple(timed(name, seconds) if own.name == name else own for own in ways)
        for rung, ways in result.ladder.items()
    }
    return replace(result, ladder=ladder)


def test_the_papers_own_times_reproduce_what_it_says(result):
    found = outcomes(result)
    times = [claim for claim in found if claim.startswith("time-")]
    assert len(times) == 23
    assert {found[claim] for claim in times} == {Outcome.REPRODUCED}
    assert found["faster-than-inverse-kinematics"] is Outcome.REPRODUCED
    assert found["analytic-faster-than-numerical"] is Outcome.REPRODUCED


@pytest.mark.parametrize(
    ("name", "seconds", "outcome"),
    [
        (timing.CLOSED, 1e-6, Outcome.CONTRADICTED),
        (timing.CLOSED, 2.01e-4, Outcome.REPRODUCED),
        (timing.PAPERS, 1.0, Outcome.NOT_REPRODUCED),
    ],
    ids=["exact is faster in the same language", "indistinguishable", "slower than the toolbox"],
)
def test_faster_means_faster_than_every_exact_way(result, name, seconds, outcome):
    assert outcomes(changed(result, name, seconds))["faster-than-inverse-kinematics"] is outcome


@pytest.mark.parametrize(
    ("factor", "outcome"),
    [
        (1.0, Outcome.REPRODUCED),
        (2.9, Outcome.IN_SHAPE),
        (0.34, Outcome.IN_SHAPE),
        (3.1, Outcome.NOT_REPRODUCED),
    ],
)
def test_a_time_is_judged_by_a_factor_of_three(result, factor, outcome):
    slower = changed(result, timing.NUMERICAL, factor * SECONDS[timing.NUMERICAL])
    assert outcomes(slower)["time-ikine"] is outcome


def test_the_exponent_is_that_of_the_grids(result):
    assert timing.exponent(result) == pytest.approx(6)
    assert outcomes(result)["complexity"] is Outcome.NOT_REPRODUCED
    table = timing.grid_table(result)
    assert table["toolbox, numerical"]["10 steps"] == "7.11 days"
    assert table["positions alone, which suffice"]["10 steps"] == "10 µs"


def test_without_times_every_claim_still_has_a_verdict(untimed, result):
    own = {claim.id for claim in load_paper("liao2018").claims if claim.study == "workspace.timing"}
    assert outcomes(untimed).keys() == outcomes(result).keys() == own
    assert timing.ladder(untimed) == timing.grid_table(untimed) == timing.other_methods(untimed) == {}
    assert timing.toolbox_table(untimed) == {}
    assert np.isnan(timing.exponent(untimed))


def test_what_is_shown_is_what_was_timed(result):
    shown = timing.toolbox_table(result)
    assert shown["inverse kinematics, numerical"]["ours"] == pytest.approx(758_300)
    assert shown["inverse kinematics, numerical"]["ours"] == pytest.approx(
        shown["inverse kinematics, numerical"]["paper"]
    )
    rows = timing.ladder(result)
    assert rows[timing.TOOLBOX, timing.ANALYTIC]["median [ns]"] == "59,800,000"
    assert len(timing.other_methods(result)) == 17


def test_every_way_gives_the_same_jacobian(untimed):
    assert untimed.solved == 1
    assert max(error for name, error in untimed.errors.items() if "differences" not in name) < 1e-10
    assert untimed.parameters[timing.PAPERS] == pytest.approx(6.5e6, rel=0.1)
