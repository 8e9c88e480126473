"""``dexterity design``: a network for an index of a robot, with its card, and what the better answer is.

Examples
--------
>>> import dexterity as dx
>>> from dexterity.command.learning import space
>>> puma, w = dx.robots.puma560(), dx.Index("manipulability")
>>> space(puma, w, "0,0.6,-0.9,0,0.8,0", "0,0.2,0.2,0,0.2,0").free_joints
(1, 2, 4)
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import dexterity as dx
from dexterity import store
from dexterity.chain import Chain
from dexterity.command.reports import Cell, Report, say
from dexterity.indices import Index
from dexterity.networks import Effort, Learned
from dexterity.sampling import Box
from dexterity.typed import numbers

__all__ = ["design", "effort", "space"]


def space(chain: Chain, index: Index, middle: str | None, half: str) -> Box:
    """Box of configurations about a middle, in which the joints vary that the index depends on.

    Parameters
    ----------
    chain, index
        Robot and index.
    middle
        Joint values; the middle of the limits by default.
    half
        How far joints go to either side: one number, or one for each joint, where 0 holds a joint.

    Raises
    ------
    ValueError
        If a number does not fit the chain, or the middle is outside of its limits.
    """
    q = None if middle is None else numbers(middle, "--middle", chain.joints)
    ranges = numbers(half, "--half-range", (1, chain.joints))
    relevant = dx.sampling.relevant_joints(chain, index)
    if len(ranges) == 1:
        return Box.around(chain, q, ranges[0], relevant)
    varying = [joint for joint in relevant if ranges[joint] > 0]
    # A held joint has no range; Box takes none but positive ones.
    return Box.around(chain, q, [value if value > 0 else 1.0 for value in ranges], varying)


def effort(sizes: str, rows: int, epochs: int, restarts: int, seed: int) -> Effort:
    """Return how much a search for a network may take.

    Raises
    ------
    ValueError
        If the sizes are no rising whole numbers, or a number is out of its range.
    """
    counts = numbers(sizes, "--sizes")
    if not counts or any(count != int(count) for count in counts):
        raise ValueError(f"--sizes is {sizes!r}; whole numbers such as 4,8,16 are needed")
    return Effort(tuple(map(int, counts)), rows=rows, epochs=epochs, restarts=restarts, seed=seed)


def design(
    chain: Chain,
    index: Index,
    where: Box,
    goal: float,
    effort: Effort,
    to: Path,
    progress: Callable[[str, int, int], None],
) -> tuple[Report, Learned]:
    """Learn an index, and write the network and its card: ``.npz``, ``.md`` and ``.html``.

    After Ctrl-C the best network so far is judged and written.

    Parameters
    ----------
    chain, index, where, goal, effort, progress
        As for :func:`dexterity.networks.for_index`.
    to
        File of the network; the card's files are beside it.

    Returns
    -------
    A summary, and what was learned.

    Raises
    ------
    ValueError
        If the index cannot be learned in this space.
    KeyboardInterrupt
        If there is no network yet.
    """
    learned = dx.networks.for_index(chain, index, where, goal, effort=effort, progress=progress)
    learned.save(to)
    store.write_atomically(to.with_suffix(".md"), learned.card.markdown())
    store.write_atomically(to.with_suffix(".html"), learned.card.html())
    say(f"{to}, {to.with_suffix('.md').name} and {to.with_suffix('.html').name} written")
    card = learned.card
    entries: dict[str, Cell] = {
        "neurons": card["neurons"],
        "median error": card["errors"]["median"],
        "largest error at a fresh point": card["errors"]["maximum"],
        "worst case found": card["worst_case"]["error"],
        "goal": goal,
        "goal kept": learned.success,
        "interrupted": learned.interrupted,
        "better answer": learned.recommendation,
    }
    facts = {"robot": chain.name, "index": index.title, "advice": str(card.get("advice", ""))}
    return Report({"entry": list(entries), "value": list(entries.values())}, facts), learned
