"""A crane of another size moves alike and sags less."""

import dataclasses
import math

import pytest
import torch
from torch.testing import assert_close

from dexterity import crane

CRANE = crane.patu655()
STROKES = torch.rand(50, 3, generator=torch.Generator().manual_seed(0), dtype=torch.float64)
STROKES *= torch.tensor(CRANE.upper, dtype=torch.float64)


@pytest.mark.parametrize("factor", [0.5, 1.0, 1.7])
def test_the_tip_scales(factor):
    small = crane.scaled(CRANE, factor)
    assert_close(crane.tip_position(factor * STROKES, small), factor * crane.tip_position(STROKES))
    points = crane.tip_position(STROKES)
    assert torch.equal(
        crane.inverse(factor * points, crane=small).within_limits, crane.inverse(points).within_limits
    )


@pytest.mark.parametrize("factor", [0.5, 1.7])
def test_with_loads_by_the_cube_the_sag_goes_with_the_square(factor):
    small = crane.scaled(CRANE, factor)
    for payload in (0.0, 300.0):
        sag = crane.deflection(factor * STROKES, factor**3 * payload, small)
        assert_close(sag, factor**2 * crane.deflection(STROKES, payload), rtol=1e-9, atol=0)


def test_the_same_size_is_the_same_crane_but_for_its_name():
    assert dataclasses.replace(crane.scaled(CRANE, 1.0), name=CRANE.name) == CRANE


@pytest.mark.parametrize("factor", [0.0, -1.0, math.nan, math.inf])
def test_a_factor_that_is_no_size_is_refused(factor):
    with pytest.raises(ValueError, match="factor"):
        crane.scaled(CRANE, factor)
