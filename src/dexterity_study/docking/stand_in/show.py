"""Tables of the chapter on a network for the area measure."""

from __future__ import annotations

from typing import Any

import pandas as pd

from dexterity.timing import Timing, ratio
from dexterity_study.docking.cases import ARMS
from dexterity_study.docking.stand_in.experiment import FIRST
from dexterity_study.engine.evidence import Evidence
from dexterity_study.engine.table import Table
from dexterity_study.page.markup import Markup
from dexterity_study.page.tables import over_seeds, show

BY = ["arm", "way"]
LABELS = {reading: f"{arm} arm" for arm, reading in ARMS.items()}


def sizes(stored: Evidence, live: Table) -> Markup:
    """Set root mean square errors on the validation set by number of neurons."""
    rows = stored["networks"].where(None)
    rows = pd.concat(
        [rows.assign(arm=rows["reading"].map(LABELS)), live.where().assign(arm="stated arm, live")]
    )
    rows["error"] = 100 * rows["validation"]
    return show(over_seeds(rows, ["arm", "neurons"], {"error": "error [%]"}))


def ways(stored: Evidence) -> pd.DataFrame:
    """Return what was judged, by arm, way and seed: networks, then the exact measure over few points."""
    network, few = stored["networks"].where(None), stored["exact"].where(None)
    few = few.assign(way=few["points"].map("{} points".format))
    rows = pd.concat([network.assign(way="network"), few], ignore_index=True).dropna(subset="needed")
    arms = rows["reading"].map(LABELS)
    return rows.assign(arm=arms).sort_values("arm", ascending=False, kind="stable")


def errors(stored: Evidence) -> Markup:
    """Set errors on fresh poses, all and those where M_a is above half of the largest, by arm and way."""
    rows, of = ways(stored), {"median": "median", "most": "99 %", "largest": "largest"}
    heads = {f"{name}_{size}": f"{name}, {title}" for name in ("all", "high") for size, title in of.items()}
    rows[[*heads]] *= 100
    return show(over_seeds(rows, BY, heads))


def times(stored: Evidence) -> Markup:
    """Set times to rate poses, and after how many poses a network has saved the time that its teaching took."""
    rows: dict[tuple[str, str], dict[str, Any]] = {}
    for reading, arm in LABELS.items():
        teaching = stored["times"].where(reading, task="teach")["median"].item()
        rate = stored["times"].where(reading, task="rate")
        quartiles = rate[["way", "configurations", "lower", "median", "upper"]].itertuples(index=False)
        network, *others = (Timing(*one) for one in quartiles)
        rows[arm, network.name] = {"a pose [μs]": 1e6 * network.median}
        for one in others:
            slower = ratio(one, network)
            rows[arm, one.name] = {"a pose [μs]": 1e6 * one.median, "over the network's": str(slower)}
            if slower.distinguishable and slower.value > 1:
                poses = teaching / (one.median - network.median)
                rows[arm, one.name]["poses that pay for teaching"] = f"{poses:,.0f}"
    return show(pd.DataFrame.from_dict(rows, orient="index"))


def searches(stored: Evidence) -> Markup:
    """Set what rankings of the pool are good for, and the times of searches by them."""
    rows, times = ways(stored), stored["times"].where(None, task="search")
    best = {f"best_of_{count}": f"best of {count} [%]" for count in FIRST}
    rows[[*best]] *= 100
    looks = {"needed": "looked at, within 1 %", "proven": "looked at, proof"}
    table = over_seeds(rows, BY, best).join(over_seeds(rows, BY, looks, "{:,.0f}"))
    times = times.assign(arm=times["reading"].map(LABELS)).set_index(BY)
    table["search [ms]"] = (1e3 * times["median"] * times["configurations"]).map("{:.3g}".format)
    return show(table)
