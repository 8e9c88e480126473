"""The training data's rule, and the test points."""

import torch
from torch.testing import assert_close

from dexterity import crane
from dexterity.crane.data import COLUMNS

TRAINING = crane.training_set()


def test_there_are_as_many_rows_as_the_thesis_has():
    assert len(TRAINING) == 3670
    assert TRAINING.rows.shape == (3670, len(COLUMNS))
    assert TRAINING.columns == COLUMNS


def test_its_values_are_those_of_the_grid():
    for column, count, step in ((0, 9, 0.066875), (1, 9, 0.0975), (2, 5, 0.4), (3, 10, 50.0)):
        values = TRAINING.rows[:, column].unique()
        assert len(values) == count
        assert_close(values.diff(), torch.full((count - 1,), step).double())
    assert TRAINING.payload.min() == 50
    assert len(TRAINING.rows[:, :4].unique(dim=0)) == 3670


def test_its_rows_are_the_models():
    rigid = crane.tip_position(TRAINING.strokes)
    assert (rigid[:, 0] >= 0).all()
    assert_close(TRAINING.tip - TRAINING.deflection, rigid, rtol=0, atol=1e-14)
    some = slice(None, None, 97)
    sag = crane.deflection(TRAINING.strokes[some], TRAINING.payload[some])
    assert_close(TRAINING.deflection[some], sag, rtol=0, atol=1e-14)


def test_poses_behind_the_pillar_are_what_is_left_out():
    tops = zip(crane.patu655().upper, (9, 9, 5), strict=True)
    grid = torch.cartesian_prod(*(torch.linspace(0, top, n, dtype=torch.float64) for top, n in tops))
    assert (crane.tip_position(grid)[:, 0] < 0).sum() == 38


def test_the_test_points_hold_those_that_the_text_names():
    assert len(set(crane.TEST_POINTS)) == 25
    assert {(1, 6), (1, 7), (2, 7), (2, 2), (1, -2), (2, -4)} <= set(crane.TEST_POINTS)
    reach = crane.inverse(crane.TEST_POINTS)
    assert reach.reached.all()
    beyond = [
        point for point, within in zip(crane.TEST_POINTS, reach.within_limits, strict=True) if not within
    ]
    assert beyond == [(2.0, -4.0)]
    assert not set(crane.TEST_PAYLOADS) & set(TRAINING.payload.tolist())
