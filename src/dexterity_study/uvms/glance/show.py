"""Pictures of the pipeline's steps, drawn from what a live run computes, and the decision that its numbers lead to."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from itertools import pairwise
from typing import NamedTuple

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import torch
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from torch import Tensor

from dexterity import robots, sampling, scenes
from dexterity.chain import Chain
from dexterity.networks.design import Design
from dexterity.networks.validation import ErrorDistribution
from dexterity.networks.worst_case import WorstCase
from dexterity.sampling import DataSets
from dexterity.timing import Timing, Way, ratio
from dexterity_study.claims.ledger import load_paper
from dexterity_study.engine.evidence import Evidence
from dexterity_study.page import figures
from dexterity_study.page.markup import Markup
from dexterity_study.page.numbers import with_range, written
from dexterity_study.page.tables import show
from dexterity_study.uvms.cost.experiment import Jacobians
from dexterity_study.uvms.feed_forward.experiment import AS_PRINTED, LIMIT
from dexterity_study.uvms.feed_forward.verdicts import ends
from dexterity_study.uvms.kinematics.show import vehicle_scene
from dexterity_study.uvms.sampling.show import outline, space
from dexterity_study.uvms.timing.experiment import EXACT, FEED_FORWARD, FOOT
from dexterity_study.uvms.timing.verdicts import SEVERAL_HUNDRED

Function = Callable[[Tensor], Tensor]

REACHING = torch.tensor(np.radians([0, 0, 0, 0, 0, 0, 10, 20, -40, 15, 25, 0]))
"""Configuration in which the robot is drawn, [rad]."""

WAYS = ("exact, numpy", "exact, C", "network, C")
"""What is timed, in this order."""

PANEL = 2.1
"""Place of the panel along y [m], in front of the reach of the drawn arm."""

NOTICEABLE = 1e-3
"""Time saved in a cycle of a planner that counts as noticed [s]: a hundredth of a cycle, at ten cycles a second."""

ELBOW, WRIST = 8, 10
"""Joints, from 0, over which the surface of w is drawn."""


def robot() -> scenes.Scene:
    """Set the vehicle with its arm, reaching, with a slider for each joint."""
    scene = vehicle_scene("The vehicle with its arm, with sliders", REACHING, axes=False, height=360)
    scene.add_letters({"tool": robots.uvms().forward(REACHING)[:3, 3]})
    panel = torch.eye(4, dtype=torch.float64)
    panel[1, 3] = PANEL
    scene.add_box((1.2, 0.08, 0.9), pose=panel, name="control panel", color="orange")
    for number, x in enumerate((-0.35, 0.0, 0.35), start=1):
        scene.add_path(valve(x), name=f"valve {number}", color="vermillion")
    scene.add_sliders("uvms")
    return scene


def valve(x: float, radius: float = 0.1) -> np.ndarray:
    """Return points (m, 3) [m] of a wheel with four spokes in front of the panel, its axis along y."""
    turn = np.linspace(0, 2 * np.pi, 33)
    rim = np.stack([radius * np.cos(turn), np.zeros(33), radius * np.sin(turn)], axis=1)
    spokes = np.array([(-1, 0, 0), (1, 0, 0), (0, 0, 0), (0, 0, 1), (0, 0, -1)]) * radius
    return np.concatenate([rim, spokes]) + np.array([x, PANEL - 0.1, 0.0])


def surface(w: Function, half_range_deg: float = 120.0, steps: int = 49) -> Figure:
    """Draw w as a surface over elbow and wrist, with the square that the paper samples."""
    fig = plt.figure(figsize=(figures.WIDTH, 4.0))
    ax = fig.add_subplot(projection="3d", computed_zorder=False)
    angle = np.linspace(-half_range_deg, half_range_deg, steps)
    elbow, wrist = np.meshgrid(angle, angle, indexing="ij")
    ax.plot_surface(elbow, wrist, over_two_joints(w, elbow, wrist), cmap="cividis", lw=0, rcount=steps)
    corners = np.array([(-1, -1), (-1, 1), (1, 1), (1, -1), (-1, -1)]) * 15.0
    path = np.concatenate([np.linspace(a, b, 9) for a, b in pairwise(corners)])
    heights = over_two_joints(w, *path.T)
    ax.plot(*path.T, heights + 0.15, color="#D55E00", lw=2.5, label="range that the paper samples, ±15°")
    ticks = (-90, 0, 90)
    ax.set(xlabel="elbow θ₉ [°]", ylabel="wrist θ₁₁ [°]", zlabel="w", xticks=ticks, yticks=ticks)
    ax.view_init(elev=32, azim=-55)
    ax.set_box_aspect((1, 1, 0.65), zoom=0.86)
    for axis in (ax.xaxis, ax.yaxis, ax.zaxis):
        axis.set_pane_color((0, 0, 0, 0))
    fig.legend(loc="outside upper center")
    return fig


def over_two_joints(w: Function, elbow: np.ndarray, wrist: np.ndarray) -> np.ndarray:
    """Return w for values of elbow and wrist [°] of one shape, the other joints at zero."""
    q = torch.zeros(*elbow.shape, 12, dtype=torch.float64)
    q[..., ELBOW], q[..., WRIST] = (torch.as_tensor(np.radians(angle)) for angle in (elbow, wrist))
    return np.asarray(w(q))


def samples(chain: Chain, w: Function, data: DataSets, arms: int = 150) -> Figure:
    """Draw arms of the search area from above, coloured by w, and how often each value of w is learned."""
    fig, panels = plt.subplots(2, figsize=(figures.WIDTH, 6.4), height_ratios=(2.4, 1))
    sector = space("chosen")
    q = sampling.uniform(sector, arms, torch.Generator().manual_seed(0))
    lines = LineCollection(list(arm_points(chain, q)[..., :2].numpy()), array=w(q).numpy(), lw=0.9)
    panels[0].add_collection(lines)
    panels[0].plot(*outline(sector).T[:2], color="#D55E00", label="search area of the arm's base")
    panels[0].plot(*sector.task_point[:2], "*", color="#1F2933", ms=14, label="task point")
    panels[0].set(xlabel="x [m]", ylabel="y [m]", aspect="equal", xlim=(-0.9, 0.9), ylim=(0.2, 2.35))
    fig.colorbar(lines, ax=panels[0], label="w", shrink=0.8)
    values = data.train.values.numpy()
    panels[1].hist(values, 40, color="C0")
    panels[1].set(xlabel="w", ylabel=f"rows of {len(values):,}")
    fig.legend(loc="outside upper center")
    return fig


def arm_points(chain: Chain, q: Tensor) -> Tensor:
    """Return base, elbow, wrist and tool [m] of the arm in configurations (m, 12), (m, 4, 3)."""
    length = robots.describe("uvms").lengths
    base = torch.tensor([0.0, length["y_MB"], length["l1"], 1.0], dtype=torch.float64)
    elbow = base + torch.tensor([0.0, length["l2"], 0.0, 0.0], dtype=torch.float64)
    frames = chain.joint_frames(q)
    at_zero = chain.joint_frames(torch.zeros(chain.joints))
    carried = [
        (frames[:, joint] @ torch.linalg.inv(at_zero[joint]) @ point)[:, :3]
        for joint, point in ((5, base), (7, elbow))
    ]
    tool = chain.forward(q)[:, :3, 3]
    return torch.stack([*carried, tool], dim=1)


def loop(design: Design, stored: Evidence) -> Figure:
    """Draw the testing error against neurons, live and of the stored loops, with the limit that ends the loop."""
    fig, ax = plt.subplots(figsize=(figures.WIDTH, 3.2))
    rows = stored["sizes"].where(index="w", kind=AS_PRINTED)
    errors = 100 * rows.pivot(index="neurons", columns="seed", values="testing_error").loc[:10]
    ax.plot(errors, color="#808080", lw=0.7, alpha=0.6)
    ax.plot([], [], color="#808080", lw=0.7, label=f"stored, {errors.shape[1]} seeds")
    tried = [trial.neurons for trial in design.trials]
    ax.plot(tried, [100 * trial.testing_error for trial in design.trials], "o-", color="C0", label="live")
    ax.plot(design.best.neurons, 100 * design.best.testing_error, "o", ms=13, mfc="none", mew=2, color="C1")
    printed = load_paper("sotiropoulos2016").printed("feed-forward-w-neurons")
    ax.plot(printed, 100 * LIMIT, "D", ms=10, mfc="none", mew=2, color="C2", label="the paper")
    ax.axhline(100 * LIMIT, color="#595959", ls=":", label="limit E")
    ax.set(xlabel="neurons", ylabel="testing error [%]", ylim=(0, None), xticks=range(1, 11))
    fig.legend(loc="outside upper center", ncols=2)
    return fig


def answers(network: Function, data: DataSets, worst: WorstCase) -> Figure:
    """Draw the network's relative error against the exact w on held-out rows, and the worst case found."""
    fig, ax = plt.subplots(figsize=(figures.WIDTH, 3.4))
    q, exact = data.validation.q, data.validation.values
    with torch.no_grad():
        errors = 100 * (network(q) / exact - 1)
    ax.plot(exact, errors, ".", ms=2, alpha=0.4, label="held-out row", rasterized=True)
    at = 100 * (worst.value / worst.exact - 1)
    ax.plot(worst.exact, at, "X", ms=11, color="C1", mec="none", label="worst case found by a search")
    for side in (-1, 1):
        ax.axhline(side * 100 * LIMIT, color="#595959", ls=":", label="limit E" if side > 0 else None)
    ax.set(xlabel="exact w", ylabel="network − exact [%]")
    fig.legend(loc="outside upper center", ncols=2, markerscale=1.2)
    return fig


