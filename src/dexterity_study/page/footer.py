"""The foot of a chapter: what its evidence was made from, when, and whether that still holds."""

from __future__ import annotations

from typing import Any

from dexterity_study.engine import card, evidence
from dexterity_study.engine.experiment import Experiment
from dexterity_study.engine.state import changed_since
from dexterity_study.page.markup import Cell, Markup, element, folded, table


def footer(*chapters: str) -> Markup:
    """Set the experiments of chapters with their runs, and whether they are current, accepted or out of date."""
    rows = {
        f"evidence-{chapter}-{name}".replace(".", "-"): _cells(experiment)
        for chapter in chapters
        for name, experiment in evidence.experiments(chapter).items()
    }
    shown = table("Evidence of this chapter", ("Experiment", "Runs", "Made", "State"), rows)
    return Markup(
        element("div", folded("Where the numbers of this page come from", shown), css_class="provenance")
    )


def _cells(experiment: Experiment) -> list[Cell]:
    cards = [
        card.read(place.card)
        for reading, seed in evidence.runs(experiment)
        if (place := evidence.files(experiment, reading, seed)).card.is_file()
    ]
    if not cards:
        return [Cell(experiment.name), Cell("none"), Cell("–"), Cell("not run")]
    made = [one["made"] for one in cards]
    dates = sorted({str(one["date"]) for one in made})
    machines = sorted({f"{one['processor']}, Python {one['versions']['python']}" for one in made})
    readings = f", {1 + len(experiment.readings)} readings" if experiment.readings else ""
    return [
        Cell(experiment.name),
        Cell(f"{len(experiment.seeds)} seed{'s'[: len(experiment.seeds) > 1]}{readings}"),
        Cell(" to ".join(dict.fromkeys([dates[0], dates[-1]])), "; ".join(machines)),
        _state(experiment, cards),
    ]


def _state(experiment: Experiment, cards: list[dict[str, Any]]) -> Cell:
    if changed := changed_since(experiment):
        return Cell("out of date", f"since then: {', '.join(changed)}")
    accepted = [entry for one in cards for entry in one.get("accepted", ())]
    if accepted:
        last = max(accepted, key=lambda entry: entry["date"])
        return Cell("accepted", f"{last['date']}: {last['reason']}")
    return Cell("current")
