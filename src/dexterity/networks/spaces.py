"""Spaces as a card holds them: to and from what JSON can say.

Examples
--------
>>> from dexterity import sampling
>>> from dexterity.networks import spaces
>>> spaces.from_card(spaces.to_card(sampling.Box([-1, 0], [1, 0])))
Box(lower=(-1.0, 0.0), upper=(1.0, 0.0), levels=(None,))
"""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Callable, Mapping
from typing import Any

from dexterity import checks
from dexterity.sampling import Box, Space, TaskSector

__all__ = ["from_card", "to_card"]


def to_card(space: Space) -> dict[str, Any]:
    """Return the kind of a space and all that defines it, in what JSON can say.

    Raises
    ------
    TypeError
        If the space is neither a box nor a sector about a task point.
    """
    if not isinstance(space, Box | TaskSector):
        raise TypeError(f"space is a {type(space).__name__}; Box and TaskSector can stand on a card")
    return {"kind": type(space).__name__, **json.loads(json.dumps(dataclasses.asdict(space)))}


def from_card(entry: Mapping[str, Any]) -> Box | TaskSector:
    """Return the space that an entry of a card describes.

    Raises
    ------
    ValueError
        If the entry does not describe a space.
    """
    if not isinstance(entry, Mapping):
        raise ValueError(f"entry is {checks.shown(entry)}; a mapping with the kind of a space is needed")
    fields = dict(entry)
    kind = fields.pop("kind", None)
    if kind not in _KINDS:
        raise ValueError(f"space is of the kind {kind!r}; {sorted(_KINDS)} are known")
    try:
        return _KINDS[kind](**fields)
    except (TypeError, AttributeError, KeyError) as error:
        raise ValueError(f"space does not describe a {kind}: {error}") from error


def _sector(rest: Mapping[str, Any], **fields: Any) -> TaskSector:
    for name in ("task_point", "base_offset"):
        fields[name] = tuple(fields[name])
    return TaskSector(**fields, rest=Box(**rest))


_KINDS: Mapping[str, Callable[..., Box | TaskSector]] = {"Box": Box, "TaskSector": _sector}
