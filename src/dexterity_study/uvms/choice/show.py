"""Figures and tables of the chapter on which network to use, from rows of its experiments."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import torch
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from dexterity.networks import train
from dexterity.networks.feed_forward import Readout
from dexterity.networks.levenberg_marquardt import Options
from dexterity.networks.network import View
from dexterity_study.claims.ledger import load_paper
from dexterity_study.engine.evidence import Evidence
from dexterity_study.page import figures
from dexterity_study.page.markup import Markup
from dexterity_study.page.numbers import with_range, written
from dexterity_study.page.tables import show
from dexterity_study.uvms.choice.verdicts import speeds
from dexterity_study.uvms.feed_forward.experiment import INDICES

_WAYS = {
    "as the paper": "KCI, as the paper",
    "1/KCI": "1/KCI",
    "log KCI": "log KCI",
    "log σ1 and log σ6": "log $σ_1$ and log $σ_6$",
    "origin seen from the vehicle": "log KCI, vehicle frame",
    "eigenvalue of 2×2": "2×2 eigenvalue",
    "eigenvalue of 3×3": "3×3 eigenvalue",
    "seen from the arm's first link": "3×3, frame of the arm",
    "+ rows on the faces": "+ points on faces",
    "+ twice the rows": "+ twice the points",
    "+ worst points": "+ worst points",
    "+ more neurons": "+ twice the neurons",
}
"""Ways of training in the words of the figure; up to the fourth, the paper's inputs."""

_SYSTEMS = {
    ("UVMS in other postures", "{}"): "UVMS, other postures",
    ("UVMS in other postures", "{}, slow vehicle"): "UVMS, slow vehicle",
    ("UVMS in other postures", "{} of the tool, body frame"): "UVMS, tool frame",
    ("UVMS with pitch and roll passive", "{}"): "UVMS, pitch and roll passive",
    ("UVMS confined to a plane", "{}"): "UVMS in a plane",
    ("docking arm on a vehicle", "{}"): "docking arm on a vehicle",
    ("PUMA 560 on a free base", "{}"): "PUMA 560 on a free base",
    ("PUMA 560, fixed", "{}"): "PUMA 560, fixed base",
}
"""Names of the systems of the page, by the stored system and the stored index, {} for w or KCI."""


def errors_by_function(stored: Evidence) -> Figure:
    """Draw the errors of networks and of simpler functions, for both indices."""
    fig, panels = plt.subplots(2, 1, figsize=(figures.WIDTH, 3.9), sharex=True)
    metrics = {
        "most": ("99 % of samples below", "|"),
        "sampled": ("largest sampled", "o"),
        "worst": ("worst case found", "^"),
    }
    for ax, index in zip(panels, INDICES, strict=True):
        rows = stored["judged"].where(index=index).set_index("what")
        for metric, (label, marker) in metrics.items():
            ax.plot(100 * rows[metric], rows.index, marker, ms=9 if marker == "|" else 6, mew=2, label=label)
        _draw_limit(ax)
        ax.set(xscale="log", title=_head(index))
        ax.xaxis.set_major_formatter("{x:g}")
        ax.margins(y=0.1)
        ax.invert_yaxis()
    panels[1].set(xlabel="relative error [%]")
    fig.legend(*panels[0].get_legend_handles_labels(), loc="outside upper center", ncols=2)
    return fig


def shipped(stored: Evidence) -> Markup:
    """Set the networks that come with the package against the exact indices, both in C."""
    rows = speeds(stored)
    table = pd.DataFrame(
        {
            "neurons": rows["neurons"],
            "worst case [%]": 100 * rows["worst"],
            "network [µs]": rows["network_1"] / 1000,
            "exact [µs]": rows["exact_1"] / 1000,
            "exact / network": rows["ratio"],
        }
    )
    names = [(_head(index), kind) for index, kind in table.index]
    table.index = pd.MultiIndex.from_tuples(names, names=[None, None])
    return show(table, "{:.3f}", forms={"worst case [%]": "{:.2f}"})


def errors_by_way(stored: Evidence) -> Figure:
    """Draw the largest error for KCI by way of training, every seed a dot."""
    fig, ax = plt.subplots(figsize=(figures.WIDTH, 3.8))
    for metric, label, marker in (("sampled", "largest sampled", "o"), ("worst", "worst case found", "^")):
        errors = 100 * stored["ways"].by_seed(metric, over="way").rename(columns=_WAYS)
        color = ax.plot(errors.median(), errors.columns, marker, ms=7, label=label)[0].get_color()
        for of_seed in errors.to_numpy():
            ax.plot(of_seed, errors.columns, marker, ms=3, alpha=0.4, color=color)
    _draw_limit(ax)
    ax.set(xscale="log", xlabel="relative error [%]")
    ax.set_xticks([1, 2, 5, 10, 20], labels=["1", "2", "5", "10", "20"])
    ax.minorticks_off()
    ax.invert_yaxis()
    fig.legend(loc="outside upper center", ncols=2)
    return fig


