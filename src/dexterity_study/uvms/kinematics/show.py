"""Figures, tables and scenes of the chapter on the kinematics."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import torch
from matplotlib.figure import Figure
from scipy.optimize import linear_sum_assignment
from torch import Tensor

from dexterity import robots, scenes, spatial
from dexterity.chain import Chain
from dexterity.indices import Index
from dexterity.scenes import Body, Slider
from dexterity_study.engine.evidence import Evidence
from dexterity_study.engine.table import Table
from dexterity_study.page import figures
from dexterity_study.page.markup import Markup
from dexterity_study.page.tables import over_seeds, show, stored_and_live
from dexterity_study.uvms.kinematics import experiment

ELBOW, THETA_X = 8, 3
"""The joint whose column is drawn, and the first rotation of the vehicle."""

SEEDS = 10

POSTURE = torch.tensor([0.35, -1.3, 0.0, 0.0, 0.0, 0.0, 0.0, 0.6, -1.3, 0.0, 0.5, 0.0], dtype=torch.float64)
"""A posture with the world's origin outside of the vehicle and off the arm."""

LOW, VIEW = 240, (1.0, 0.35, 0.4)
"""Height of a scene of the derivation [CSS pixels], and from where it is seen."""

HALF = 0.5
"""Length of an arrow for 1 m/s [m]."""

ELLIPSOID = 0.2
"""Length of a semi-axis for 1 m/s [m]."""


def screws(chain: Chain) -> Markup:
    """Set the screws of a chain, its joints under the paper's symbols and under their names."""
    symbols = pd.Index([rf"$\theta_{{{n}}}$" for n in range(1, chain.joints + 1)], name="paper")
    frame = pd.DataFrame(
        chain.screws.numpy(), symbols, ["$v_x$", "$v_y$", "$v_z$", "$ω_x$", "$ω_y$", "$ω_z$"]
    )
    frame.insert(0, "name", chain.joint_names)
    return show(frame, "{:.2f}")


def vehicle_scene(title: str, q: Tensor, *, axes: bool = True, **options: Any) -> scenes.Scene:
    """Set the vehicle with its arm in a configuration, and the box of its body; options are those of a scene."""
    scene = scenes.Scene(title, **options)
    scene.add_chain(robots.uvms(), q, name="uvms", axes=axes)
    scene.add_box(robots.describe("uvms").vehicle_size or (), on="uvms", joint=6, name="vehicle")
    return scene


def reference_scene() -> scenes.Scene:
    """Set the vehicle at its reference configuration, with a slider for each joint."""
    scene = vehicle_scene("The UVMS at its reference configuration, with sliders", torch.zeros(12))
    scene.add_sliders("uvms")
    return scene


def deviations(stored: Table, live: Table) -> Markup:
    """Set the largest deviations, with their range over the stored seeds, and of one live run."""
    titles = {
        "forward": "tool pose − scipy.linalg.expm",
        "spatial": "spatial Jacobian − central differences",
        "body": "body Jacobian − central differences",
        "geometric": "geometric Jacobian − central differences",
        "printed": "Eq. 6 as printed − spatial Jacobian",
        "spatial_last_joint": "spatial Jacobian, last joint turned",
        "body_last_joint": "body Jacobian, last joint turned",
    }
    return show(stored_and_live(stored.where(), live.where(), titles, "{:.0e}"))


def changes_of_w(stored: Evidence) -> Figure:
    """Draw by how much each joint alone changes w, for three sets of velocity limits."""
    sets = {
        "unit": "chosen",
        "slow vehicle": "velocity-limits=rov",
        "slow z": "velocity-limits=slow-heave",
    }
    return changes_by_joint(stored["changes_of_w"], "w", "velocity limits", sets)


