"""Samples of reach maps, placements, scenes, measured times."""

from __future__ import annotations

from functools import cache

import numpy as np
import pandas as pd
from good_values import UNIT, VECTOR, Arguments, Q, folder, of, planar, puma

import dexterity as dx
from dexterity import indices, reach, scenes, timing


@cache
def reach_map() -> reach.ReachMap:
    return reach.survey(
        planar(), [[1.2, 0.8, 0.0], [0.3, 0.2, 0.0]], reach.rotations(20), rows=(0, 1), starts=2
    )


@cache
def T() -> np.ndarray:
    return planar().forward([0.3, 0.4]).numpy()


@cache
def placements() -> reach.Placements:
    return reach.place(
        planar(), T()[None], np.eye(4)[None], planar_index(), rows=(0, 1), refine=False, starts=2
    )


@cache
def planar_index() -> dx.Index:
    return dx.Index("manipulability", "geometric", rows=(0, 1))


@cache
def ellipsoid() -> indices.Ellipsoid:
    return indices.velocity_ellipsoid(puma().geometric_jacobian(Q), "translational")


@cache
def saved() -> str:
    path = folder() / "map.npz"
    reach_map().save(path)
    return str(path)


@cache
def table() -> pd.DataFrame:
    timings = [timing.Timing("exact", 1, 1.0, 2.0, 3.0), timing.Timing("network", 1, 1.0, 2.0, 3.0)]
    return timing.table(timings, "exact")


def scene() -> scenes.Scene:
    """Return a scene with an arm and bars to add to."""
    drawn = scenes.Scene("An arm")
    drawn.add_chain(puma(), Q, name="arm")
    drawn.add_bars("bars", np.arange(12.0).reshape(2, 2, 3))
    return drawn


def times(median: float = 2.0) -> timing.Timing:
    return timing.Timing("exact", 1, 1.0, median, 3.0)


