"""Reach maps: parts, files, and maps that contradict themselves."""

import dataclasses
import math

import pytest
import torch
from torch.testing import assert_close

import dexterity as dx
from dexterity import reach, sealed, spatial

PUMA = dx.robots.puma560()
GRID = reach.box([-0.6, 0.0, -0.4], [0.6, 0.6, 0.8], spacing=0.4)
TURNS = reach.rotations(24)
MAP = reach.survey(PUMA, GRID, TURNS, index="w")


def same(one: reach.ReachMap, other: reach.ReachMap) -> None:
    for field in dataclasses.fields(one):
        a, b = (getattr(each, field.name) for each in (one, other))
        if isinstance(a, torch.Tensor):
            assert_close(a, b, rtol=0, atol=0, equal_nan=True)
        elif field.name != "chain":
            assert a == b


def test_a_saved_map_comes_back(tmp_path):
    MAP.save(tmp_path / "a" / "map.npz")
    loaded = reach.ReachMap.load(tmp_path / "a" / "map.npz")
    same(loaded, MAP)
    assert loaded.chain.joint_names == PUMA.joint_names
    assert_close(loaded.chain.screws, PUMA.screws)
    loaded.save(tmp_path / "again.npz")
    assert (tmp_path / "again.npz").read_bytes() == (tmp_path / "a" / "map.npz").read_bytes()


@pytest.mark.parametrize("frame", ["body", "geometric"])
@pytest.mark.parametrize("rows", ["translational", ("vx", "vy", "vz", "wx", "wy"), ("vx", "wz")])
def test_maps_of_some_rows_and_sampled_ones_come_back(rows, frame, tmp_path):
    some = reach.survey(PUMA, GRID[:6], TURNS[:3], rows=rows, frame=frame, starts=2)
    assert some.reached.any()
    some.save(tmp_path / "map.npz")
    same(reach.ReachMap.load(tmp_path / "map.npz"), some)
    drawn = reach.survey(PUMA, GRID, TURNS, method="sampling", draws=1000)
    drawn.save(tmp_path / "drawn.npz")
    same(reach.ReachMap.load(tmp_path / "drawn.npz"), drawn)


def altered(tmp_path, header=None, arrays=None):
    """Return a file whose checksum is right and whose content is not."""
    MAP.save(tmp_path / "map.npz")
    old_header, old_arrays = sealed.unpacked((tmp_path / "map.npz").read_bytes(), "reach map")
    content = sealed.packed("reach map", old_header | (header or {}), old_arrays | (arrays or {}))
    (tmp_path / "map.npz").write_bytes(content)
    return tmp_path / "map.npz"


def moved() -> torch.Tensor:
    q = MAP.configurations.clone()
    q[MAP.reached.nonzero()[0, 0], MAP.reached.nonzero()[0, 1], 1] += 1e-3
    return q


@pytest.mark.parametrize(
    ("header", "arrays", "message"),
    [
        ({}, {"configurations": moved().numpy()}, "misses the pose"),
        ({}, {"reached": torch.ones_like(MAP.reached).numpy()}, "without a configuration"),
        ({}, {"upper": PUMA.lower.numpy() + 0.1}, "leaves the limits"),
        ({}, {"best": MAP.best.flip(0).numpy()}, "without an index"),
        ({}, {"count": MAP.count.double().numpy()}, "count is torch.float64"),
        ({}, {"count": MAP.count.numpy()[1:]}, "count has shape"),
        ({}, {"positions": MAP.positions.numpy() + 0.01}, "misses the pose"),
        ({}, {"rotations": 1.1 * MAP.rotations.numpy()}, "misses orthonormality"),
        ({"version": 3}, {}, "version 3"),
        ({"format": "other"}, {}, "'other'"),
        ({"rows": [7]}, {}, "rows is 7"),
        ({"frame": "spatial"}, {}, "frame is 'spatial'"),
        ({"joint_names": ["one"]}, {}, "joint_names"),
        ({"missed": {"estimate": -1.0, "upper": None, "share": None, "basis": "x"}}, {}, "estimate is -1"),
        ({"missed": 3}, {}, "holds no reach map"),
    ],
)
@pytest.mark.usefixtures("annotations_unchecked")
def test_files_that_contradict_themselves_are_refused(header, arrays, message, tmp_path):
    with pytest.raises(reach.ReachMapFileError, match=message):
        reach.ReachMap.load(altered(tmp_path, header, arrays))


def test_damaged_and_missing_files_are_refused(tmp_path):
    MAP.save(tmp_path / "map.npz")
    content = (tmp_path / "map.npz").read_bytes()
    (tmp_path / "map.npz").write_bytes(content[:-100])
    with pytest.raises(reach.ReachMapFileError, match="its end is missing"):
        reach.ReachMap.load(tmp_path / "map.npz")
    with pytest.raises(FileNotFoundError):
        reach.ReachMap.load(tmp_path / "none.npz")


def test_parts_are_those_of_the_whole():
    plane = MAP.slice("z", 0.05)
    assert_close(plane.positions[:, 2], torch.zeros(len(plane.positions), dtype=torch.float64))
    assert len(plane.positions) == 4 * 3
    chosen = MAP.where(MAP.dexterous | (MAP.share > 0.5))
    assert (chosen.share > 0.5).all()
    assert_close(MAP.where([3, 5]).best, MAP.best[[3, 5]], equal_nan=True)
    with pytest.raises(ValueError, match="positions chooses 0"):
        MAP.where(MAP.share > 2)
    with pytest.raises(ValueError, match="axis is 'w'"):
        MAP.slice("w", 0.0)


def test_what_a_map_says():
    summary = MAP.summary()
    assert summary["poses reached"] == int(MAP.reached.sum())
    assert summary["best index"] == pytest.approx(float(MAP.best[MAP.reached].max()))
    assert "closed form" in str(MAP)
    assert repr(MAP).startswith("ReachMap('puma560', 48 positions × 24 rotations, closed form")
    reached = MAP.reached.any(1)
    assert_close(MAP.best_at_position[reached], MAP.best.nan_to_num(nan=0.0).amax(1)[reached])
    assert MAP.best_at_position[~reached].isnan().all()
    assert_close(MAP.capability, MAP.best.nan_to_num(nan=0.0).mean(1))


def test_the_nearest_pose():
    turn = spatial.exp([0, 0, 0, 0.1, 0.0, 0.0])
    T = MAP.poses()[7, 11] @ turn
    T[:3, 3] += torch.tensor([0.05, 0.0, 0.0])
    near = MAP.nearest(T)
    assert (int(near.position), int(near.rotation)) == (7, 11)
    assert float(near.distance) == pytest.approx(0.05)
    assert float(near.angle) == pytest.approx(0.1)


@pytest.mark.usefixtures("annotations_unchecked")
def test_a_map_that_contradicts_itself_cannot_be_made():
    with pytest.raises(ValueError, match="reached and not examined"):
        dataclasses.replace(MAP, examined=torch.zeros_like(MAP.examined))
    with pytest.raises(ValueError, match="hits has shape"):
        dataclasses.replace(MAP, hits=MAP.hits[1:])
    best = MAP.best.clone()
    best[MAP.reached] = math.nan
    with pytest.raises(ValueError, match="without an index"):
        dataclasses.replace(MAP, best=best)
