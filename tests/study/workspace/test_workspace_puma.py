"""The PUMA's maps, the five notions and the control loop, and what the verdicts go by."""

import numpy as np
import pytest
import torch

from dexterity.workspace import maps, reachability
from dexterity.workspace.maps import Map
from dexterity_study.claims.outcome import Outcome
from dexterity_study.engine.evidence import Evidence
from dexterity_study.engine.table import Table
from dexterity_study.workspace.puma import experiment as study
from dexterity_study.workspace.puma import show
from dexterity_study.workspace.puma.verdicts import verdicts


@pytest.fixture(scope="module")
def evidence() -> Evidence:
    return Evidence.smoke("workspace.puma")


def outcomes(evidence: Evidence, **changes: dict[str, float]) -> dict[str, Outcome]:
    """Return outcomes with other maps."""
    rows = evidence["learned"].rows.copy()
    for network, values in changes.items():
        where = rows["network"].eq(network) & rows["case"].isin((study.ALIGNED, study.RANDOM))
        rows.loc[where, list(values)] = list(values.values())
    tables = {name: evidence[name] for name in evidence}
    tables["learned"] = Table(rows, tables["learned"].keys, tables["learned"].arrays)
    return {one.claim: one.outcome for one in verdicts(Evidence("workspace.puma", tables))}


GOOD = {"reached": 0.99, "unreached": 0.96, "median_error": 0.04}
BLURRED, WEAK = GOOD | {"unreached": 0.94}, GOOD | {"median_error": 0.06}


@pytest.mark.parametrize(
    ("rotation", "plane", "workspace", "manipulability"),
    [
        (GOOD, GOOD, Outcome.REPRODUCED, Outcome.REPRODUCED),
        (BLURRED, GOOD, Outcome.IN_SHAPE, Outcome.REPRODUCED),
        (WEAK, BLURRED, Outcome.IN_SHAPE, Outcome.IN_SHAPE),
    ],
)
def test_maps_vary_slightly_as_the_ledger_has_it(evidence, rotation, plane, workspace, manipulability):
    found = outcomes(evidence, rotation=rotation, plane=plane)
    # Its figure is of the paper's own networks, for which no others stand.
    assert found["puma-maps-alike"] is Outcome.NOT_RUN
    assert found["workspace-from-jacobian"] is workspace
    assert found["manipulability-from-estimate"] is manipulability


def test_without_limits_or_tool_the_notions_are_one(evidence):
    rows = evidence["notions"].where().set_index("arm")
    neither = rows.loc["neither"]
    assert neither["reachable"] == neither["total_orientation"] == neither["dexterous"]
    assert neither["mean_share"] == 1
    assert (rows["mean_share"].iloc[1:] < 1).all()
    assert (rows["reachable"] >= rows["constant_orientation"]).all()
    assert (rows["constant_orientation"] >= rows["dexterous"]).all()


def test_the_exact_loop_stays_on_the_circle_and_ends_near_a_singularity(evidence):
    runs = evidence["loops"].where().set_index("case")
    assert runs.loc[study.FINE, "largest"] < 1e-4
    assert runs.loc[study.FEEDBACK, "ended"] == "on time"
    assert "rad/s" in runs.loc[study.SINGULAR, "ended"]
    assert runs.loc[study.FEEDBACK, "jacobian_error"] == 0


def test_the_circle_is_in_the_range_of_the_networks():
    times = torch.linspace(0, study.CIRCLE.period, 50, dtype=torch.float64)
    assert maps.in_training_range(study.LINKS, study.CIRCLE(times).T_world_tool[:, :3, 3]).all()
    start, reached = reachability.inverse(study.LINKS, study.CIRCLE(times[0]).T_world_tool)
    assert reached
    assert start.shape == (6,)


def test_agreement_is_intersection_over_union():
    ours = Map(torch.tensor([True, True, False, False]), torch.tensor([0.1, 0.3, 0.0, 0.0]).double())
    exact = Map(torch.tensor([True, False, False, False]), torch.tensor([0.2, 0.0, 0.0, 0.0]).double())
    found = study.agreement(ours, exact)
    assert (found["reached"], found["unreached"], found["right"]) == (0.5, pytest.approx(2 / 3), 0.75)
    assert found["median_error"] == found["largest_error"] == pytest.approx(0.5)
    assert study.agreement(Map(~exact.reached, exact.manipulability), exact)["median_error"] == np.inf


def test_the_border_error_is_the_wrong_volume_over_the_area_of_the_cylinder(monkeypatch):
    assert show.border_error(1.0) == 0
    # Everything in reach: the volume of the cylinder over its area is half its radius.
    d3, side = study.LINKS[0], 2 * maps.TRAINED_HALF_SIDE
    assert show.border_error(1 - np.pi * d3**2 / side**2) == pytest.approx(d3 / 2)
    monkeypatch.setattr(study, "LINKS", (0.15, 0.2, 0.2, 0.0203))
    with pytest.raises(ValueError, match="cuts more than the cylinder"):
        show.border_error(0.9)


def test_the_trivial_answer_stands_above_the_networks(evidence):
    html = show.agreement(evidence, evidence["learned"]).html
    assert html.index("everything in reach") < html.index("rotation matrix")


def test_scenes_show_what_they_say(evidence):
    assert show.manipulability_scene(15)._repr_html_().count("w 0.0") >= 3
    assert "rotation Jacobian" in show.tracking_scene(evidence)._repr_html_()