SAMPLES: dict[str, Arguments] = {
    # ---- reach ----
    "reach.ball": of(centre=VECTOR, radius=0.3, spacing=0.2),
    "reach.bounds": of(chain=puma),
    "reach.box": of(lower=np.zeros(3), upper=np.ones(3), spacing=0.5),
    "reach.covering_radius": of(rotations=lambda: reach.rotations(20).numpy()),
    "reach.rotations": of(count=20),
    "reach.rotations (by spacing)": of(spacing=1.5),
    "reach.panel": of(
        centre=VECTOR,
        normal=UNIT,
        width=0.2,
        height=0.3,
        columns=2,
        rows=2,
        up=np.array([1.0, 0, 0]),
        standoff=0.1,
        roll=0.1,
    ),
    "reach.follow": of(
        chain=planar,
        poses=lambda: T()[None],
        largest_step=0.5,
        index=planar_index,
        rows=(0, 1),
        starts=2,
        limit_tolerance=1e-9,
        seed=0,
    ),
    "reach.place": of(
        chain=planar,
        poses=lambda: T()[None],
        bases=np.eye(4)[None],
        index=planar_index,
        by="worst",
        method="auto",
        rows=(0, 1),
        starts=2,
        limit_tolerance=1e-9,
        refine=False,
        seed=0,
        threads=1,
        progress=False,
    ),
    "reach.planar_bases": of(x=np.array([0.0, 1.0]), y=np.array([0.0, 1.0]), yaw=np.array([0.0]), height=0.1),
    "reach.pointing": of(direction=np.array([1.0, 0, 0]), roll=0.1, up=UNIT),
    "reach.seam": of(start=VECTOR, end=2 * VECTOR, count=3, tool_rotation=np.eye(3)),
    "reach.survey": of(
        chain=planar,
        positions=np.array([[1.2, 0.8, 0.0]]),
        rotations=np.eye(3)[None],
        index=planar_index,
        method="auto",
        rows=(0, 1),
        starts=2,
        draws=8,
        cell=(0.1, 0.1),
        limit_tolerance=1e-9,
        seed=0,
        threads=1,
        progress=False,
    ),
    "reach.ReachMap.where": of(self=reach_map, positions=(0, 1)),
    "reach.ReachMap.slice": of(self=reach_map, axis="z", value=0.0),
    "reach.ReachMap.nearest": of(self=reach_map, T_world_tool=T),
    "reach.ReachMap.compared": of(self=reach_map, other=reach_map),
    "reach.ReachMap.save": of(self=reach_map, path=lambda: folder() / "again.npz"),
    "reach.ReachMap.load": of(path=saved),
    "reach.InverseReachMap": of(forward=reach_map),
    "reach.InverseReachMap.bases": of(
        self=lambda: reach.InverseReachMap(reach_map()), T_world_tool=T, largest_tilt=3.0
    ),
    "reach.InverseReachMap.estimate": of(
        self=lambda: reach.InverseReachMap(reach_map()),
        T_world_tool=lambda: T()[None],
        bases=np.eye(4)[None],
        largest_distance=3.0,
        largest_angle=3.0,
    ),
    "reach.Placements.candidate": of(self=placements, number=0),
    "reach.Placements.table": of(self=placements, count=1),
    "reach.Placements.to_csv": of(self=placements, path=lambda: folder() / "bases.csv"),
    # ---- scenes ----
    "scenes.Scene": of(title="An arm", height=300, view_from=np.array([1.0, 0.5, 0.5])),
    "scenes.Scene.add_chain": of(
        self=lambda: scenes.Scene("An arm"), chain=puma, q=Q, name="arm", color="blue"
    ),
    "scenes.Scene.add_mechanism": of(
        self=lambda: scenes.Scene("A mechanism"),
        bodies=(
            scenes.Body("crank", rods=np.eye(3)[None, :2], arrows=np.eye(3), ball=0.1, stretches=np.ones(3)),
        ),
        sliders=(),
        name="mechanism",
        pose=np.eye(4),
    ),
    "scenes.Scene.add_box": of(self=scene, size=np.ones(3), on="arm", joint=6, pose=np.eye(4), name="box"),
    "scenes.Scene.add_ellipsoid": of(
        self=scene, ellipsoid=ellipsoid, center=VECTOR, name="ellipsoid", scale=1.0
    ),
    "scenes.Scene.add_path": of(self=scene, points=np.eye(3), name="path", color="blue"),
    "scenes.Scene.add_points": of(self=scene, points=np.eye(3), name="points", size=0.1, color="blue"),
    "scenes.Scene.add_letters": of(self=scene, points=lambda: {"A": VECTOR}, name="letters"),
    "scenes.Scene.add_bars": of(
        self=scene, name="more bars", ends=np.arange(12.0).reshape(2, 2, 3), radius=0.1, color="blue"
    ),
    "scenes.Scene.animate": of(self=scene, name="arm", q_frames=np.stack([Q, 2 * Q]), frames_per_second=24.0),
    "scenes.Scene.add_sliders": of(self=scene, name="arm"),
    "scenes.Scene.animate_bars": of(
        self=scene, name="bars", frames=np.arange(24.0).reshape(2, 2, 2, 3), frames_per_second=24.0
    ),
    "scenes.Scene.add_remark": of(self=scene, text="Drawn larger"),
    "scenes.Scene.look_at": of(self=scene, low=np.zeros(3), high=np.ones(3)),
    "scenes.copy_viewer": of(folder=lambda: folder() / "viewer"),
    "scenes.side_by_side": of(scenes=scene),
    "scenes.standalone": of(shown="<p>So.</p>"),
    # ---- timing ----
    "timing.Timing": of(name="exact", configurations=1, lower=1.0, median=2.0, upper=3.0),
    "timing.Timing.from_times": of(name="exact", configurations=1, times=(1.0, 2.0, 3.0)),
    "timing.conditions": of(distributions="numpy"),
    "timing.versions": of(distributions="numpy"),
    "timing.measure": of(
        ways=lambda: (timing.Way("nothing", lambda: None, 1),), rounds=1, seconds=1e-4, clock=lambda: _clock
    ),
    "timing.ratio": of(timing=times, reference=times),
    "timing.readable": of(table=table),
    "timing.table": of(
        timings=lambda: (times(), timing.Timing("network", 1, 1.0, 2.0, 3.0)), reference="exact"
    ),
    "timing.to_csv": of(table=table, conditions=lambda: {"processor": "some"}),
    "timing.to_markdown": of(table=table, conditions=lambda: {"processor": "some"}, title="Times"),
    "timing.write": of(
        stem=lambda: folder() / "times", table=table, conditions=lambda: {"processor": "some"}, title="Times"
    ),
}


def _clock() -> float:
    from time import perf_counter

    return perf_counter()
