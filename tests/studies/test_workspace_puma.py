"""The PUMA's maps: what the verdicts go by, on made-up results, and what scenes and surfaces show."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from dexterity.report.claims import Outcome, load_paper
from dexterity.report.runs import run_study
from dexterity.studies.workspace import puma as study
from dexterity.workspace import maps, reachability
from dexterity.workspace.maps import Grid, Map


@pytest.fixture(scope="module")
def result() -> study.Result:
    return run_study("workspace.puma", study.CONFIGS["smoke"]).result


def outcomes(result: study.Result) -> dict[str, Outcome]:
    return {verdict.claim: verdict.outcome for verdict in study.verdicts(result)}


def with_networks(result: study.Result, **agreements: study.Agreement) -> study.Result:
    learned = {
        name: replace(own, aligned=agreements[name], random=agreements[name])
        for name, own in result.learned.items()
    }
    return replace(result, learned=learned)


GOOD = study.Agreement(0.99, 0.96, 0.99, 0.04, 0.1, 0.3)
BLURRED = replace(GOOD, unreached=0.94)
WEAK = replace(GOOD, median_error=0.06)


def test_its_claims_are_the_ledgers(result):
    own = {claim.id for claim in load_paper("liao2018").claims if claim.study == "workspace.puma"}
    assert outcomes(result).keys() == own


@pytest.mark.parametrize(
    ("rotation", "plane", "alike", "workspace", "manipulability"),
    [
        (GOOD, GOOD, Outcome.REPRODUCED, Outcome.REPRODUCED, Outcome.REPRODUCED),
        (BLURRED, GOOD, Outcome.IN_SHAPE, Outcome.IN_SHAPE, Outcome.REPRODUCED),
        (WEAK, GOOD, Outcome.IN_SHAPE, Outcome.REPRODUCED, Outcome.IN_SHAPE),
        (BLURRED, WEAK, Outcome.NOT_REPRODUCED, Outcome.IN_SHAPE, Outcome.REPRODUCED),
        (WEAK, BLURRED, Outcome.NOT_REPRODUCED, Outcome.REPRODUCED, Outcome.IN_SHAPE),
    ],
)
def test_maps_vary_slightly_as_the_ledger_has_it(result, rotation, plane, alike, workspace, manipulability):
    found = outcomes(with_networks(result, rotation=rotation, plane=plane))
    assert found["puma-maps-alike"] is alike
    assert found["workspace-from-jacobian"] is workspace
    assert found["manipulability-from-estimate"] is manipulability


@pytest.mark.parametrize(
    ("off", "message", "outcome"),
    [
        (0.9e-3, "", Outcome.REPRODUCED),
        (5e-3, "", Outcome.IN_SHAPE),
        (2e-2, "", Outcome.NOT_REPRODUCED),
        (0.9e-3, "after 1 s a joint would turn at 11 rad/s", Outcome.NOT_REPRODUCED),
    ],
)
def test_the_loop_is_judged_by_how_far_off_the_circle_it_gets(result, off, message, outcome):
    run = replace(result.runs["rotation"], largest_position_error=off, message=message)
    changed = replace(with_networks(result, rotation=GOOD, plane=GOOD), runs={**result.runs, "rotation": run})
    assert outcomes(changed)["rate-control-through-the-pose"] is outcome
    assert outcomes(changed)["jacobian-is-useful"] is outcome
    weak = with_networks(changed, rotation=WEAK, plane=GOOD)
    assert outcomes(weak)["jacobian-is-useful"] is not Outcome.REPRODUCED


def test_without_limits_or_tool_the_notions_are_one(result):
    neither = result.notions["neither"]
    assert neither.reachable == neither.total_orientation == neither.dexterous
    assert neither.mean_share == 1
    for name, notions in result.notions.items():
        assert notions.reachable >= notions.constant_orientation >= notions.dexterous
        assert (notions.mean_share < 1) == (name != "neither")


def test_the_exact_loop_stays_on_the_circle_and_ends_near_a_singularity(result):
    assert result.runs["exact, fourth order, ten times the step"].largest_position_error < 1e-4
    assert not result.runs["exact"].message
    assert "rad/s" in result.runs["exact, near a singularity"].message
    assert result.runs["exact"].jacobian_error == 0


def test_the_circle_is_in_the_range_of_the_networks():
    times = torch.linspace(0, study.CIRCLE.period, 50, dtype=torch.float64)
    assert maps.in_training_range(study.LINKS, study.CIRCLE(times).T_world_tool[:, :3, 3]).all()


def test_agreement_is_intersection_over_union():
    ours = Map(torch.tensor([True, True, False, False]), torch.tensor([0.1, 0.3, 0.0, 0.0]).double())
    exact = Map(torch.tensor([True, False, False, False]), torch.tensor([0.2, 0.0, 0.0, 0.0]).double())
    found = study._agreement(ours, exact)
    assert (found.reached, found.unreached, found.right) == (0.5, pytest.approx(2 / 3), 0.75)
    assert found.median_error == found.largest_error == pytest.approx(0.5)
    nothing = study._agreement(Map(~exact.reached, exact.manipulability), exact)
    assert nothing.median_error == np.inf
    assert not nothing.is_slight


def test_a_surface_is_what_has_a_neighbour_outside():
    grid = Grid.cube(1.0, 7)
    ball = grid.points().norm(dim=-1) < 0.8
    surface = study._surface(ball)
    inner = ball & ~surface
    assert not (surface & ~ball).any()
    assert inner[3, 3, 3]
    for axis in range(3):
        for step in (-1, 1):
            assert ball[tuple((inner.nonzero() + step * torch.eye(3, dtype=torch.int64)[axis]).T)].all()
    assert study._surface(torch.ones(3, 3, 3, dtype=torch.bool)).sum() == 26


def test_scenes_show_what_they_say(result):
    page = study.manipulability_scene(15)._repr_html_()
    assert page.count("w 0.0") >= 3
    assert "taken for" in study.difference_scene(result, "plane")._repr_html_()
    assert "rotation Jacobian" in study.tracking_scene(result)._repr_html_()


def test_tables_have_a_row_for_each(result):
    assert len(study.agreement_table(result)) == 4
    assert list(study.notion_table(result)) == ["neither", "limits", "tool", "limits and tool"]
    assert set(study.run_table(result)) == set(result.runs)


def test_the_links_are_the_papers_puma():
    start, reached = reachability.inverse(
        study.LINKS, study.CIRCLE(torch.zeros((), dtype=torch.float64)).T_world_tool
    )
    assert reached
    assert torch.equal(study.tracking_arm().screws, reachability.arm(study.LINKS).screws)
    assert start.shape == (6,)
