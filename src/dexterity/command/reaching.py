"""``dexterity ik``, ``map`` and ``place``: configurations at poses, what an arm reaches, and where to put it.

Examples
--------
>>> import dexterity as dx
>>> from dexterity.command.reaching import inverse_kinematics
>>> puma = dx.robots.puma560()
>>> report, reached = inverse_kinematics(puma, puma.forward([[0.1, 0.5, 0.25, 0.2, 0.5, 0.3]]))
>>> reached, len(report.columns["pose"]) >= 2
(True, True)
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import torch
from torch import Tensor

import dexterity as dx
from dexterity.chain import Chain
from dexterity.command.reports import Cell, Report, say
from dexterity.reach.placements import Placements
from dexterity.spatial import TensorLike
from dexterity.typed import numbers, values_of_range

__all__ = ["inverse_kinematics", "placements", "positions", "reach_map", "seam"]


def inverse_kinematics(
    chain: Chain, T: TensorLike, *, beyond_limits: bool = False, **options: Any
) -> tuple[Report, bool]:
    """Find the configurations at tool poses.

    Parameters
    ----------
    chain
        Robot.
    T
        (m, 4, 4) tool poses.
    beyond_limits
        Whether configurations outside of the limits are listed too.
    options
        As for :func:`dexterity.inverse_kinematics.solve`.

    Returns
    -------
    The configurations, and whether each pose has one within the limits.

    Raises
    ------
    ValueError
        If an option does not fit the chain.
    """
    _say_if_few_joints(chain, options, "--rows")
    solutions = dx.inverse_kinematics.solve(chain, T, **options)
    wanted = solutions.valid if beyond_limits else solutions.usable
    poses, branches = torch.nonzero(wanted, as_tuple=True)
    q = solutions.q[poses, branches]
    columns: dict[str, list[Cell]] = {
        "pose": poses.tolist(),
        "residual": solutions.residual[poses, branches].tolist(),
    }
    if beyond_limits:
        columns["within limits"] = solutions.within_limits[poses, branches].tolist()
    columns |= {name: column.tolist() for name, column in zip(chain.joint_names, q.T, strict=True)}
    facts: dict[str, Cell] = {
        "robot": chain.name,
        "method": solutions.method,
        "finds all": solutions.complete,
        "poses reached": f"{int(solutions.reached.sum())} of {len(solutions.reached)}",
    }
    return Report(columns, facts), bool(solutions.reached.all())


def positions(chain: Chain, lower: str | None, upper: str | None, spacing: float) -> Tensor:
    """Return a grid of positions over a box, or over the ball that the tool cannot leave: (p, 3).

    Raises
    ------
    ValueError
        If one corner is missing or is no point, or the spacing is not positive.
    """
    if (lower is None) != (upper is None):
        raise ValueError("--lower and --upper are the corners of a box; give both, or neither")
    if lower is None or upper is None:
        return dx.reach.ball(*dx.reach.bounds(chain), spacing)
    return dx.reach.box(numbers(lower, "--lower", 3), numbers(upper, "--upper", 3), spacing)


def reach_map(
    chain: Chain, where: Tensor, rotations: int, to: Path, go_on: bool, **options: Any
) -> tuple[Report, bool]:
    """Survey poses, and save the map; after Ctrl-C, the map of what is finished.

    Parameters
    ----------
    chain, where
        Robot and positions.
    rotations
        Least number of rotations.
    to
        File of the map (.npz).
    go_on
        Whether to go on from the map in that file.
    options
        As for :func:`dexterity.reach.survey`.

    Returns
    -------
    The map in a few numbers, and whether it is finished.

    Raises
    ------
    ValueError
        If an option does not fit, or the file holds another survey.
    OSError
        If a file cannot be read or written.
    """
    unfinished = dx.reach.ReachMap.load(to) if go_on else None
    grid = dx.reach.rotations(rotations)
    _say_if_few_joints(chain, options, "--pose-rows")
    found = dx.reach.survey(chain, where, grid, unfinished=unfinished, **options)
    found.save(to)
    say(f"{to} written" if found.finished else f"{to} written, as far as it goes; --continue goes on")
    entries = found.summary()
    return Report({"entry": list(entries), "value": list(entries.values())}), found.finished


def seam(ends: str, count: int, tool: str) -> Tensor:
    """Return tool poses along a straight seam: (count, 4, 4).

    Parameters
    ----------
    ends
        x, y, z of its start and of its end [m].
    count
        Number of poses.
    tool
        Roll, pitch, yaw [rad] of the tool.

    Raises
    ------
    ValueError
        If the ends are not six numbers, the tool's angles are not three, or there are fewer than two poses.
    """
    values = numbers(ends, "--seam", 6)
    rotation = dx.spatial.from_rpy(numbers(tool, "--tool", 3))[:3, :3]
    return dx.reach.seam(values[:3], values[3:], count, rotation)


def placements(
    chain: Chain, poses: Tensor, x: str, y: str, yaw: str, height: float, best: int, **options: Any
) -> tuple[Report, Placements]:
    """Compare bases on a floor, by what the robot does from there at all poses.

    Parameters
    ----------
    chain, poses
        Robot and poses of its tool in the world.
    x, y, yaw
        A number each, or a range such as ``-0.4:0.4:5``.
    height
        Of the base above the world's origin [m].
    best
        How many bases are listed.
    options
        As for :func:`dexterity.reach.place`.

    Raises
    ------
    ValueError
        If a range or an option is none.
    """
    bases = dx.reach.planar_bases(
        values_of_range(x, "--x"), values_of_range(y, "--y"), values_of_range(yaw, "--yaw"), height
    )
    _say_if_few_joints(chain, options, "--pose-rows")
    found = dx.reach.place(chain, poses, bases, **options)
    rows = found.table(best)
    columns: dict[str, list[Cell]] = {name: [row[name] for row in rows] for name in (rows[0] if rows else ())}
    facts: dict[str, Cell] = {
        "robot": chain.name,
        "index": found.index,
        "by": found.by,
        "poses": len(poses),
        "bases looked at": f"{int(found.examined.sum())} of {len(found.bases)}",
        "bases that reach all poses": int((found.reached == len(poses)).sum()),
    }
    if found.followed is not None:
        facts["bases that follow them"] = int(found.followed.sum())
    return Report(columns, facts), found


def _say_if_few_joints(chain: Chain, options: Mapping[str, Any], option: str) -> None:
    """Say that a robot with fewer joints than the rows of a pose meets hardly any pose."""
    count = len(dx.indices.rows.row_numbers(options.get("rows", "full")))
    if chain.joints < count:
        say(
            f"{chain.name} has {chain.joints} joints and meets hardly any pose in all {count} rows; "
            f"{option} translational asks for positions alone"
        )
