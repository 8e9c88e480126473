"""The structure of the crane: its fits, its training data, and what its rows must satisfy."""

import math
from dataclasses import replace

import numpy as np
import pytest

from dexterity import crane
from dexterity_study.claims.ledger import load_paper
from dexterity_study.crane.structure import experiment, show, verdicts
from dexterity_study.crane.structure.experiment import STATISTICS, TARGETS, UNTUNED
from dexterity_study.engine.evidence import Evidence

WHOLE = crane.patu655()
STROKES = crane.inverse(crane.TEST_POINTS).strokes


@pytest.fixture(scope="module")
def fits():
    return experiment.fits().rows.set_index("to")


@pytest.fixture(scope="module")
def errors():
    return experiment.uncompensated().rows


# ---- errors and their statistics -------------------------------------------------------------------


def test_statistics_are_means_and_largest_values_in_millimetres():
    found = experiment.statistics([[[3e-3, -4e-3], [0.0, 1e-3]]])
    assert tuple(found.values()) == pytest.approx((1.5, 2.5, 3.0, 3.0, 4.0, 5.0))


def test_the_targets_of_the_fit_are_the_printed_ones():
    assert {name: value for name, value in verdicts.printed().items() if name in TARGETS} == TARGETS


def test_errors_are_what_the_rigid_crane_misses_its_targets_by(errors):
    tip = crane.flexible_tip(STROKES[:, None], crane.TEST_PAYLOADS).numpy()
    missed = np.array(crane.TEST_POINTS)[:, None] - tip
    found = errors[["error_x", "error_y"]].to_numpy().reshape(missed.shape)
    np.testing.assert_allclose(found, missed, rtol=0, atol=1e-9)


def test_an_end_stop_changes_only_the_point_that_is_beyond_the_end(errors):
    stopped = experiment.uncompensated(reading="crane-beyond-the-end=end-stop").rows
    changed = (stopped["error_x"] - errors["error_x"]).abs() > 1e-9
    assert {tuple(point) for point in errors.loc[changed, ["x", "y"]].to_numpy()} == {(2.0, -4.0)}


# ---- the fit ---------------------------------------------------------------------------------------


def test_the_refit_is_that_of_the_crane_of_the_package(fits):
    refit = fits.loc["fitted"]
    assert refit["first"] * UNTUNED[0] == pytest.approx(WHOLE.structure.bending_factor, rel=1e-3)
    assert refit["second"] * UNTUNED[1] == pytest.approx(WHOLE.structure.ground_stiffness, rel=1e-3)


def test_every_fit_that_was_found_meets_both_targets(fits):
    found = fits[fits["found"] == True]  # noqa: E712
    assert set(fits.index) - set(found.index) == {"untuned", "own weight left out"}
    for name, target in TARGETS.items():
        np.testing.assert_allclose(found[name].to_numpy(dtype=float), target, rtol=1e-5)


@pytest.mark.parametrize("name", ["walls a third thicker", "lift arm 15 % lower"])
def test_a_fit_with_other_sections_is_that_of_such_a_crane(fits, name):
    fit = fits.loc[name]
    other = experiment.other_structures(WHOLE.structure)[name]
    numbers = {"bending_factor": fit["first"] * UNTUNED[0], "ground_stiffness": fit["second"] * UNTUNED[1]}
    structure = replace(other, **numbers)
    sag = crane.deflection(STROKES[:, None], crane.TEST_PAYLOADS, replace(WHOLE, structure=structure))
    expected = list(experiment.statistics(sag.numpy()).values())
    np.testing.assert_allclose(expected, fit[list(STATISTICS)].to_numpy(dtype=float), rtol=1e-6)


def test_no_sections_bring_the_largest_x_near(fits):
    found = fits[(fits["found"] == True) & (fits["changed"] == "sections, masses, pads, strokes")]  # noqa: E712
    assert (found["max x"] / verdicts.printed()["max x"]).min() > 1.25


def test_one_point_does(errors):
    swaps = Evidence("crane.structure", {"swaps": experiment.swaps(candidates=3)})
    left, _, nearest = verdicts.nearest_swap(swaps)
    assert left == "(4, 6)"
    assert max(abs(nearest[name] / value - 1) for name, value in verdicts.printed().items()) < 0.05
    largest = errors.assign(size=errors["error_x"].abs()).groupby(["x", "y"])["size"].max().sort_values()
    assert largest.index[-1] == (4.0, 6.0)
    assert 1e3 * largest.iloc[-2] < verdicts.printed()["max x"]


# ---- beams -----------------------------------------------------------------------------------------


def test_beams_are_those_of_the_textbook_whatever_the_number_of_elements():
    for elements in (1, 4):
        assert experiment.beams(elements=elements).rows[["force", "own_weight"]].abs().max().max() < 1e-9


# ---- the working area ------------------------------------------------------------------------------


def test_the_training_data_has_the_printed_number_of_vectors():
    paper, row = load_paper("rouvinen1999"), experiment.coverage(spacing=0.8).rows.iloc[0]
    assert row["vectors"] == paper.printed("crane-training-vectors")
    assert row["grid"] == paper.printed("crane-grid-vectors")
    shorter = experiment.coverage(reading="crane-jib-stroke=0.75", spacing=0.8).rows.iloc[0]
    assert shorter["vectors"] > row["vectors"]


def test_ways_to_reach_a_point_hold_the_one_with_the_least_extension():
    ways = experiment.ways(extensions=9).rows.set_index(["x", "y"])
    sag = crane.deflection(STROKES, WHOLE.rating).norm(dim=-1).tolist()
    assert (ways["least"] <= ways["largest"]).all()
    for point, s3, own in zip(crane.TEST_POINTS, STROKES[:, 2].tolist(), sag, strict=True):
        if s3 == 0:
            assert ways.loc[point, "least"] <= own + 1e-12 <= ways.loc[point, "largest"] + 2e-12


def test_the_largest_error_in_x_agrees_after_an_exchange_alone():
    (ax,) = show.agreement(Evidence("crane.structure")).axes
    row = show.TESTED.index("max x")
    spans = {bars.get_label(): bars.get_segments()[row][:, 0] for bars in ax.collections}
    assert spans["other sections"].min() > 1.25
    assert spans["one point exchanged"].min() < 1 < spans["one point exchanged"].max()


def test_bars_sway_from_no_payload_to_the_rating_and_back():
    rest, moving = show.swaying_bars((5.0, 2.0), frames=9)
    assert len(moving) == len(show.PART_COLORS)
    assert rest.shape == (27, 2, 3)
    tips = [ends[:, -1, 1] for ends in moving.values()]
    assert all(math.isclose(ends[0, 2], ends[-1, 2], abs_tol=1e-9) for ends in tips)
    strokes = crane.inverse([5.0, 2.0]).strokes
    for frame, payload in ((0, 0.0), (4, 500.0)):
        sag = crane.deflection(strokes, payload).numpy() * show.MAGNIFIED
        np.testing.assert_allclose(
            moving["extension"][frame, 3, 1], [5.0 + sag[0], 0.0, 2.0 + sag[1]], atol=1e-8
        )
