"""Scenes, figures and tables of the chapter on the PUMA 560, from rows of its experiments."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import torch
from matplotlib.figure import Figure

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
    w, reached = (
        torch.cat([getattr(cut, of).flatten() for cut in cuts]) for of in ("manipulability", "reached")
    )
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
    scene = Scene("Round a circle by resolved rates", view_from=(1.0, 0.3, 0.6))
    for name, experiment, color in (("rotation", "learned", "vermillion"), ("exact", "loops", "blue")):
        q = stored[experiment].array("q")[0, 0].astype(np.float64)
        frames = q[~np.isnan(q[:, 0])]
        scene.add_chain(
            puma.tracking_arm(), frames[0], name=f"{name} Jacobian", axes=False, color=COLORS[color]
        )
        if len(frames) > 1:
            scene.animate(f"{name} Jacobian", frames, frames_per_second=20)
        scene.add_path(
            puma.tracking_arm().forward(frames)[:, :3, 3], name=f"tool, {name} Jacobian", color=color
        )
    return scene


def agreement(table: Table) -> Markup:
    """Set how the learned maps agree with the exact one; errors of w in per cent of its largest value."""
    rows = table.where().set_index(["network", "case"])
    rows = rows[rows.index.isin((puma.ALIGNED, puma.RANDOM), level="case")]
    columns = {"reached": "IoU in reach", "unreached": "IoU out of reach", "right": "right"}
    errors = {
        "median_error": "median [%]",
        "ninth_decile": "nine in ten below [%]",
        "largest_error": "largest [%]",
    }
    of_w = (100 * rows[list(errors)]).rename(columns=errors).add_prefix("error of w, ")
    return show(rows[list(columns)].rename(columns=columns).join(of_w))


def maps_beside(stored: Evidence) -> Figure:
    """Draw two slices of the exact map, and of the differences of the networks from it."""
    fig, panels = plt.subplots(3, 2, figsize=(6.8, 9), sharex=True)
    half, exact = maps.TRAINED_HALF_SIDE, stored["exact"].array("slices")[0]
    top = np.nanmax(exact)
    look = {"origin": "lower", "extent": (-half, half, -half, half)}
    for ax, cut, w in zip(panels[0], CUTS, exact, strict=True):
        image = ax.imshow(w.T, vmin=0, vmax=top, **look)
        ax.set(title=f"exact, {cut}")
    fig.colorbar(image, ax=panels[0], label="w [m³]")
    for row, name, slices in zip(
        panels[1:], puma.NETWORKS, stored["learned"].array("slices")[0], strict=True
    ):
        for ax, cut, w, ours in zip(row, CUTS, exact, slices, strict=True):
            off = np.nan_to_num(ours) - np.nan_to_num(w)
            image = ax.imshow(off.T, vmin=-top / 2, vmax=top / 2, cmap="PuOr", **look)
            x, y = (np.linspace(-half, half, len(w))[i] for i in np.nonzero(np.isnan(ours) != np.isnan(w)))
            ax.plot(x, y, ".", ms=1.5, color=COLORS["vermillion"])
            ax.set(title=f"{name} − exact, {cut}")
        fig.colorbar(image, ax=row, label="difference of w [m³]")
    for row in panels:
        row[0].set(ylabel="z [m]")
        row[1].set(ylabel="y [m]")
    for ax in panels.flat:
        ax.grid(visible=False)
    plt.setp(panels[2], xlabel="x [m]")
    return fig


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
        extent = (-puma.HALF_SIDE, puma.HALF_SIDE, -puma.HALF_SIDE, puma.HALF_SIDE)
        shown = np.where(share > 0, share, np.nan)
        image = ax.imshow(shown.T, origin="lower", extent=extent, vmin=0, vmax=1)
        ax.set(title=name)
        ax.grid(visible=False)
    plt.setp(panels[1], xlabel="x [m]")
    plt.setp(panels[:, 0], ylabel="z [m]")
    fig.colorbar(image, ax=panels, label="share of the orientations")
    return fig


def runs(stored: Evidence) -> Markup:
    """Set the errors of the runs of the control loop."""
    exact = stored["loops"].where().assign(network="exact")
    rows = pd.concat([exact, stored["learned"].where().dropna(subset="ended")])
    factors = {
        "jacobian_error": ("Jacobian off by [%]", 100),
        "largest": ("position, largest [mm]", 1e3),
        "last": ("position, end [mm]", 1e3),
        "orientation": ("orientation, largest [mrad]", 1e3),
    }
    table = rows.set_index(["network", "case"])
    columns = {head: factor * table[metric] for metric, (head, factor) in factors.items()}
    return show(pd.DataFrame({**columns, "ended": table["ended"]}))


def errors(stored: Evidence) -> Figure:
    """Draw the error of the position over time, with and without feedback."""
    fig, panels = plt.subplots(2, 1, figsize=(6.8, 5.6), sharex=True, sharey=True)
    exact = stored["loops"].array("position_error")[0]
    curves = np.concatenate([exact, stored["learned"].array("position_error")[0]]).reshape(3, 2, -1)
    time = np.linspace(0, READING["rate-control-path"][1], curves.shape[-1])
    for name, color, own in zip(
        ("exact", *puma.NETWORKS), ("blue", "vermillion", "bluish green"), curves, strict=True
    ):
        for ax, error in zip(panels, own, strict=True):
            ax.semilogy(time[1:], 1e3 * error[1:], color=COLORS[color], label=name)
    for ax, case in zip(panels, (puma.FEEDBACK, puma.OPEN), strict=True):
        ax.set(title=case, ylabel="position error [mm]")
    panels[1].set(xlabel="time [s]")
    panels[0].legend(loc="lower right", fontsize="small")
    return fig
