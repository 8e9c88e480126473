"""Poses that follow one another: against all sequences there are, over full turns, for redundant arms."""

import itertools
import math

import pytest
import torch
from torch.testing import assert_close

import dexterity as dx
from dexterity import reach, spatial
from dexterity.inverse_kinematics import solve

UR5E, PANDA, PUMA = dx.robots.ur5e(), dx.robots.panda(), dx.robots.puma560()
DOWN = reach.pointing([0, 0, -1])
KCI = dx.Index("kinematic_conditioning", "geometric")


def every_sequence(chain, poses, step):
    """Worst and mean KCI and length of all sequences whose joints move by a step at most."""
    each = [solve(chain, pose).copies() for pose in poses]
    rows = []
    for chosen in itertools.product(*each):
        q = torch.stack(chosen)
        moves = q.diff(dim=0)
        if moves.abs().max() <= step:
            values = KCI(chain, q)
            rows.append((float(values.min()), float(values.mean()), float(moves.norm(dim=-1).sum())))
    return rows


@pytest.mark.parametrize("step", [0.3, 1.2, 3.0])
def test_it_is_the_best_of_all_sequences(step):
    poses = reach.seam([0.5, -0.3, 0.1], [0.6, 0.3, 0.3], 4, DOWN)
    rows = every_sequence(PUMA, poses, step)
    worst = reach.follow(PUMA, poses, step, KCI)
    mean = reach.follow(PUMA, poses, step, KCI, by="mean")
    short = reach.follow(PUMA, poses, step)
    assert worst.complete
    if not rows:
        assert not worst.followed
        return
    assert float(worst.values.min()) == pytest.approx(max(row[0] for row in rows), abs=1e-9)
    assert float(mean.values.mean()) == pytest.approx(max(row[1] for row in rows), abs=1e-9)
    length = float(short.configurations.diff(dim=0).norm(dim=-1).sum())
    assert length == pytest.approx(min(row[2] for row in rows), abs=1e-9)
    # Of those with the best worst value, the shortest.
    length = float(worst.configurations.diff(dim=0).norm(dim=-1).sum())
    best = [row[2] for row in rows if row[0] >= float(worst.values.min()) - 1e-12]
    assert length == pytest.approx(min(best), abs=1e-9)


@pytest.mark.parametrize(
    ("chain", "y"), [(UR5E, 0.5), (PANDA, 0.4)], ids=["closed form", "redundant, by search"]
)
def test_what_is_said_of_a_path_is_so(chain, y):
    poses = reach.seam([-0.15, y, 0.3], [0.15, y, 0.3], 6, DOWN)
    path = reach.follow(chain, poses, 0.35, KCI, starts=6)
    assert path.followed
    assert path.complete == (chain is UR5E)
    assert_close(chain.forward(path.configurations), poses, rtol=0, atol=1e-8)
    assert path.largest_step <= 0.35 + 1e-9
    assert_close(path.values, KCI(chain, path.configurations))
    assert dx.inverse_kinematics.within_limits(chain, path.configurations).all()


def test_a_joint_turns_on_over_a_full_turn():
    """A ring about the base, one and a half times round, for limits of a full turn to either side."""
    angle = torch.linspace(0, 3 * math.pi, 31, dtype=torch.float64)
    start = spatial.compose(spatial.translation(0.5, 0, 0.2), spatial.from_rpy([math.pi, 0, 0]))
    turned = spatial.exp(torch.stack([*[torch.zeros_like(angle)] * 5, angle], -1)) @ start
    path = reach.follow(UR5E, turned, 0.4, KCI)
    assert path.followed
    first = path.configurations[:, 0]
    assert float(first[-1] - first[0]) == pytest.approx(3 * math.pi, abs=1e-9)
    assert dx.inverse_kinematics.within_limits(UR5E, path.configurations).all()
    narrow = UR5E.with_limits(lower=[-math.pi] * 6, upper=[math.pi] * 6)
    stopped = reach.follow(narrow, turned, 0.4, KCI)
    assert not stopped.followed
    assert stopped.configurations.isnan().all()
    # Only the first joint moves, from where it is at the first pose to its limit.
    start = solve(narrow, turned[0])
    room = (math.pi - start.q[start.usable][:, 0]) / (0.1 * math.pi)
    assert stopped.until == int(room.max()) + 1
    for lower, upper in ((-math.inf, math.inf), (50.0, math.inf), (-math.inf, -50.0)):
        free = UR5E.with_limits(lower=[lower] + [-7.0] * 5, upper=[upper] + [7.0] * 5)
        path = reach.follow(free, turned, 0.4)
        assert path.followed
        assert dx.inverse_kinematics.within_limits(free, path.configurations).all()