def _draw_limit(ax: Axes) -> None:
    limit = load_paper("sotiropoulos2016").printed("feed-forward-within-two-per-cent")
    ax.axvline(100 * limit, color="#595959", linestyle="--", label="limit of the paper")


class Tip(NamedTuple):
    """A function with a tip on a square, and networks that learned it, by the names of their outputs.

    `line` holds places (m) along a line through the tip, `exact` (m) and `answers` (m) values there, and `errors` the
    largest relative error on a grid of the whole square.
    """

    line: np.ndarray
    exact: np.ndarray
    answers: Mapping[str, np.ndarray]
    errors: Mapping[str, float]


def train_on_a_tip(neurons: int, seed: int, epochs: int = 100, rows: int = 1000, steps: int = 81) -> Tip:
    """Train two networks with as many neurons on exp(−‖x‖): with a smooth output, and with an eigenvalue."""
    random = torch.Generator().manual_seed(seed)
    x = 2 * torch.rand(rows, 2, generator=random, dtype=torch.float64) - 1
    line = torch.linspace(-1, 1, 201, dtype=torch.float64)
    through = torch.stack([line, torch.zeros_like(line)], dim=-1)
    # An odd number of steps has the tip itself.
    edge = torch.linspace(-1, 1, steps, dtype=torch.float64)
    square = torch.cartesian_prod(edge, edge)
    answers, errors = {}, {}
    outputs: Mapping[str, Readout] = {"smooth output": "identity", "smallest eigenvalue": "cone"}
    for name, readout in outputs.items():
        learned = train.for_seeds(
            View(2, (0, 1)), neurons, x, _tip(x), [seed], Options(epochs=epochs), readout=readout
        )
        network = learned[0].network
        with torch.no_grad():
            answers[name] = network(through).numpy()
            errors[name] = float((network(square) / _tip(square) - 1).abs().max())
    return Tip(line.numpy(), _tip(through).numpy(), answers, errors)


def _tip(x: torch.Tensor) -> torch.Tensor:
    return torch.exp(-x.norm(dim=-1))


def tip(example: Tip) -> Figure:
    """Draw a function with a tip and the networks that learned it, along a line through the tip."""
    fig, ax = plt.subplots(figsize=(figures.WIDTH, 3.2))
    ax.plot(example.line, example.exact, color="#808080", lw=4, alpha=0.6, label="function with a tip")
    for (name, values), line in zip(example.answers.items(), ("--", "-"), strict=True):
        error = written(100 * example.errors[name], "{:.2g}")
        ax.plot(example.line, values, line, label=f"{name}, error {error} %")
    ax.set(xlabel="$x_1$, with $x_2$ = 0", ylabel="value")
    fig.legend(loc="outside upper center")
    return fig


def selection(stored: Evidence) -> Markup:
    """Set networks that pass a test, and their errors elsewhere."""
    rows = stored["selection"].where()
    table = pd.DataFrame(
        {
            "limit [%]": 100 * rows["limit"],
            "neurons": rows["neurons"],
            "pass the test": rows["accepted"],
            "above the limit elsewhere": rows["broken"],
            "error in the test [%]": 100 * rows["testing"],
            "on held-out points [%]": 100 * rows["grid"],
            "worst case [%]": 100 * rows["worst"],
        }
    )
    return show(table.set_index("limit [%]"), "{:.2f}")


def pruned(stored: Evidence) -> Markup:
    """Set the neurons of radial-basis networks after pruning, and the errors that were allowed."""
    rows = stored["pruned"].where().assign(allowed=lambda own: 100 * own["allowed"])
    names = {"after": "neurons left", "allowed": "error allowed [%]"}
    by_index: dict[tuple[str, str], pd.Series] = {}
    for index in INDICES:
        own = rows[rows["index"] == index].set_index("spread")
        head = f"{_head(index)}, from {own['before'].iloc[0]} neurons"
        by_index |= {(head, name): own[metric] for metric, name in names.items()}
    return show(pd.DataFrame(by_index).rename_axis("spread [rad, m]"), "{:.1f}")


def elsewhere(stored: Evidence) -> Markup:
    """Set the errors of constants and networks for other systems, over the postures."""
    rows = stored["elsewhere"].where().set_index(["system", "index"])
    cells: dict[tuple[str, str], dict[str, str]] = {}
    for (system, form), name in _SYSTEMS.items():
        for index in INDICES:
            if (system, form.format(index)) in rows.index:
                own = 100 * rows[["constant", "error"]].loc[[(system, form.format(index))]]
                head = _head(index)
                cells.setdefault((head, "constant [%]"), {})[name] = written(
                    own["constant"].median(), "{:.2g}"
                )
                cells.setdefault((head, "network [%]"), {})[name] = with_range(own["error"], "{:.2g}")
    names = list(_SYSTEMS.values())
    return show(pd.DataFrame(cells, index=names).fillna("–"))


def _head(index: str) -> str:
    return "$w$" if index == "w" else index
