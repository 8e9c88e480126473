"""Scenes, figures and tables of the chapter on the PUMA 560, from rows of its experiments."""

from __future__ import annotations

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
from dexterity_study.page.markup import Markup
from dexterity_study.page.tables import show
from dexterity_study.workspace.puma import experiment as puma
from dexterity_study.workspace.puma.verdicts import READING

PALETTE = ("blue", "sky blue", "bluish green", "yellow", "orange")
CUTS = ("y = 0", "z = 0")


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


def difference_scene(stored: Evidence, network: str) -> Scene:
    """Show the border of the exact map within the training cube, and the cells where a network is wrong."""
    scene = Scene(f"Where the network ({network}) is wrong about the PUMA", view_from=(0.6, -1.0, 0.5))
    surface = stored["exact"].array("surface")[0]
    inner = surface[np.abs(surface).max(axis=1) < 0.999 * maps.TRAINED_HALF_SIDE]
    scene.add_points(inner, name="inner border of what is in reach", size=0.006, color="sky blue")
    for kind, name, color in (
        ("invented", "out of reach, taken for in reach", "vermillion"),
        ("missed", "in reach, taken for out of reach", "black"),
    ):
        cells = stored["learned"].array(kind)[0]
        cells = cells[cells[:, 0] == list(puma.NETWORKS).index(network), 1:]
        if len(cells):
            scene.add_points(cells, name=name, size=0.014, color=color)
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


def agreement(table: Table) -> Markup:
    """Set how the learned maps agree with the exact one; errors of w in per cent of its largest value."""
    rows = table.where().set_index(["network", "case"])
    rows = rows[rows.index.isin((puma.ALIGNED, puma.RANDOM), level="case")]
    columns = {
        "IoU in reach": rows["reached"],
        "IoU out of reach": rows["unreached"],
        "right": rows["right"],
        "error of w, median [%]": 100 * rows["median_error"],
        "error of w, nine in ten below [%]": 100 * rows["ninth_decile"],
        "error of w, largest [%]": 100 * rows["largest_error"],
    }
    return show(pd.DataFrame(columns))


def maps_beside(stored: Evidence) -> Figure:
    """Draw two slices of the exact map, and of the differences of the networks from it."""
    fig, panels = plt.subplots(3, 2, figsize=(6.8, 9), sharex=True)
    half, exact = maps.TRAINED_HALF_SIDE, stored["exact"].array("slices")[0]
    top = np.nanmax(exact)
    for ax, cut, w in zip(panels[0], CUTS, exact, strict=True):
        image = _slice(ax, w, half, f"exact, {cut}", vmin=0, vmax=top)
    fig.colorbar(image, ax=panels[0], label="w [m³]")
    learned = stored["learned"].array("slices")[0]
    for row, name, slices in zip(panels[1:], puma.NETWORKS, learned, strict=True):
        for ax, cut, w, ours in zip(row, CUTS, exact, slices, strict=True):
            off = np.nan_to_num(ours) - np.nan_to_num(w)
            title = f"{name} − exact, {cut}"
            image = _slice(ax, off, half, title, vmin=-top / 2, vmax=top / 2, cmap="PuOr")
            x, y = (np.linspace(-half, half, len(w))[i] for i in np.nonzero(np.isnan(ours) != np.isnan(w)))
            ax.plot(x, y, ".", ms=1.5, color=COLORS["vermillion"])
        fig.colorbar(image, ax=row, label="difference of w [m³]")
    plt.setp(panels[:, 0], ylabel="z [m]")
    plt.setp(panels[:, 1], ylabel="y [m]")
    plt.setp(panels[2], xlabel="x [m]")
    return fig


def _slice(ax: Axes, values: np.ndarray, half: float, title: str, **look: Any) -> AxesImage:
    """Draw values over a square of which the first axis goes to the right."""
    ax.set_title(title)
    ax.grid(visible=False)
    return ax.imshow(values.T, origin="lower", extent=(-half, half, -half, half), **look)


def notions(stored: Evidence) -> Markup:
    """Set volumes [m³] of four workspaces, and the mean share of the orientations, the measure of the fifth."""
    titles = ("reachable", "within 45° of down", "straight down", "dexterous", "mean share of orientations")
    heads = dict(zip((*puma.NOTIONS, "mean_share"), titles, strict=True))
    return show(stored["notions"].where().set_index("arm")[list(heads)].rename(columns=heads))


def orientations(stored: Evidence) -> Figure:
    """Draw the share of the orientations that positions with y = 0 have."""
    fig, panels = plt.subplots(2, 2, figsize=(6.8, 6.2), sharex=True, sharey=True)
    table = stored["notions"]
    for ax, name, share in zip(panels.flat, table.where()["arm"], table.array("share")[0], strict=True):
        image = _slice(ax, np.where(share > 0, share, np.nan), puma.HALF_SIDE, name, vmin=0, vmax=1)
    plt.setp(panels[1], xlabel="x [m]")
    plt.setp(panels[:, 0], ylabel="z [m]")
    fig.colorbar(image, ax=panels, label="share of the orientations")
    return fig


def runs(stored: Evidence) -> Markup:
    """Set the errors of the runs of the control loop."""
    exact = stored["loops"].where().assign(network="exact")
    rows = pd.concat([exact, stored["learned"].where().dropna(subset="ended")]).set_index(["network", "case"])
    columns = {
        "Jacobian off by [%]": 100 * rows["jacobian_error"],
        "position, largest [mm]": 1e3 * rows["largest"],
        "position, end [mm]": 1e3 * rows["last"],
        "orientation, largest [mrad]": 1e3 * rows["orientation"],
        "ended": rows["ended"],
    }
    return show(pd.DataFrame(columns))


def errors(stored: Evidence) -> Figure:
    """Draw the error of the position over time, with and without feedback."""
    fig, panels = plt.subplots(2, 1, figsize=(6.8, 5.6), sharex=True, sharey=True)
    parts = [stored[name].array("position_error")[0] for name in ("loops", "learned")]
    curves = np.concatenate(parts).reshape(3, 2, -1)
    time = np.linspace(0, READING["rate-control-path"][1], curves.shape[-1])
    names, colors = ("exact", *puma.NETWORKS), ("blue", "vermillion", "bluish green")
    for name, color, own in zip(names, colors, curves, strict=True):
        for ax, error in zip(panels, own, strict=True):
            ax.semilogy(time[1:], 1e3 * error[1:], color=COLORS[color], label=name)
    for ax, case in zip(panels, (puma.FEEDBACK, puma.OPEN), strict=True):
        ax.set(title=case, ylabel="position error [mm]")
    panels[1].set(xlabel="time [s]")
    panels[0].legend(loc="lower right", fontsize="small")
    return fig
