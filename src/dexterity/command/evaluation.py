"""``dexterity evaluate`` and ``rank``: an index at configurations, and candidates in its order.

Examples
--------
>>> import dexterity as dx
>>> from dexterity.command.evaluation import evaluate
>>> puma, w = dx.robots.puma560(), dx.Index("manipulability")
>>> report = evaluate(puma, w, [[0.0, 0.5, 0.25, 0.0, 0.5, 0.0]], gradient=False, compiled=False)
>>> [round(value, 4) for value in report.columns["manipulability"]]
[0.0087]
"""

from __future__ import annotations

import torch

import dexterity as dx
from dexterity import spatial
from dexterity.chain import Chain
from dexterity.command.options import IndexOptions
from dexterity.command.reports import Cell, Report
from dexterity.indices import Index, require_not_zero_everywhere
from dexterity.spatial import TensorLike

__all__ = ["describe", "evaluate", "rank"]


def evaluate(chain: Chain, index: Index, q: TensorLike, gradient: bool, compiled: bool) -> Report:
    """Values of an index, and their derivatives by the joint values.

    Parameters
    ----------
    chain, index
        Robot and index.
    q
        (m, n) configurations.
    gradient
        Whether derivatives are wanted.
    compiled
        Whether the index is compiled to C first.

    Raises
    ------
    ValueError
        If the index does not fit the robot, or is zero at all configurations.
    dexterity.symbolic.CompilationFailed
        If there is no C compiler.
    """
    require_not_zero_everywhere(index, chain)
    q = spatial.to_float64(q, "q").detach().requires_grad_(gradient)
    f = dx.symbolic.compile_index(chain, index, backend="c") if compiled else index.bind(chain)
    values = f(q)
    columns: dict[str, list[Cell]] = {"configuration": list(range(len(values))), index.name: values.tolist()}
    if gradient:
        (slopes,) = torch.autograd.grad(values.sum(), q)
        columns |= {
            f"d/d {joint}": slope.tolist()
            for joint, slope in zip(chain.joint_names, slopes.unbind(-1), strict=True)
        }
    return Report(columns, describe(chain, index))


def rank(chain: Chain, task: str, meaning: IndexOptions, q: TensorLike, best: int) -> Report:
    """Order candidates by a task or an index, best first.

    Parameters
    ----------
    chain
        Robot.
    task
        Name of a task, or name or alias of an index.
    meaning
        Options of the index; where none is given, those of the task.
    q
        (m, n) candidate configurations.
    best
        How many of them are listed.

    Raises
    ------
    ValueError
        If neither a task nor an index has that name, or the index is zero at all configurations.
    """
    asked = meaning != IndexOptions()
    ranking = dx.tasks.rank(chain, q, meaning.index(_index_of(task), chain.joints) if asked else task)
    chosen = ranking.best(best)
    columns: dict[str, list[Cell]] = {
        "place": list(range(1, len(chosen) + 1)),
        "configuration": chosen.tolist(),
        ranking.index.name: ranking.values[chosen].tolist(),
    }
    candidates = spatial.to_float64(q, "q")[chosen]
    columns |= {name: column.tolist() for name, column in zip(chain.joint_names, candidates.T, strict=True)}
    facts: dict[str, Cell] = {"task": task, **describe(chain, ranking.index)}
    effect, meant = ranking.explain().splitlines()[1:]
    return Report(columns, {**facts, "effect": effect, "meaning": meant.removeprefix("Meaning: ")})


def _index_of(task: str) -> str:
    """Return the name of the index of a task; an index is its own."""
    try:
        return dx.tasks.find(task).index
    except ValueError as error:
        try:
            return dx.indices.describe(task).name
        except ValueError:
            raise error from None


def describe(chain: Chain, index: Index) -> dict[str, Cell]:
    """Say what the values of an index are, in lines above a table."""
    facts: dict[str, Cell] = {"robot": chain.name, "index": index.title, "frame": index.frame}
    if index.measure.unit:
        facts["unit"] = index.measure.unit
    return facts
