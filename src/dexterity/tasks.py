"""Which dexterity index serves which underwater task, and the ranking of configurations by it.

The mapping is that of Sotiropoulos & Aspragathos (2016), Table 1 and section 2.3, kept in
``data/tasks.toml``.

Examples
--------
>>> import dexterity as dx
>>> dx.tasks.index_for("welding").name
'kinematic_conditioning'
>>> straight, bent = [0.0] * 12, [0.0] * 8 + [1.5] + [0.0] * 3
>>> dx.tasks.rank(dx.robots.uvms(), [straight, bent], "welding").order.tolist()
[1, 0]
"""

from __future__ import annotations

import difflib
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import torch
from jaxtyping import Float64, Int64
from torch import Tensor

from dexterity import spatial, store
from dexterity.chain import Chain
from dexterity.indices import Frame, Index
from dexterity.spatial import TensorLike

__all__ = ["TASKS", "Ranking", "Task", "find", "index_for", "rank"]


@dataclass(frozen=True)
class Task:
    """An underwater task and the index by which configurations for it are graded.

    Attributes
    ----------
    name, aliases
        What the task is called here, and other names it is found under.
    index
        Name of its dexterity index.
    also
        Name of a second index that the paper wants considered, if any.
    comment, where
        What the task asks of the tool, and where the paper says so.
    """

    name: str
    index: str
    comment: str
    where: str
    aliases: tuple[str, ...] = ()
    also: str | None = None


@dataclass(frozen=True)
class Ranking:
    """Candidate configurations in order of an index.

    Attributes
    ----------
    task
        The task they were ranked for.
    index
        The index, with its frame and limits.
    order
        (m,) positions of the candidates from the best to the worst; equal ones keep their order.
    values
        (m,) index values, in the order of the candidates.
    """

    task: Task
    index: Index
    order: Int64[Tensor, " m"]
    values: Float64[Tensor, " m"]


def _read_tasks() -> Mapping[str, Task]:
    rows = tomllib.loads(store.data_path("tasks.toml").read_text(encoding="utf-8"))["tasks"]
    tasks = [Task(**{**row, "aliases": tuple(row.get("aliases", ()))}) for row in rows]
    return MappingProxyType({task.name: task for task in tasks})


TASKS: Mapping[str, Task] = _read_tasks()
"""All tasks, by name."""


def find(task: str) -> Task:
    """Task of that name or alias, whatever its case.

    Raises
    ------
    ValueError
        If no task is called that; the nearest names are given.
    """
    known = {alias: entry for entry in TASKS.values() for alias in (entry.name, *entry.aliases)}
    wanted = task.strip().lower()
    if wanted in known:
        return known[wanted]
    near = difflib.get_close_matches(wanted, known, n=3, cutoff=0.3) or sorted(TASKS)
    raise ValueError(f"task is {task!r}; there is no such task. Nearest: {', '.join(near)}")


def index_for(
    task: str,
    *,
    frame: Frame = "spatial",
    joint_rates: tuple[float, ...] | None = None,
    tool_rates: tuple[float, ...] | None = None,
) -> Index:
    """Index that grades configurations for a task.

    Parameters
    ----------
    task
        Name or alias of a task.
    frame, joint_rates, tool_rates
        As for :class:`dexterity.indices.Index`.

    Raises
    ------
    ValueError
        If no task is called that; the nearest names are given.
    """
    return Index(find(task).index, frame, joint_rates, tool_rates)


def rank(
    chain: Chain,
    q: TensorLike,
    task: str,
    *,
    frame: Frame = "spatial",
    joint_rates: tuple[float, ...] | None = None,
    tool_rates: tuple[float, ...] | None = None,
) -> Ranking:
    """Order candidate configurations by the index of a task, best first.

    Parameters
    ----------
    chain
        The robot.
    q
        (m, n) candidate configurations, [rad] and [m].
    task
        Name or alias of a task.
    frame, joint_rates, tool_rates
        As for :class:`dexterity.indices.Index`. The kinematic conditioning index, unlike the
        manipulability, ranks differently from frame to frame.

    Raises
    ------
    ValueError
        If the task is unknown or `q` is not (m, n).
    """
    q = spatial.to_float64(q, "q")
    if q.ndim != 2:
        raise ValueError(f"q has shape {tuple(q.shape)}; (candidates, {chain.joints}) is needed")
    index = index_for(task, frame=frame, joint_rates=joint_rates, tool_rates=tool_rates)
    values = index.bind(chain)(q)
    order = torch.argsort(values, descending=True, stable=True)
    return Ranking(find(task), index, order, values)
