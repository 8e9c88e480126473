"""Figures and tables of the chapter on what beats the methods of paper D."""

from __future__ import annotations

from typing import Any

import matplotlib.pyplot as plt
import pandas as pd
from matplotlib.figure import Figure

from dexterity.crane import positioning
from dexterity_study.crane.beyond.experiment import COROTATIONAL
from dexterity_study.crane.beyond.verdicts import loop, times
from dexterity_study.engine.evidence import Evidence
from dexterity_study.engine.table import Table
from dexterity_study.page.markup import Markup
from dexterity_study.page.tables import over_seeds, show

KINDS = ("mean", "largest")


def placed(task: positioning.Task, placement: positioning.Placement) -> Markup:
    """Set the strokes that position a point, and the error that is left."""
    missed = positioning.errors(task, placement).distance
    rows = pd.DataFrame(placement.strokes.numpy(), columns=["s1 [m]", "s2 [m]", "s3 [m]"])
    return show(rows.assign(**{"error [mm]": [f"{error:.1e}" for error in 1e3 * missed]}), "{:.6f}")


def loops(stored: Evidence) -> Markup:
    """Set errors [mm] by the number of structural solves."""
    names = ("linear", "co-rotational")
    columns = {f"{name}, {kind}": 1e3 * loop(stored, name)[kind] for name in names for kind in KINDS}
    return show(pd.DataFrame(columns).rename(index=str))


def methods(stored: Evidence, live: Table) -> Markup:
    """Set errors [mm] on linear statics: on the test, live besides, and at fresh points."""
    kinds = {"test_mean": "mean", "test_largest": "largest"}
    kinds |= {"fresh_mean": "fresh, mean", "fresh_99": "fresh, 99 %", "fresh_largest": "fresh, largest"}
    columns = _in_mm(_methods(stored), "method", kinds)
    columns.insert(1, "mean, live", _in_mm(live.where(), "method", {"test_mean": "mean"})["mean"])
    return show(columns.fillna("–"))


def corotational(stored: Evidence) -> Markup:
    """Set errors [mm] on the co-rotational structure."""
    itself = loop(stored, "co-rotational").tail(1).rename(columns={k: f"corotational_{k}" for k in KINDS})
    rows = pd.concat([_methods(stored), itself.assign(method=COROTATIONAL)])
    return show(_in_mm(rows, "method", {f"corotational_{kind}": kind for kind in KINDS}))


def speed(stored: Evidence, of: str) -> Markup:
    """Set processor times [µs] of sags or points, median and quartiles, at once and one by one."""
    at_once, alone = (
        1e6 * times(stored, of, points)[["median", "lower", "upper"]] for points in ("at once", "one by one")
    )
    columns = {
        f"{title} [µs]": own.map(_three_digits).apply(lambda row: "{} ({}–{})".format(*row), axis=1)
        for title, own in (("at once", at_once), ("one by one", alone))
    }
    columns["a second, at once"] = (1e6 / at_once["median"]).map("{:,.0f}".format)
    return show(pd.DataFrame(columns).reindex(alone.index).fillna("–"))


def trade(stored: Evidence) -> Figure:
    """Draw the mean error on the test, each method's on its structure, against the time for a point."""
    errors = _methods(stored).groupby("method")["test_mean"].median()
    errors[COROTATIONAL] = loop(stored, "co-rotational")["mean"].iloc[-1]
    at_once, alone = (1e3 * times(stored, "point", points)["median"] for points in ("at once", "one by one"))
    fig, ax = plt.subplots(figsize=(6.8, 5.6))
    for marker, (name, slow) in zip("osD^v<>PX*hpd8", alone.items(), strict=False):
        error = 1e3 * errors[str(name)]
        ax.loglog([at_once.get(name, slow), slow], [error, error], f"{marker}-", linewidth=1, label=name)
    ax.set(xlabel="processor time for a point [ms]", ylabel="mean error on the test [mm]")
    fig.legend(loc="outside upper center", ncols=2, fontsize="small")
    return fig


def remedies(stored: Evidence) -> Markup:
    """Set errors [mm] with the data that the thesis wishes for."""
    lighter = stored["lighter_payloads"].where().assign(method="method 1")
    rows = pd.concat([lighter, stored["even_data"].where()])
    heads = {"spot": "(2, 2), 30 kg", "light": "mean with 30 kg", "mean": "mean", "largest": "largest"}
    return show(_in_mm(rows, ["method", "data"], heads))


def sizes(stored: Evidence) -> Markup:
    """Set errors [mm] of method 4 by size of the crane."""
    rows = stored["smaller_crane"].where()
    rows["beside"] = rows["mean"] / rows["size"]
    heads = {"mean": "mean", "largest": "largest", "beside": "mean, of the first crane's size"}
    columns = _in_mm(rows, "size", heads).join(rows.groupby("size")["amplification"].first())
    return show(columns.rename(index=_size))


def tables(stored: Evidence) -> Markup:
    """Set the largest error [mm] of tables by the number of their entries, and by size of the crane."""
    errors = 1e3 * stored["tables"].where().pivot(index="entries", columns="size", values="largest")
    columns = errors.sort_index(axis="columns", ascending=False).rename_axis(columns=None)
    return show(columns.rename(index="{:,}".format, columns=_size))


def _methods(stored: Evidence) -> pd.DataFrame:
    return pd.concat([stored["learned_methods"].where(), stored["exact_methods"].where()])


def _in_mm(rows: pd.DataFrame, index: str | list[str], heads: dict[str, str]) -> pd.DataFrame:
    """Write medians and ranges over the seeds [mm]."""
    return over_seeds(rows.assign(**{name: 1e3 * rows[name] for name in heads}), index, heads)


def _size(size: Any) -> str:
    return "the crane" if size == 1 else f"{size:g} times its size"


def _three_digits(value: float) -> str:
    return f"{value:,.0f}" if value >= 100 else f"{value:.3g}"
