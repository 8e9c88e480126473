"""Verdicts on times: what the thresholds in the study's docstring say, on made-up times."""

from dataclasses import replace

import numpy as np
import pytest

from dexterity.report.claims import Outcome, load_paper
from dexterity.studies.uvms import timing
from dexterity.timing import Timing

KINDS = ("exact", "feed-forward", "radial-basis")
SIZES = {"w": {"feed-forward": (8, 7), "radial-basis": (149, 7)}}
SIZES["KCI"] = {"feed-forward": (25, 11), "radial-basis": (142, 11)}


def timed(*seconds: float) -> tuple[Timing, ...]:
    return tuple(Timing(kind, 1000, 0.99 * s, s, 1.01 * s) for kind, s in zip(KINDS, seconds, strict=True))


def made_up(in_kind: tuple[Timing, ...], rung: tuple[Timing, ...]) -> timing.Result:
    values = tuple(Timing(f"{i}", 1, 1e-5, 1e-5, 1e-5) for i in range(5))
    return timing.Result(
        SIZES,
        in_kind={"w": in_kind, "KCI": in_kind},
        ladder={"w": {"C": rung}, "KCI": {"C": rung}},
        instructions={"w": {}, "KCI": {}},
        singular_values=values,
        same_values=values,
        errors={"w": 0.0, "KCI": 0.0},
    )


def outcomes(result: timing.Result) -> dict[str, Outcome]:
    return {verdict.claim: verdict.outcome for verdict in timing.verdicts(result)}


PRINTED = timed(0.7043e-3, 0.0057e-3, 0.0152e-3)


def test_the_papers_own_times_reproduce_what_follows_from_them():
    found = outcomes(made_up(PRINTED, PRINTED))
    for claim in ("analytical-w-time", "feed-forward-time", "radial-basis-time"):
        assert found[claim] is Outcome.REPRODUCED
    for claim in ("networks-faster-than-analytical", "feed-forward-fastest", "feed-forward-hundredfold"):
        assert found[claim] is Outcome.REPRODUCED
    # By its own times the radial-basis network is faster by more than ten times, and the span is wider.
    assert found["radial-basis-tenfold"] is Outcome.NOT_REPRODUCED
    assert found["ten-to-hundredfold"] is Outcome.NOT_REPRODUCED
    assert found["second-saved-per-iteration"] is Outcome.CONTRADICTED


@pytest.mark.parametrize(
    ("rung", "faster", "fastest"),
    [
        (timed(2e-8, 1e-8, 1.5e-8), Outcome.REPRODUCED, Outcome.REPRODUCED),
        (timed(2e-8, 1e-8, 2.01e-8), Outcome.REPRODUCED, Outcome.REPRODUCED),
        (timed(2e-8, 1e-8, 3e-8), Outcome.CONTRADICTED, Outcome.REPRODUCED),
        (timed(2e-8, 3e-8, 1e-8), Outcome.CONTRADICTED, Outcome.IN_SHAPE),
    ],
    ids=["as claimed", "indistinguishable", "one slower", "other order"],
)
def test_orderings_must_hold_on_every_rung(rung, faster, fastest):
    found = outcomes(made_up(PRINTED, rung))
    assert found["networks-faster-than-analytical"] is faster
    assert found["feed-forward-fastest"] is fastest


@pytest.mark.parametrize(
    ("slowest", "outcome"),
    [(1.0, Outcome.NOT_REPRODUCED), (1.2, Outcome.IN_SHAPE), (2.0, Outcome.REPRODUCED)],
)
def test_times_vary_only_if_they_do_so_more_than_those_of_one_configuration(slowest, outcome):
    result = made_up(PRINTED, PRINTED)
    noisy = tuple(replace(t, lower=t.lower * (1.5 if t.name == "0" else 1)) for t in result.same_values)
    varying = tuple(replace(t, lower=t.lower * (slowest if t.name == "0" else 1)) for t in noisy)
    assert outcomes(replace(result, singular_values=varying, same_values=noisy))["kci-time-varies"] is outcome


def test_without_times_every_claim_still_has_a_verdict():
    result = made_up(PRINTED, PRINTED)
    untimed = replace(result, in_kind={"w": (), "KCI": ()}, ladder={"w": {"C": ()}, "KCI": {"C": ()}})
    own = {claim.id for claim in load_paper("sotiropoulos2016").claims if claim.study == "uvms.timing"}
    assert outcomes(untimed).keys() == outcomes(result).keys() == own
    assert timing.table_5(untimed) == timing.foot(untimed) == {}


def test_what_is_shown_is_what_was_timed():
    result = made_up(PRINTED, timed(2e-8, 1e-8, 4e-8))
    shown = timing.advantages(result)["w"]
    assert shown["C"]["feed-forward"].value == 2
    assert shown["C"]["radial-basis"].value == 0.5
    assert np.isclose(shown["as in the paper"]["feed-forward"].value, timing.printed_ratios()["feed-forward"])
    assert timing.planner(result)["like for like, in C"]["200 configurations"] == pytest.approx(0.002)
    assert timing.table_5(result)["w, exact"]["ours"] == pytest.approx(
        timing.table_5(result)["w, exact"]["paper"]
    )
