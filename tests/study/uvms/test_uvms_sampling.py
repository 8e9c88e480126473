"""The search area of paper A, and what the rows of the sampling experiments satisfy."""

import dataclasses

import numpy as np
import pytest
import torch
from torch.testing import assert_close

from dexterity import robots
from dexterity_study.uvms.sampling import experiment, show

UVMS = robots.uvms()
READINGS = ["chosen", *experiment.search_area.readings]


def test_the_wrist_moves_between_the_radii_about_the_base_of_the_arm():
    space, home = show.space("chosen"), torch.zeros(12, dtype=torch.float64)
    q = home + torch.eye(12)[8] * torch.linspace(0, torch.pi, 50, dtype=torch.float64)[:, None]
    q[:, :6] = experiment.draw(space, 50, seed=0)[:, :6]
    q[:, 6:8] = torch.linspace(-1, 1, 50)[:, None]
    distance = (UVMS.forward(q)[:, :3, 3] - experiment.base_positions(q)).norm(dim=-1)
    assert (distance.diff() < 0).all()
    assert_close(distance[[0, -1]], q.new_tensor([space.r_max, space.r_min]), rtol=0, atol=1e-12)


def test_bases_of_the_turned_vehicle_lie_inside_the_outline():
    space = dataclasses.replace(show.space(show.TURNED), elevation=0.0)
    bases = experiment.base_positions(experiment.draw(space, 500, seed=0))
    base, outline = (
        bases.numpy() - np.array(space.task_point),
        show.outline(space) - np.array(space.task_point),
    )
    assert_close(base[:, 2], np.zeros(500), rtol=0, atol=1e-12)
    turn, border = (np.arctan2(xyz[:, 0], -xyz[:, 1]) for xyz in (base, outline))
    assert border.min() <= turn.min() < turn.max() <= border.max()
    radius, radii = (np.linalg.norm(xyz, axis=1) for xyz in (base, outline))
    assert radii.min() <= radius.min() < radius.max() <= radii.max()
    assert_close(outline[0], outline[-1])


@pytest.mark.parametrize("reading", READINGS)
def test_every_reading_has_the_joints_of_equation_11_or_fewer(reading):
    held = {"base-orientation=upright": {3, 4, 5}, "sector-of-the-base=planar": {2}}.get(reading, set())
    assert set(experiment.varying(show.space(reading))) == set(range(11)) - held


def test_w_varies_more_in_a_wider_range():
    cases = (("w", experiment.AS_PRINTED, (5.0, 15.0), (1,)),)
    rows = experiment.extensions(cases=cases, rows=50, drawn=2000, test=50, fresh=100, epochs=1).rows
    narrow, wide = (rows[rows["half_width"] == deg].iloc[0] for deg in (5.0, 15.0))
    assert wide["highest"] - wide["lowest"] > narrow["highest"] - narrow["lowest"]
