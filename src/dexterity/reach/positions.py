"""Positions for a reach map: boxes, balls, and all that an arm might get to.

Examples
--------
>>> import dexterity as dx
>>> from dexterity import reach
>>> reach.box([0.2, -0.1, 0.0], [0.4, 0.1, 0.0], spacing=0.1).shape
torch.Size([9, 3])
>>> centre, radius = reach.bounds(dx.robots.puma560())
>>> round(radius, 2)
1.01
>>> len(reach.ball(centre, radius, spacing=0.2))
515
"""

from __future__ import annotations

import math

import torch
from jaxtyping import Float64
from torch import Tensor

from dexterity import checks, spatial
from dexterity.chain import Chain
from dexterity.spatial import TensorLike
from dexterity.spatial.values import on_cpu

__all__ = ["ball", "bounds", "box"]

_MOST = 10**7


def box(lower: TensorLike, upper: TensorLike, spacing: float) -> Float64[Tensor, "p 3"]:
    """Return positions on a regular grid over a box, its faces included, x slowest and z fastest.

    Parameters
    ----------
    lower, upper
        (3,) corners [m]; where a coordinate is the same in both, the grid is flat.
    spacing
        Largest distance between neighbours along a coordinate [m]; an even smaller one where it must divide
        the side.

    Raises
    ------
    ValueError
        If a corner is no point, a lower coordinate exceeds the upper one, the spacing is not positive, or
        there are more than ten million positions.
    """
    low, high = (_point(corner, name) for corner, name in ((lower, "lower"), (upper, "upper")))
    if (low > high).any():
        raise ValueError(f"lower is {low.tolist()} and exceeds upper, {high.tolist()}")
    sides = ((high - low) / checks.positive(spacing, "spacing")).tolist()
    _require_few(math.prod(side + 1 for side in sides), spacing)
    steps = [math.ceil(side - 1e-9) for side in sides]
    axes = [
        torch.linspace(a, b, n + 1, dtype=torch.float64) for a, b, n in zip(low, high, steps, strict=True)
    ]
    return torch.cartesian_prod(*axes)


def ball(centre: TensorLike, radius: float, spacing: float) -> Float64[Tensor, "p 3"]:
    """Return positions on a cubic grid through the centre of a ball, as far as its surface.

    Parameters
    ----------
    centre
        (3,) centre [m].
    radius
        Radius [m].
    spacing
        Distance between neighbours along a coordinate [m].

    Raises
    ------
    ValueError
        If the centre is no point, a length is not positive, or there are more than ten million positions.
    """
    middle = _point(centre, "centre")
    radius, spacing = checks.positive(radius, "radius"), checks.positive(spacing, "spacing")
    ratio = radius / spacing
    _require_few(ratio * ratio * ratio, spacing)
    count = math.floor(ratio + 1e-9)
    side = spacing * torch.arange(-count, count + 1, dtype=torch.float64)
    offsets = torch.cartesian_prod(side, side, side)
    return middle + offsets[offsets.norm(dim=-1) <= radius * (1 + 1e-9)]


@checks.arguments(chain=checks.Instance(Chain))
def bounds(chain: Chain) -> tuple[Float64[Tensor, " 3"], float]:
    """Return centre and radius of a ball that the tool point cannot leave, whatever the joint values are.

    The centre is on the first joint's axis, and the radius is the length of the links behind it, stretched
    out straight, with the largest travel of prismatic joints.

    Parameters
    ----------
    chain
        A chain whose prismatic joints have limits.

    Returns
    -------
    The centre (3,) in the chain's world frame [m], and the radius [m].

    Raises
    ------
    ValueError
        If a prismatic joint has no limits, so that no ball holds the tool point.
    """
    links, radius = chain.link_transforms, 0.0
    centre = links[0].clone()
    for i, kind in enumerate(chain.kinds):
        link = links[i + 1][:3, 3]
        if i == 0 and kind == "revolute":
            # The next joint circles about the first axis, at a height that does not change.
            along = torch.stack([torch.zeros(()), torch.zeros(()), link[2]])
            centre, link = centre @ spatial.pose(torch.eye(3), along), link - along
        radius += float(link.norm())
        if kind == "prismatic":
            radius += _travel(chain, i)
    return centre[:3, 3].clone(), radius


def _travel(chain: Chain, joint: int) -> float:
    travel = max(abs(float(chain.lower[joint])), abs(float(chain.upper[joint])))
    if math.isinf(travel):
        raise ValueError(
            f"chain moves {chain.joint_names[joint]} without limits, and its tool anywhere; give limits to "
            "the joint, or positions to the map"
        )
    return travel


def _point(value: TensorLike, name: str) -> Tensor:
    point = on_cpu(value, name)
    if point.shape != (3,):
        raise ValueError(f"{name} has shape {tuple(point.shape)}; (3,) is needed")
    return point.clone()


def _require_few(count: float, spacing: float) -> None:
    if not count <= _MOST:
        raise ValueError(
            f"spacing is {spacing}, which makes {count:.3g} positions; at most {_MOST:.0e} are taken"
        )
