"""Verdicts on the times of paper C, on made-up times."""

import pytest

from dexterity_study.claims.judge import Judge
from dexterity_study.claims.outcome import Outcome
from dexterity_study.engine.evidence import Evidence
from dexterity_study.engine.table import Table
from dexterity_study.workspace.timing import experiment as study
from dexterity_study.workspace.timing import show, verdicts

SECONDS = {
    study.NUMERICAL: 0.7583,
    study.NUMERICAL_JACOBIAN: 0.6146,
    study.ANALYTIC: 0.0598,
    study.ANALYTIC_JACOBIAN: 0.0626,
    study.ANGLES: 2e-3,
    study.CLOSED: 1e-3,
    study.REACH: 1e-8,
    study.PAPERS: 2e-4,
}


@pytest.fixture(scope="module")
def measured() -> Evidence:
    return Evidence.smoke("workspace.timing")


def made_up(measured: Evidence, **changes: float) -> Evidence:
    """Return the paper's own times, with exact ways in torch slower than its network, grids of power six."""
    seconds = SECONDS | {getattr(study, name): value for name, value in changes.items()}
    tables = {name: measured[name] for name in measured}
    for name, medians in (
        ("ladder", [seconds.get(way, 1e-5) for way in tables["ladder"].rows["way"]]),
        ("grids", (1e-7 * tables["grids"].rows["side"] ** 6).tolist()),
    ):
        rows = tables[name].rows.assign(median=medians)
        rows = rows.assign(lower=0.99 * rows["median"], upper=1.01 * rows["median"])
        tables[name] = Table(rows, tables[name].keys)
    return Evidence("workspace.timing", tables)


def outcomes(evidence: Evidence) -> dict[str, Outcome]:
    return {one.claim: one.outcome for one in verdicts.verdicts(evidence)}


def test_times_of_the_authors_machine_are_not_judged(measured):
    found = outcomes(measured)
    assert {found[claim] for claim in found if claim.startswith("time-")} == {Outcome.OUT_OF_SCOPE}
    assert len([claim for claim in found if claim.startswith("time-")]) == 23


@pytest.mark.parametrize(
    ("changes", "outcome"),
    [
        ({}, Outcome.REPRODUCED),
        ({"CLOSED": 1e-6}, Outcome.IN_SHAPE),
        ({"CLOSED": 2.01e-4}, Outcome.IN_SHAPE),
        ({"PAPERS": 1.0}, Outcome.CONTRADICTED),
    ],
    ids=["faster than all", "exact is faster in the same language", "indistinguishable", "slower than all"],
)
def test_faster_means_faster_than_every_exact_way(measured, changes, outcome):
    found = outcomes(made_up(measured, **changes))
    assert found["faster-than-inverse-kinematics"] is outcome
    assert found["analytic-faster-than-numerical"] is Outcome.REPRODUCED


def test_the_exponent_is_that_of_the_grids(measured):
    evidence = made_up(measured)
    assert verdicts.exponent(evidence["grids"]) == pytest.approx(6)
    assert outcomes(evidence)["complexity"] is Outcome.NOT_REPRODUCED
    assert "7.11 days" in show.grids(evidence).html
    assert "10 µs" in show.grids(evidence).html


def test_printed_times_are_in_seconds(measured):
    on = Judge("liao2018")
    for name in (study.NUMERICAL, study.ANALYTIC, study.PAPERS):
        claim = next(claim for claim, (_, way) in verdicts.PRINTED.items() if way == name)
        assert verdicts.printed_seconds(on, claim) == pytest.approx(SECONDS[name])


def test_every_way_gives_the_same_jacobian(measured):
    ways = measured["ways"].where().iloc[0]
    assert ways["solved"] == 1
    assert max(ways[["toolbox", "torch", "c"]]) < 1e-10
    assert ways["parameters"] == pytest.approx(6.5e6, rel=0.1)
