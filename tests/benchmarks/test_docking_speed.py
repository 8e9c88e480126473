"""Area manipulability in closed form beside all branches by determinants, on one core."""

import torch

import dexterity as dx
from dexterity import docking
from dexterity.docking.area import TOOL_UP, _by_branches
from dexterity.networks.threads import one_thread
from dexterity.timing import Way, measure

POSES = 100_000
FEW = 1_000


def poses(count: int) -> torch.Tensor:
    problem = docking.DockingProblem(dx.robots.docking_arm())
    unit = torch.rand(count, 4, generator=torch.Generator().manual_seed(0), dtype=torch.float64)
    return problem.lower + (problem.upper - problem.lower) * unit


def test_a_million_poses_in_a_second():
    arm, corners = dx.robots.docking_arm(), docking.square(0.2)
    many, few, tool = poses(POSES), poses(FEW), torch.tensor(TOOL_UP, dtype=torch.float64)
    with one_thread():
        closed, branches = measure(
            [
                Way("closed form", lambda: docking.area_manipulability(arm, many, corners), POSES),
                Way("all branches", lambda: _by_branches(arm, few, corners, tool), FEW),
            ]
        )
    print(
        f"{1 / closed.median:,.0f} poses a second, {branches.median / closed.median:.0f} times all branches"
    )
    assert 1 / closed.median > 1e6
    assert branches.median / closed.median > 20


def test_with_bodies_hundreds_of_thousands_of_poses_in_a_second():
    """Four corners, all branches, the arm, block and vehicle."""
    arm, corners = dx.robots.docking_arm(), docking.square(0.2)
    bodies, many = docking.block_and_vehicle(arm), poses(POSES)
    with one_thread():
        (around,) = measure(
            [
                Way(
                    "with bodies",
                    lambda: docking.area_manipulability(arm, many, corners, TOOL_UP, bodies),
                    POSES,
                )
            ]
        )
    print(f"{1 / around.median:,.0f} poses a second with bodies")
    assert 1 / around.median > 4e5


def test_a_genetic_run_of_the_paper_s_size_takes_less_than_a_second():
    problem = docking.DockingProblem(dx.robots.docking_arm())
    runs = [
        Way(f"seed {seed}", lambda seed=seed: docking.genetic_docking(problem, seed), 1) for seed in range(5)
    ]
    seconds = [timing.median for timing in measure(runs, rounds=3)]
    print(f"{min(seconds):.2f} to {max(seconds):.2f} s a run")
    assert max(seconds) < 1.0
