"""Tables of the chapter on a network for the area measure."""

from __future__ import annotations

import pandas as pd
from torch import Tensor

from dexterity.timing import Timing, ratio
from dexterity_study.docking.area.show import by_arm
from dexterity_study.docking.cases import ARMS
from dexterity_study.docking.stand_in.experiment import FIRST
from dexterity_study.engine.evidence import Evidence
from dexterity_study.page.markup import Markup
from dexterity_study.page.tables import over_seeds, show


def quarter_turns(values: Tensor) -> Markup:
    """Set M_a [m³] of four poses after no, one, two and three quarter turns (4, 4)."""
    table = pd.DataFrame(values.numpy(), ["no turn", "one", "two", "three"], list("abcd"))
    return show(table, "{:.4f}")


def errors(stored: Evidence) -> Markup:
    """Set errors on all poses, and on those where M_a is above half of the largest, by arm and way."""
    rows, of = by_arm(stored["ways"]), {"median": "median", "most": "99 %", "largest": "largest"}
    heads = {f"{name}_{size}": f"{name}, {title}" for name in ("all", "high") for size, title in of.items()}
    rows[[*heads]] *= 100
    return show(over_seeds(rows, ["arm", "way"], heads))


def times(stored: Evidence) -> Markup:
    """Set times to rate poses, and after how many poses a network has saved the time that its teaching took."""
    rows = {}
    for arm, reading in ARMS.items():
        timed = stored["times"].where(reading)[["name", "configurations", "lower", "median", "upper"]]
        teaching, network, *others = (Timing(*one) for one in timed.itertuples(index=False))
        rows[arm, network.name] = (f"{1e6 * network.median:.3g}", "1", "–")
        for one in others:
            slower, saved = ratio(one, network), one.median - network.median
            pays = slower.distinguishable and saved > 0
            poses = f"{teaching.median / saved:,.0f}" if pays else "–"
            rows[arm, one.name] = (f"{1e6 * one.median:.3g}", str(slower), poses)
    columns = ["a pose [μs]", "over the network's", "poses that pay for teaching"]
    return show(pd.DataFrame(rows, index=columns).T)


def searches(stored: Evidence) -> Markup:
    """Set what rankings of the pool are good for."""
    rows, best = by_arm(stored["ways"]), {f"best_of_{count}": f"best of {count} [%]" for count in FIRST}
    rows[[*best]] *= 100
    looks = {"needed": "looked at, within 1 %", "proven": "looked at, proof"}
    by = ["arm", "way"]
    return show(over_seeds(rows, by, best).join(over_seeds(rows, by, looks, "{:,.0f}")))
