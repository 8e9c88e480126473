"""Figures and tables of the chapter on feed-forward networks, from rows of its experiments."""

from __future__ import annotations

from collections.abc import Mapping
from typing import cast

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from dexterity.networks.design import Design
from dexterity.networks.problem import DesignProblem
from dexterity_study.claims.ledger import load_paper
from dexterity_study.engine.evidence import Evidence
from dexterity_study.engine.readings import Reading
from dexterity_study.page import diagrams, figures
from dexterity_study.page.diagrams import Arrow, Box
from dexterity_study.page.markup import Markup
from dexterity_study.page.numbers import with_range, written
from dexterity_study.page.tables import over_seeds, show
from dexterity_study.uvms.feed_forward.experiment import AS_PRINTED, GOALS, LARGER, LIMIT, LIMITS, TRAINED_ON
from dexterity_study.uvms.feed_forward.verdicts import ends

_KINDS = {AS_PRINTED: "with the goal of the paper", TRAINED_ON: "without a goal"}
_RULES = {"factor": "toolbox rule", "gain_ratio": "gain ratio"}
_READINGS = {
    "initial-weights=best-of-ten": "best of ten initial weights",
    "task-point=world-origin": "task point at the origin",
}
"""Names of kinds of training, damping rules and readings on the page."""


def settings() -> Markup:
    """Set Table 3 of the paper, the settings of both design loops, with our reading of each row."""
    paper, reading = load_paper("sotiropoulos2016"), Reading.chosen("sotiropoulos2016")

    def of(name: str, kind: str) -> tuple[str, str]:
        w, kci = paper.printed(f"{kind}-{name}")
        return written(float(w)), written(float(kci))

    none = ("–", "–")
    tested = (written(float(paper.printed("test-set-size"))),) * 2
    spreads = tuple(written(float(limit)) for limit in paper.printed("spread-limit"))
    first, step = cast(tuple[float, float], reading["spread-steps"])
    gives_up = " and ".join(f"{limit} ({index})" for index, limit in LIMITS.items())
    rows = {
        r"$E$, testing error": (
            *of("testing-error-limit", "radial-basis"),
            *of("testing-error-limit", "feed-forward"),
            "largest relative error on the test set",
        ),
        r"$E_{mse}$, training error": (
            *of("training-error-goals", "radial-basis"),
            *of("training-error-goals", "feed-forward"),
            "in units of the index, squared",
        ),
        r"$E_{th}$, error threshold": (
            *of("error-thresholds", "radial-basis"),
            *none,
            "in units of the index, squared",
        ),
        r"$L_{iter}$, neurons": (
            *none,
            *of("neuron-limit", "feed-forward"),
            f"radial-basis {reading['radial-basis-neuron-limit']}; feed-forward {gives_up}, and as printed for the verdicts",
        ),
        r"$L_{epochs}$, epochs": (*none, *of("epoch-limit", "feed-forward"), "steps of the trainer"),
        r"$L_s$, largest spread": (*spreads, *none, f"from {first:g} in steps of {step:g}, rad and m"),
        r"$T$, test points": (*tested, *tested, "drawn as the training set is"),
    }
    heads = ["RBFN, $w$", "RBFN, KCI", "FFBN, $w$", "FFBN, KCI", "our reading"]
    return show(pd.DataFrame.from_dict(rows, orient="index", columns=heads).rename_axis("setting"))


def architecture() -> Figure:
    """Draw the feed-forward network for w of the printed size, Fig. 4 of the paper."""
    neurons = load_paper("sotiropoulos2016").printed("feed-forward-w-neurons")
    return diagrams.layers([f"θ{n}" for n in range(5, 12)], int(neurons), np.tanh, "w")


