"""Sets of paper C: who is in them, their columns, their files."""

import math
import subprocess
from pathlib import Path

import joblib
import numpy as np
import pytest
import torch
from scipy.spatial.transform import Rotation
from torch.testing import assert_close

from dexterity import spatial
from dexterity.workspace import dataset, dynamics, reachability
from dexterity.workspace.dataset import Scaling


def same(one, other) -> bool:
    if one is None or other is None:
        return one is other
    if isinstance(one, torch.Tensor):
        return torch.equal(one, other)
    return all(map(same, one, other))


def test_labels_are_the_rule():
    samples, reach = dataset.confidence_data(5_000, 1)
    assert torch.equal(reach, reachability.reachable(samples.links, samples.position))
    assert (samples.links.amin(), samples.links.amax()) >= (0, 0)
    assert samples.links.max() <= dataset.LARGEST_LENGTH
    assert samples.position.abs().max() <= 0.4
    assert 0 <= samples.angles.min() <= samples.angles.max() <= math.tau


def test_redrawing_raises_the_share_in_reach_as_it_must():
    plain = dataset.confidence_data(100_000, 2, redraw=0.0).reachable.double().mean().item()
    redrawn = dataset.confidence_data(100_000, 2).reachable.double().mean().item()
    assert plain == pytest.approx(0.421, abs=0.01)
    # Links are not redrawn, so an arm that reaches little stays: less than p / (1 − 0.75 (1 − p)) is gained.
    assert plain + 0.1 < redrawn < plain / (1 - 0.75 * (1 - plain))


@pytest.mark.parametrize("dynamic", [False, True])
def test_a_set_is_the_same_for_any_number_of_workers(monkeypatch, dynamic):
    monkeypatch.setattr(dataset, "_CHUNK", 50)
    for draw in (dataset.confidence_data, dataset.jacobian_data):
        one = draw(120, 7, dynamics=dynamic)
        with joblib.parallel_config(backend="threading"):
            assert same(one, draw(120, 7, dynamics=dynamic, workers=2))
        assert not same(one, draw(120, 8, dynamics=dynamic))
        assert len(one.samples.links) == 120


def test_jacobians_are_those_of_the_named_branch_and_kept_poses_are_even_enough():
    data = dataset.jacobian_data(400, 3)
    q, reach = reachability.inverse(
        data.samples.links, spatial.pose(data.samples.rotation(), data.samples.position)
    )
    assert reach.all()
    assert_close(data.jacobian, reachability.geometric_jacobian(data.samples.links, q), rtol=0, atol=1e-14)
    ratio = dynamics.asada_ratio(data.samples.links, data.samples.dynamics, q)
    assert ratio.min() > 0.03
    tool = data.in_frame("tool")
    assert_close(tool, reachability.body_jacobian(data.samples.links, q), rtol=0, atol=1e-14)


def test_rotation_is_about_x_then_the_new_y_then_the_new_z():
    angles = 6 * torch.rand(10, 3, generator=torch.Generator().manual_seed(0), dtype=torch.float64)
    theirs = Rotation.from_euler("XYZ", angles.numpy()).as_matrix()
    assert_close(dataset.rotation(angles), torch.as_tensor(theirs), rtol=0, atol=1e-14)


def test_columns_are_the_papers():
    data = dataset.jacobian_data(500, 0)
    x = dataset.features(data.samples)
    assert x.shape == (500, 96)
    assert tuple((x.amax(0) == x.amin(0)).nonzero()[:, 0].tolist()) == dataset.CONSTANT_COLUMNS
    for column, link in zip((2, 3, 7, 8), data.samples.links.unbind(-1), strict=True):
        assert torch.equal(x[:, column], link)
    for name, columns in dataset.COLUMNS.items():
        part = getattr(data.samples.dynamics, name, None)
        if part is not None:
            assert torch.equal(x[:, columns], part.flatten(1))
    backwards = x[:, dataset.COLUMNS["coulomb"]][:, 1::2]
    assert backwards.max() <= 0
    plain = dataset.features(dataset.confidence_data(10, 0).samples)
    assert plain.shape == (10, 24)
    # The smallest width that holds all columns is the whole.
    assert max(columns.stop for columns in dataset.KINEMATIC_COLUMNS.values()) == 24
    assert max(columns.stop for columns in dataset.COLUMNS.values()) == 96


def test_scaling_is_that_of_the_training_part():
    train = dataset.features(dataset.confidence_data(300, 0).samples)
    fresh = dataset.features(dataset.confidence_data(300, 1).samples)
    by_deviation, by_range = Scaling.to_unit_deviation(train), Scaling.to_range(train)
    scaled = by_deviation.apply(train)
    varying = train.amax(0) > train.amin(0)
    assert_close(scaled.mean(0), torch.zeros(24).double(), atol=1e-12, rtol=0)
    assert_close(scaled.std(0, correction=0)[varying], torch.ones(10).double())
    assert scaled[:, ~varying].abs().max() < 1e-12
    ranged = by_range.apply(train)
    assert_close(ranged[:, varying].amax(0), torch.ones(10).double())
    assert_close(ranged[:, varying].amin(0), -torch.ones(10).double())
    assert by_range.apply(fresh).abs().max() > 1
    assert_close(by_range.undo(by_range.apply(fresh)), fresh)


