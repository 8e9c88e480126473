"""Measurements on simulated cranes: what must hold whatever is drawn."""

import dataclasses

import numpy as np
import pytest

from dexterity import crane
from dexterity.report.claims import Outcome, load_paper
from dexterity.report.runs import run_study
from dexterity.studies.crane import experiment as study

NAME = "crane.experiment"


@pytest.fixture(scope="module")
def result():
    return run_study(NAME, study.CONFIGS["smoke"]).result


def test_nothing_measured_is_called_reproduced(result):
    assert {verdict.outcome for verdict in study.verdicts(result)} <= {
        Outcome.IN_SHAPE,
        Outcome.NOT_REPRODUCED,
        Outcome.OUT_OF_SCOPE,
    }


def test_cranes_without_errors_are_not_what_was_measured(result):
    exact = {way: np.zeros((3, 9, 3, 2)) for way in study.WAYS}
    judged = study.verdicts(dataclasses.replace(result, errors=exact))
    assert Outcome.IN_SHAPE not in {verdict.outcome for verdict in judged}


def test_the_points_are_those_of_the_captions_about_the_middle_of_the_text():
    assert np.mean(study.POINTS, axis=0) == pytest.approx([3.0, 0.95])
    assert {(3.8, 0.15), (3.8, 0.95)} <= set(study.POINTS)


def test_just_two_points_have_the_jib_beyond_the_vertical(result):
    assert tuple(np.flatnonzero(np.degrees(result.jib_angle) < -90)) == study.BEYOND_THE_VERTICAL


def test_the_cylinder_pushes_where_the_load_is_behind_the_jib_joint(result):
    exact = crane.inverse(study.POINTS)
    links = crane.patu655().linkage
    lift = crane.posture(exact.strokes).lift
    elbow = links.lift_joint[0] + crane.kinematics.turned(lift, links.jib_joint)[:, 0].numpy()
    behind = np.array(study.POINTS)[:, 0] < elbow
    more = result.jib_cylinder[:, -1] > result.jib_cylinder[:, 0]
    assert behind.tolist() == more.tolist()
    assert behind.tolist() == (result.jib_cylinder > 0).all(axis=1).tolist()


def test_assumed_sizes_are_those_of_the_ledger():
    chosen = {entry.id: entry.chosen for entry in load_paper("rouvinen1999").assumptions}
    assert "1 mm" in chosen["crane-existing-misalignment"]
    assert study.EXISTING.misalignment == 0.001
    assert "1 mm" in chosen["crane-existing-play"]
    assert study.EXISTING.play == 0.001
    assert "15 %" in chosen["crane-existing-stiffness"]
    assert study.EXISTING.stiffness == 0.15
    assert "millimetre" in chosen["crane-existing-sensors"]
    assert (study.EXISTING.stroke_step, study.EXISTING.reading_step) == (0.001, 0.0005)


def test_a_summary_by_hand():
    errors = np.zeros((1, 2, 2, 2))
    errors[0, 0, 0] = (3, -4)
    errors[0, 1, 1] = (-6, 8)
    np.testing.assert_array_equal(
        study.summary(errors)[0],
        [[3, 6, 6], [4, 8, 8], [5, 10, 10], [1.5, 3, 2.25], [2, 4, 3], [2.5, 5, 3.75]],
    )


def test_errors_from_the_point_reached_are_differences_of_readings(result):
    both = [study.from_reference(result.errors, study.WAYS[0], name) for name in study.REFERENCES]
    moved = both[0] - both[1]
    np.testing.assert_allclose(moved, np.broadcast_to(moved[:, :, :1], moved.shape), rtol=0, atol=1e-15)
    with pytest.raises(ValueError, match="reference is 'wall'"):
        study.from_reference(result.errors, study.WAYS[0], "wall")


def test_readings_are_rounded(result):
    for errors in result.errors.values():
        readings = (np.array(study.POINTS)[None, :, None] - errors) / study.EXISTING.reading_step
        np.testing.assert_allclose(readings, readings.round(), rtol=0, atol=1e-3)


def test_tables_hold_every_way_difference_and_point(result):
    assert len(study.table(result, "target")) == 6
    assert study.way_table(result).keys() == set(study.WAYS)
    assert study.share_table(result, "reached").keys() == study.DIFFERENCES.keys()
    assert len(study.point_table(result)) == len(study.POINTS)
    assert len(study.network_table(result)) == len(result.payloads)
    assert 0 <= study.typical(result) < result.cranes
    places = study.bar_places(3)
    assert places.shape == (9, 3)
    np.testing.assert_allclose(places.mean(axis=1), np.arange(1, 10))