def flow_chart(design: Design) -> Figure:
    """Draw the design loop, Fig. 6a of the paper, with how often a run passed each box and where it ended."""
    x = 1.6
    boxes = {
        "start": Box("network with one neuron", (x, 4.4), height=0.36),
        "train": Box("train until $e_{mse} \\leq E_{mse}$\nor $L_{epochs}$ steps", (x, 3.65)),
        "test": Box("test: $e \\leq E$ ?", (x, 2.75), asks=True),
        "full": Box("$L_{iter}$ neurons reached?", (x, 1.85), asks=True),
        "add": Box("add a neuron", (x, 1.05), height=0.36),
        "pass": Box("return\nthis network", (3.7, 2.75), width=1.25),
        "stop": Box("return the\nbest network", (3.7, 1.85), width=1.25),
    }
    arrows = (
        Arrow([(x, 4.22), (x, 3.9)]),
        Arrow([(x, 3.4), (x, 3.0)]),
        Arrow([(x, 2.5), (x, 2.1)], "no", (x - 0.3, 2.25)),
        Arrow([(x, 1.6), (x, 1.23)], "no", (x - 0.3, 1.36)),
        Arrow([(2.8, 2.75), (3.075, 2.75)], "yes", (2.75, 2.55)),
        Arrow([(2.8, 1.85), (3.075, 1.85)], "yes", (2.75, 1.65)),
        Arrow([(x, 0.87), (x, 0.65), (0.15, 0.65), (0.15, 3.65), (0.4, 3.65)]),
    )
    return diagrams.flow_chart(boxes, arrows, *passages(design), height=4.7)


def passages(design: Design) -> tuple[dict[str, int], str]:
    """Return how often a run of the loop passed each box of its flow chart, and the box where it ended."""
    trained = len(design.trials)
    last = "pass" if design.success else "stop"
    failed = trained - design.success
    passed = {"start": 1, "train": trained, "test": trained, "full": failed, "add": trained - 1, last: 1}
    return {name: count for name, count in passed.items() if count}, last


def error_by_size(stored: Evidence) -> Figure:
    """Draw the testing error against neurons, Figs. 10 and 14 of the paper."""
    fig, panels = plt.subplots(2, 1, figsize=(figures.WIDTH, 4.8))
    loop = stored["loop"].where(index="KCI").assign(kind=AS_PRINTED)
    rows_of = pd.concat([stored["sizes"].where(), loop]).groupby(["index", "kind"]).get_group
    for ax, index, ticks in zip(panels, GOALS, ((0.1, 0.2, 0.5, 1, 2), (2, 5, 10, 20)), strict=True):
        for kind, color in ((AS_PRINTED, "C1"), (TRAINED_ON, "C0")):
            errors = 100 * rows_of((index, kind)).pivot(
                index="neurons", columns="seed", values="testing_error"
            )
            ax.plot(errors, color=color, lw=0.7, alpha=0.3)
            ax.plot(errors.median(axis=1), "o-", color=color, ms=4, label=_KINDS[kind])
        printed = load_paper("sotiropoulos2016").printed(f"feed-forward-{index.lower()}-neurons")
        ax.plot(printed, 100 * LIMIT, "D", color="C2", fillstyle="none", mew=2, ms=10, label="the paper")
        ax.axhline(100 * LIMIT, color="#595959", ls=":", label="limit of the paper")
        ax.set(yscale="log", title=_head(index), ylabel="testing error [%]")
        ax.set_yticks(ticks, labels=ticks)
        ax.minorticks_off()
    panels[1].set(xlabel="neurons")
    for ax in panels:
        ax.xaxis.get_major_locator().set_params(integer=True)
    fig.legend(*panels[0].get_legend_handles_labels(), loc="outside upper center", ncols=2)
    return fig


def trials(design: Design, stored: Evidence) -> str:
    """Say where a live run of the printed loop for w ends, next to the stored loops."""
    tried = ", ".join(f"{trial.testing_error:.2%}" for trial in design.trials)
    neurons = with_range(ends(stored, "w").query("reading == 'chosen'")["neurons"], "{:.0f}")
    return (
        f"Testing errors with one, two, … neurons: {tried}. The loop ends at {design.best.neurons} neurons; the stored loops "
        f"end at {neurons} neurons."
    )