@pytest.mark.parametrize(("frame", "prefix"), [("tool", "jacob"), ("world", "jacob0")])
def test_files_have_the_papers_names_and_hold_the_numbers(tmp_path, frame, prefix):
    train, test = (dataset.jacobian_data(30, seed) for seed in (0, 1))
    dataset.write_csv(tmp_path / "new", train, test, frame)
    names = sorted(path.name for path in (tmp_path / "new").iterdir())
    files = [f"{prefix}_{kind}_{part}.csv" for kind in ("feature", "label") for part in ("test", "train")]
    assert names == sorted([*files, f"{prefix}.sha256"])
    x = np.loadtxt(tmp_path / "new" / f"{prefix}_feature_train.csv", delimiter=",")
    np.testing.assert_array_equal(x, dataset.features(train.samples).numpy())
    y = np.loadtxt(tmp_path / "new" / f"{prefix}_label_test.csv", delimiter=",")
    np.testing.assert_array_equal(y.reshape(-1, 6, 6), test.in_frame(frame).numpy())


def test_files_of_labels(tmp_path):
    train, test = (dataset.confidence_data(30, seed, dynamics=True) for seed in (0, 1))
    written = dataset.write_csv(tmp_path, train, test)
    assert [path.name for path in written] == [
        "conf_feature_dyna_test.csv",
        "conf_label_dyna_test.csv",
        "conf_feature_dyna_train.csv",
        "conf_label_dyna_train.csv",
    ]
    np.testing.assert_array_equal(np.loadtxt(written[3]), train.reachable.numpy())
    with pytest.raises(ValueError, match="different kinds"):
        dataset.write_csv(tmp_path, train, dataset.confidence_data(30, 0))


@pytest.mark.parametrize(
    ("draw", "options", "message"),
    [
        (dataset.confidence_data, {"count": 0}, "count is 0"),
        (dataset.confidence_data, {"count": 5, "redraw": 1.0}, "redraw is 1.0"),
        (dataset.jacobian_data, {"count": 5, "poses": 0}, "poses is 0"),
        (dataset.jacobian_data, {"count": 5, "threshold": 1.0}, "threshold is 1.0"),
        (dataset.jacobian_data, {"count": -1}, "count is -1"),
    ],
)
def test_bad_input_is_named(draw, options, message):
    with pytest.raises(ValueError, match=message):
        draw(seed=0, **options)


def test_three_angles_are_needed():
    with pytest.raises(ValueError, match=r"angles has shape \(2,\)"):
        dataset.rotation([0.0, 1.0])


@pytest.mark.parametrize("kind", [0, 1, 2, 3, 4])
def test_a_set_that_was_stopped_halfway_is_not_read(tmp_path, kind, monkeypatch):
    older, newer = (dataset.confidence_data(20, seed) for seed in (0, 1))
    dataset.write_csv(tmp_path, older, older)
    read = dataset.read_csv(tmp_path, "conf")
    np.testing.assert_array_equal(read["train"][0], dataset.features(older.samples).numpy())
    np.testing.assert_array_equal(read["test"][1][:, 0], older.reachable.numpy())
    replace, replaced = Path.replace, []

    def replace_or_stop(path, target):
        if len(replaced) == kind:
            raise KeyboardInterrupt
        replaced.append(target)
        return replace(path, target)

    monkeypatch.setattr(Path, "replace", replace_or_stop)
    with pytest.raises(KeyboardInterrupt):
        dataset.write_csv(tmp_path, newer, newer)
    with pytest.raises(FileNotFoundError, match=r"conf\.sha256"):
        dataset.read_csv(tmp_path, "conf")


def test_files_of_two_sets_are_not_read_as_one(tmp_path):
    older, newer = (dataset.jacobian_data(20, seed, dynamics=False) for seed in (0, 1))
    dataset.write_csv(tmp_path / "a", older, older)
    dataset.write_csv(tmp_path / "b", newer, newer)
    (tmp_path / "b" / "jacob_label_test.csv").replace(tmp_path / "a" / "jacob_label_test.csv")
    with pytest.raises(ValueError, match=r"jacob_label_test\.csv is not the file"):
        dataset.read_csv(tmp_path / "a", "jacob")
    (tmp_path / "a" / "jacob.sha256").write_text("0  ../jacob_label_test.csv\n")
    with pytest.raises(ValueError, match="no list of checksums"):
        dataset.read_csv(tmp_path / "a", "jacob")


def test_sha256sum_knows_the_list(tmp_path):
    data = dataset.confidence_data(5, 0)
    dataset.write_csv(tmp_path, data, data)
    subprocess.run(["sha256sum", "--check", "--quiet", "conf.sha256"], cwd=tmp_path, check=True)


def test_a_threshold_that_no_pose_passes_ends():
    with pytest.raises(ValueError, match=r"^threshold is 0\.99; of \d+ poses none"):
        dataset.jacobian_data(100, 0, threshold=0.99)


@pytest.mark.usefixtures("annotations_unchecked")
@pytest.mark.parametrize("draw", [dataset.confidence_data, dataset.jacobian_data])
@pytest.mark.parametrize("argument", ["count", "seed", "dynamics", "workers"])
@pytest.mark.parametrize("value", [math.nan, 2.5, "3", None, np.ones(2)])
def test_what_is_no_number_is_named(draw, argument, value):
    with pytest.raises((TypeError, ValueError), match=f"^{argument} is "):
        draw(**{"count": 3, "seed": 0, argument: value})


@pytest.mark.usefixtures("annotations_unchecked")
def test_numbers_of_numpy_are_taken():
    one, other = dataset.confidence_data(np.int32(5), np.uint8(1)), dataset.confidence_data(5, 1)
    assert torch.equal(one.samples.links, other.samples.links)


@pytest.mark.usefixtures("annotations_unchecked")
def test_a_frame_that_is_none_is_named(tmp_path):
    data = dataset.jacobian_data(5, 0, dynamics=False)
    with pytest.raises(ValueError, match=r"^frame is 'x'"):
        dataset.write_csv(tmp_path, data, data, "x")
    with pytest.raises(TypeError, match=r"^test is None"):
        dataset.write_csv(tmp_path, data, None)
    assert not list(tmp_path.iterdir())