def ways(exact: Function, network: Function, q: Tensor) -> Sequence[Way]:
    """Return three ways to compute w: exactly in numpy, exactly in C, and by a network in C."""
    in_numpy = Way(WAYS[0], partial(_in_numpy, Jacobians(), q.numpy()), len(q))
    return [in_numpy, Way(WAYS[1], partial(exact, q), len(q)), Way(WAYS[2], partial(network, q), len(q))]


def _in_numpy(jacobians: Jacobians, q: np.ndarray) -> np.ndarray:
    J = jacobians.at_once(q)
    return np.asarray(np.sqrt(np.linalg.det(J @ np.swapaxes(J, -1, -2))))


def times(timings: Sequence[Timing]) -> Figure:
    """Draw the times per configuration as bars with their quartiles, on a logarithmic axis."""
    fig, ax = plt.subplots(figsize=(figures.WIDTH, 2.4))
    for place, one in enumerate(timings):
        median, lower, upper = (1e9 * t for t in (one.median, one.lower, one.upper))
        ax.barh(place, median, xerr=[[median - lower], [upper - median]], color=f"C{place}", capsize=4)
        ax.text(upper * 1.25, place, f"{written(median)} ns", va="center")
    longest = max(one.upper for one in timings)
    ax.set(xscale="log", xlabel="time per configuration on this machine [ns]", xlim=(1, 1e10 * longest))
    ax.set_yticks(range(len(timings)), [one.name for one in timings])
    ax.invert_yaxis()
    return fig


