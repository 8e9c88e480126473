"""``dexterity ik``: all configurations at tool poses, within the limits.

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

from typing import Any

import torch

import dexterity as dx
from dexterity.chain import Chain
from dexterity.command.reports import Cell, Report
from dexterity.spatial import TensorLike

__all__ = ["inverse_kinematics"]


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
