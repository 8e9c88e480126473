"""Maps against one pose at a time, two exact answers against each other, and the five notions."""

import itertools
import math

import numpy as np
import pytest
import torch
from scipy.spatial.transform import Rotation
from torch.testing import assert_close

import dexterity as dx
from dexterity import spatial
from dexterity.workspace import maps, reachability
from dexterity.workspace.maps import ByBranches, ByClosedForm, ByNetwork, Grid
from dexterity.workspace.reachability import Branch

LINKS = (0.15, 0.4318, 0.4318, 0.0203)
PUMA = dx.robots.puma560()
TOOL = spatial.pose(torch.eye(3), [0.02, 0.0, 0.1])
DOWN = (0.0, 0.0, -1.0)
SMALL = Grid.cube(0.5, 5)
SOME = maps.rotations(24)


class TrueNetwork:
    """Stands in for networks: the named branch itself, with a confidence of 1 or 0."""

    def answer(self, links, T_base_tool):
        q, reached = reachability.inverse(links, T_base_tool)
        J = reachability.geometric_jacobian(links, q)
        return reached.double(), J, reached


def limited(**options):
    return ByClosedForm(LINKS, None, lower=PUMA.lower, upper=PUMA.upper, **options)


def row(*numbers: float) -> torch.Tensor:
    return torch.tensor(numbers, dtype=torch.float64)


def same(one: maps.Survey, other: maps.Survey) -> bool:
    return all(torch.equal(a, b) for a, b in zip(surveyed(one), surveyed(other), strict=True))


def surveyed(found: maps.Survey) -> tuple[torch.Tensor, ...]:
    return found.count, found.count_in_range, found.largest


def test_without_limits_or_tool_the_notions_are_one():
    found = maps.survey(ByClosedForm(LINKS, None), SMALL, SOME, maps.around(SOME, DOWN, 1.0))
    rule = reachability.reachable(LINKS, SMALL.points())
    assert 0 < rule.sum() < rule.numel()
    for notion in (found.reachable, found.total_orientation, found.dexterous, found.share == 1):
        assert torch.equal(notion, rule)
    constant = maps.constant_orientation(ByClosedForm(LINKS), SMALL, SOME[3])
    assert torch.equal(constant.reached, rule)


@pytest.mark.parametrize(
    "answer",
    [limited(), ByClosedForm(LINKS, None, T_flange_tool=TOOL), limited(T_flange_tool=TOOL)],
    ids=["limits", "tool", "both"],
)
def test_with_limits_or_a_tool_they_are_not(answer):
    found = maps.survey(answer, Grid.cube(0.6, 7), SOME, maps.around(SOME, DOWN, 1.0))
    reachable, total = int(found.reachable.sum()), int(found.total_orientation.sum())
    assert reachable > total > int(found.dexterous.sum())
    # Each is part of the one before.
    assert not (found.total_orientation & ~found.reachable).any()
    assert not (found.dexterous & ~found.total_orientation).any()


@pytest.mark.parametrize("T_flange_tool", [None, TOOL], ids=["no tool", "tool"])
def test_two_exact_answers_agree_with_limits(T_flange_tool):
    arm = PUMA if T_flange_tool is None else PUMA.with_tool(T_flange_tool)
    by_branches = maps.survey(ByBranches(arm), Grid.cube(0.5, 4), SOME, maps.around(SOME, DOWN, 1.0))
    closed = maps.survey(
        limited(T_flange_tool=T_flange_tool), Grid.cube(0.5, 4), SOME, maps.around(SOME, DOWN, 1.0)
    )
    assert torch.equal(by_branches.count, closed.count)
    assert torch.equal(by_branches.count_in_range, closed.count_in_range)
    assert_close(by_branches.largest, closed.largest, rtol=0, atol=1e-12)
    assert 0 < by_branches.count.sum() < 64 * len(SOME)


@pytest.mark.parametrize("branch", [Branch(), Branch(left=False, up=False, flip=True), None])
def test_w_is_that_of_the_branch_or_the_best_of_all(branch):
    T = maps_poses(40)
    reply = ByClosedForm(LINKS, branch)(T)
    every = [branch] if branch else [Branch(*s) for s in itertools.product([True, False], repeat=3)]
    values = []
    for each in every:
        q, reach = reachability.inverse(LINKS, T, each)
        values.append(torch.linalg.det(reachability.geometric_jacobian(LINKS, q)).abs() * reach)
    assert torch.equal(reply.reached, reach)
    assert_close(reply.manipulability, torch.stack(values).amax(0), rtol=0, atol=1e-14)


