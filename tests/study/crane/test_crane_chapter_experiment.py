"""Measurements on simulated cranes: what must hold whatever is drawn."""

import numpy as np
import pytest

from dexterity import crane
from dexterity_study.claims.ledger import load_paper
from dexterity_study.crane.experiment import experiment, show, verdicts
from dexterity_study.engine.evidence import Evidence


@pytest.fixture(scope="module")
def evidence():
    return Evidence.smoke("crane.experiment")


def test_what_was_measured_on_a_crane_that_is_gone_is_out_of_scope(evidence):
    assert {verdict.outcome for verdict in verdicts.verdicts(evidence)} == {"out of scope"}


def test_points_and_settings_are_those_of_the_paper():
    assert np.mean(experiment.POINTS, axis=0) == pytest.approx([3.0, 0.95])
    assert {(3.8, 0.15), (3.8, 0.95)} <= set(experiment.POINTS)
    paper = load_paper("rouvinen1999")
    assert paper.printed("crane-measured-loads") == experiment.PAYLOADS
    assert pytest.approx(paper.printed("crane-measured-accuracy")) == 1e3 * experiment.READING_STEP


def test_just_points_2_and_3_have_the_jib_beyond_the_vertical(evidence):
    angles = evidence["model"].where(payload=0).set_index("point")["jib_angle"]
    assert angles.index[np.degrees(angles) < -90].tolist() == [2, 3]


def test_the_cylinder_pushes_where_the_load_is_behind_the_jib_joint(evidence):
    links = crane.patu655().linkage
    lift = crane.posture(crane.inverse(experiment.POINTS).strokes).lift
    elbow = links.lift_joint[0] + crane.kinematics.turned(lift, links.jib_joint)[:, 0].numpy()
    behind = np.array(experiment.POINTS)[:, 0] < elbow
    forces = (
        evidence["model"].where().pivot(index="point", columns="payload", values="jib_cylinder").to_numpy()
    )
    assert behind.tolist() == (forces[:, -1] > forces[:, 0]).tolist() == (forces > 0).all(axis=1).tolist()


def test_a_layout_by_hand(evidence):
    errors = np.zeros((1, 5, 9, 3, 2), dtype=np.float32)
    errors[0, 0, 0, 0] = (3, -4)
    errors[0, 1, 1, 1] = (-6, 8)
    held = {("chosen", 0): {**evidence["measurements"].arrays["chosen", 0], "errors": 1e-3 * errors}}
    table = type(evidence["measurements"])(evidence["measurements"].rows, ("crane", "point"), held)
    layout = verdicts.layout(Evidence("crane.experiment", {"measurements": table}), "target")[0]
    np.testing.assert_allclose(layout[:3], np.outer([3, 4, 5], [1, 0, 0, 2, 0, 0, 1, 2]), rtol=1e-6)
    means = np.outer([3, 4, 5], [1 / 9, 0, 0, 2 / 9, 0, 0, 1 / 27, 2 / 27])
    np.testing.assert_allclose(layout[3:], means, rtol=1e-6)


def test_errors_from_the_point_reached_are_differences_of_readings(evidence):
    errors = verdicts.errors_of(evidence)
    reached = experiment.from_reference(errors, "point reached")
    moved = errors - reached
    np.testing.assert_allclose(moved, np.broadcast_to(moved[..., :1, :], moved.shape), rtol=0, atol=1e-9)
    assert (reached[:, [1, 3, 4], :, 0] == 0).all()


def test_readings_are_rounded(evidence):
    readings = np.array(experiment.POINTS)[:, None] - verdicts.errors_of(evidence) / 1e3
    steps = readings / experiment.READING_STEP
    np.testing.assert_allclose(steps, steps.round(), rtol=0, atol=1e-3)


def test_each_difference_is_drawn_alike_with_others_and_alone(evidence):
    means = np.concatenate(evidence["measurements"].array("means"))
    names = list(experiment.DIFFERENCES)
    sizes = [
        means[:, names.index(name), 0, -1]
        for name in ("nothing", "all, half as large", "all, twice as large")
    ]
    assert (sizes[0] < 1e-6).all()
    assert (3 * sizes[1] < sizes[2]).all()


def test_tables_and_figures_hold_all_points_payloads_and_references(evidence):
    assert show.points(evidence).html.count("<tr") == 1 + len(experiment.POINTS)
    assert show.networks(evidence, evidence["measurements"]).html.count("<tr") == 1 + len(experiment.PAYLOADS)
    for draw in (show.measured, show.by_difference):
        titles = [ax.get_title() for ax in draw(evidence).axes]
        assert titles == [f"from the {reference}" for reference in experiment.REFERENCES]
