"""Surveys: the search against the closed form, the sampling, and the bounds of what is missed."""

import math
import sys

import hypothesis
import hypothesis.strategies as st
import numpy as np
import pytest
import torch
from scipy.stats import binom
from torch.testing import assert_close

import dexterity as dx
from dexterity import reach, spatial
from dexterity.reach import missed
from dexterity.reach.configurations import finder
from dexterity.spatial.tolerances import LIMIT

PUMA, PANDA = dx.robots.puma560(), dx.robots.panda()
GRID = reach.box([-0.6, -0.6, -0.4], [0.6, 0.6, 0.8], spacing=0.4)
TURNS = reach.rotations(24)
KCI = dx.Index("kinematic_conditioning", "geometric")


@pytest.fixture(scope="module")
def exact() -> reach.ReachMap:
    return reach.survey(PUMA, GRID, TURNS, index=KCI)


@pytest.fixture(scope="module")
def searched() -> reach.ReachMap:
    return reach.survey(PUMA, GRID, TURNS, index=KCI, method="search", starts=8)


def witnesses(surveyed: reach.ReachMap) -> tuple[torch.Tensor, torch.Tensor]:
    return surveyed.configurations[surveyed.reached], surveyed.poses()[surveyed.reached]


def test_the_closed_form_is_each_pose_by_itself(exact):
    assert (exact.method, exact.finished, exact.missed.upper) == ("closed form", True, 0.0)
    for i, j in ((0, 0), (20, 5), (33, 11), (40, 20)):
        q, valid = dx.inverse_kinematics.spherical_wrist(PUMA, spatial.pose(TURNS[j], GRID[i]))
        q, within = dx.inverse_kinematics.nearest_copy(PUMA, q)
        values = KCI(PUMA, q)[valid & within]
        assert bool(exact.reached[i, j]) == (len(values) > 0)
        assert exact.count[i, j] <= len(values)
        if len(values):
            assert_close(exact.best[i, j], values.max())


def test_the_search_finds_what_the_closed_form_finds(exact, searched):
    lost = exact.reached & ~searched.reached
    assert not (searched.reached & ~exact.reached).any()
    assert int(lost.sum()) <= searched.missed.upper
    assert int(lost.sum()) <= 0.002 * exact.reached.sum()
    assert 0.2 < exact.share.mean() < 0.8
    assert (searched.count <= exact.count)[searched.reached].double().mean() > 0.99
    assert (searched.best <= exact.best + 1e-6)[searched.reached].all()
    assert (searched.best > 0.99 * exact.best)[searched.reached].double().mean() > 0.9


@pytest.mark.parametrize("name", ["exact", "searched"])
def test_each_reached_pose_has_a_configuration_within_the_limits(name, request):
    q, T = witnesses(request.getfixturevalue(name))
    assert_close(PUMA.forward(q), T, rtol=0, atol=1e-8)
    assert ((q >= PUMA.lower - LIMIT) & (q <= PUMA.upper + LIMIT)).all()


def test_a_redundant_arm_and_its_threads():
    grid = reach.box([0.3, -0.2, 0.1], [0.7, 0.2, 0.5], spacing=0.4)
    one, two = (reach.survey(PANDA, grid, TURNS[:6], index="w", starts=4, threads=n) for n in (1, 2))
    assert one.method == "search"
    for name in ("reached", "count", "best", "configurations"):
        assert_close(getattr(one, name), getattr(two, name), equal_nan=True)
    q, T = witnesses(one)
    assert len(q) > 10
    assert_close(PANDA.forward(q), T, rtol=0, atol=1e-8)
    assert_close(one.best[one.reached], dx.Index("w", "geometric")(PANDA, q))


def test_a_joint_without_a_rate_is_locked():
    rover = PUMA.on_vehicle(torch.eye(4), rates=[1, 0, 0, 0, 0, 0], lower=[-1] * 6, upper=[1] * 6)
    surveyed = reach.survey(rover, GRID[:8], TURNS[:6], starts=4)
    q, T = witnesses(surveyed)
    assert len(q) > 10
    assert (q[:, 1:6] == 0).all()
    assert q[:, 0].abs().max() > 0.1
    assert_close(rover.forward(q), T, rtol=0, atol=1e-8)


