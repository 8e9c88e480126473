"""Which pins of `environment.lock` count for modules that import this and that.

What is imported belongs to a distribution, which needs others; the metadata of what is installed tell.
"""

import functools
from collections.abc import Collection, Iterable
from importlib import metadata

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

__all__ = ["counted_pins"]


def counted_pins(lock: str, imports: Iterable[str]) -> dict[str, str]:
    """Return the pins of the distributions that imports come from, and of all that these require.

    Extras are not followed, and a requirement that has no pin is left out. If it is not known what an import
    needs, since it or a requirement is not installed or it has no pin, all pins count.

    Parameters
    ----------
    lock
        Text of the lock: a pin a line, besides comments.
    imports
        Top-level names, such as `"sklearn"`.

    Returns
    -------
    Lines of the lock by names of distributions, such as `"scikit-learn"`.

    Notes
    -----
    What a distribution uses without requiring it, if only it is there, is not seen.
    """
    lines = (line.strip() for line in lock.splitlines())
    pins = {_name(line): line for line in lines if line and not line.startswith("#")}
    waiting: list[str] = []
    for name in set(imports):
        installed = _distributions().get(name, frozenset())
        if pins.keys().isdisjoint(installed):
            return pins
        waiting.extend(installed)
    counted: set[str] = set()
    while waiting:
        name = waiting.pop()
        if name in pins and name not in counted:
            counted.add(name)
            try:
                waiting.extend(_requirements(name))
            except metadata.PackageNotFoundError:
                return pins
    return {name: pins[name] for name in sorted(counted)}


@functools.cache
def _distributions() -> dict[str, frozenset[str]]:
    """Return the distributions of every top-level name that can be imported."""
    found = metadata.packages_distributions()
    return {name: frozenset(map(canonicalize_name, those)) for name, those in found.items()}


@functools.cache
def _requirements(distribution: str) -> Collection[str]:
    """Return what an installed distribution requires here, without extras."""
    texts = metadata.requires(distribution) or ()
    return [_name(text) for text in texts if _applies(Requirement(text))]


def _applies(requirement: Requirement) -> bool:
    return requirement.marker is None or requirement.marker.evaluate({"extra": ""})


def _name(requirement: str) -> str:
    return canonicalize_name(Requirement(requirement).name)
