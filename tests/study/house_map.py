"""The map of the house, drawn from the imports; run as a script it prints the map."""

from __future__ import annotations

import sys
from collections.abc import Iterator

import grimp

PACKAGES = ("dexterity", "dexterity_study")


def house_map() -> str:
    """Return a line for each room, from the ground up: its name, and the rooms whose code it imports."""
    graph = grimp.build_graph(*PACKAGES, cache_dir=None)
    rooms = [room for package in PACKAGES for room in _rooms(graph, package)]
    uses = {room: sorted(set(_used_by(graph, room))) for room in rooms}
    lines = [
        f"{_short(room):<22}{', '.join(map(_short, uses[room])) or '–'}" for room in _from_the_ground(uses)
    ]
    return "\n".join([f"{'room':<22}imports", *lines])


def _rooms(graph: grimp.ImportGraph, package: str) -> list[str]:
    return sorted(graph.find_children(package))


def _used_by(graph: grimp.ImportGraph, room: str) -> Iterator[str]:
    rooms = {one for own in PACKAGES for one in _rooms(graph, own)}
    for module in {room, *graph.find_descendants(room)}:
        for used in graph.find_modules_directly_imported_by(module):
            other = ".".join(used.split(".")[:2])
            if other in rooms and other != room:
                yield other


def _from_the_ground(uses: dict[str, list[str]]) -> list[str]:
    """Sort rooms so that each stands below all that it imports."""
    placed: list[str] = []
    while len(placed) < len(uses):
        free = sorted(one for one in uses if one not in placed and set(uses[one]) <= set(placed))
        if not free:
            raise ValueError(f"imports go in a circle among {sorted(uses.keys() - set(placed))}")
        placed += free
    return placed


def _short(room: str) -> str:
    package, _, name = room.partition(".")
    return name if package == "dexterity" else f"study.{name}"


if __name__ == "__main__":
    sys.stdout.write(f"{house_map()}\n")