def test_the_ur5e_has_a_closed_form(exact):
    surveyed = reach.survey(dx.robots.ur5e(), GRID, TURNS, index=KCI)
    q, T = witnesses(surveyed)
    assert (surveyed.method, surveyed.missed.upper) == ("closed form", 0.0)
    assert surveyed.count.max() == 8
    assert_close(dx.robots.ur5e().forward(q), T, rtol=0, atol=1e-8)


def test_beyond_the_arm_nothing_is_reached():
    """reach_ros2#42: no reachable point is said to be reached, and what is out of reach is said to be."""
    surveyed = reach.survey(dx.robots.ur5e(), [[3.0, 0.0, 0.0]], TURNS[:3], starts=2)
    assert not surveyed.reached.any()
    assert surveyed.best.isnan().all()


def test_positions_alone_and_a_free_turn_about_the_tool():
    """reach#29, reach#31: a survey of chosen rows, for an arm of five joints."""
    rows = [{"d": 0.05, "a": 0.02, "alpha": math.pi / 2}, {"a": 0.15}, {"a": 0.02, "alpha": -math.pi / 2},
            {"d": 0.18, "alpha": math.pi / 2}, {"d": 0.05}]  # fmt: skip
    arm = dx.Chain.from_dh(rows, lower=[-3.1, 0, -2, -2, -3], upper=[3.1, 3.1, 2, 2, 3], name="five joints")
    grid = reach.box([0.1, -0.1, 0.0], [0.3, 0.1, 0.2], spacing=0.1)
    places = reach.survey(arm, grid, torch.eye(3)[None], rows="translational", starts=4)
    assert places.share.mean() > 0.8
    share = torch.rand(12, 5, generator=torch.Generator().manual_seed(0), dtype=torch.float64)
    wanted = arm.forward(arm.lower + (arm.upper - arm.lower) * share) @ spatial.exp([0, 0, 0, 0, 0, 1.0])
    some = {"rows": ("vx", "vy", "vz", "wx", "wy"), "starts": 8}
    pointing = reach.survey(arm, wanted[:, :3, 3], wanted[:, :3, :3], **some)
    assert pointing.reached.diagonal().all()
    q, T = witnesses(pointing)
    assert_close(arm.forward(q)[:, :3, 2:], T[:, :3, 2:], rtol=0, atol=1e-8)
    with pytest.raises(ValueError, match="closed form has all six"):
        reach.survey(PUMA, GRID, TURNS, rows="translational", method="closed form")


def test_an_index_of_which_smaller_is_better():
    deviation = dx.Index("tool_deviation", "geometric")
    surveyed = reach.survey(PUMA, GRID[30:50], TURNS[:4], index=deviation)
    worst = reach.survey(PUMA, GRID[30:50], TURNS[:4], index=lambda q: deviation(PUMA, q))
    chosen = surveyed.reached & (surveyed.count > 1)
    assert (surveyed.best <= worst.best)[chosen].all()
    assert (surveyed.best < worst.best)[chosen].any()
    with pytest.raises(ValueError, match="smaller is better"):
        _ = surveyed.capability


# ---- sampling ----------------------------------------------------------------------------------------


def test_sampling_marks_only_cells_with_a_configuration_in_them():
    surveyed = reach.survey(PUMA, GRID, TURNS, index="w", method="sampling", draws=20_000)
    q, T = witnesses(surveyed)
    side, angle = surveyed.cell
    assert side == pytest.approx(0.2)
    assert angle == pytest.approx(reach.covering_radius(TURNS))
    away = spatial.inverse(T) @ PUMA.forward(q)
    assert ((PUMA.forward(q)[:, :3, 3] - T[:, :3, 3]).abs() <= side + 1e-9).all()
    assert (spatial.log(away)[:, 3:].norm(dim=-1) <= angle + 1e-9).all()
    assert torch.equal(surveyed.reached, surveyed.hits > 0)
    assert surveyed.missed.upper is None


def test_the_held_out_share_and_the_estimate_hold_for_more_draws():
    few, many = (reach.survey(PUMA, GRID, TURNS, method="sampling", draws=n) for n in (5_000, 200_000))
    later = many.reached & ~few.reached
    assert not (few.reached & ~many.reached).any() or few.hits[few.reached & ~many.reached].max() == 1
    share = many.hits[later].sum() / many.hits.sum()
    assert 0 < share <= few.missed.share
    assert 0.2 * int(later.sum()) < few.missed.estimate < 3 * int(later.sum())