class Figures(NamedTuple):
    """What a decision rests on: neurons, relative errors, seconds per configuration, and whether their quartiles lie apart."""

    neurons: int
    testing: float
    sampled: float
    worst: float
    exact: float
    network: float
    distinguishable: bool

    @classmethod
    def of(
        cls, design: Design, errors: ErrorDistribution, worst: WorstCase, timings: Sequence[Timing]
    ) -> Figures:
        """Take them from a run."""
        exact, network = (next(one for one in timings if one.name == name) for name in WAYS[1:])
        apart = ratio(exact, network).distinguishable
        sizes = (design.best.neurons, design.best.testing_error, errors.maximum, worst.error)
        return cls(*sizes, exact.median, network.median, apart)

    @property
    def saved(self) -> float:
        """Time that the network saves in a cycle of a planner [s]; 0 where the quartiles of the times overlap."""
        return max(SEVERAL_HUNDRED) * (self.exact - self.network) if self.distinguishable else 0.0


def live_and_stored(run: Figures, loops: Evidence, timed: Evidence) -> Markup:
    """Set the numbers of a run beside the stored ones, by which the verdicts are judged."""
    of_seeds = ends(loops, "w").query("reading == 'chosen'")
    stored = timed["ladder"].where(index="w", rung=FOOT).set_index("side")["median"]
    rows = {
        "neurons": (f"{run.neurons}", with_range(of_seeds["neurons"], "{:.0f}")),
        "testing error": _percents(run.testing, of_seeds["testing_error"]),
        "error on held-out points": _percents(run.sampled, of_seeds["fresh"]),
        "exact $w$ in C": _nanoseconds(run.exact, stored[EXACT]),
        "network in C": _nanoseconds(run.network, stored[FEED_FORWARD]),
    }
    return show(pd.DataFrame.from_dict(rows, orient="index", columns=["this run", "stored"]))


def _percents(live: float, stored: pd.Series) -> tuple[str, str]:
    return f"{100 * live:.2f} %", f"{with_range(100 * stored, '{:.2f}')} %"


def _nanoseconds(live: float, stored: float) -> tuple[str, str]:
    return f"{1e9 * live:.0f} ns", f"{1e9 * stored:.0f} ns"


def decision(run: Figures) -> str:
    """Say in words which of the two to use, and by which numbers."""
    if run.saved > 0:
        saved = f"it saves {written(1e6 * run.saved, '{:.2g}')} µs in a cycle of {max(SEVERAL_HUNDRED)} configurations"
    elif run.saved < 0:
        saved = "it saves no time"
    else:
        saved = "the quartiles of the two times overlap, so that neither is faster in this run"
    side = "within" if run.worst <= LIMIT else "above"
    return (
        f"The network takes {1e9 * run.network:.0f} ns per configuration and the exact index {1e9 * run.exact:.0f} ns: {saved}. "
        f"Its testing error is {100 * run.testing:.2f} %, and a search finds an error of {100 * run.worst:.2f} %, "
        f"{side} the limit of {100 * LIMIT:.0f} %. **{advice(run)}**"
    )


def advice(run: Figures) -> str:
    """Return the decision for a run: a network has to hold its limit at the worst case found, and to be faster."""
    if run.worst > LIMIT:
        return "Use the exact index: the network passed its test and breaks the limit elsewhere."
    if run.saved <= 0:
        return "Use the exact index: it has no error, and the network is not faster."
    if run.saved < NOTICEABLE:
        return "Use the exact index: the network holds its limit and saves no time that a planner notices."
    return "Use the network: it holds its limit and saves time that a planner notices."
