"""Figures, tables and the scene of the chapter on the structure of the crane."""

from __future__ import annotations

import math

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import torch
from matplotlib.figure import Figure
from torch import Tensor

from dexterity import crane
from dexterity.crane.shape import PARTS, bars
from dexterity.scenes import Scene
from dexterity.scenes.colors import COLORS
from dexterity_study.crane.cases import BOX
from dexterity_study.crane.structure.experiment import (
    NAMED,
    STATISTICS,
    TARGETS,
    UNTUNED,
    Flexibilities,
    named,
    test_strokes,
)
from dexterity_study.crane.structure.verdicts import nearest_swap, printed, statistics_of, swap_statistics
from dexterity_study.engine.evidence import Evidence
from dexterity_study.engine.table import Table
from dexterity_study.page.markup import Markup
from dexterity_study.page.tables import show

MAGNIFIED = 10.0
"""Factor of displacements as they are drawn."""

PART_COLORS = ("black", "blue", "bluish green", "orange", "reddish purple", "vermillion")
PART_RADII = (0.05, 0.045, 0.04, 0.028, 0.03, 0.03)
TESTED = [name for name in STATISTICS if name not in TARGETS]


def deflections(strokes: Tensor, payloads: list[float]) -> Markup:
    """Set the deflection of one pose by payload."""
    sag = 1e3 * crane.deflection(strokes, payloads).numpy()
    index = pd.Index(payloads, name="payload [kg]")
    return show(pd.DataFrame(sag, columns=["along x [mm]", "along y [mm]"], index=index), "{:.1f}")