def test_one_pose_and_a_step_for_each_joint():
    pose = spatial.pose(DOWN, [0.5, 0.1, 0.2])
    alone = reach.follow(UR5E, pose[None], 0.1, KCI)
    assert alone.followed
    assert alone.largest_step == 0
    assert float(alone.values) == pytest.approx(float(KCI(UR5E, solve(UR5E, pose).q).max()), abs=1e-9)
    poses = reach.seam([0.4, -0.1, 0.2], [0.4, 0.1, 0.2], 3, DOWN)
    steps = torch.tensor([0.5, 0.5, 0.5, 0.5, 0.5, 1e-6])
    assert reach.follow(UR5E, poses, 0.5).followed
    assert not reach.follow(UR5E, poses, steps).followed


def test_out_of_reach_is_told_with_the_last_pose_in_reach():
    poses = reach.seam([0.5, 0, 0.2], [1.5, 0, 0.2], 11, DOWN)
    path = reach.follow(UR5E, poses, 1.0, KCI)
    reached = solve(UR5E, poses).reached
    assert path.until == int(reached.sum()) < 11
    assert "followed to pose" in repr(path)


def test_a_base_is_chosen_from_which_a_seam_can_be_followed():
    """Without a path, the best configurations of a redundant arm jump from pose to pose."""
    seam = reach.seam([-0.1, 0, 0.2], [0.1, 0, 0.2], 4, DOWN)
    bases = [[0.0, -0.5, 0.0], [0.1, -0.4, 0.3], [0.0, -3.0, 0.0]]
    for chain in (UR5E, PANDA):
        loose = reach.place(chain, seam, bases, KCI, refine=False, starts=6)
        tight = reach.place(chain, seam, bases, KCI, largest_step=0.3, refine=False, starts=6)
        assert loose.followed is None
        assert tight.followed.tolist() == [True, True, False]
        assert tight.best.largest_step <= 0.3 + 1e-9
        if loose.complete:  # else a path has more candidates
            assert (loose.scores[:2] >= tight.scores[:2] - 1e-9).all()
        T = tight.best.T_world_base @ chain.forward(tight.best.configurations)
        assert_close(T, seam, rtol=0, atol=1e-8)
        assert "2 follow them" in repr(tight)
    tiny = reach.place(UR5E, seam, bases, KCI, largest_step=1e-3)
    assert not tiny.followed.any()
    assert tiny.reached.tolist() == [4, 4, 0]
    assert tiny.scores.isnan().all()
    assert tiny.refined is None


def test_the_refined_base_follows_the_seam():
    seam = reach.seam([-0.1, 0, 0.2], [0.1, 0, 0.2], 3, DOWN)
    bases = reach.planar_bases([-0.1, 0.1], [-0.5], [0.0])
    placed = reach.place(UR5E, seam, bases, KCI, largest_step=0.4)
    assert placed.refined.score >= placed.scores.max()
    assert placed.refined.largest_step <= 0.4 + 1e-9


def test_rows_along_the_axes_of_the_world():
    """A drill whose heading is free, with the tool's own axes tilted."""
    tilted = UR5E.with_tool(spatial.from_rpy([0.4, 0.2, 0.0]))
    poses = reach.seam([-0.1, 0.5, 0.3], [0.1, 0.5, 0.3], 3, DOWN)
    rows = ("vx", "vy", "vz", "wx", "wy")
    path = reach.follow(tilted, poses, 0.5, KCI, rows=rows, frame="geometric", starts=6)
    assert path.followed
    T = tilted.forward(path.configurations)
    assert_close(T[:, :3, 3], poses[:, :3, 3], rtol=0, atol=1e-8)
    assert_close(T[:, 2, :3], poses[:, 2, :3], rtol=0, atol=1e-8)


@pytest.mark.usefixtures("annotations_unchecked")
@pytest.mark.parametrize(
    ("change", "error", "message"),
    [
        ({"poses": torch.eye(4)}, ValueError, "poses has shape"),
        ({"poses": torch.zeros(0, 4, 4)}, ValueError, "poses has shape"),
        ({"largest_step": 0.0}, ValueError, "largest_step is 0"),
        ({"largest_step": -1.0}, ValueError, "largest_step is -1"),
        ({"largest_step": [0.1, 0.1]}, ValueError, "largest_step is"),
        ({"largest_step": math.nan}, ValueError, "largest_step is not finite"),
        ({"largest_step": "far"}, TypeError, "largest_step"),
        ({"by": "median"}, ValueError, "by is 'median'"),
        ({"frame": "spatial"}, ValueError, "frame is 'spatial'"),
        ({"index": "nonsense"}, ValueError, "nonsense"),
        ({"chain": 3}, TypeError, "chain is 3"),
    ],
)
def test_bad_input_is_named(change, error, message):
    arguments = {"chain": UR5E, "poses": reach.seam([0.4, 0, 0], [0.5, 0, 0], 2, DOWN), "largest_step": 0.3}
    with pytest.raises(error, match=message):
        reach.follow(**arguments | change)
