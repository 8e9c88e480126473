"""What the chapter on the data of paper C shows, against the library's own answers."""

import numpy as np
import pytest
import torch
from torch.testing import assert_close

from dexterity.workspace import dataset
from dexterity_study.claims.ledger import load_paper
from dexterity_study.engine.evidence import Evidence
from dexterity_study.engine.table import Table
from dexterity_study.workspace.data import experiment, show, verdicts

PAPER = load_paper("liao2018")


@pytest.fixture(scope="module")
def evidence():
    made = {}
    for name in ("fanuc", "files", "rule", "influence"):
        one = getattr(experiment, name)
        made[name] = Table.joined([one(0, reading, **one.smoke) for reading in ("chosen", *one.readings)])
    return Evidence("workspace.data", made)


def test_the_fanuc_arm_has_every_printed_velocity():
    J = experiment.fanuc_arm().geometric_jacobian(torch.zeros(6))
    for claim, (joint, rows) in verdicts.VELOCITIES.items():
        printed = torch.tensor(PAPER.printed(claim), dtype=torch.float64).reshape(-1)
        assert_close(J[rows, joint], printed, rtol=0, atol=1e-12)


def test_one_printed_entry_is_impossible(evidence):
    printed = np.reshape(PAPER.printed("fanuc-rotation-difference"), (3, 3))
    pose = evidence["fanuc"].array("pose")[0]
    assert np.argwhere(np.abs(pose[:3, :3] - printed) > 1e-6).tolist() == [[1, 1]]
    # The derivative of a rotation at the identity is skew.
    np.testing.assert_allclose(pose[:3, :3], -pose[:3, :3].T, atol=1e-8)
    assert (printed != -printed.T).any()


def test_forward_differences_lose_as_their_step_and_central_ones_as_its_square(evidence):
    steps = evidence["fanuc"].array("steps")[0]
    coarse = (steps <= 1e-1) & (steps >= 1e-3)
    for kind, order in (("forward", 1), ("central", 2)):
        errors = evidence["fanuc"].array(kind)[0]
        slope = np.polyfit(np.log(steps[coarse]), np.log(errors[coarse]), 1)[0]
        assert slope == pytest.approx(order, abs=0.05)


def test_files_are_as_large_and_as_wide_as_printed(evidence):
    facts = evidence["files"].where(columns="all").set_index("file")
    assert tuple(facts["targets"]) == PAPER.printed("table-targets")
    assert tuple(facts["features"]) == PAPER.printed("table-features")
    assert tuple(facts["samples"][0::2]) == PAPER.printed("table-samples")[0::2]
    assert facts["is_binary"].tolist() == 4 * [True] + 4 * [False]
    for name, varying in (("jacob0", 21), ("jacob", 23)):
        assert set(facts.loc[[f"{name}, test", f"{name}, train"], "varying_targets"]) == {varying}


def test_the_sizes_of_the_whole_sets_are_those_of_table_1():
    sizes = [size for both in (*experiment.SIZES.values(), experiment.SIZES["jacob"]) for size in both]
    assert tuple(sizes) == PAPER.printed("table-samples")


def test_columns_stay_within_the_printed_ranges_and_fill_them(evidence):
    groups = evidence["files"].where(None).dropna(subset=["low"]).groupby("columns")
    for group in ("mass", "centre", "inertia", "viscous", "gear", "position"):
        low, high = PAPER.printed(f"{group}-range")
        least, most = groups.get_group(group)["low"], groups.get_group(group)["high"]
        assert low <= least.min()
        assert most.max() <= high
        assert (most - least).min() > 0.97 * (high - low)


def test_a_redraw_raises_the_share_in_reach_and_bends_the_distributions(evidence):
    shares = verdicts.in_reach(evidence)
    assert shares["redraw=0"] < 0.5 < shares["chosen"]
    position = verdicts.uniformity(evidence)["position"]
    assert position["labels, nothing redrawn"] < position["labels"] < position["Jacobians"]


def test_tests_and_trainings_are_drawn_alike():
    """The first Jacobians of a set are of arms that reach far; a split must not keep that order."""
    drawn = experiment.sets(0, share=0.02)
    reach = [drawn[f"jacob, {part}"][0].links[:, 1:].sum(1).mean() for part in ("test", "train")]
    assert_close(reach[0], reach[1], rtol=0, atol=0.02)
    in_order = dataset.jacobian_data(4_000, 0).samples.links[:, 1:].sum(1)
    assert in_order[:1000].mean() - in_order[-1000:].mean() > 0.02


def test_a_row_of_table_6_tells_the_share_in_reach():
    # Of 1000 poses 400 are in reach; 300 of these and 50 others are said to be.
    accuracy, precision, recall = (300 + 550) / 1000, 300 / 350, 300 / 400
    share = (1 - accuracy) / (1 - 2 * recall + recall / precision)
    assert share == pytest.approx(0.4)
    shares = verdicts.implied_shares()
    assert len(shares) == 15
    assert all(low < high for low, high in shares.values())
    low, high = shares["logistic regression"]
    assert low < (1 - 0.752) / (1 - 2 * 0.77 + 0.77 / 0.75) < high


def test_what_nothing_depends_on_has_no_influence(evidence):
    own = evidence["influence"].where().set_index("columns")
    assert own["label"]["three angles"] == 0
    for name in ("viscous", "coulomb"):
        assert own.loc[name, ["label", "jacobian", "kept"]].tolist() == [0, 0, 0]
    assert (own["kept"][["mass", "inertia", "gear"]] > 0).all()
    columns = ["d3", "d4", "a2", "a3", "x", "y", "z"]
    assert (own["label"][columns] > 0.1).all()
    assert (own["jacobian"][columns] > 0).all()


def test_the_influence_of_a_column_is_its_part_of_the_variance():
    # Of f = 2a + b with independent a and b of the same variance, four fifths need a.
    a, b, other = torch.rand(3, 200_000, generator=torch.Generator().manual_seed(0), dtype=torch.float64)
    share = experiment.needed((2 * a + b)[:, None], (2 * other + b)[:, None])
    assert share == pytest.approx(0.8, abs=0.01)


def test_a_map_keeps_clusters_apart():
    random = torch.Generator().manual_seed(2)
    rows = torch.rand(80, 3, generator=random, dtype=torch.float64)
    rows[:40, 0] += 10
    rows = torch.cat([rows, torch.ones(80, 1)], 1)
    points = experiment.embedded(rows, seed=0)
    assert points.shape == (80, 2)
    centres = points[:40].mean(0), points[40:].mean(0)
    assert np.linalg.norm(centres[0] - centres[1]) > points[:40].std(0).max()


def test_both_arms_of_the_scene_are_drawn_with_their_lengths():
    shown = show.family()._repr_html_()
    for links in show.ARMS.values():
        for name, length in zip(show.LENGTHS, links, strict=True):
            assert f"{name} = {length:g} m" in shown
