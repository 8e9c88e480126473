"""The control loop of paper C is judged by the gain that a Jacobian needs, whatever gains were run."""

import math

import numpy as np
import pytest

from dexterity_study.claims.outcome import Outcome
from dexterity_study.engine.evidence import Evidence
from dexterity_study.engine.table import Table
from dexterity_study.workspace.control import show, verdicts
from dexterity_study.workspace.control.experiment import EXACT, GAINS, gains

GRID = np.array([1.0, 5.0, 20.0, 100.0])


@pytest.mark.parametrize(
    ("error", "expected"), [(0.0153, 15.3), (0.0003, 0.3), (0.08, 80.0), (0.2, math.inf)]
)
def test_an_error_in_inverse_proportion_needs_the_gain_of_its_product(error, expected):
    assert verdicts.smallest_gain(GRID, error / GRID, 1e-3) == pytest.approx(expected)


def test_a_run_that_ended_is_within_no_limit():
    assert verdicts.smallest_gain(GRID, np.array([math.inf, 0.5e-3, 0.2e-3, 0.1e-3]), 1e-3) == 5.0
    assert 5 < verdicts.smallest_gain(GRID, np.array([0.1, 0.01, 0.1e-3, math.inf]), 1e-3) < 20
    assert verdicts.smallest_gain(GRID, np.array([0.1, 0.01, 0.002, math.inf]), 1e-3) == math.inf


def judged(errors, ended="on time"):
    """Judge loops of the first network with errors [m] by gain; the others are as stored."""
    stored = Evidence("workspace.control")
    rows = stored["gains"].rows.copy()
    own = rows["jacobian"] == "rotation"
    rows.loc[own, "largest"] = list(errors)
    rows.loc[own, "ended"] = ended
    table = Table(rows, stored["gains"].keys)
    return {one.claim: one for one in verdicts.verdicts(Evidence("workspace.control", {"gains": table}))}


@pytest.mark.parametrize(
    ("product", "ended", "held"),
    [
        (0.015, "on time", {"a tenth": True, "a hundredth": True}),
        (0.5, "on time", {"a tenth": True, "a hundredth": False}),
        (5.0, "on time", {"a tenth": False, "a hundredth": False}),
    ],
)
def test_the_estimate_is_judged_by_whether_some_gain_holds_it(product, ended, held):
    found = judged(product / GRID, ended)["rate-control-through-the-pose"]
    for name, holds in held.items():
        assert f"{name} of the radius, shorter training: {'yes' if holds else 'no'}" in found.ours
    reproduced = found.outcome is Outcome.REPRODUCED
    assert reproduced == (": no" not in found.ours)


def test_a_weak_network_of_the_maps_holds_no_limit():
    stored = Evidence("workspace.puma")
    rows = stored["learned"].rows.copy()
    own = rows["network"].eq("rotation") & rows["case"].eq("feedback")
    rows.loc[own, "largest"] = 5.0
    puma = Evidence("workspace.puma", {"learned": Table(rows, stored["learned"].keys)})
    needed = verdicts.needed_gains(Evidence("workspace.control"), puma)
    assert needed.loc[verdicts.LONGER["rotation"], "a hundredth"] == pytest.approx(5000)
    assert needed.loc[verdicts.LONGER["rotation"], "largest gain"] == needed.loc["rotation", "largest gain"]


def test_the_verdict_does_not_depend_on_the_gain_of_the_ledger():
    found = judged(0.015 / GRID)
    assert found["jacobian-is-useful"].readings == found["rate-control-through-the-pose"].readings == ""


def test_stored_products_hardly_depend_on_the_gain():
    stored, puma = Evidence("workspace.control"), Evidence("workspace.puma")
    product = verdicts.products(stored)
    assert list(product.columns) == list(GAINS)
    done = product.where(np.isfinite(product))
    assert (done.max(axis=1) / done.min(axis=1)).max() < 1.5
    needed = verdicts.needed_gains(stored, puma)
    assert needed.loc[EXACT, "a hundredth"] < needed.loc["plane", "a hundredth"]
    assert needed.loc["plane", "a tenth"] < needed.loc["rotation", "a tenth"]
    assert "rotation matrix" in show.gains(stored, puma).html


def test_a_short_run_has_a_row_for_each_jacobian_and_gain():
    rows = gains(0, **gains.smoke).where()
    assert len(rows) == 3 * len(gains.smoke["at"])
    assert (rows.loc[rows["jacobian"] == EXACT, "jacobian_error"] == 0).all()
