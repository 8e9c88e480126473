"""Cards: what is known of a network, for people and for programs.

A card is what :func:`dexterity.networks.save` stores beside the weights, so that whoever loads a network
later knows what it approximates, where, and how well. It is a mapping of entries that JSON can say, and it
reads them: as the chain, the index and the space that the network was made for, as text, and as a page.

Examples
--------
>>> import dexterity as dx
>>> card = dx.networks.load_shipped("uvms-manipulability-feed-forward").card
>>> card.space().joints, round(card["worst_case"]["error"], 4)
(12, 0.002)
>>> print(card.markdown().splitlines()[0])
# uvms-manipulability-feed-forward
"""

from __future__ import annotations

import dataclasses
import json
import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from torch import Tensor

from dexterity import checks
from dexterity.chain import Chain
from dexterity.indices import Index
from dexterity.networks import card_text, spaces
from dexterity.sampling import Space

__all__ = ["Card", "chain_entry", "index_entry", "plain"]


class Card(Mapping[str, Any]):
    """Entries of a network's card, which cannot be changed.

    Parameters
    ----------
    entries
        Texts as keys; numbers, texts, truth values, None, and lists and mappings of these as values. They are
        copied. Entries that :func:`dexterity.networks.judgement.describe` writes are understood by the
        methods; others are shown as they are.

    Raises
    ------
    TypeError
        If `entries` is no mapping, a key is no text, or a value is of another kind.
    ValueError
        If a number is not finite or too large for 64 bits, or lists and mappings are nested too deeply.
    """

    def __init__(self, entries: Mapping[str, Any] | None = None) -> None:
        if entries is not None and not isinstance(entries, Mapping):
            raise TypeError(f"entries of a card are {checks.shown(entries)}; a mapping is needed")
        try:
            self._entries: dict[str, Any] = _copied(dict(entries or {}), "card")
            json.dumps(self._entries, ensure_ascii=False).encode()
        except RecursionError:
            raise ValueError("card is nested too deeply to be written") from None
        except UnicodeEncodeError as error:
            raise ValueError(f"card holds a text that cannot be written: {error}") from None

    def __getitem__(self, key: str) -> Any:
        return self._entries[key]

    def __iter__(self) -> Iterator[str]:
        return iter(self._entries)

    def __len__(self) -> int:
        return len(self._entries)

    def __repr__(self) -> str:
        return f"<card of {self.get('name', 'a network')}: {', '.join(self) or 'empty'}>"

    def _repr_html_(self) -> str:
        return self.html(whole_page=False)

    def to_dict(self) -> dict[str, Any]:
        """Return a copy of the entries that can be changed."""
        copied: dict[str, Any] = _copied(self._entries, "card")
        return copied

    def with_entries(self, **entries: Any) -> Card:
        """Return a card with further entries, or with others in the place of those of the same name."""
        return Card(self._entries | entries)

    def space(self) -> Space:
        """Return the space that the network was trained on and judged in.

        Raises
        ------
        ValueError
            If the card has no space, or its entry does not describe one.
        """
        return spaces.from_card(self._entry("space"))

    def chain(self) -> Chain:
        """Return the chain that the network was made for, from the screws on the card.

        Raises
        ------
        ValueError
            If the card has no chain with its geometry.
        """
        entry = self._entry("chain")
        if not isinstance(entry, Mapping) or not {"screws", "home"} <= entry.keys():
            raise ValueError("card holds no geometry of its chain: the screws and home are not on it")
        limits = {name: _numbers(entry.get(name), unlimited) for name, unlimited in _UNLIMITED.items()}
        inertias = entry.get("inertias")
        try:
            return Chain(
                entry["screws"],
                entry["home"],
                name=entry.get("name", "chain"),
                joint_names=entry.get("joint_names"),
                inertias=None if inertias is None else tuple(inertias[name] for name in _INERTIAS),
                **limits,
            )
        except (TypeError, AttributeError, KeyError) as error:
            raise ValueError(f"card does not describe a chain: {error}") from error

    def index(self) -> Index:
        """Return the index that the network approximates.

        Raises
        ------
        ValueError
            If the card has no index, or its entry does not describe one.
        """
        entry = self._entry("index")
        known = {field.name for field in dataclasses.fields(Index)}
        if not isinstance(entry, Mapping) or "name" not in entry:
            raise ValueError(f"card holds {entry!r} as its index; a mapping with a name is needed")
        try:
            return Index(**{key: _tupled(value) for key, value in entry.items() if key in known})
        except TypeError as error:
            raise ValueError(f"card does not describe an index: {error}") from error

    def markdown(self) -> str:
        """Return the card as text in Markdown, with tables."""
        return card_text.markdown(self._entries)

    @checks.arguments(whole_page=checks.Flag())
    def html(self, whole_page: bool = True) -> str:
        """Return the card as a page that needs nothing beside it, with pictures, or as what a page holds."""
        # matplotlib takes a second to import, and only this method needs it.
        from dexterity.networks import card_page

        return card_page.html(self._entries, whole_page)

    def _entry(self, name: str) -> Any:
        if name not in self._entries:
            raise ValueError(f"card has no entry {name!r}; its entries are {sorted(self._entries)}")
        return self._entries[name]


