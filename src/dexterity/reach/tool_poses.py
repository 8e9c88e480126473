"""Poses that a task wants of the tool: a weld seam, the valves of a panel.

Examples
--------
>>> from dexterity import reach
>>> down = reach.pointing([0, 0, -1])
>>> seam = reach.seam([-0.25, 0, 0], [0.25, 0, 0], 5, down)
>>> seam[:, 0, 3].tolist()
[-0.25, -0.125, 0.0, 0.125, 0.25]
>>> reach.panel([1.2, 0, 0.8], normal=[-1, 0, 0], width=0.6, height=0.4, columns=3, rows=2).shape
torch.Size([6, 4, 4])
"""

from __future__ import annotations

import math

import torch
from jaxtyping import Float64
from torch import Tensor

from dexterity import checks, spatial
from dexterity.spatial import TensorLike
from dexterity.spatial.values import on_cpu

__all__ = ["panel", "planar_bases", "pointing", "seam"]


def pointing(
    direction: TensorLike, roll: float = 0.0, up: TensorLike = (0.0, 0.0, 1.0)
) -> Float64[Tensor, "3 3"]:
    """Return a rotation whose z axis points along a direction, as that of a tool does.

    Parameters
    ----------
    direction
        (3,) direction in the world, of any length but zero.
    roll
        Further turn about the direction [rad].
    up
        (3,) direction that the x axis points against, as far as it can, when the roll is zero; where it is
        along `direction`, the x axis points along the world's x axis.

    Raises
    ------
    ValueError
        If a direction is no vector, or zero.
    """
    z, above = _direction(direction, "direction"), _direction(up, "up")
    x = (z @ above) * z - above
    if float(x.norm()) < 1e-9:
        ahead = torch.tensor([1.0, 0.0, 0.0], dtype=torch.float64)
        ahead = ahead if abs(float(z[0])) < 0.9 else ahead.roll(1)
        x = ahead - (ahead @ z) * z
    x = x / x.norm()
    frame = torch.stack([x, torch.linalg.cross(z, x), z], dim=1)
    angle = checks.real(roll, "roll")
    cosine, sine = math.cos(angle), math.sin(angle)
    return frame @ frame.new_tensor([[cosine, -sine, 0], [sine, cosine, 0], [0, 0, 1]])


def seam(
    start: TensorLike, end: TensorLike, count: int, tool_rotation: TensorLike
) -> Float64[Tensor, "count 4 4"]:
    """Return tool poses along a straight seam, evenly spaced from its start to its end.

    Parameters
    ----------
    start, end
        (3,) ends in the world [m].
    count
        Number of poses, at least 2.
    tool_rotation
        (3, 3) rotation of the tool to the world, the same at all of them.

    Raises
    ------
    ValueError
        If a shape does not fit, something is not finite, or the rotation is none.
    """
    first, last = _vector(start, "start"), _vector(end, "end")
    share = torch.linspace(0, 1, checks.whole(count, "count", least=2), dtype=torch.float64)
    return spatial.pose(_rotation(tool_rotation), torch.lerp(first, last, share[:, None]))


