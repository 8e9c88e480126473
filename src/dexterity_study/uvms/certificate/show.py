"""Figures and tables of the chapter on proved bounds, from rows of its experiments."""

from __future__ import annotations

from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import torch
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from dexterity import networks, robots
from dexterity.networks.certificate import Certificate
from dexterity_study.engine.evidence import Evidence
from dexterity_study.page import figures
from dexterity_study.page.markup import Markup
from dexterity_study.page.numbers import power_of_ten
from dexterity_study.page.tables import show
from dexterity_study.uvms.certificate.experiment import NETWORK, box_of_network

SLICE = (3, 2)
"""Joints of the slice, counted from 0 among the seven that vary: horizontal and vertical."""


def certificate(stored: Evidence, name: str) -> Certificate:
    """Return the stored certificate of the closest bound for a network or a polynomial."""
    table = stored["proofs"]
    row = table.where(approximation=name).sort_values("factor").iloc[0]
    network, box = networks.load_shipped(NETWORK), box_of_network()
    lower, upper = (np.array(limits)[list(network.inputs)] for limits in (box.lower, box.upper))
    tree, bounds = (table.array(f"{name}_{what}")[0] for what in ("tree", "bounds"))
    return Certificate(
        network.inputs, lower, upper, float(row["wanted"]), 6, tree, bounds, float(row["reached"])
    )


def in_short(stored: Evidence) -> str:
    """Say how close the proved bound is to the largest error found, and what the proof takes."""
    row = stored["proofs"].where(approximation="network").sort_values("factor").iloc[0]
    return (
        f"The relative error is at most {_rounded_up(row['bound']):.4f} %, and this is proved. A search in the same box finds "
        f"{100 * row['found']:.4f} %, so the bound is {row['bound'] / row['found'] - 1:.0%} larger than the largest error found. "
        f"The proof takes {row['seconds']:.0f} seconds on one core."
    )


@torch.no_grad()
def parts_at_the_worst(stored: Evidence) -> Figure:
    """Draw the error in a slice through the worst configuration, and the parts of the proof that the slice cuts."""
    one, network = certificate(stored, "network"), networks.load_shipped(NETWORK)
    worst = torch.tensor(network.card["worst_case"]["q"], dtype=torch.float64)
    across, up = (one.joints[i] for i in SLICE)
    x, y = (torch.linspace(one.lower[i], one.upper[i], 81).double() for i in SLICE)
    q = worst.repeat(len(y), len(x), 1)
    q[..., across], q[..., up] = torch.meshgrid(x, y, indexing="xy")
    error = 100 * (network(q) / network.card.index().bind(robots.uvms())(q) - 1).abs()
    fig, ax = plt.subplots(figsize=(figures.WIDTH, 3.6))
    mesh = ax.pcolormesh(np.degrees(x), np.degrees(y), error, cmap="viridis", vmin=0, rasterized=True)
    lower, upper, _ = one.parts
    point = worst[list(one.joints)].numpy()
    held = [i for i in range(len(point)) if i not in SLICE]
    cut = ((lower[:, held] <= point[held]) & (point[held] <= upper[:, held])).all(1)
    for corner, size in zip(np.degrees(lower[cut]), np.degrees(upper[cut] - lower[cut]), strict=True):
        i, j = SLICE
        ax.add_patch(
            Rectangle((corner[i], corner[j]), size[i], size[j], fill=False, ec="white", lw=1, zorder=2)
        )
    ax.plot(*np.degrees(worst[[across, up]]), "o", color=figures.ON_COLOR, mfc="white", ms=8, clip_on=False)
    ax.set(xlabel=f"joint {across + 1} [deg]", ylabel=f"joint {up + 1} [deg]")
    ax.grid(visible=False)
    fig.colorbar(mesh, ax=ax, label="relative error [%]")
    return fig


def depths(stored: Evidence) -> Figure:
    """Draw how many parts there are after each number of bisections."""
    fig, ax = plt.subplots(figsize=(figures.WIDTH, 2.6))
    for name, marker in (("network", "o"), ("cubic", "s")):
        counts = np.bincount(certificate(stored, name).parts[2])
        numbers = np.flatnonzero(counts)
        ax.plot(numbers, counts[numbers], marker, ls="-", label=f"{name}, {counts.sum():,} parts")
    ax.set(xlabel="bisections", ylabel="parts", yscale="log")
    ax.legend()
    return fig


def proofs(stored: Evidence) -> Markup:
    """List the bounds that were proved with the work that they took."""
    rows = stored["proofs"].where()
    table = pd.DataFrame(
        {
            "found [%]": 100 * rows["found"],
            "asked / found": rows["factor"],
            "proved [%]": _rounded_up(rows["bound"]),
            "parts": rows["parts"],
            "time [s]": rows["seconds"],
        }
    )
    table.index = pd.Index(rows["approximation"], name="")
    forms = {"found [%]": "{:.4f}", "proved [%]": "{:.4f}", "asked / found": "{:.2f}", "time [s]": "{:.0f}"}
    return show(table, forms=forms)


def _rounded_up(bound: Any) -> Any:
    """Return a bound in per cent with four digits, and never less than it is."""
    return np.ceil(1e6 * bound) / 1e4


def checks(stored: Evidence) -> Markup:
    """Count the parts that were proved again by other arithmetic."""
    rows = stored["checked"].where()
    facts = {
        "parts of the certificate": int(rows["parts"].iloc[0]),
        "proved again by mpmath": int(rows["confirmed"].sum()),
        "tried": int(rows["tried"].sum()),
        "proved again by the compiled code": bool(rows["compiled_again"].all()),
    }
    return show(pd.Series(facts, name="network for w"))


def conditioning(stored: Evidence) -> Figure:
    """Draw for KCI which share of boxes can be bounded, and how the bound grows with the box."""
    rows = stored["conditioning"].where()
    sums = rows.groupby("half_width")[["bounded", "within_limit", "draws"]].sum()
    fig, (shares, bounds) = plt.subplots(2, 1, figsize=(figures.WIDTH, 4.4), sharex=True)
    shares.plot(sums.index, 100 * sums["bounded"] / sums["draws"], "o-", label="any bound")
    shares.plot(sums.index, 100 * sums["within_limit"] / sums["draws"], "s--", label="at most 2 %")
    shares.set(ylabel="boxes [%]", ylim=(0, 105))
    shares.legend()
    medians = rows.pivot_table("median", "seed", "half_width")
    bounds.plot(medians.columns, 100 * medians.median(), "o-")
    bounds.set(xscale="log", yscale="log", xlabel="half width [rad or m]", ylabel="median bound [%]")
    bounds.xaxis.set_major_formatter("{x:g}")
    bounds.yaxis.set_major_formatter("{x:g}")
    bounds.minorticks_off()
    return fig


def reach_of_kci(stored: Evidence) -> str:
    """Say for how many boxes a bound for KCI is proved, and how many of them the whole space takes."""
    sums = stored["conditioning"].where().groupby("half_width")[["bounded", "draws"]].sum()
    small, middle, large = sums.index[[-3, -2, -1]]
    parts = power_of_ten(f"1e{11 * np.log10(np.radians(15.0) / middle):.0f}").removeprefix("1 × ")
    return (
        f"At a half width of {small:g} (rad or m), one model proves a bound for {sums['bounded'][small]:.0f} of {sums['draws'][small]:.0f} "
        f"boxes. At {large:g} it proves one for {sums['bounded'][large]:.0f}, since most boxes then hold a kink. Eleven "
        f"coordinates of ±15° take about {parts} boxes of {middle:g}."
    )
