"""Scenes, figures and tables of the chapter on the PUMA 560, from rows of its experiments."""

from __future__ import annotations

import math
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import torch
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.image import AxesImage

from dexterity.scenes import Scene
from dexterity.scenes.colors import COLORS
from dexterity.workspace import maps
from dexterity.workspace.maps import ByClosedForm, Grid
from dexterity_study.engine.evidence import Evidence
from dexterity_study.engine.table import Table
from dexterity_study.page import figures
from dexterity_study.page.markup import Markup
from dexterity_study.page.tables import show
from dexterity_study.workspace.puma import experiment as puma
from dexterity_study.workspace.puma.verdicts import READING

PALETTE = ("blue", "sky blue", "bluish green", "yellow", "orange")
CUTS = ("y = 0", "z = 0")
NETWORKS = {"rotation": "rotation matrix", "plane": "plane of the arm"}
"""What the networks take as input, by their names in the rows."""

ARMS = {
    "neither": "no limits, no tool",
    "limits": "joint limits",
    "tool": "tool",
    "limits and tool": "limits and tool",
}
"""Arms of the five notions by what they have, by their names in the rows."""


TOUCHES = 1e-3
"""Share of the cylinder's radius by which the inner sphere may be larger: it then touches the cylinder from inside."""


def manipulability_scene(per_side: int = 41) -> Scene:
    """Show the reach of the PUMA in three sections, by the w of the best branch, with the tool upright."""
    side, middle = torch.linspace(-0.9, 0.9, per_side, dtype=torch.float64), torch.zeros(1).double()
    # The section square to the first one is left out where it would hide that.
    half = side[side > 0]
    grids = Grid(side, middle, side), Grid(middle, half, side), Grid(side, half, middle)
    cuts = [maps.constant_orientation(ByClosedForm(puma.LINKS, None), grid, torch.eye(3)) for grid in grids]
    points = torch.cat([grid.points().flatten(0, 2) for grid in grids])
    reached, w = (torch.cat([part.flatten() for part in parts]) for parts in zip(*cuts, strict=True))
    scene = Scene("Three sections through what the PUMA 560 reaches", view_from=(0.6, -1.0, 0.5))
    scene.add_chain(puma.tracking_arm(), [-1.2, 0.9, -2.2, 0.0, 0.6, 0.0], axes=False)
    classes = (w / w.max() * len(PALETTE)).long().clamp(max=len(PALETTE) - 1)
    borders = np.linspace(0, w.max().item(), len(PALETTE) + 1)
    for i, color in enumerate(PALETTE):
        name = f"w {borders[i]:.3f}–{borders[i + 1]:.3f} m³"
        scene.add_points(points[reached & (classes == i)], name=name, size=1.8 / per_side, color=color)
    return scene


def tracking_scene(stored: Evidence) -> Scene:
    """Show the arm on its way round the circle, with the exact Jacobian and that of the first network."""
    scene, arm = Scene("Round a circle by resolved rates", view_from=(1.0, 0.3, 0.6)), puma.tracking_arm()
    for name, experiment, color, of_path in (
        ("rotation", "learned", "vermillion", "orange"),
        ("exact", "loops", "blue", "sky blue"),
    ):
        q = stored[experiment].array("q")[0, 0].astype(np.float64)
        frames, title = q[~np.isnan(q[:, 0])], f"{name} Jacobian"
        scene.add_chain(arm, frames[0], name=title, axes=False, color=COLORS[color])
        if len(frames) > 1:
            scene.animate(title, frames, frames_per_second=20)
        scene.add_path(arm.forward(frames)[:, :3, 3], name=f"tool, {title}", color=of_path)
    return scene


def agreement(stored: Evidence, live: Table) -> Markup:
    """Set how the learned maps agree with the exact one, stored and live; errors of w in per cent of its largest.

    The first row is the answer that everything is in reach.
    """
    exact, learned = stored["exact"].where()["share_reached"].iloc[0], stored["learned"]
    parts = {
        "base axes": learned.where(case=puma.ALIGNED),
        "random": learned.where(case=puma.RANDOM),
        "base axes, live": live.where(case=puma.ALIGNED),
    }
    rows = pd.concat({title: part.set_index("network") for title, part in parts.items()}).swaplevel()
    columns = {
        "in reach: overlap [%]": 100 * rows["reached"],
        "out of reach: overlap [%]": 100 * rows["unreached"],
        "border error [mm]": 1e3 * rows["right"].map(border_error),
        "$w$: median error [%]": 100 * rows["median_error"],
        "90 % below [%]": 100 * rows["ninth_decile"],
    }
    table = pd.concat([pd.DataFrame(columns).loc[[name]] for name in NETWORKS]).rename(
        index=NETWORKS, level=0
    )
    values = (100 * exact, 0.0, 1e3 * border_error(exact))
    trivial = pd.DataFrame([dict(zip(columns, values, strict=False))], [("everything in reach", "any")])
    trivial.index = pd.MultiIndex.from_tuples(trivial.index)
    return show(pd.concat([trivial, table]).rename_axis([None, "tool"]), "{:.1f}")


def border_error(right: float) -> float:
    """Return by how much the border of a map of the cube is off on average [m]: its wrong volume over the border's area.

    Parameters
    ----------
    right
        Share of the cube's cells that the map has right.

    Raises
    ------
    ValueError
        If a sphere of the rule cuts the cube, so that its border is not the cylinder around the first axis alone.
    """
    d3, d4, a2, a3 = puma.LINKS
    half, forearm = maps.TRAINED_HALF_SIDE, math.hypot(d4, a3)
    inner, outer = math.hypot(a2 - forearm, d3), math.hypot(a2 + forearm, d3)
    if inner > d3 * (1 + TOUCHES) or outer < math.sqrt(3) * half or d3 > half:
        raise ValueError(f"the cube of half side {half} m cuts more than the cylinder of radius {d3} m")
    return (1 - right) * (2 * half) ** 3 / (math.tau * d3 * 2 * half)


