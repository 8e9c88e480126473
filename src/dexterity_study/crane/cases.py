"""The crane of a reading, its working area and random numbers, which the chapters on the crane share."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any, TypeAlias

import torch

from dexterity import crane

Rows: TypeAlias = Iterator[dict[str, Any]]
Made: TypeAlias = tuple[list[dict[str, Any]], dict[str, Any]]
Values: TypeAlias = Mapping[str, Any]

CRANE: Mapping[str, Any] = {"data": ("robots/patu655.toml",)}
PAPER: Mapping[str, Any] = {"paper": "rouvinen1999", **CRANE}

BOX = ((0.0, 6.6), (-4.2, 7.8))
"""Ranges of x and y that hold the working area ahead of the pillar [m]."""


def with_jib_stroke(reading: Values) -> crane.Crane:
    """Return the crane whose jib cylinder ends where a reading says."""
    own = crane.patu655()
    return replace(own, upper=(own.upper[0], reading["crane-jib-stroke"], own.upper[2]))


def seeded(seed: int) -> torch.Generator:
    """Return a generator of random numbers that starts at a seed."""
    return torch.Generator().manual_seed(seed)
