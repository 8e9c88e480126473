"""What the chapter on the data of paper C shows, against the package's own answers."""

import numpy as np
import pytest
import torch
from torch.testing import assert_close

from dexterity.report.claims import Outcome, load_paper
from dexterity.studies.workspace import data as study
from dexterity.workspace import dataset

PAPER = load_paper("liao2018")


@pytest.fixture(scope="module")
def result():
    return study.run(study.CONFIGS["smoke"])


def outcomes(result):
    return {verdict.claim: verdict.outcome for verdict in study.verdicts(result)}


def test_the_fanuc_arm_has_every_printed_velocity():
    J = study.fanuc().geometric_jacobian(torch.zeros(6))
    for joint, claim in ((0, "fanuc-first-velocity"), (1, "fanuc-second-velocity")):
        printed = torch.tensor(PAPER.claim(claim).value, dtype=torch.float64)
        assert_close(J[:3, joint], printed, rtol=0, atol=1e-12)
    assert_close(J[:3, 2], torch.tensor([1.06, 0, 0.1], dtype=torch.float64), rtol=0, atol=1e-12)
    assert_close(J[:3, 4], torch.tensor([0.1, 0, 0], dtype=torch.float64), rtol=0, atol=1e-12)


def test_one_printed_entry_is_impossible(result):
    assert outcomes(result)["fanuc-rotation-difference"] is Outcome.CONTRADICTED
    printed = np.reshape(PAPER.claim("fanuc-rotation-difference").value, (3, 3))
    off = np.abs(result.fanuc.pose[:3, :3] - printed) > 1e-6
    assert np.argwhere(off).tolist() == [[1, 1]]
    # The derivative of a rotation at the identity is skew.
    np.testing.assert_allclose(result.fanuc.pose[:3, :3], -result.fanuc.pose[:3, :3].T, atol=1e-8)
    assert (printed != -printed.T).any()


def test_forward_differences_lose_as_their_step_and_central_ones_as_its_square(result):
    steps, forward, central = result.fanuc.steps, result.fanuc.forward, result.fanuc.central
    coarse = (steps <= 1e-1) & (steps >= 1e-3)
    for errors, order in ((forward, 1), (central, 2)):
        slope = np.polyfit(np.log(steps[coarse]), np.log(errors[coarse]), 1)[0]
        assert slope == pytest.approx(order, abs=0.05)


def test_files_are_those_that_the_paper_lists(result):
    # The paper's listing, section IV: four prefixes, features and labels, test and training.
    stems = ["conf_{}", "conf_{}_dyna", "jacob_{}", "jacob0_{}"]
    listed = [
        f"{stem.format(kind)}_{part}.csv"
        for stem in stems
        for kind in ("feature", "label")
        for part in ("test", "train")
    ]
    assert result.names == tuple(sorted(listed))


def test_tables_come_out_as_printed(result):
    found = outcomes(result)
    claims = ("table-targets", "table-features", "table-kinds", "constant-columns", "link-range")
    assert {found[claim] for claim in claims} == {Outcome.REPRODUCED}
    for part in ("test", "train"):
        assert result.files[f"jacob0, {part}"].varying_targets == 21
        assert result.files[f"jacob, {part}"].varying_targets == 23
    tests = [result.files[f"{name}, test"].samples for name in ("conf", "conf_dyna", "jacob", "jacob0")]
    assert tuple(tests) == PAPER.claim("table-samples").value[0::2]


def test_a_range_that_is_left_or_not_filled_is_not_reproduced(result):
    file = result.files["conf, train"]
    for edges in ((-0.01, 0.5), (0.1, 0.5)):
        changed = study.File(**{**vars(file), "ranges": {**file.ranges, "links": edges}})
        files = {**result.files, "conf, train": changed}
        other = study.Result(**{**vars(result), "files": files})
        assert outcomes(other)["link-range"] is Outcome.NOT_REPRODUCED


def test_a_row_of_table_6_tells_the_share_in_reach():
    # Of 1000 poses 400 are in reach; 300 of these and 50 others are said to be.
    accuracy, precision, recall = (300 + 550) / 1000, 300 / 350, 300 / 400
    share = (1 - accuracy) / (1 - 2 * recall + recall / precision)
    assert share == pytest.approx(0.4)
    shares = study.implied_shares()
    assert len(shares) == 15
    assert all(low < high for low, high in shares.values())
    low, high = shares["logistic regression"]
    assert low < (1 - 0.752) / (1 - 2 * 0.77 + 0.77 / 0.75) < high


def test_what_nothing_depends_on_has_no_influence(result):
    own = result.influences
    assert own["three angles"].label == 0
    for name in ("viscous", "coulomb"):
        assert (own[name].label, own[name].jacobian, own[name].kept) == (0, 0, 0)
    for name in ("mass", "inertia", "gear"):
        assert own[name].kept > 0
    for name in ("d3", "d4", "a2", "a3", "x", "y", "z"):
        assert own[name].label > 0.1
        assert own[name].jacobian > 0
    assert own["d3"].bits > 10 * abs(own["three angles"].bits)


def test_the_influence_of_a_column_is_its_part_of_the_variance():
    # Of f = 2a + b with independent a and b of the same variance, four fifths need a.
    a, b, other = torch.rand(3, 200_000, generator=torch.Generator().manual_seed(0), dtype=torch.float64)
    needed = study._needed((2 * a + b)[:, None], (2 * other + b)[:, None])
    assert needed == pytest.approx(0.8, abs=0.01)


def test_bits_of_a_label_that_is_a_column_and_of_noise():
    random = torch.Generator().manual_seed(1)
    column, noise = torch.rand(2, 20_000, generator=random, dtype=torch.float64)
    label = column > 0.5
    assert study._bits(column[:, None], label) == pytest.approx(1, abs=0.01)
    assert study._bits(noise[:, None], label) == pytest.approx(0, abs=0.002)


def test_a_map_keeps_clusters_apart_and_comes_out_again():
    random = torch.Generator().manual_seed(2)
    rows = torch.rand(80, 3, generator=random, dtype=torch.float64)
    rows[:40, 0] += 10
    rows = torch.cat([rows, torch.ones(80, 1)], 1)
    points = study.embedded(rows, seed=0)
    assert points.shape == (80, 2)
    centres = points[:40].mean(0), points[40:].mean(0)
    spread = points[:40].std(0).max()
    assert np.linalg.norm(centres[0] - centres[1]) > spread
    np.testing.assert_array_equal(points, study.embedded(rows, seed=0))


def test_tests_and_trainings_are_drawn_alike():
    """The first Jacobians of a set are of arms that reach far; a split must not keep that order."""
    config = study.Config(share=0.05)
    test, train = study._sets(config)
    reach = [own.jacob.samples.links[:, 1:].sum(1).mean() for own in (test, train)]
    assert_close(reach[0], reach[1], rtol=0, atol=0.02)
    in_order = dataset.jacobian_data(4_000, 0).samples.links[:, 1:].sum(1)
    assert in_order[:1000].mean() - in_order[-1000:].mean() > 0.02
