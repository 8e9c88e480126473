"""Which dexterity index serves which task, and the ranking of configurations by an index.

The mapping for underwater tasks is that of Sotiropoulos & Aspragathos (2016), Table 1 and section 2.3, in
``data/tasks.toml``. A :class:`Task` of one's own, an index, a compiled index or the name of an index ranks
as well.

Examples
--------
>>> import dexterity as dx
>>> dx.tasks.index_for("welding")
Index('kinematic_conditioning', 'geometric')
>>> straight, bent, halfway = ([0.0] * 8 + [angle] + [0.0] * 3 for angle in (0.0, 1.5, 0.7))
>>> ranking = dx.tasks.rank(dx.robots.uvms(), [straight, bent, halfway], "welding")
>>> ranking.order.tolist(), ranking.best(2).tolist()
([1, 2, 0], [1, 2])
>>> print(ranking.explain().splitlines()[0])
welding, by the kinematic conditioning index, KCI, in the geometric frame: 3 candidates.

A task of one's own, a positioning task for which only the velocity of the tool counts:

>>> position = dx.tasks.Task("positioning", "smallest_singular_value", rows="translational")
>>> dx.tasks.rank(dx.robots.uvms(), [straight, bent], position).order.tolist()
[1, 0]
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, TypeAlias

import torch
from jaxtyping import Float64, Int64
from torch import Tensor

from dexterity import checks, spatial, store
from dexterity.chain import Chain
from dexterity.indices import Frame, Index, Rows, describe, names, require_not_zero_everywhere
from dexterity.spatial import TensorLike

if TYPE_CHECKING:
    from dexterity.symbolic import CompiledIndex

__all__ = ["TASKS", "Criterion", "Effect", "Ranking", "Task", "find", "index_for", "rank"]


@dataclass(frozen=True)
class Task:
    """A task and the index by which configurations for it are graded.

    Parameters
    ----------
    name, aliases
        What the task is called here, and other names it is found under.
    index
        Name or alias of its dexterity index.
    also
        Name of a second index that the source wants considered, if any.
    comment, where
        What the task asks of the tool, and where the source says so.
    rows, direction
        Of the index; see :class:`dexterity.indices.Index`.

    Raises
    ------
    ValueError
        If an index is unknown, or its rows or direction do not fit.
    TypeError
        If a name or a comment is no text, or `aliases` no sequence.
    """

    name: str
    index: str
    comment: str = ""
    where: str = ""
    aliases: tuple[str, ...] = ()
    also: str | None = None
    rows: Rows = "full"
    direction: tuple[float, ...] | str | None = None

    def __post_init__(self) -> None:
        checks.name(self.name, "name")
        for field in ("comment", "where"):
            if not isinstance(getattr(self, field), str) or getattr(self, field):
                checks.name(getattr(self, field), field)
        object.__setattr__(self, "aliases", checks.names(self.aliases, "aliases"))
        index = Index(self.index, rows=self.rows, direction=self.direction)
        for field in ("rows", "direction"):
            object.__setattr__(self, field, getattr(index, field))
        object.__setattr__(self, "index", index.name)
        if self.also is not None:
            object.__setattr__(self, "also", describe(self.also).name)


Criterion: TypeAlias = "Task | Index | CompiledIndex | str"
"""What may rank, a task, an index, a compiled index, or the name of a task or of an index."""


@dataclass(frozen=True)
class Effect:
    """How much a choice among candidates matters.

    Attributes
    ----------
    best, median, worst
        Values of the index.
    over_median, over_worst
        How many times better the best is than the median and than the worst candidate; for an index that
        may be negative, such as a logarithm, by how much it is larger.
    """

    best: float
    median: float
    worst: float
    over_median: float
    over_worst: float


@dataclass(frozen=True, repr=False)
class Ranking:
    """Candidate configurations in order of an index.

    Attributes
    ----------
    task
        The task they were ranked for; for an index alone, one of its title.
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

    def __repr__(self) -> str:
        best = ", ".join(f"{i} ({float(self.values[i]):.4g})" for i in self.order[:3].tolist())
        count = f"{len(self.order)} candidates, best {best or 'none'}"
        return f"Ranking({self.task.name!r} by {self.index!r}: {count})"

    def best(self, k: int = 1) -> Int64[Tensor, " k"]:
        """Positions of the best candidates, the best first.

        Parameters
        ----------
        k
            How many; all if there are no more.

        Raises
        ------
        ValueError
            If `k` is below 1.
        TypeError
            If `k` is no whole number.
        """
        return self.order[: checks.whole(k, "k", 1)]

    @property
    def effect(self) -> Effect:
        """How much better the best candidate is than the median and the worst.

        Raises
        ------
        ValueError
            If there is no candidate.
        """
        if len(self.order) == 0:
            raise ValueError("the ranking is empty: there is no candidate to compare")
        ordered = self.values[self.order]
        best, median, worst = (float(ordered[i]) for i in (0, (len(ordered) - 1) // 2, -1))
        return Effect(best, median, worst, self._gain(best, median), self._gain(best, worst))

    def _gain(self, best: float, other: float) -> float:
        if best == other:
            return 0.0 if self._on_a_scale_of_differences else 1.0
        if self._on_a_scale_of_differences:
            return best - other
        better, worse = (best, other) if self.index.measure.larger_is_better else (other, best)
        return better / worse if worse else math.inf

    @property
    def _on_a_scale_of_differences(self) -> bool:
        return self.index.measure.bounds[0] < 0

    def explain(self) -> str:
        """Say what the numbers mean for the task, and how much the choice matters.

        Raises
        ------
        ValueError
            If there is no candidate.
        """
        effect, measure = self.effect, self.index.measure
        title = self.index.title[0].lower() + self.index.title[1:]
        median, worst = f"{effect.over_median:.3g}", f"{effect.over_worst:.3g}"
        if self._on_a_scale_of_differences:
            size = f"{median} more than the median, {worst} more than the worst"
        else:
            word = "times" if measure.larger_is_better else "times smaller than"
            size = f"{median} {word} the median, {worst} {word} the worst"
        count, frame = len(self.order), self.index.frame
        values = f"{effect.best:.4g} (median {effect.median:.4g}, worst {effect.worst:.4g})"
        return (
            f"{self.task.name}, by the {title}, in the {frame} frame: {count} candidates.\n"
            f"Best: candidate {int(self.order[0])} with {values}: {size}.\n"
            f"Meaning: {measure.meaning}"
        )


def _read_tasks() -> Mapping[str, Task]:
    rows = store.read_toml(store.data_path("tasks.toml"))["tasks"]
    tasks = [Task(**{**row, "aliases": tuple(row.get("aliases", ()))}) for row in rows]
    return MappingProxyType({task.name: task for task in tasks})


TASKS: Mapping[str, Task] = _read_tasks()
"""All tasks, by name."""


def find(task: str) -> Task:
    """Task of that name or alias, whatever its case.

    Raises
    ------
    ValueError
        If no task is called that; all are listed, with the nearest names.
    TypeError
        If `task` is no text.
    """
    if not isinstance(task, str):
        raise TypeError(f"task is {checks.shown(task)}; the name of a task is needed: {', '.join(TASKS)}")
    known = {alias: entry for entry in TASKS.values() for alias in (entry.name, *entry.aliases)}
    wanted = task.strip().lower()
    if wanted in known:
        return known[wanted]
    listed = (*TASKS, f"or, to rank, an index: {', '.join(names())}")
    raise ValueError(f"task is {checks.shown(task)}; {checks.hint(task, known, listed)}")


def index_for(
    task: Task | str,
    *,
    frame: Frame = "geometric",
    joint_rates: tuple[float, ...] | None = None,
    tool_rates: tuple[float, ...] | None = None,
    rows: Rows | None = None,
) -> Index:
    """Index that grades configurations for a task.

    Parameters
    ----------
    task
        A task, or the name or alias of one.
    frame, joint_rates, tool_rates
        As for :class:`dexterity.indices.Index`. The geometric frame, about the tool and in the world's axes,
        means the tool; the paper's is the spatial one, about the world's origin.
    rows
        Rows of the Jacobian that count, for an arm that cannot serve all six; those of the task by default.

    Raises
    ------
    ValueError
        If no task is called that; the nearest names are given.
    """
    task = task if isinstance(task, Task) else find(task)
    return Index(
        task.index,
        frame,
        joint_rates,
        tool_rates,
        rows=task.rows if rows is None else rows,
        direction=task.direction,
    )


def rank(
    chain: Chain,
    q: TensorLike,
    task: Criterion,
    *,
    frame: Frame | None = None,
    joint_rates: tuple[float, ...] | None = None,
    tool_rates: tuple[float, ...] | None = None,
    rows: Rows | None = None,
) -> Ranking:
    """Order candidate configurations by the index of a task, best first.

    Parameters
    ----------
    chain
        The robot.
    q
        (m, n) candidate configurations, [rad] and [m]; the ranking of none is empty.
    task
        A task, the name or alias of one, an index, the name or alias of one, or a compiled index of the
        chain, which is the fastest.
    frame, joint_rates, tool_rates, rows
        As for :class:`dexterity.indices.Index`; ``"geometric"`` by default, which means the tool. An index
        has its own, and takes none here. The kinematic conditioning index, unlike the manipulability, ranks
        differently from frame to frame.

    Raises
    ------
    ValueError
        If the task is unknown, `q` is not (m, n), the index is zero at all configurations of the chain, a
        frame, rates or rows are given beside an index, or it was compiled for another chain.
    TypeError
        If `task` is none of these.
    """
    checks.instance(chain, "chain", Chain)
    q = spatial.to_float64(q, "q")
    if q.ndim != 2:
        raise ValueError(f"q has shape {tuple(q.shape)}; (candidates, {chain.joints}) is needed")
    given = {"frame": frame, "joint_rates": joint_rates, "tool_rates": tool_rates, "rows": rows}
    if isinstance(task, str | Task):
        task = _named(task)
        index = index_for(
            task,
            frame="geometric" if frame is None else frame,
            joint_rates=joint_rates,
            tool_rates=tool_rates,
            rows=rows,
        )
        require_not_zero_everywhere(index, chain)
        values = index.bind(chain)(q)
    else:
        for name, value in given.items():
            if value is not None:
                raise ValueError(f"{name} is {value!r}; an index has its own")
        index, values = _graded(chain, q, task)
        task = Task(index.title, index.name, rows=index.rows, direction=index.direction)
    order = torch.argsort(values.detach(), descending=index.measure.larger_is_better, stable=True)
    return Ranking(task, index, order, values)


def _named(task: Task | str) -> Task:
    """Task of a name, or one made of the name of an index."""
    if isinstance(task, Task):
        return task
    try:
        return find(task)
    except ValueError:
        try:
            measure = describe(task)
        except ValueError:
            measure = None
        if measure is None:
            raise
    return Task(measure.title, measure.name)


def _graded(chain: Chain, q: Tensor, criterion: Index | CompiledIndex) -> tuple[Index, Tensor]:
    if isinstance(criterion, Index):
        require_not_zero_everywhere(criterion, chain)
        return criterion, criterion.bind(chain)(q)
    index = getattr(criterion, "index", None)
    if not isinstance(index, Index):
        raise TypeError(f"task is {criterion!r}; a task, an index, a compiled index or a name is needed")
    compiled_for = criterion.chain.numeric()
    same = compiled_for.kinds == chain.kinds and all(
        torch.allclose(ours, theirs, rtol=0, atol=1e-9)
        for ours, theirs in ((compiled_for.screws, chain.screws), (compiled_for.home, chain.home))
    )
    if not same:
        raise ValueError(f"task is {criterion!r}, compiled for another chain than {chain.name}")
    return index, criterion(q)