_UNLIMITED = {"lower": -math.inf, "upper": math.inf, "rates": 1.0}
"""What stands for None among an entry's limits and rates."""


_INERTIAS = ("masses", "centres", "tensors")
"""What an entry says of the masses of a chain, in their order."""


@checks.arguments(chain=checks.Instance(Chain))
def chain_entry(chain: Chain) -> dict[str, Any]:
    """Return what a card says of a chain: enough to make the same chain again."""

    def finite(numbers: list[float]) -> list[float | None]:
        return [number if math.isfinite(number) else None for number in numbers]

    return {
        "name": chain.name,
        "joint_names": list(chain.joint_names),
        "screws": chain.screws.tolist(),
        "home": chain.home.tolist(),
        "lower": finite(chain.lower.tolist()),
        "upper": finite(chain.upper.tolist()),
        "rates": finite(chain.rates.tolist()),
        **({} if chain.inertias is None else {"inertias": _inertias(chain.inertias)}),
    }


def _inertias(parts: Sequence[Tensor]) -> dict[str, Any]:
    return {name: part.tolist() for name, part in zip(_INERTIAS, parts, strict=True)}


@checks.arguments(index=checks.Instance(Index))
def index_entry(index: Index) -> dict[str, Any]:
    """Return what a card says of an index: enough to make the same index again."""
    return {name: value for name, value in plain(index).items() if value is not None}


def plain(value: Any) -> dict[str, Any]:
    """Return the fields of a dataclass in what JSON can say: tuples become lists, at any depth."""
    if not dataclasses.is_dataclass(value) or isinstance(value, type):
        raise TypeError(f"value is {checks.shown(value)}; an instance of a dataclass is needed")
    fields: dict[str, Any] = json.loads(json.dumps(dataclasses.asdict(value)))
    return fields


def _tupled(item: Any) -> Any:
    return tuple(map(_tupled, item)) if isinstance(item, list) else item


def _numbers(entry: Any, absent: float) -> Any:
    return [absent if number is None else number for number in entry] if isinstance(entry, list) else entry


def _copied(value: Any, place: str) -> Any:
    """Copy what JSON says and gives back as it was; errors name the place."""
    if value is None or type(value) in (bool, str, int):
        if type(value) is int and value.bit_length() > 63:
            raise ValueError(f"{place} is {checks.shown(value)}; a number in 64 bits is needed")
        return value
    if isinstance(value, float):
        if not math.isfinite(value):
            raise ValueError(f"{place} is {value}; a finite number is needed")
        return float(value)
    if isinstance(value, Mapping):
        if strange := [key for key in value if not isinstance(key, str)]:
            raise TypeError(f"{place} has the key {strange[0]!r}; keys must be texts")
        return {str(key): _copied(item, f"{place}[{key!r}]") for key, item in value.items()}
    if isinstance(value, list):
        return [_copied(item, f"{place}[{i}]") for i, item in enumerate(value)]
    raise TypeError(
        f"{place} is a {type(value).__name__}; numbers, texts, truth values, None, lists and mappings are "
        "needed"
    )
