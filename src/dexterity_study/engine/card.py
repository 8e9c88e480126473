"""The card of a run: what made it, when, on what, and under which changes it was accepted since."""

from __future__ import annotations

import importlib.metadata
import json
from collections.abc import Mapping
from datetime import UTC, date, datetime
from pathlib import Path
from types import MappingProxyType
from typing import Any

from dexterity import store
from dexterity.timing.machine import Machine
from dexterity_study.engine import sources


def made(module: str, seconds: float, programs: Mapping[str, str] = MappingProxyType({})) -> dict[str, Any]:
    """Describe a run that has just ended: command, date, duration, machine, and versions.

    They are those of what `module` imports, and of `programs` that were run outside of Python.
    """
    machine = Machine.present()
    return {
        "command": "make evidence",
        "date": datetime.now(UTC).date(),
        "seconds": round(seconds, 1),
        "processor": machine.processor,
        "threads": machine.threads,
        "versions": {"python": machine.python, **versions(module), **programs},
    }


def versions(module: str) -> dict[str, str]:
    """Return the versions of the distributions that a module's closure imports."""
    distributions = importlib.metadata.packages_distributions()
    names = {one for name in sources.imported_distributions(module) for one in distributions.get(name, ())}
    return {name: importlib.metadata.version(name) for name in sorted(names, key=str.lower)}


def read(file: Path) -> dict[str, Any]:
    """Read a card.

    Raises
    ------
    FileNotFoundError
        If there is none.
    ValueError
        If it is no TOML, or does not say what was made.
    """
    card = store.read_toml(file)
    if not isinstance(card.get("made"), dict) or not isinstance(card.get("accepted", []), list):
        raise ValueError(f"{file} is no card of a run: it has no [made]")
    return card


def write(file: Path, card: Mapping[str, Any]) -> None:
    """Write a card: `[made]`, `[made.versions]`, and an `[[accepted]]` for each acceptance."""
    facts = {name: value for name, value in card["made"].items() if name != "versions"}
    blocks = [("[made]", facts), ("[made.versions]", card["made"].get("versions", {}))]
    blocks += [("[[accepted]]", entry) for entry in card.get("accepted", ())]
    lines = (
        "\n".join([head, *(f"{_key(name)} = {_toml(value)}" for name, value in entries.items())])
        for head, entries in blocks
    )
    store.write_atomically(file, "\n\n".join(lines) + "\n")


def accept(file: Path, reason: str, changed: list[str]) -> None:
    """Append an acceptance to a card: that a run still stands although files have changed since."""
    card = read(file)
    entry = {"date": datetime.now(UTC).date(), "reason": reason, "changed": changed}
    write(file, {**card, "accepted": [*card.get("accepted", []), entry]})


def _key(name: str) -> str:
    return name if name.replace("_", "").replace("-", "").isalnum() else json.dumps(name)


def _toml(value: object) -> str:
    # A text of JSON is one of TOML, and so is a list of texts.
    if isinstance(value, date):
        return value.isoformat()
    return json.dumps(value, ensure_ascii=False)