def maps_beside(stored: Evidence) -> Figure:
    """Draw two slices of the exact map, and of the differences of the networks from it."""
    fig, panels = plt.subplots(3, 2, figsize=(figures.WIDTH, 4.9), sharex=True, sharey=True)
    half, exact = maps.TRAINED_HALF_SIDE, stored["exact"].array("slices")[0]
    top = np.nanmax(exact)
    for ax, cut, w in zip(panels[0], CUTS, exact, strict=True):
        image = _slice(ax, w, half, cut, vmin=0, vmax=top)
    fig.colorbar(image, ax=panels[0], label="exact w [m³]")
    learned = stored["learned"].array("slices")[0]
    for row, name, slices in zip(panels[1:], puma.NETWORKS, learned, strict=True):
        for ax, w, ours in zip(row, exact, slices, strict=True):
            off = np.nan_to_num(ours) - np.nan_to_num(w)
            image = _slice(ax, off, half, "", vmin=-top / 2, vmax=top / 2, cmap="PuOr")
            x, y = (np.linspace(-half, half, len(w))[i] for i in np.nonzero(np.isnan(ours) != np.isnan(w)))
            ax.plot(x, y, ".", ms=1.5, color=COLORS["vermillion"])
        fig.colorbar(image, ax=row, label=f"{NETWORKS[name]}\n− exact [m³]")
    plt.setp(panels[:, 0], ylabel="z or y [m]", yticks=(-0.3, 0, 0.3))
    plt.setp(panels[2], xlabel="x [m]", xticks=(-0.3, 0, 0.3))
    return fig


def _slice(ax: Axes, values: np.ndarray, half: float, title: str, **look: Any) -> AxesImage:
    """Draw values over a square of which the first axis goes to the right."""
    ax.set_title(title)
    ax.grid(visible=False)
    return ax.imshow(values.T, origin="lower", extent=(-half, half, -half, half), **look)


def notions(stored: Evidence) -> Markup:
    """Set volumes of four workspaces, and the mean share of the orientations, the measure of the fifth."""
    rows = stored["notions"].where().set_index("arm").rename(index=ARMS)
    titles = ("reachable", "within 45° of down", "straight down", "dexterous")
    columns = {f"{title} [m³]": rows[name] for name, title in zip(puma.NOTIONS, titles, strict=True)}
    columns["orientations [%]"] = 100 * rows["mean_share"]
    return show(
        pd.DataFrame(columns).rename_axis("what the arm has"), "{:.1f}", forms={"orientations [%]": "{:.0f}"}
    )


def orientations(stored: Evidence) -> Figure:
    """Draw the share of the orientations that positions with y = 0 have."""
    fig, panels = plt.subplots(2, 2, figsize=(figures.WIDTH, 3.8), sharex=True, sharey=True)
    table = stored["notions"]
    for ax, name, share in zip(panels.flat, table.where()["arm"], table.array("share")[0], strict=True):
        values = np.where(share > 0, 100 * share, np.nan)
        image = _slice(ax, values, puma.HALF_SIDE, ARMS[name], vmin=0, vmax=100)
    plt.setp(panels[1], xlabel="x [m]")
    plt.setp(panels[:, 0], ylabel="z [m]")
    fig.colorbar(image, ax=panels, label="orientations in reach [%]")
    return fig


def runs(stored: Evidence, live: Table) -> Markup:
    """Set the errors of the control loop with the exact and the estimated Jacobians, and of one live run."""
    parts = {
        "exact": stored["loops"].where(),
        "exact, live": live.where(),
        **{title: stored["learned"].where(network=name) for name, title in NETWORKS.items()},
    }
    rows = pd.concat({title: part.set_index("case") for title, part in parts.items()})
    loops = rows[rows.index.isin((puma.FEEDBACK, puma.OPEN), level=1)].unstack()
    columns = {
        "wrong by [%]": 100 * loops["jacobian_error", puma.FEEDBACK],
        "with feedback [mm]": 1e3 * loops["largest", puma.FEEDBACK],
        "without [mm]": 1e3 * loops["largest", puma.OPEN],
        "turned by [mrad]": 1e3 * loops["orientation", puma.FEEDBACK],
    }
    return show(pd.DataFrame(columns).loc[list(parts)].rename_axis("Jacobian"), "{:.1f}")


def errors(stored: Evidence) -> Figure:
    """Draw the error of the position over time, with and without feedback."""
    fig, panels = plt.subplots(2, 1, figsize=(figures.WIDTH, 4.2), sharex=True, sharey=True)
    parts = [stored[name].array("position_error")[0] for name in ("loops", "learned")]
    curves = np.concatenate(parts).reshape(3, 2, -1)
    time = np.linspace(0, READING["rate-control-path"][1], curves.shape[-1])
    names, colors = ("exact", *NETWORKS.values()), ("blue", "vermillion", "bluish green")
    for name, color, own in zip(names, colors, curves, strict=True):
        for ax, error in zip(panels, own, strict=True):
            ax.semilogy(time[1:], 1e3 * error[1:], color=COLORS[color], label=name)
    for ax, case in zip(panels, ("with feedback", "without feedback"), strict=True):
        ax.set(title=case, ylabel="error [mm]")
    panels[1].set(xlabel="time [s]")
    fig.legend(*panels[0].get_legend_handles_labels(), loc="outside upper center", ncols=3, columnspacing=1)
    return fig