def maps_poses(count: int) -> torch.Tensor:
    random = torch.Generator().manual_seed(5)
    return spatial.pose(maps.rotations(count), 1.2 * torch.rand(count, 3, generator=random).double() - 0.6)


def test_a_learned_answer_drops_in():
    answer, exact = ByNetwork(TrueNetwork(), LINKS), ByClosedForm(LINKS)
    assert isinstance(TrueNetwork(), maps.PoseNetwork)
    one, other = (maps.constant_orientation(each, SMALL, SOME[1]) for each in (answer, exact))
    assert torch.equal(one.reached, other.reached)
    assert_close(one.manipulability, other.manipulability, rtol=0, atol=1e-14)
    here = maps.orientation_workspace(answer, [0.3, 0.1, 0.2], SOME)
    assert here.reached.all()
    assert here.manipulability.shape == (24,)


def test_where_networks_were_trained_is_told():
    answer = ByNetwork(TrueNetwork(), LINKS)
    inside = answer.in_training_range(SMALL.points())
    assert torch.equal(inside, (SMALL.points().abs() <= 0.4).all(-1))
    assert inside.sum() == 27
    assert not ByNetwork(TrueNetwork(), (0.1, 0.2, 0.6, 0.1)).in_training_range([0.0, 0.0, 0.1])
    assert maps.in_training_range([[0.1] * 4, [0.7] * 4], [0.1, 0.1, 0.1]).tolist() == [True, False]


@pytest.mark.parametrize("at_once", [1, 7, 24, 100])
def test_the_size_of_a_slab_changes_nothing(at_once):
    answer, chosen = limited(T_flange_tool=TOOL), maps.around(SOME, DOWN, 1.0)
    grid = Grid(row(0.2, 0.3), row(0.1), row(0.0, 0.1, 0.2))
    whole = maps.survey(answer, grid, SOME, chosen)
    assert whole.count.shape == (2, 1, 3)
    assert same(maps.survey(answer, grid, SOME, chosen, poses_at_once=at_once), whole)


def test_a_survey_is_what_single_poses_say():
    grid = Grid(row(0.2, 0.5), row(-0.3), row(0.1, 0.4))
    found = maps.survey(limited(T_flange_tool=TOOL), grid, SOME)
    for i, k in itertools.product(range(2), range(2)):
        here = maps.orientation_workspace(limited(T_flange_tool=TOOL), grid.points()[i, 0, k], SOME)
        assert found.count[i, 0, k] == here.reached.sum()
        assert found.largest[i, 0, k] == here.manipulability.max()


def test_rotations_are_spread_evenly():
    R = maps.rotations(2_000)
    unit = torch.eye(3, dtype=torch.float64).expand_as(R)
    assert_close(R @ R.mT, unit, rtol=0, atol=1e-14)
    assert_close(torch.linalg.det(R), torch.ones(len(R)).double())
    # Integrals over all rotations: of an entry 0, of its square a third.
    assert R.mean(0).abs().max() < 2e-3
    assert_close(R.square().mean(0), torch.full((3, 3), 1 / 3).double(), rtol=0, atol=2e-3)
    q = Rotation.from_matrix(R.numpy()).as_quat()
    alike = np.abs(q @ q.T) - 2 * np.eye(len(q))
    nearest = 2 * np.arccos(alike.max(1).clip(max=1))
    drawn = Rotation.random(2_000, rng=np.random.default_rng(0)).as_quat()
    random = 2 * np.arccos((np.abs(drawn @ drawn.T) - 2 * np.eye(2_000)).max(1).clip(max=1))
    assert nearest.min() > 5 * random.min()
    assert nearest.min() > 0.5 * nearest.max()


