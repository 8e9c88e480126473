"""A table of corrections: exact at its nodes, and better with more of them."""

import itertools

import pytest
import torch
from torch.testing import assert_close

from dexterity import crane
from dexterity.crane.positioning import TableSag

DATA = crane.training_set()


def test_the_training_grid_as_a_table_holds_the_training_data():
    table = TableSag.of((9, 9, 5))
    assert_close(table(DATA.strokes, DATA.payload), DATA.deflection, rtol=0, atol=1e-12)
    assert table.entries == 4 * 405


def test_between_two_nodes_it_is_their_mean():
    table = TableSag.of((2, 2, 2))
    corners = torch.cartesian_prod(*torch.tensor([[0.0, 0.535], [0.0, 0.78], [0.0, 1.6]]).double())
    payload = torch.full((8,), 200.0, dtype=torch.float64)
    assert_close(table(corners.mean(0)[None], payload[:1])[0], crane.deflection(corners, payload).mean(0))


def test_the_error_falls_with_the_square_of_the_step():
    strokes = torch.rand(2000, 3, generator=torch.Generator().manual_seed(0)).double()
    strokes = strokes * strokes.new_tensor(crane.patu655().upper)
    payload = torch.full((2000,), 500.0, dtype=torch.float64)
    exact = crane.deflection(strokes, payload)
    misses = [(TableSag.of((n, n, n))(strokes, payload) - exact).norm(dim=-1).mean() for n in (9, 17, 33)]
    for coarse, fine in itertools.pairwise(misses):
        assert 3 < coarse / fine < 5


def test_beyond_the_strokes_it_goes_on():
    strokes = torch.tensor([[0.2, 0.3, 1.63]], dtype=torch.float64)
    payload = torch.tensor([300.0], dtype=torch.float64)
    found = TableSag.of((9, 9, 9))(strokes, payload)
    assert_close(found, crane.deflection(strokes, payload), rtol=0, atol=3e-3)


@pytest.mark.parametrize("nodes", [(9, 9), (9, 9, 1), (9, 9, 5, 10)])
def test_nodes_that_make_no_table_are_refused(nodes):
    with pytest.raises(ValueError, match="nodes"):
        TableSag.of(nodes)