def goals(sets: Mapping[str, DesignProblem]) -> str:
    """Say what the goals of the paper mean as relative errors, for the training sets of both indices."""
    shares = {
        index: 100 * GOALS[index] ** 0.5 / float(own.data.train.values.mean()) for index, own in sets.items()
    }
    words = [
        f"the goal for {_head(index)} is a root mean square error of {written(share, '{:.2g}')} % of its mean value"
        for index, share in shares.items()
    ]
    return f"On the training sets of seed 0, {' and '.join(words)}. The limit of {100 * LIMIT:g} % is for the largest error."


def loops(stored: Evidence) -> Markup:
    """Set where the loop of this chapter ends or is cut, and what the networks that it returns are worth."""
    rows = pd.concat([ends(stored, index).assign(index=_head(index)) for index in GOALS]).reset_index()
    names = {"chosen": _RULES["factor"], "damping-rule=gain-ratio": _RULES["gain_ratio"]}
    rows = rows.assign(rule=rows["reading"].map(names))
    percents = ["testing_error", "fresh", "above"]
    rows[percents] *= 100
    keys = ["index", "rule"]
    groups = rows.groupby(keys, sort=False)
    passed = groups["passes"].agg(lambda own: f"{own.sum()} of {len(own)}").rename("loops that pass")
    sizes = over_seeds(rows, keys, {"neurons": "neurons"}, "{:.0f}")
    metrics = {"testing_error": "testing error [%]", "fresh": "on held-out points [%]"}
    errors = over_seeds(rows, keys, metrics, "{:.2f}")
    above = over_seeds(rows, keys, {"above": "held-out points above the limit [%]"}, "{:.2f}")
    return show(pd.concat([passed, sizes, errors, above], axis="columns").rename_axis([None, None]))


def error_by_epoch(stored: Evidence) -> Figure:
    """Draw the mean square error against epochs without a goal, Figs. 11 and 15 of the paper."""
    fig, panels = plt.subplots(2, 1, figsize=(figures.WIDTH, 4.4), sharex=True)
    for ax, (index, goal) in zip(panels, GOALS.items(), strict=True):
        for color, (rule, label) in zip(("C1", "C0"), _RULES.items(), strict=True):
            histories = stored["printed_sizes"].array(f"{index}_{rule}")
            ax.plot(histories.T, color=color, lw=0.7, alpha=0.3)
            ax.plot(np.median(histories, axis=0), color=color, label=label)
        ax.axhline(goal, color="#595959", ls="--", label="goal of the paper")
        ax.set(yscale="log", title=f"{_head(index)}, {LARGER[index][0]} neurons", ylabel="mean square error")
    panels[1].set(xlabel="epochs")
    fig.legend(*panels[0].get_legend_handles_labels(), loc="outside upper center", ncols=2)
    return fig


def judged(stored: Evidence) -> Markup:
    """Set networks of the printed sizes, and larger ones for w, on points that no loop has tested."""
    grid = stored["whole_grid"].where().assign(kind="trained on the whole grid")
    rows = pd.concat([stored["printed_sizes"].where(None), grid])
    is_chosen = rows["reading"] == "chosen"
    other = (rows["kind"] == AS_PRINTED) & rows["reading"].isin(_READINGS)
    # The task point moves KCI alone.
    other &= (rows["index"] == "KCI") | (rows["reading"] != "task-point=world-origin")
    rows = rows[(is_chosen | other) & (rows["neurons"] != 24)]
    rows = rows.assign(index=rows["index"].map(_head), name=rows.apply(_name, axis="columns"))
    metrics = {
        "testing_error": "test set",
        "between": "held-out, 1,000",
        "fresh": "held-out, many",
    }
    rows[list(metrics)] *= 100
    table = over_seeds(rows, ["index", "name"], metrics, "{:.2f}")
    ordered = table.loc[[_head(index) for index in GOALS]]
    return show(ordered.rename_axis([None, None]))


def _name(row: pd.Series) -> str:
    kind = _READINGS.get(row["reading"], _KINDS.get(row["kind"], row["kind"]))
    return f"{row['neurons']} neurons, {kind}"


def _head(index: str) -> str:
    return "$w$" if index == "w" else index