def test_a_cone_holds_its_share_of_the_orientations():
    R = maps.rotations(5_000)
    for angle in (0.3, 1.0, 2.0):
        share = maps.around(R, [1.0, 2.0, -0.5], angle).double().mean().item()
        assert share == pytest.approx((1 - math.cos(angle)) / 2, abs=5e-3)
    assert maps.around(R, DOWN, math.pi).all()


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: maps.constant_orientation(limited(), SMALL, 2 * torch.eye(3)), "orthonormality"),
        (
            lambda: maps.constant_orientation(limited(), SMALL, [1.0, 0.0]),
            r"^orientation has shape \(2,\); \(3, 3\) is",
        ),
        (lambda: Grid(row(), row(0.0), row(0.0)), r"x has shape \(0,\)"),
        (lambda: Grid(row(0.0), row(math.nan), row(0.0)), "y is not finite"),
        (lambda: Grid.cube(-0.4, 5), "half_side is -0.4"),
        (lambda: Grid.cube(0.4, 1), "per_side is 1"),
        (lambda: maps.rotations(0), "count is 0"),
        (lambda: maps.around(SOME, [0.0, 0.0, 0.0], 1.0), "direction is"),
        (lambda: maps.around(SOME, DOWN, 4.0), "half_angle is 4.0"),
        (lambda: maps.survey(limited(), SMALL, SOME[:0]), r"orientations has shape \(0, 3, 3\)"),
        (lambda: maps.survey(limited(), SMALL, SOME, poses_at_once=0), "poses_at_once is 0"),
        (lambda: maps.survey(limited(), SMALL, SOME, [True] * 3), "24 truth values"),
        (lambda: maps.survey(limited(), SMALL, SOME, torch.zeros(24, dtype=torch.bool)), "24 truth values"),
        (lambda: ByClosedForm((0.1, 0.2, 0.3)), r"links has shape \(3,\)"),
        (lambda: ByClosedForm((0.1, 0.2, 0.3, -0.1)), "links holds -0.1"),
        (lambda: ByClosedForm(LINKS, lower=[1.0] * 6, upper=[0.0] * 6), "lower"),
        (
            lambda: ByClosedForm(LINKS, T_flange_tool=torch.eye(4).expand(2, 4, 4)),
            r"T_flange_tool has shape \(2, 4, 4\)",
        ),
        (lambda: ByNetwork(TrueNetwork(), [LINKS, LINKS]), r"links has shape \(2, 4\)"),
        (lambda: maps.in_training_range([0.1] * 3, [0.0] * 3), r"links has shape \(3,\)"),
    ],
)
def test_bad_input_is_named(call, message, annotations_unchecked):
    with pytest.raises(ValueError, match=message):
        call()


def test_an_unknown_backend_is_named(annotations_unchecked):
    with pytest.raises(ValueError, match="backend is 'fortran'"):
        ByClosedForm(LINKS, backend="fortran")


@pytest.mark.parametrize("answer", [limited(), ByBranches(PUMA), ByNetwork(TrueNetwork(), LINKS)])
def test_a_pose_must_be_rigid(answer):
    with pytest.raises(ValueError, match="rigid"):
        answer(torch.diag(torch.tensor([2.0, 1, 1, 1]).double()))


# ---- limits with their ends, arrays of the caller, other arms ------------------------------------------

WAIST = [[-90, 30, 120], [0, 60, 150], [-120, -30, 20], [-60, 45, 90], [100, -100], [0, 45]]
FAMILY = [[-90, 30, 120], [-100, 60, 120], *WAIST[2:]]
FAMILY_LIMITS = torch.deg2rad(torch.tensor([160, 135, 135, 140, 100, 170], dtype=torch.float64))


def round_degrees(values: list[list[int]]) -> torch.Tensor:
    return torch.deg2rad(torch.tensor(list(itertools.product(*values)), dtype=torch.float64))


def test_a_joint_exactly_at_its_limit_is_within_it():
    """moveit#598, dart#1449, predicators#1292: 324 configurations with the fifth joint at ±100°."""
    q = round_degrees(WAIST)
    assert len(q) == 324
    assert ByBranches(PUMA)(PUMA.forward(q)).reached.all()


@pytest.mark.parametrize("backend", ["torch", "c"])
def test_a_joint_exactly_at_its_limit_is_within_it_in_closed_form(backend):
    """moveit#598, dart#1449, predicators#1292, for the family of paper C; both answers agree."""
    free = reachability.arm(LINKS)
    q = round_degrees(FAMILY)
    limited_arm = free.with_limits(lower=-FAMILY_LIMITS, upper=FAMILY_LIMITS)
    T = limited_arm.forward(q)
    closed = ByClosedForm(LINKS, None, lower=-FAMILY_LIMITS, upper=FAMILY_LIMITS, backend=backend)(T)
    branches = ByBranches(limited_arm)(T)
    assert closed.reached.all()
    assert branches.reached.all()
    assert_close(closed.manipulability, branches.manipulability, rtol=0, atol=1e-9)