def changes_by_joint(table: Table, index: str, legend: str, readings: Mapping[str, str]) -> Figure:
    """Draw by how much each joint alone changes an index, for some readings by their titles."""
    fig, ax = plt.subplots(figsize=(figures.WIDTH, 2.8))
    shifts = np.linspace(-0.2, 0.2, len(readings))
    for shift, (title, reading) in zip(shifts, readings.items(), strict=True):
        change = table.where(reading).groupby("joint")["change"].max()
        ax.plot(np.arange(12) + shift, np.maximum(change, 1e-17), "o", label=title)
    ax.axhspan(1e-17, 1e-13, color="#E6E6E6", zorder=0)
    ax.set(yscale="log", ylim=(1e-17, 10), ylabel=f"largest relative change of {index}")
    ax.set_xticks(range(12), robots.uvms().joint_names, rotation=60)
    ax.set(xlabel="joint that is redrawn")
    fig.legend(title=legend, loc="outside upper center", ncols=len(readings))
    return fig


def w_at_home(stored: Evidence) -> Markup:
    """Set w at the reference configuration, for each reading of the lengths."""
    return show(stored["at_home"].where(None).set_index("reading")["w"].rename("w at home"), "{:.2f}")


def changes_by_range() -> Markup:
    """Set by how much θx changes w while z is slower than y, for two ranges of the rotations, over live draws."""
    limits: Any = experiment.changes_of_w.reading("velocity-limits=slow-heave")["velocity-limits"]
    joint_rates, tool_rates = limits
    w = Index("manipulability", joint_rates=joint_rates, tool_rates=tool_rates).bind(robots.uvms())
    rows = [
        {"range": f"±{deg:g}°", "change": 100 * change_under_theta_x(w, seed, deg)}
        for deg in (15.0, 60.0)
        for seed in range(SEEDS)
    ]
    heading = {"change": "largest change of $w$ [%]"}
    frame = over_seeds(pd.DataFrame(rows), "range", heading, "{:.0f}")
    return show(frame.rename_axis("rotations within"))


def change_under_theta_x(
    f: Callable[[Tensor], Tensor], seed: int, range_deg: float, configurations: int = 2000
) -> float:
    """Return the largest relative change of an index when θx alone is redrawn, with rotations within ±`range_deg`."""
    q, redrawn = experiment.draws(robots.uvms(), seed, configurations, range_deg)
    turned = q.clone()
    turned[:, THETA_X] = redrawn[:, THETA_X]
    return experiment.largest(f(turned) / f(q) - 1)


# ---- scenes ---------------------------------------------------------------------------------------


def screw_scene() -> scenes.Scene:
    """Set a body that follows a screw with a pitch, with the axis and the velocity of the point at the origin."""
    axis, point, pitch = np.array([0.0, 0.0, 1.0]), np.array([0.7, 0.0, 0.0]), 0.15
    screw = np.concatenate([-np.cross(axis, point) + pitch * axis, axis])
    angles = np.linspace(0.0, 6.5, 53)
    poses = spatial.exp(np.outer(angles, screw)).numpy()
    corner, x, z = point - np.array([0.0, 0.45, 0.0]), np.array([0.2, 0.0, 0.0]), 0.2 * axis
    body = Body(
        "body",
        slider="q [rad]",
        poses=poses,
        rods=np.array([[point, corner], [corner, corner + x], [corner, corner + z]]),
        radius=0.025,
        color="blue",
    )
    path = spatial.apply(poses, corner).numpy()
    scene = scenes.Scene("A body that follows a screw", height=LOW, view_from=VIEW)
    rest = [
        _rod_to("body, extended to O", "q [rad]", path, np.zeros_like(path)),
        Body(
            "axis ω",
            rods=np.array([[point - 0.1 * axis, point + 1.1 * axis]]),
            radius=0.012,
            color="orange",
        ),
        Body("v, velocity at the origin", arrows=HALF * screw[None, :3], radius=0.018, color="vermillion"),
    ]
    scene.add_mechanism([body, *rest], [Slider("q [rad]", angles, 1.5)])
    scene.add_path(path, name="path of a corner", color="sky blue")
    scene.add_letters({"O": np.zeros(3), "a": point})
    scene.add_remark("velocity 0.5 m for 1 m/s")
    return scene