def panel(
    centre: TensorLike,
    normal: TensorLike,
    width: float,
    height: float,
    *,
    columns: int,
    rows: int,
    up: TensorLike = (0.0, 0.0, 1.0),
    standoff: float = 0.0,
    roll: float = 0.0,
) -> Float64[Tensor, "poses 4 4"]:
    """Return tool poses on a panel, such as at its valves, row by row from its lower edge.

    The tool's z axis points into the panel.

    Parameters
    ----------
    centre, normal
        (3,) middle of the panel in the world [m], and direction out of it.
    width, height
        Distances between the outermost columns and rows [m]; 0 where there is only one.
    columns, rows
        Numbers of poses across and up, at least 1.
    up
        (3,) direction in the world that is up on the panel, as far as it can be.
    standoff
        How far the tool stays in front of the panel [m].
    roll
        Turn of the tool about its z axis [rad]; with 0 its x axis points down.

    Raises
    ------
    ValueError
        If a shape does not fit, a number is out of its range, or `up` is along the normal.
    """
    middle, out, above = _vector(centre, "centre"), _direction(normal, "normal"), _direction(up, "up")
    raised = above - (above @ out) * out
    if float(raised.norm()) < 1e-9:
        raise ValueError("up is along the normal; another direction is needed")
    raised = raised / raised.norm()
    across = torch.linalg.cross(raised, out)
    x, y = (
        _spread(checks.real(size, name, least=0.0), checks.whole(count, counted, least=1))
        for size, name, count, counted in (
            (width, "width", columns, "columns"),
            (height, "height", rows, "rows"),
        )
    )
    front = middle + checks.real(standoff, "standoff") * out
    points = front + y[:, None, None] * raised + x[:, None] * across
    return spatial.pose(pointing(-out, roll, above), points.flatten(0, 1))


def planar_bases(
    x: TensorLike, y: TensorLike, yaw: TensorLike, height: float = 0.0
) -> Float64[Tensor, "bases 4 4"]:
    """Return upright poses of a base on a floor, all combinations, the yaw fastest.

    Parameters
    ----------
    x, y
        Coordinates in the world [m].
    yaw
        Turns about the vertical [rad].
    height
        Of the base above the world's origin [m].

    Raises
    ------
    ValueError
        If something is not finite, or no row of numbers.
    """
    axes = [_values(x, "x"), _values(y, "y"), _values(yaw, "yaw")]
    at_x, at_y, turn = torch.cartesian_prod(*axes).unbind(-1)
    T = torch.eye(4, dtype=torch.float64).repeat(len(turn), 1, 1)
    T[:, 0, 0], T[:, 0, 1], T[:, 1, 0], T[:, 1, 1] = turn.cos(), -turn.sin(), turn.sin(), turn.cos()
    T[:, 0, 3], T[:, 1, 3], T[:, 2, 3] = at_x, at_y, checks.real(height, "height")
    return T


def _spread(size: float, count: int) -> Tensor:
    if count == 1:
        return torch.zeros(1, dtype=torch.float64)
    return torch.linspace(-size / 2, size / 2, count, dtype=torch.float64)


def _values(values: TensorLike, name: str) -> Tensor:
    row = on_cpu(values, name)
    if row.ndim > 1 or row.numel() == 0:
        raise ValueError(f"{name} has shape {tuple(row.shape)}; one value or a row of values is needed")
    return row.reshape(-1)


def _vector(value: TensorLike, name: str) -> Tensor:
    vector = on_cpu(value, name)
    if vector.shape != (3,):
        raise ValueError(f"{name} has shape {tuple(vector.shape)}; (3,) is needed")
    return vector


def _direction(value: TensorLike, name: str) -> Tensor:
    vector = _vector(value, name)
    largest = vector.abs().max()
    if not float(largest) > 0:
        raise ValueError(f"{name} is zero; a direction is needed")
    # First by the largest entry, so that no square overflows.
    vector = vector / largest
    return vector / vector.norm()


def _rotation(value: TensorLike) -> Tensor:
    R = on_cpu(value, "tool_rotation")
    if R.shape != (3, 3):
        raise ValueError(f"tool_rotation has shape {tuple(R.shape)}; (3, 3) is needed")
    return spatial.require_rotation(R, "tool_rotation")


def several_poses(poses: TensorLike, name: str) -> Float64[Tensor, "k 4 4"]:
    """Return rigid poses, at least one, on the processor and without memory shared with the caller."""
    T = spatial.require_rigid(on_cpu(poses, name), name)
    if T.ndim != 3 or not len(T):
        raise ValueError(f"{name} has shape {tuple(T.shape)}; (k, 4, 4) with k ≥ 1 is needed")
    return T.detach().clone()
