"""Cards as text: Markdown with tables, and the short lines that stand at the head of exported code.

Examples
--------
>>> from dexterity.networks import card_text
>>> card_text.lines({"name": "mine", "worst_case": {"error": 0.01, "reached": [0.01] * 256}})
['name: "mine"', 'worst_case: {"error": 0.01, "reached": "256 numbers"}']
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from dexterity import checks

__all__ = ["facts", "limits", "lines", "markdown", "percent", "rows_of_errors"]

LONGEST = 16
"""Lists of more numbers than this are only counted at the head of exported code."""

PICTURES = ("histogram", "slices")
"""Entries that a page draws and that no text shows."""


@checks.arguments(card=checks.Instance(Mapping))
def lines(card: Mapping[str, Any]) -> list[str]:
    """Return a line for each entry of a card, long lists of numbers counted and not written out."""
    return [
        f"{key}: {json.dumps(_shortened(value), ensure_ascii=False)}"
        for key, value in card.items()
        if key not in PICTURES
    ]


def _shortened(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {key: _shortened(item) for key, item in value.items()}
    if not isinstance(value, list):
        return value
    if any(isinstance(item, list) for item in value):
        return f"{len(value)} rows"
    return f"{len(value)} numbers" if len(value) > LONGEST else [_shortened(item) for item in value]


@checks.arguments(card=checks.Instance(Mapping))
def markdown(card: Mapping[str, Any]) -> str:
    """Return a card in Markdown."""
    parts = [f"# {escaped(str(card.get('name', 'A network')))}"]
    if advice := card.get("advice"):
        parts.append(escaped(str(advice)))
    parts.append(_table(("", ""), facts(card)))
    if errors := rows_of_errors(card):
        parts += ["## Errors", _table(("error", "", "found"), errors)]
    if joints := limits(card):
        parts += ["## Space", _table(("coordinate", "from", "to"), joints)]
    return "\n\n".join(parts) + "\n"


@checks.arguments(card=checks.Instance(Mapping))
def facts(card: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Return what a card says in a line each: chain, index, size, training, operations and time."""
    chain, index = card.get("chain"), card.get("index")
    found = [
        ("chain", chain.get("name") if isinstance(chain, Mapping) else chain),
        ("index", _index(index)),
        ("network", _kind(card)),
        ("inputs", card.get("inputs")),
        ("training", _sentence(card.get("training"))),
        ("chosen", card.get("chosen")),
        ("operations", _sentence(card.get("operations"))),
        ("time of a configuration", _time(card.get("time"))),
        ("rounding", _sentence(card.get("rounding"))),
        ("train again", card.get("retrain")),
        ("licence", card.get("licence")),
    ]
    known = {"name", "advice", "kind", "neurons", "errors", "worst_case", "space", "time", "retrain"}
    known |= {"chain", "index", "inputs", "training", "chosen", "operations", "rounding", "licence"}
    known |= {"validation", "baselines", *PICTURES}
    further = [(key, _sentence(value)) for key, value in card.items() if key not in known]
    return [(name, str(value)) for name, value in (*found, *further) if value not in (None, "")]


@checks.arguments(card=checks.Instance(Mapping))
def rows_of_errors(card: Mapping[str, Any]) -> list[tuple[str, str, str]]:
    """Return the errors of a network and of what it is compared with: name, size and where it was found."""
    errors, worst = card.get("errors"), card.get("worst_case")
    rows: list[tuple[str, str, str]] = []
    if isinstance(errors, Mapping):
        points = f"{errors.get('count', '?')} fresh points"
        names = {"median": "median", "percentile_99": "99 % of the points", "maximum": "largest"}
        rows += [(title, percent(errors[key]), points) for key, title in names.items() if key in errors]
    if isinstance(worst, Mapping) and "error" in worst:
        rows.append(("worst case", percent(worst["error"]), str(worst.get("found_by", "search"))))
    baselines = card.get("baselines")
    if isinstance(baselines, Mapping):
        rows += [
            (f"{name} instead", percent(entry["maximum"]), "largest at the same points")
            for name, entry in baselines.items()
            if isinstance(entry, Mapping) and "maximum" in entry
        ]
    return rows


@checks.arguments(card=checks.Instance(Mapping))
def limits(card: Mapping[str, Any]) -> list[tuple[str, str, str]]:
    """Return the coordinates of a card's space with their limits, those that are held left out."""
    space = card.get("space")
    if not isinstance(space, Mapping):
        return []
    rows: list[tuple[str, str, str]] = []
    if space.get("kind") == "TaskSector":
        rows.append(("distance of the base [m]", _number(space["r_min"]), _number(space["r_max"])))
        rows += [(f"{name} [rad]", _number(-space[name]), _number(space[name])) for name in _ANGLES]
        box, first = space.get("rest"), 4
    else:
        box, first = space, 1
    if isinstance(box, Mapping):
        names = _joint_names(card)
        pairs = enumerate(zip(box.get("lower", ()), box.get("upper", ()), strict=False), start=first)
        rows += [(names.get(i, f"joint {i}"), _number(a), _number(b)) for i, (a, b) in pairs if a != b]
    return rows


_ANGLES = ("azimuth", "elevation")


def percent(value: Any) -> str:
    """Write a relative error with three digits."""
    if not isinstance(value, int | float):
        return str(value)
    return "0" if value == 0 else f"{100 * value:.{max(0, 2 - math.floor(math.log10(abs(100 * value))))}f} %"


def escaped(text: str) -> str:
    """Return a text whose characters mean nothing to Markdown or to a browser."""
    plain = "".join(c if c.isprintable() else " " for c in text)
    for character in "\\`*_[]|":
        plain = plain.replace(character, "\\" + character)
    return plain.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")


def _table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    cells = [head, ["---"] * len(head), *([escaped(cell) for cell in row] for row in rows)]
    return "\n".join(f"| {' | '.join(row)} |" for row in cells)


def _index(index: Any) -> str | None:
    if not isinstance(index, Mapping):
        return None if index is None else str(index)
    details = [
        f"{key} {_brief(value)}" for key, value in index.items() if key != "name" and value is not None
    ]
    return ", ".join([str(index.get("name", "")), *details])


def _kind(card: Mapping[str, Any]) -> str | None:
    return f"{card['kind']} of {card.get('neurons', '?')} neurons" if "kind" in card else None


def _time(time: Any) -> str | None:
    if not isinstance(time, Mapping):
        return None if time is None else str(time)
    each = time.get("ns_per_configuration")
    if not isinstance(each, Mapping):
        return _sentence(time)
    medians = ", ".join(f"{name} {values[1]} ns" for name, values in each.items())
    return f"{medians} ({time.get('both', 'one run')}; {time.get('processor', '')})"


def _sentence(entry: Any) -> str | None:
    if isinstance(entry, Mapping):
        return ", ".join(f"{key} {_brief(value)}" for key, value in entry.items())
    return None if entry is None else _brief(entry)


def _brief(value: Any) -> str:
    if isinstance(value, Mapping):
        return f"({_sentence(value)})"
    value = _shortened(value)
    if isinstance(value, list):
        return ", ".join(_brief(item) for item in value)
    return _number(value) if isinstance(value, float) else str(value)


def _number(value: Any) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def _joint_names(card: Mapping[str, Any]) -> dict[int, str]:
    chain = card.get("chain")
    names = chain.get("joint_names", ()) if isinstance(chain, Mapping) else ()
    return {i: str(name) for i, name in enumerate(names, start=1)}