def scene(point: tuple[float, float] = (6.0, 2.0), frames: int = 25) -> Scene:
    """Draw the crane that reaches a point, from no payload to its rating and back."""
    drawn = Scene("The crane from no payload to its rating", view_from=(0.3, -1, 0.25))
    drawn.add_remark(f"displacements drawn {MAGNIFIED:.0f} : 1")
    unloaded, moving = swaying_bars(point, frames)
    drawn.add_bars("without any weight", unloaded, radius=0.012, color="#94A3B8")
    for (part, ends), color, radius in zip(moving.items(), PART_COLORS, PART_RADII, strict=True):
        drawn.add_bars(part, ends[frames // 2], radius=radius, color=color)
        drawn.animate_bars(part, ends, frames_per_second=12)
    return drawn


def swaying_bars(point: tuple[float, float], frames: int) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Return ends (m, 2, 3) of all bars without any weight, and by part ends (frames, m, 2, 3) as they sway."""
    own = bars(crane.inverse(point).strokes)
    shares = (1 - torch.cos(torch.linspace(0, 2 * math.pi, frames, dtype=torch.float64))) / 2
    loaded = torch.stack([own.loaded(float(s) * own.crane.rating, MAGNIFIED) for s in shares])
    # The plane of the crane stands up: its y is the world's z.
    still, moved = (np.insert(ends.numpy(), 1, 0.0, axis=-1) for ends in (own.ends, loaded))
    return still, {part: moved[:, [name == part for name in own.parts]] for part in PARTS}


def linear_statics(stored: Evidence) -> Markup:
    """Set the differences of linear statics from the co-rotational solution."""
    rows = stored["linear_statics"].where().set_index("on")[["mean", "largest"]]
    return show(rows.add_suffix(" [mm]").rename_axis("linear from co-rotational"), "{:.2f}")


def rates(stored: Evidence) -> Markup:
    """Set solves per second of processor time on one core."""
    rows = 1 / stored["rates"].where().set_index("way")[["median", "upper", "lower"]]
    return show(rows.set_axis(["solves per second", "lower quartile", "upper quartile"], axis=1), "{:,.0f}")


def statistics(stored: Evidence, live: Table) -> Markup:
    """Set the six statistics side by side: printed, untuned, fitted, live, co-rotational, and with a swap."""
    ours, fits = statistics_of(stored).droplevel("seed"), stored["fits"].where().set_index("to")
    left, taken, nearest = nearest_swap(stored)
    columns = {
        "printed": printed(),
        "untuned": fits.loc["untuned"],
        "fitted": ours.loc["chosen"],
        "fitted, live": live.where().set_index("to").loc["fitted"],
        "co-rotational": ours.loc["crane-linear-statics=co-rotational"],
        f"{taken} for {left}": nearest,
    }
    return show(pd.DataFrame(columns).loc[list(STATISTICS)].astype(float), "{:.1f}")


def ranges(stored: Evidence) -> Markup:
    """Set the ranges of the four statistics that were not fitted, by what was changed before [mm]."""
    refits = stored["fits"].where().query("found == True and changed != 'nothing'")
    groups = {str(name): own for name, own in refits.groupby("changed", sort=False)}
    rows = {"printed": {**printed()[TESTED].map("{:.1f}".format), "fits": "–"}}
    for changed, own in (groups | {"a test point swapped": swap_statistics(stored)}).items():
        spans = {name: f"{own[name].min():.1f}–{own[name].max():.1f}" for name in TESTED}
        rows[changed] = {**spans, "fits": f"{len(own)}"}
    return show(pd.DataFrame.from_dict(rows, orient="index"))


def fit(stored: Evidence) -> Figure:
    """Draw which pairs of numbers meet either target, and the errors at each test point."""
    fig, (left, right) = plt.subplots(1, 2, figsize=(7.2, 3.6), width_ratios=(2, 3))
    bending, ground = np.meshgrid(np.linspace(0.85, 1.45, 61), np.linspace(2.6, 4.8, 61))
    untuned = np.array(UNTUNED) / [1, 1e6]
    scaled = (axis[..., None, None, None] for axis in (bending / untuned[0], ground / untuned[1]))
    sags = Flexibilities.of(test_strokes(), crane.patu655())
    distance = 1e3 * np.linalg.norm(sags.errors(*scaled), axis=-1)
    fields = (distance.mean(axis=(-2, -1)), distance.max(axis=(-2, -1)))
    for field, look, (name, target) in zip(fields, ("C0-", "C1--"), TARGETS.items(), strict=True):
        left.contour(bending, ground, field, [target], colors=look[:2], linestyles=look[2:])
        left.plot([], [], look, label=f"{name} as printed")
    factors = stored["fits"].where(to="fitted")[["first", "second"]].to_numpy(dtype=float)[0]
    left.plot(*untuned * factors, "o", color=COLORS["black"])
    left.plot(*untuned, "x", color=COLORS["black"])
    left.set(xlabel="bending factor β", ylabel="ground stiffness k [MN·m/rad]")
    rows = stored["uncompensated"].where()
    errors = 1e3 * rows[["error_x", "error_y"]].abs().to_numpy().reshape(len(crane.TEST_POINTS), -1, 2)
    order = errors[:, -1, 0].argsort()
    for column, (name, color) in enumerate((("x", "blue"), ("y", "vermillion"))):
        right.plot(errors[order, :, column], ".", color=COLORS[color])
        right.axhline(printed()[f"max {name}"], color=COLORS[color], lw=1, ls=":")
        right.plot([], [], ".", color=COLORS[color], label=f"error in {name}")
    labels = [named(crane.TEST_POINTS[i])[1:-1] for i in order]
    right.set_xticks(range(len(labels)), labels, rotation=90, fontsize="x-small")
    right.set(ylabel="error [mm]", xlabel="test point, by its error in x")
    fig.legend(loc="outside upper center", ncols=2, fontsize="small")
    return fig


def working_area(spacing: float = 0.05) -> Figure:
    """Draw the deflection at the rating over the working area, and the poses of the training data."""
    fig, (left, right) = plt.subplots(1, 2, figsize=(7.2, 5.2), sharex=True, sharey=True)
    x, y = (torch.arange(*sides, spacing, dtype=torch.float64) for sides in BOX)
    reach = crane.inverse(torch.cartesian_prod(x, y))
    strokes = torch.where(reach.within_limits[:, None], reach.strokes, 0.0)
    sag = 1e3 * crane.deflection(strokes, crane.patu655().rating).norm(dim=-1)
    seen = torch.where(reach.within_limits, sag, torch.nan).reshape(len(x), len(y))
    image = left.imshow(seen.T.numpy(), origin="lower", extent=(*BOX[0], *BOX[1]))
    left.plot(*np.transpose(crane.TEST_POINTS), "o", mfc="none", color="C1", label="test points")
    training = crane.training_set()
    rigid = (training.tip - training.deflection)[training.payload == training.payload[0]]
    right.plot(*rigid.numpy().T, ".", ms=4, label="training poses")
    right.plot(*np.transpose(NAMED), "o", ms=14, mfc="none", color="C3", label="said to be scarce")
    for ax in (left, right):
        ax.set(xlabel="x [m]", aspect="equal")
    left.set(ylabel="y [m]")
    fig.colorbar(image, ax=(left, right), label="deflection at the rating [mm]", shrink=0.7)
    fig.legend(loc="outside upper center", ncols=3, fontsize="small")
    return fig
