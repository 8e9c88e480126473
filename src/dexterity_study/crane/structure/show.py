"""Figures, tables and the scene of the chapter on the structure of the crane."""

from __future__ import annotations

import math

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import torch
from matplotlib.axes import Axes
from matplotlib.figure import Figure

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
from dexterity_study.page import figures
from dexterity_study.page.markup import Markup
from dexterity_study.page.tables import show

MAGNIFIED = 10.0
"""Factor of displacements as they are drawn."""

PART_COLORS = ("black", "blue", "bluish green", "orange", "reddish purple", "vermillion")
PART_RADII = (0.05, 0.045, 0.04, 0.028, 0.03, 0.03)
TESTED = [name for name in STATISTICS if name not in TARGETS]
TITLES = {name: name.replace("max", "largest") for name in STATISTICS}
"""Names of the statistics on the page."""


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


def statistics(stored: Evidence, live: Table) -> Markup:
    """Set the six statistics side by side: printed, untuned, fitted, live, co-rotational, and with an exchange."""
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
    rows = pd.DataFrame(columns).loc[list(STATISTICS)].astype(float).rename(index=TITLES)
    return show(rows.rename_axis("error [mm]"), "{:.1f}")


def agreement(stored: Evidence) -> Figure:
    """Draw the statistics that were not fitted over the printed ones: of this crane, and after other choices."""
    refits = stored["fits"].where().query("found == True")
    groups = {
        "other sections": refits[refits["changed"] == "sections, masses, pads, strokes"],
        "one point left out": refits[refits["changed"] == "a test point left out"],
        "one point exchanged": swap_statistics(stored),
    }
    wanted = printed()[TESTED]
    rows = np.arange(len(TESTED))
    fig, ax = plt.subplots(figsize=(figures.WIDTH, 3.4))
    for shift, (label, group) in zip((-0.2, 0.0, 0.2), groups.items(), strict=True):
        ratios = group[TESTED].astype(float) / wanted
        ax.hlines(
            rows + shift, ratios.min(), ratios.max(), color=f"C{len(ax.collections)}", lw=6, label=label
        )
    fitted = statistics_of(stored).xs("chosen").iloc[0][TESTED] / wanted
    ax.plot(fitted, rows, "o", color=COLORS["black"], label="fitted crane")
    ax.plot(nearest_swap(stored)[2][TESTED] / wanted, rows + 0.2, "D", color="#595959", label="best exchange")
    ax.axvline(1, color="#808080", ls="--", label="as printed")
    ax.set_yticks(rows, [TITLES[name] for name in TESTED])
    ax.invert_yaxis()
    ax.set(xlabel="statistic / printed statistic")
    fig.legend(loc="outside upper center", ncols=2)
    return fig


def fit(stored: Evidence) -> Figure:
    """Draw which pairs of numbers meet either target, and the errors at each test point."""
    fig, (plane, points) = plt.subplots(2, 1, figsize=(figures.WIDTH, 4.8))
    _draw_fit(plane, stored)
    _draw_errors(points, stored)
    for ax in (plane, points):
        ax.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2)
    return fig


def _draw_fit(ax: Axes, stored: Evidence) -> None:
    bending, ground = np.meshgrid(np.linspace(0.85, 1.45, 61), np.linspace(2.6, 4.8, 61))
    untuned = np.array(UNTUNED) / [1, 1e6]
    scaled = (axis[..., None, None, None] for axis in (bending / untuned[0], ground / untuned[1]))
    sags = Flexibilities.of(test_strokes(), crane.patu655())
    distance = 1e3 * np.linalg.norm(sags.errors(*scaled), axis=-1)
    fields = (distance.mean(axis=(-2, -1)), distance.max(axis=(-2, -1)))
    for field, look, (name, target) in zip(fields, ("C0-", "C1--"), TARGETS.items(), strict=True):
        ax.contour(bending, ground, field, [target], colors=look[:2], linestyles=look[2:])
        ax.plot([], [], look, label=TITLES[name])
    factors = stored["fits"].where(to="fitted")[["first", "second"]].to_numpy(dtype=float)[0]
    ax.plot(*untuned * factors, "o", color=COLORS["black"])
    ax.plot(*untuned, "x", color=COLORS["black"])
    ax.set(xlabel="bending factor β", ylabel="ground stiffness k\n[MN·m/rad]")


def _draw_errors(ax: Axes, stored: Evidence) -> None:
    rows = stored["uncompensated"].where()
    errors = 1e3 * rows[["error_x", "error_y"]].abs().to_numpy().reshape(len(crane.TEST_POINTS), -1, 2)
    order = errors[:, -1, 0].argsort()
    for column, (name, color) in enumerate((("x", "blue"), ("y", "vermillion"))):
        ax.plot(errors[order, :, column], ".", color=COLORS[color])
        ax.axhline(printed()[f"max {name}"], color=COLORS[color], lw=1, ls=":")
        ax.plot([], [], ".", color=COLORS[color], label=f"error in {name}")
    largest = (len(order) - 1, errors[order[-1], :, 0].max())
    ax.annotate(
        named(crane.TEST_POINTS[order[-1]]),
        largest,
        (0, 20),
        textcoords="offset points",
        ha="right",
        arrowprops={"arrowstyle": "-", "color": "#595959"},
    )
    ax.set(ylabel="error [mm]", xlabel="test points by error in x", xticks=[])


def working_area(spacing: float = 0.05) -> Figure:
    """Draw the deflection at the rating over the working area, and the poses of the training data."""
    fig, (left, right) = plt.subplots(1, 2, figsize=(figures.WIDTH, 4.2), sharex=True, sharey=True)
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
        ax.grid(visible=False)
    left.set(ylabel="y [m]")
    fig.colorbar(image, ax=(left, right), location="bottom", label="sag at the rating [mm]", shrink=0.9)
    fig.legend(loc="outside upper center", ncols=2)
    return fig
