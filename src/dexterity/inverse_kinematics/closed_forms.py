"""Which closed form a chain has, if any, and by how much its description misses the conditions of it.

Examples
--------
>>> import dexterity as dx
>>> from dexterity.inverse_kinematics import closed_form, geometric_miss
>>> closed_form(dx.robots.load("ur5e")), closed_form(dx.robots.puma560())
('three parallel axes', 'spherical wrist')
>>> closed_form(dx.robots.load("panda")) is None
True
>>> geometric_miss(dx.robots.puma560()) < 1e-12
True
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import dataclass

import torch
from torch import Tensor

from dexterity import checks, spatial
from dexterity.chain import Chain
from dexterity.inverse_kinematics.parallel_axes import parallel_branches, parallel_geometry
from dexterity.inverse_kinematics.wrists import geometry_of, reversed_arm, wrist_branches

__all__ = ["closed_form", "geometric_miss"]

Branches = Callable[[Chain, Tensor], tuple[Tensor, Tensor, Tensor]]


@dataclass(frozen=True)
class Form:
    """A closed form that a chain has: its name, its branches at poses, and what its conditions miss."""

    name: str
    branches: Branches
    miss: float


def closed_form(chain: Chain) -> str | None:
    """Return the name of the closed form that finds every configuration of a chain at a pose.

    Returns
    -------
    ``"spherical wrist"`` (the axes of the last three of six revolute joints meet), ``"three parallel axes"``
    (those of joints 2, 3 and 4 are parallel and 5 and 6 meet, or the same seen from the tool),
    ``"spherical shoulder"`` (the first three meet), or None: only a search finds configurations. Axes that
    meet or are parallel to six digits count; :func:`.geometric_miss` says by how much they miss.
    """
    form = form_of(checks.instance(chain, "chain", Chain))
    return None if form is None else form.name


def geometric_miss(chain: Chain) -> float:
    """Largest distance [m] and sine of an angle by which axes miss meeting or being parallel.

    Configurations are improved by Newton's method on the chain as it is described, so that they have all
    their digits whatever the miss.

    Raises
    ------
    ValueError
        If the chain has no closed form.
    """
    form = form_of(checks.instance(chain, "chain", Chain))
    if form is None:
        raise ValueError(f"chain {chain.name!r} has no closed form, and so no condition to miss")
    return form.miss


@functools.lru_cache(maxsize=32)
def form_of(chain: Chain) -> Form | None:
    """First closed form whose conditions a chain fulfils."""
    for name, branches, measured in _candidates(chain):
        try:
            return Form(name, branches, measured())
        except ValueError:
            continue
    return None


def reasons(chain: Chain) -> str:
    """Why a chain has none of the closed forms, in words."""
    texts = []
    for _, _, measured in _candidates(chain):
        try:
            measured()
        except ValueError as error:
            texts.append(str(error))
    return "; ".join(dict.fromkeys(texts))


def _candidates(chain: Chain) -> list[tuple[str, Branches, Callable[[], float]]]:
    cpu = torch.device("cpu")
    return [
        ("spherical wrist", wrist_branches, lambda: geometry_of(chain, cpu).miss),
        ("three parallel axes", parallel_branches, lambda: parallel_geometry(chain, cpu)[0].miss),
        ("spherical shoulder", _shoulder_branches, lambda: geometry_of(reversed_arm(chain), cpu).miss),
    ]


def _shoulder_branches(arm: Chain, T: Tensor) -> tuple[Tensor, Tensor, Tensor]:
    q, valid, miss = wrist_branches(reversed_arm(arm), spatial.inverse(T))
    return q.flip(-1), valid, miss