def test_random_configurations_at_a_limit_are_reached():
    """dart#1449: of 6000 configurations with one joint at a limit none is lost."""
    random = torch.Generator().manual_seed(0)
    q = PUMA.lower + (PUMA.upper - PUMA.lower) * torch.rand(6000, 6, generator=random, dtype=torch.float64)
    rows, joint = torch.arange(6000), torch.arange(6000) % 6
    q[rows, joint] = torch.where(rows % 2 == 0, PUMA.lower[joint], PUMA.upper[joint])
    assert ByBranches(PUMA)(PUMA.forward(q)).reached.all()
    assert not ByBranches(PUMA, limit_tolerance=0.0)(PUMA.forward(q)).reached.all()


def test_beyond_the_tolerance_a_limit_is_a_limit():
    q = torch.tensor([0.3, 0.4, -0.5, 0.6, 0.0, 0.2], dtype=torch.float64)
    narrow = {"lower": [-3, -3, -3, -3, -1, -3], "upper": [3, 3, 3, 3, 1, 3]}
    free = reachability.arm(LINKS)
    q[4] = 1.0
    every = [Branch(*sides) for sides in itertools.product([True, False], repeat=3)]
    (branch,) = (
        each
        for each in every
        if (reachability.inverse(LINKS, free.forward(q), each)[0] - q).abs().max() < 1e-6
    )
    for excess, allowed in ((0.0, True), (5e-10, True), (1e-6, False)):
        q[4] = 1 + excess
        reply = ByClosedForm(LINKS, branch, **narrow)(free.forward(q))
        assert bool(reply.reached) is allowed
    assert ByClosedForm(LINKS, branch, limit_tolerance=1e-5, **narrow)(free.forward(q)).reached


@pytest.mark.parametrize("backend", ["torch", "c"])
def test_nothing_changes_when_the_callers_arrays_change(backend):
    links, side = np.array(LINKS), np.linspace(-0.4, 0.4, 3)
    answer, grid = ByClosedForm(links, None, backend=backend), Grid(*[torch.from_numpy(side)] * 3)
    before = maps.survey(answer, grid, SOME)
    links[2] = 0.7
    side[:] = 9.0
    after = maps.survey(answer, grid, SOME)
    assert same(before, after)
    assert grid.x.tolist() == [-0.4, 0.0, 0.4]


@pytest.mark.parametrize("arm", [dx.robots.panda(), dx.robots.ur5e()], ids=["panda", "ur5e"])
def test_other_arms_are_sent_to_where_they_are_served(arm):
    with pytest.raises(ValueError, match=r"dexterity\.reach\.survey maps any chain"):
        ByBranches(arm)


@pytest.mark.parametrize(
    ("call", "error", "message"),
    [
        (lambda: Grid.cube(math.nan, 3), ValueError, "half_side is nan"),
        (lambda: Grid.cube(1.0, 2.5), TypeError, "per_side is 2.5"),
        (lambda: maps.rotations(math.nan), TypeError, "count is nan"),
        (lambda: maps.around(SOME, DOWN, math.nan), ValueError, "half_angle is nan"),
        (
            lambda: maps.survey(ByBranches(PUMA), SMALL, SOME, None, math.nan),
            TypeError,
            "poses_at_once is nan",
        ),
        (lambda: maps.survey(ByBranches(PUMA), SMALL, SOME, None, 0), ValueError, "poses_at_once is 0"),
        (lambda: maps.survey(3, SMALL, SOME), TypeError, "answer is 3"),
        (lambda: maps.survey(ByBranches(PUMA), SOME, SOME), TypeError, "grid is"),
        (
            lambda: maps.orientation_workspace(ByBranches(PUMA), [0, 0], SOME),
            ValueError,
            "position has shape",
        ),
        (
            lambda: maps.orientation_workspace(ByBranches(PUMA), [0, 0, 0], 2 * SOME),
            ValueError,
            "orientations",
        ),
        (lambda: ByBranches(PUMA, -1.0), ValueError, "limit_tolerance is -1"),
        (lambda: ByBranches("puma"), TypeError, "arm is 'puma'"),
        (lambda: ByClosedForm(LINKS, limit_tolerance=math.nan), ValueError, "limit_tolerance is nan"),
        (lambda: ByClosedForm(LINKS, backend="cuda"), ValueError, "backend is 'cuda'"),
    ],
)
@pytest.mark.usefixtures("annotations_unchecked")
def test_numbers_that_are_none_are_named(call, error, message):
    with pytest.raises(error, match=message):
        call()