def lever_scene() -> scenes.Scene:
    """Set an axis that is moved away from the origin, with its lever arm and the velocity at the origin."""
    label = "distance of the axis from O [m]"
    lengths = np.linspace(0.05, 1.0, 20)
    shift = np.tile(np.eye(4), (len(lengths), 1, 1))
    shift[:, 0, 3] = lengths
    ones, along = np.ones((len(lengths), 2)), lengths[:, None]
    at_rest = np.tile(np.eye(4), (len(lengths), 1, 1))
    bodies = [
        Body(
            "axis ω", slider=label, poses=shift, arrows=np.array([[0, 0, 0.5]]), radius=0.02, color="orange"
        ),
        Body(
            "turning disc",
            slider=label,
            poses=shift,
            ball=1.0,
            stretches=np.concatenate([along, along, 0.01 * ones[:, :1]], axis=1),
            color="sky blue",
        ),
        _rod_to("lever arm t", label, np.zeros((len(lengths), 3)), shift[:, :3, 3]),
        Body(
            "v = t × ω",
            slider=label,
            poses=at_rest,
            arrows=np.array([[0, -HALF, 0]]),
            radius=0.02,
            stretches=np.insert(ones, 1, lengths, axis=1),
            color="vermillion",
        ),
    ]
    scene = scenes.Scene("An axis that is moved away from the origin", height=LOW, view_from=(1, 1, 0.8))
    scene.add_mechanism(bodies, [Slider(label, lengths, 0.6)])
    scene.add_letters({"O": np.array([0.0, 0.0, -0.06])})
    scene.add_remark("velocity 0.5 m for 1 m/s")
    return scene


def column_scene() -> scenes.Scene:
    """Set the elbow's column of two Jacobians as arrows, and let the elbow alone move."""
    chain, label = robots.uvms(), "elbow [rad]"
    tool = chain.forward(POSTURE)[:3, 3].numpy()
    places = chain.joint_frames(POSTURE)[:, :3, 3].numpy()
    column = chain.spatial_jacobian(POSTURE)[:, ELBOW].numpy()
    of_tool = chain.geometric_jacobian(POSTURE)[:3, ELBOW].numpy()
    angles = np.linspace(-1.2, 1.2, 25)
    motion = spatial.exp(np.outer(angles, column)).numpy()
    at_tool = motion @ spatial.translation(*tool).numpy()
    circle = spatial.exp(np.outer(np.linspace(0, 2 * np.pi, 73), column))
    bodies = [
        Body("vehicle and arm at rest", rods=_bars(places[5 : ELBOW + 1]), radius=0.025),
        Body(
            "moving links",
            slider=label,
            poses=motion,
            rods=_bars([places[ELBOW], tool]),
            radius=0.025,
            color="blue",
        ),
        Body(
            "velocity of the tool",
            slider=label,
            poses=at_tool,
            arrows=HALF * of_tool[None],
            radius=0.016,
            color="bluish green",
        ),
        _rod_to("tool body, extended to O", label, at_tool[:, :3, 3], np.zeros((len(angles), 3))),
        Body("v of the column, at O", arrows=HALF * column[None, :3], radius=0.016, color="vermillion"),
    ]
    scene = scenes.Scene("The elbow moves: its column as two velocities", height=LOW, view_from=VIEW)
    scene.add_mechanism(bodies, [Slider(label, angles, 0.0)], name="robot")
    paths = {"path of the tool": (tool, "sky blue"), "circle through O": (np.zeros(3), "reddish purple")}
    for name, (start, color) in paths.items():
        scene.add_path(spatial.apply(circle, start), name=name, color=color)
    scene.add_letters({"O": np.zeros(3), "elbow": places[ELBOW]})
    scene.add_remark("velocity 0.5 m for 1 m/s")
    return scene


