"""Closed forms: what all of them share, from an arm and poses to branches that solve forward kinematics.

A closed form measures an arm, and has its branches for motions of the tool from home. An arm whose conditions
hold from the tool to the base is solved as the arm that is seen from its tool, and its joints are put back in
order.

Examples
--------
>>> import dexterity as dx
>>> from dexterity.inverse_kinematics.wrists import SHOULDER, WRIST
>>> puma = dx.robots.puma560()
>>> q, valid, miss = WRIST.branches(puma, puma.forward([0.0, 0.5, 0.25, 0.0, 0.5, 0.0]))
>>> q.shape, bool((miss[valid] < 1e-9).all())
(torch.Size([8, 6]), True)
>>> SHOULDER.miss(puma)
Traceback (most recent call last):
    ...
ValueError: seen from its tool, arm has no spherical wrist: the axes of its last three joints do not meet
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, Protocol, runtime_checkable

import torch
from torch import Tensor

from dexterity import checks, spatial
from dexterity.chain import Chain
from dexterity.inverse_kinematics.refinement import polished
from dexterity.spatial import TensorLike
from dexterity.spatial.poses import assemble
from dexterity.spatial.values import require_values

__all__ = ["Form", "Geometry", "reversed_arm"]

_AT_ONCE = 4096  # poses; what they need is far larger than the answer


@runtime_checkable
class Geometry(Protocol):
    """What a closed form measures of an arm."""

    @property
    def size(self) -> float:
        """Size of the arm [m]."""
        ...

    @property
    def miss(self) -> float:
        """By how much the arm misses the conditions of the closed form."""
        ...

    def branches(self, moved: Tensor) -> Tensor:
        """All joints (k, 8, 6) for motions (k, 4, 4) of the tool from home."""
        ...


@dataclass(frozen=True)
class Form:
    """A closed form.

    Attributes
    ----------
    name
        Its name.
    measured
        Measures an arm on a device; raises ValueError if the arm does not meet the conditions.
    ends
        From which end of the arm its conditions may hold, in the order in which they are tried.
    """

    name: str
    measured: Callable[[Chain, torch.device], Geometry]
    ends: tuple[Literal["base", "tool"], ...]

    def __call__(self, arm: Chain, T_base_tool: TensorLike) -> tuple[Tensor, Tensor]:
        """Check an arm and poses (..., 4, 4); return branches (..., 8, 6) and which are valid (..., 8)."""
        checks.instance(arm, "arm", Chain)
        T = require_values(spatial.require_rigid(T_base_tool, "T_base_tool"), "T_base_tool")
        q, valid, _ = self.branches(arm, T)
        return q, valid

    def branches(self, arm: Chain, T: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        """Branches (..., 8, 6) at rigid poses (..., 4, 4), which are valid (..., 8), and misses (..., 8).

        Raises
        ------
        ValueError
            If the arm does not meet the conditions.
        """
        geometry, seen, end, enlarged = _measured(self, arm, T.device)
        targets = T.reshape(-1, 4, 4)
        if enlarged != 1:
            targets = assemble(targets[:, :3, :3], enlarged * targets[:, :3, 3])
        targets = targets if end == "base" else spatial.inverse(targets)
        from_home = spatial.inverse(seen.home).to(T.device)
        pieces = [
            polished(seen, geometry.branches(some @ from_home), some[:, None], geometry.size, geometry.miss)
            for some in targets.split(_AT_ONCE)
        ]
        q, valid, miss = (
            torch.cat(parts).reshape(*T.shape[:-2], *parts[0].shape[1:])
            for parts in zip(*pieces, strict=True)
        )
        return q if end == "base" else q.flip(-1), valid, miss

    def miss(self, arm: Chain) -> float:
        """By how much an arm misses the conditions.

        Raises
        ------
        ValueError
            If by too much.
        """
        return _measured(self, arm, torch.device("cpu"))[0].miss


@functools.lru_cache(maxsize=64)
def _measured(form: Form, arm: Chain, device: torch.device) -> tuple[Geometry, Chain, str, float]:
    """Geometry of an arm on a device, the arm as it is seen from an end, the end, and its enlargement."""
    # Cached tensors must serve callers that differentiate, whatever the mode of the first one.
    with torch.inference_mode(False), device:
        reasons = []
        enlarged = _enlargement(arm)
        arm = arm if enlarged == 1 else _times(arm, enlarged)
        for end in form.ends:
            seen = arm if end == "base" else reversed_arm(arm)
            try:
                return form.measured(seen, device), seen, end, enlarged
            except ValueError as error:
                reasons.append(f"{error}" if end == "base" else f"seen from its tool, {error}")
        raise ValueError(reasons[0])


def _enlargement(arm: Chain) -> float:
    """Factor that makes a small arm one metre long; 1 for other arms.

    Tolerances of lengths are in metres: an arm of a millimetre would meet every condition.
    """
    length = float(arm.link_transforms[:, :3, 3].norm(dim=-1).sum())
    return 1 / length if 0 < length < _SMALL and set(arm.kinds) == {"revolute"} else 1.0


_SMALL = 0.1  # [m]


def _times(arm: Chain, factor: float) -> Chain:
    """Return an arm of revolute joints with all lengths multiplied."""
    with torch.device("cpu"):
        scale = torch.tensor([factor] * 3 + [1.0] * 3, dtype=torch.float64)
        home = assemble(arm.home[:3, :3], factor * arm.home[:3, 3])
        return Chain(arm.screws * scale, home, name=arm.name)


def reversed_arm(arm: Chain) -> Chain:
    """Return the arm from its tool to its base: it is at T⁻¹ at the joint values in reverse order."""
    with torch.device("cpu"):
        to_tool = spatial.inverse_adjoint(arm.home)
        return Chain(-(arm.screws @ to_tool.mT).flip(0), spatial.inverse(arm.home), name=arm.name)
