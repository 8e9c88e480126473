"""Objects of the library from words and files: indices, configurations and tool poses.

Examples
--------
>>> import dexterity as dx
>>> from dexterity.command.inputs import configurations, poses
>>> configurations(dx.robots.puma560(), ["0,0.5,0.25,0,pi/2,0"], None).shape
torch.Size([1, 6])
>>> poses(["0.4, 0, 0.3, 180deg, 0, 0"], None)[0, :3, 3].tolist()
[0.4, 0.0, 0.3]
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import Tensor

import dexterity as dx
from dexterity.chain import Chain
from dexterity.command.files import table
from dexterity.command.options import IndexOptions
from dexterity.indices import Index
from dexterity.typed import number, numbers

__all__ = ["configurations", "index", "poses", "rows"]


def index(options: IndexOptions, name: str, joints: int) -> Index:
    """Return an index with the options of the command line.

    Parameters
    ----------
    options
        Frame, rows, direction, length, rates and noise, as words.
    name
        Name or alias of the index.
    joints
        How many joints the robot has; one rate stands for all of them.

    Raises
    ------
    ValueError
        If the name or a word is unknown, or the number of rates does not fit.
    """
    direction: Any = options.direction
    if direction is not None and direction.strip() not in dx.indices.ROW_NAMES:
        direction = tuple(numbers(direction, "--direction"))
    return Index(
        name,
        options.frame.value,
        _rates(options.joint_rates, "--joint-rates", joints),
        _rates(options.tool_rates, "--tool-rates", 6),
        rows=rows(options.rows),
        direction=direction,
        characteristic_length=None if options.length is None else number(options.length, "--length"),
        joint_noise=_rates(options.joint_noise, "--joint-noise", joints),
    )


def rows(text: str) -> Any:
    """Read a word for rows, or their names or numbers between commas."""
    if "," not in text:
        return text.strip()
    return tuple(int(row) if row.strip().isdecimal() else row.strip() for row in text.split(","))


def _rates(text: str | None, name: str, count: int) -> tuple[float, ...] | None:
    """Read one number for each joint or row, or one for all of them."""
    if text is None:
        return None
    values = numbers(text, name, (1, count))
    return tuple(values * count if len(values) == 1 else values)


def configurations(chain: Chain, words: Sequence[str], file: Path | None) -> Tensor:
    """Joint values from words such as ``0,0.5,pi/2`` and from a file: (rows, n).

    Parameters
    ----------
    chain
        Robot of which they are joint values.
    words
        A configuration each.
    file
        Table of joint values. Columns with the names of the joints may stand in any order.

    Raises
    ------
    ValueError
        If there is none, or one does not fit the chain or is not finite; the error names where.
    OSError
        If the file cannot be read.
    """
    rows = [np.array([numbers(word, "--q", chain.joints) for word in words]).reshape(-1, chain.joints)]
    if file is not None:
        values = table(file, [chain.joint_names])
        if values.shape[-1] != chain.joints:
            raise ValueError(
                f"{file} has {values.shape[-1]} columns; the robot has {chain.joints} joints: "
                f"{', '.join(chain.joint_names)}"
            )
        rows.append(values.reshape(-1, chain.joints))
    joined = np.concatenate(rows)
    if not len(joined):
        raise ValueError("there is no configuration; name joint values by --q, or a file by --file")
    return torch.from_numpy(joined)


POSITION = ("x", "y", "z")
POSES = (
    (*POSITION, "qx", "qy", "qz", "qw"),
    (*POSITION, "roll", "pitch", "yaw"),
    POSITION,
)
"""Columns of a table of poses."""


def poses(words: Sequence[str], file: Path | None) -> Tensor:
    """Tool poses from words and from a file: (rows, 4, 4).

    Parameters
    ----------
    words
        A pose each: x, y, z [m], then nothing for the axes of the base, or roll, pitch, yaw [rad], or a
        quaternion x, y, z, w; or 16 entries of the matrix by rows.
    file
        Table with the columns x, y, z and roll, pitch, yaw or qx, qy, qz, qw; or matrices (..., 4, 4).

    Raises
    ------
    ValueError
        If there is none, or one is no pose; the error names where.
    OSError
        If the file cannot be read.
    """
    found = [_pose(numbers(word, "--pose", (3, 6, 7, 16)), "--pose") for word in words]
    if file is not None:
        values = table(file, POSES)
        if values.shape[-2:] == (4, 4):
            values = values.reshape(-1, 16)
        if values.shape[-1] not in (3, 6, 7, 16):
            raise ValueError(f"{file} has the shape {values.shape}; 3, 6, 7 or 16 columns are needed")
        rows = values.reshape(-1, values.shape[-1]).tolist()
        found += [_pose(row, f"{file}, row {i}") for i, row in enumerate(rows, 1)]
    if not found:
        raise ValueError("there is no pose; name one by --pose, or a file by --poses")
    return torch.stack(found)


def _pose(values: Sequence[float], where: str) -> Tensor:
    try:
        if len(values) == 16:
            return dx.spatial.nearest_rigid(torch.tensor(values, dtype=torch.float64).reshape(4, 4))
        if len(values) == 7:
            return dx.spatial.from_quaternion(values[3:], values[:3], order="xyzw")
        return dx.spatial.from_rpy(values[3:] or [0.0, 0.0, 0.0], values[:3])
    except ValueError as error:
        raise ValueError(f"{where} is no pose: {error}") from error