def origin_scene() -> scenes.Scene:
    """Set the robot at rest, and move the origin: the ellipsoid of velocities of the point of the tool body there."""
    label = "place of the origin along y [m]"
    places = np.linspace(-1.6, 1.2, 57)
    points = np.outer(places, [0.0, 1.0, 0.0])
    axes, semi_axes = ellipsoids_at(points)
    poses = np.tile(np.eye(4), (len(places), 1, 1))
    poses[:, :3, :3], poses[:, :3, 3] = axes, points
    tool = robots.uvms().forward(POSTURE)[:3, 3].numpy()
    bodies = [
        Body(
            "velocities at the origin",
            slider=label,
            poses=poses,
            ball=ELLIPSOID,
            stretches=semi_axes,
            color="blue",
        ),
        _rod_to("tool body, extended to O", label, np.broadcast_to(tool, points.shape), points),
        Body(
            "origin O",
            slider=label,
            poses=poses_at(points),
            letters={"O": np.zeros(3)},
            pins=np.zeros((1, 3)),
            radius=0.02,
            color="black",
        ),
    ]
    scene = vehicle_scene(
        "The origin moves, the robot rests", POSTURE, axes=False, height=LOW, view_from=VIEW
    )
    scene.add_mechanism(bodies, [Slider(label, places, -1.0)], name="origin")
    scene.add_remark(f"ellipsoid {ELLIPSOID:g} m for 1 m/s")
    return scene


def ellipsoids_at(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Take the ellipsoids of velocities of those points of the tool body that are at some places, for unit joint rates.

    Parameters
    ----------
    points
        (k, 3) places in the world [m].

    Returns
    -------
    Axes as rotations (k, 3, 3), each following the last one without a jump, and their semi-axes (k, 3) [m/s].
    """
    J = robots.uvms().spatial_jacobian(POSTURE).numpy()
    linear = J[:3] + np.cross(J[3:].T, points[:, None, :]).swapaxes(1, 2)
    axes, semi_axes, _ = np.linalg.svd(linear, full_matrices=False)
    for i in range(1, len(points)):
        overlap = axes[i - 1].T @ axes[i]
        _, order = linear_sum_assignment(-np.abs(overlap))
        axes[i] = axes[i][:, order] * np.sign(overlap[np.arange(3), order])
        semi_axes[i] = semi_axes[i][order]
    axes[..., 2] *= np.linalg.det(axes)[:, None]
    return axes, semi_axes


def poses_at(points: np.ndarray) -> np.ndarray:
    """Return poses (k, 4, 4) without rotation at points (k, 3)."""
    poses = np.tile(np.eye(4), (len(points), 1, 1))
    poses[:, :3, 3] = points
    return poses


def _bars(points: np.ndarray | Sequence[np.ndarray]) -> np.ndarray:
    """Join points (k, 3) one after the other, (m, 2, 3), and leave out steps without length."""
    ends = np.stack([points[:-1], points[1:]], axis=1)
    return ends[np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1) > 1e-9]


def _rod_to(name: str, slider: str, starts: np.ndarray, ends: np.ndarray) -> Body:
    """Join two points, (k, 3) each along a slider, by a thin rod."""
    ways = ends - starts
    poses = poses_at(starts)
    poses[:, :3, :3] = [_along_y(way) for way in ways]
    return Body(
        name,
        slider=slider,
        poses=poses,
        rods=np.array([[[0, 0, 0], [0, 1.0, 0]]]),
        radius=0.012,
        stretches=np.insert(np.ones((len(ways), 2)), 1, np.linalg.norm(ways, axis=1), axis=1),
        color="black",
    )


def _along_y(direction: np.ndarray) -> np.ndarray:
    """Return a rotation (3, 3) that turns y along a direction (3,)."""
    y = direction / np.linalg.norm(direction)
    x = np.cross(y, [0.0, 0.0, 1.0])
    x /= np.linalg.norm(x)
    return np.column_stack([x, y, np.cross(x, y)])
