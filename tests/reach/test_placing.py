"""Base placement: the engineer's weld seam, other chains, bad input."""

import csv
import math

import pytest
import torch
from torch.testing import assert_close

import dexterity as dx
from dexterity import reach, spatial

UR5E, PANDA = dx.robots.ur5e(), dx.robots.panda()
DOWN = torch.diag(torch.tensor([1.0, -1.0, -1.0], dtype=torch.float64))
SEAM = reach.seam([-0.25, 0, 0], [0.25, 0, 0], 5, DOWN)
BASES = reach.planar_bases([-0.4, -0.2, 0, 0.2, 0.4], [-0.7, -0.5, -0.35], [0, math.pi / 2])
KCI = dx.Index("kinematic_conditioning", "geometric")


@pytest.fixture(scope="module")
def placed() -> reach.Placements:
    return reach.place(UR5E, SEAM, BASES, KCI)


def test_the_weld_seam_of_0_5_m(placed):
    """An engineer's own search, 12 random starts a pose: least KCI 0.140 at (0, −0.5, π/2) of 30 bases."""
    best = placed.candidate(int(placed.order[0]))
    assert_close(best.coordinates[:5], torch.tensor([0, -0.5, 0, 0, 0], dtype=torch.float64))
    assert best.score == pytest.approx(0.140, abs=5e-4)
    # The yaw is one with the first joint, whose limits do not bind.
    assert placed.ties == 2
    # In closed form, every configuration is looked at, and between the candidates there is a better base.
    assert placed.complete
    assert placed.refined.score > 1.01 * best.score
    assert placed.best is placed.refined


def test_what_is_said_of_a_base_is_so(placed):
    for placement in (placed.refined, placed.candidate(3)):
        T = placement.T_world_base @ UR5E.forward(placement.configurations)
        assert_close(T, SEAM, rtol=0, atol=1e-8)
        assert_close(placement.values, KCI(UR5E, placement.configurations))
        assert placement.score == pytest.approx(float(placement.values.min()))
        assert_close(reach.placements.coordinates_of(placement.T_world_base), placement.coordinates)


def test_the_refined_base_stays_within_the_candidates(placed):
    low, high = BASES[:, :2, 3].amin(0), BASES[:, :2, 3].amax(0)
    at = placed.refined.coordinates
    assert (at[:2] >= low).all()
    assert (at[:2] <= high).all()
    assert at[2:5].tolist() == [0, 0, 0]
    assert 0 <= at[5] <= math.pi / 2


def test_the_table_is_in_order_and_goes_to_a_file(placed, tmp_path):
    rows = placed.table()
    assert [row["base"] for row in rows[:2]] == ["refined", str(int(placed.order[0]))]
    worst = [row["worst"] for row in rows if row["poses reached"] == 5]
    assert worst == sorted(worst, reverse=True)
    placed.to_csv(tmp_path / "bases.csv")
    with (tmp_path / "bases.csv").open(encoding="utf-8") as file:
        read = list(csv.DictReader(file))
    assert len(read) == len(rows) == 31
    assert float(read[0]["worst"]) == rows[0]["worst"]
    assert len(placed.table(3)) == 4


def test_a_mean_is_a_mean_and_rotated_worlds_change_nothing(placed):
    by_mean = reach.place(UR5E, SEAM, BASES[:6], KCI, by="mean", refine=False)
    assert_close(by_mean.scores, placed.values[:6].mean(1), equal_nan=True)
    turned = spatial.exp([0.3, -0.2, 0.1, 0.4, 0.5, 0.6])
    moved = reach.place(UR5E, turned @ SEAM, turned @ BASES[:6], KCI, refine=False)
    assert_close(moved.values, placed.values[:6], rtol=1e-6, atol=1e-9, equal_nan=True)


def test_ties_and_bases_that_reach_nothing_are_told():
    rows = [[0.0, -0.5, 0.1], [0.0, -0.5, 0.1], [0.0, -3.0, 0.0], [0.0, -1.0, 0.0]]
    found = reach.place(UR5E, SEAM, rows, KCI)
    assert found.ties == 2
    assert "2 are equal" in repr(found)
    assert found.order.tolist()[:2] == [0, 1]
    assert found.reached[2] == 0
    nothing = reach.place(UR5E, SEAM, rows[2:3], KCI)
    assert nothing.ties == 0
    assert nothing.refined is None
    assert math.isnan(nothing.best.score)
    assert "0 reach all; the best reaches 0" in repr(nothing)


def test_a_redundant_arm_and_a_valve_panel():
    """reuleaux#55: base placement for an arm of seven joints."""
    valves = reach.panel([0.6, 0, 0.5], [-1, 0, 0], 0.3, 0.2, columns=2, rows=2, standoff=0.05)
    found = reach.place(PANDA, valves, reach.planar_bases([0, 0.1], [0], [-0.3, 0.3]), "w", starts=6)
    assert not found.complete
    assert found.best.score > 0
    T = found.best.T_world_base @ PANDA.forward(found.best.configurations)
    assert_close(T, valves, rtol=0, atol=1e-8)


def test_an_index_of_which_smaller_is_better():
    deviation = dx.Index("tool_deviation", "geometric")
    found = reach.place(UR5E, SEAM, BASES[:10], deviation)
    scores = found.scores[~found.scores.isnan()]
    assert found.candidate(int(found.order[0])).score == float(scores.min())
    assert found.refined.score <= scores.min()
    assert_close(found.scores, found.values.amax(1), equal_nan=True)


def test_after_ctrl_c_what_was_looked_at_is_returned(monkeypatch):
    monkeypatch.setattr(reach.placing, "_POSES_AT_ONCE", 10)

    def interrupt(done: int, total: int) -> None:
        if done >= 4:
            raise KeyboardInterrupt

    found = reach.place(UR5E, SEAM, BASES, KCI, progress=interrupt)
    assert int(found.examined.sum()) == 4
    assert found.refined is None


@pytest.mark.parametrize(
    ("change", "error", "message"),
    [
        ({"poses": SEAM[0]}, ValueError, "poses has shape"),
        ({"poses": 2 * SEAM}, ValueError, "poses"),
        ({"bases": [[0.0, 0.0]]}, ValueError, "bases"),
        ({"bases": [[0.0, math.nan, 0.0]]}, ValueError, "bases"),
        ({"index": "nonsense"}, ValueError, "nonsense"),
        ({"by": "median"}, ValueError, "by is 'median'"),
        ({"refine": 3}, TypeError, "refine is 3"),
        ({"chain": 3}, TypeError, "chain is 3"),
    ],
)
@pytest.mark.usefixtures("annotations_unchecked")
def test_bad_input_is_named(change, error, message):
    arguments = {"chain": UR5E, "poses": SEAM, "bases": BASES[:2], "index": KCI} | change
    with pytest.raises(error, match=message):
        reach.place(**arguments)