# ---- estimates ---------------------------------------------------------------------------------------


@hypothesis.given(hits=st.integers(0, 50), more=st.integers(1, 500))
def test_the_upper_end_of_a_share_is_clopper_and_pearsons(hits, more):
    share = missed.largest_share(hits, hits + more)
    assert binom.cdf(hits, hits + more, share) == pytest.approx(0.05, rel=1e-6)
    assert missed.largest_share(0, 0) == 1.0


def test_chaos_estimate_of_cells_that_no_draw_saw():
    draws = np.random.default_rng(0).integers(1000, size=1500)
    times = np.bincount(draws, minlength=1000)
    assert missed.unseen(times) == pytest.approx((times == 0).sum(), rel=0.25)
    assert missed.unseen(times[times > 0]) == missed.unseen(times)


# ---- interruption, bad input ---------------------------------------------------------------------------


def test_after_ctrl_c_the_finished_part_is_kept_and_can_be_gone_on_from(exact, monkeypatch):
    monkeypatch.setitem(sys.modules["dexterity.reach.surveys"]._AT_ONCE, "closed form", 100)
    calls = []

    def interrupt(done: int, total: int) -> None:
        calls.append((done, total))
        if done >= 500:
            raise KeyboardInterrupt

    part = reach.survey(PUMA, GRID, TURNS, index=KCI, progress=interrupt)
    assert not part.finished
    assert int(part.examined.sum()) == 500 == calls[-1][0]
    assert calls[-1][1] == GRID.shape[0] * len(TURNS)
    assert part.missed.upper is None
    whole = reach.survey(PUMA, GRID, TURNS, index=KCI, unfinished=part)
    for name in ("reached", "count", "best"):
        assert_close(getattr(whole, name), getattr(exact, name), equal_nan=True)
    with pytest.raises(ValueError, match="unfinished is"):
        reach.survey(PUMA, GRID, TURNS, index="w", unfinished=part)


@pytest.mark.parametrize(
    ("change", "error", "message"),
    [
        ({"positions": [[0.0, 0.0]]}, ValueError, "positions has shape"),
        ({"positions": [[0.0, 0.0, math.nan]]}, ValueError, "positions"),
        ({"rotations": torch.eye(3)}, ValueError, "rotations has shape"),
        ({"rotations": 2 * torch.eye(3)[None]}, ValueError, "rotations"),
        ({"index": "nonsense"}, ValueError, "nonsense"),
        ({"index": 3}, TypeError, "index is 3"),
        ({"method": "magic"}, ValueError, "method is 'magic'"),
        ({"starts": 0, "method": "search"}, ValueError, "starts is 0"),
        ({"starts": math.nan, "method": "search"}, TypeError, "starts is nan"),
        ({"draws": 2.5, "method": "sampling"}, TypeError, "draws is 2.5"),
        ({"cell": (0.0, 0.1), "method": "sampling"}, ValueError, r"cell\[0\] is 0"),
        ({"positions": [[0.0, 0, 0]], "method": "sampling"}, ValueError, "positions holds one"),
        ({"threads": 0}, ValueError, "threads is 0"),
        ({"limit_tolerance": -1.0}, ValueError, "limit_tolerance is -1"),
        ({"chain": "panda"}, TypeError, "chain is 'panda'"),
        ({"chain": PANDA, "method": "closed form"}, ValueError, "panda has none"),
        ({"chain": dx.robots.uvms()}, ValueError, "without limits"),
    ],
)
@pytest.mark.usefixtures("annotations_unchecked")
def test_bad_input_is_named(change, error, message):
    arguments = {"chain": PUMA, "positions": GRID[:2], "rotations": TURNS[:1]} | change
    with pytest.raises(error, match=message):
        reach.survey(
            arguments.pop("chain"), arguments.pop("positions"), arguments.pop("rotations"), **arguments
        )


def test_the_finder_says_how():
    assert (finder(PUMA).method, finder(PANDA).method) == ("closed form", "search")
    assert finder(PUMA, "search").complete is False
