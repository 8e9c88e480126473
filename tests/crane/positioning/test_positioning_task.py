"""What is to be positioned, and how errors are measured."""

import dataclasses
import math

import pytest
import torch
from torch.testing import assert_close

from dexterity import crane
from dexterity.crane import positioning
from dexterity.crane.positioning import Placement, errors, thesis_task, uncompensated

TASK = thesis_task()


def answered(strokes: torch.Tensor) -> Placement:
    return Placement(
        strokes, torch.ones(len(strokes), dtype=torch.bool), torch.ones(len(strokes), dtype=torch.long)
    )


def test_every_point_is_wanted_with_every_payload():
    assert len(TASK) == 125
    assert_close(TASK.targets[:5], torch.tensor(crane.TEST_POINTS[:1] * 5, dtype=torch.float64))
    assert TASK.payload[:5].tolist() == list(crane.TEST_PAYLOADS)


def test_starts_are_rounded_to_the_centimetre():
    exact = crane.inverse(TASK.targets).strokes
    assert_close(TASK.starts * 100, (TASK.starts * 100).round(), rtol=0, atol=1e-12)
    assert (TASK.starts - exact).abs().max() <= 0.005
    assert (TASK.starts - exact).abs().max() > 0.004


def test_limits_hold_the_start():
    assert TASK.allows(TASK.starts).all()
    beyond = (TASK.upper > torch.tensor(crane.patu655().upper, dtype=torch.float64)).any(-1)
    assert TASK.targets[beyond].unique(dim=0).tolist() == [[2.0, -4.0]]
    assert not TASK.allows(TASK.upper + 1e-6).any()


def test_errors_without_compensation_are_the_deflection():
    placement = uncompensated(TASK)
    found = errors(TASK, placement)
    assert_close(found.each, -crane.deflection(placement.strokes, TASK.payload), rtol=0, atol=1e-9)
    assert_close(found.distance, found.each.norm(dim=-1))
    assert not found.stopped.any()


def test_a_summary_by_hand():
    found = positioning.Errors(torch.tensor([[3.0, -4.0], [-1.0, 0.0]]).double(), torch.tensor([False, True]))
    assert found.mean.tolist() == [2.0, 2.0, 3.0]
    assert found.largest.tolist() == [3.0, 4.0, 5.0]


def test_cylinders_stop_at_their_ends_or_do_not():
    task = dataclasses.replace(
        TASK, targets=TASK.targets[:2], payload=TASK.payload[:2], starts=TASK.starts[:2]
    )
    told = torch.tensor([[0.3, 0.3, -0.02], [0.3, 0.3, 0.2]], dtype=torch.float64)
    held = told.clone()
    held[0, 2] = 0.0
    stopped, moved = (errors(task, answered(told), end_stops=stops) for stops in (True, False))
    assert stopped.stopped.tolist() == moved.stopped.tolist() == [True, False]
    assert_close(stopped.each, task.targets - crane.flexible_tip(held, task.payload))
    sag = crane.deflection(held, task.payload)
    assert_close(moved.each, task.targets - crane.tip_position(told) - sag)


def test_the_true_deflection_is_whichever_is_given():
    placement = uncompensated(TASK)
    found = errors(TASK, placement, lambda strokes, payload: torch.zeros_like(strokes[:, :2]))
    assert found.distance.max() < 1e-9
    few = dataclasses.replace(
        TASK, targets=TASK.targets[:3], payload=TASK.payload[:3], starts=TASK.starts[:3]
    )
    judged = errors(few, answered(placement.strokes[:3]), positioning.corotational_sag())
    expected = crane.corotational_deflection(placement.strokes[:3], few.payload).deflection
    assert_close(judged.each, -expected, rtol=0, atol=1e-9)


@pytest.mark.parametrize(
    "points", [[[-0.09, 1.115]], [[9.0, 9.0]], [[2.0, -4.2]], [[math.nan, 1.0]], [[1.0, 2.0, 3.0]]]
)
def test_points_that_cannot_be_wanted_are_refused(points):
    with pytest.raises(ValueError, match=r"points|position"):
        thesis_task(points)


@pytest.mark.usefixtures("annotations_unchecked")
@pytest.mark.parametrize("name", ["payload", "starts"])
def test_a_task_whose_parts_do_not_fit_is_refused(name):
    with pytest.raises(ValueError, match=name):
        dataclasses.replace(TASK, **{name: getattr(TASK, name)[:3]})


def test_strokes_that_are_none_are_refused():
    with pytest.raises(ValueError, match="strokes"):
        errors(TASK, answered(TASK.starts * torch.nan))


@pytest.mark.parametrize("payload", [-1.0, 501.0, math.inf])
def test_loads_that_the_crane_may_not_lift_are_refused_by_name(payload):
    """Asked for of every method, learned ones too, which would answer to any number."""
    with pytest.raises(ValueError, match="payload"):
        thesis_task([(3.0, 2.0)], [payload])
