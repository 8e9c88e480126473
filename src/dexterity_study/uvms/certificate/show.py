"""Figures and tables of the chapter on proved bounds, from rows of its experiments."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from dexterity import networks
from dexterity.networks.certificate import Certificate
from dexterity_study.engine.evidence import Evidence
from dexterity_study.page import figures
from dexterity_study.page.markup import Markup
from dexterity_study.page.tables import show
from dexterity_study.uvms.certificate.experiment import NETWORK, box_of_network

SLICE = (3, 2)
"""Joints of the slice among the seven that vary, horizontal and vertical: the elbow and the shoulder's second."""


def certificate(stored: Evidence, name: str) -> Certificate:
    """Return the stored certificate of the closest bound for a network or a polynomial."""
    table = stored["proofs"]
    row = table.where(approximation=name).sort_values("factor").iloc[0]
    network, box = networks.load_shipped(NETWORK), box_of_network()
    lower, upper = (np.array(limits)[list(network.inputs)] for limits in (box.lower, box.upper))
    tree, bounds = (table.array(f"{name}_{what}")[0] for what in ("tree", "bounds"))
    return Certificate(network.inputs, lower, upper, row["wanted"], 6, tree, bounds, row["reached"])


def parts_at_the_worst(stored: Evidence) -> Figure:
    """Draw the parts that a slice through the worst configuration cuts, coloured by their bounds."""
    one = certificate(stored, "network")
    network = networks.load_shipped(NETWORK)
    worst = np.array(network.card["worst_case"]["q"])[list(network.inputs)]
    lower, upper, _ = one.parts
    bounds = 100 * one.bounds[one.tree >= 254]
    across, up = SLICE
    held = [i for i in range(len(worst)) if i not in SLICE]
    # Faces are shared: of the parts on both sides of one the slice shows the lower.
    cut = ((lower[:, held] <= worst[held]) & (worst[held] <= upper[:, held])).all(1)
    scale = ScalarMappable(Normalize(0, 100 * one.wanted), "viridis")
    fig, ax = plt.subplots(figsize=(figures.WIDTH, 3.6))
    for corner, end, bound in zip(np.degrees(lower[cut]), np.degrees(upper[cut]), bounds[cut], strict=True):
        size = end - corner
        ax.add_patch(
            Rectangle(
                corner[list(SLICE)], size[across], size[up], fc=scale.to_rgba(bound), ec="white", lw=0.8
            )
        )
    ax.plot(*np.degrees(worst[list(SLICE)]), "o", color="black", mfc="white", ms=8, clip_on=False)
    limits = np.degrees([one.lower, one.upper])
    ax.set(xlim=limits[:, across], ylim=limits[:, up])
    ax.set(xlabel=f"joint {one.joints[across] + 1} [deg]", ylabel=f"joint {one.joints[up] + 1} [deg]")
    ax.grid(visible=False)
    fig.colorbar(scale, ax=ax, label="proved bound [%]")
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
            "proved [%]": 100 * rows["bound"],
            "parts": rows["parts"],
            "time [s]": rows["seconds"],
        }
    )
    table.index = pd.Index(rows["approximation"], name="")
    forms = {"found [%]": "{:.4f}", "proved [%]": "{:.4f}", "asked / found": "{:.2f}", "time [s]": "{:.0f}"}
    return show(table, forms=forms)


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
