"""Times of the Jacobian of a pose, of the other methods of the tables, and of a whole grid.

Sources: Liao & Mao (2018), Tables VI and VII, column Avg. Time, and section I. Each way gets the same poses of the PUMA
560, which are in reach within its limits, and gives the Jacobian there, unless its name says otherwise. The
networks have random weights, since trained ones take as long.
"""

from __future__ import annotations

import ctypes
import math
import warnings
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from typing import Any

import numpy as np
import torch
from torch import Tensor

from dexterity.codegen.library import compiled_library
from dexterity.timing import Timing, Way, measure
from dexterity.workspace import closed_form, compiled, dataset, maps, reachability, training
from dexterity.workspace.compiled import CompiledArm
from dexterity.workspace.dataset import Scaling
from dexterity.workspace.jacobian_net import PAPER_SIZE, Architecture, JacobianNet
from dexterity_study.engine.experiment import experiment
from dexterity_study.workspace.baselines.experiment import CLASSIFIERS, REGRESSORS, seeded

NUMERICAL, NUMERICAL_JACOBIAN = "numerical angles alone", "numerical angles, exact Jacobian"
ANALYTIC, ANALYTIC_JACOBIAN = "analytic angles alone", "analytic angles, exact Jacobian"
ANGLES, CLOSED, REACH = "exact, by angles", "exact, closed form", "exact, w alone"
PLANE, PAPERS = "network, plane", "network, paper's size"

TOOLBOX = "toolbox, one by one"
SINGLE, SOME, MANY = "torch, one by one", "torch, test set", "torch, many at once"
C_FROM_PYTHON, C_FROM_C = "C from Python, one by one", "C from C, one by one"
C_SOME, C_MANY = "C, test set", "C, many at once"

_SMALL = Architecture(confidence=(192,) * 3, estimation=(256,) * 3)
NETWORKS: Mapping[str, tuple[Architecture, Any, Any]] = {
    "network, rotation": (_SMALL, "rotation", "tool"),
    PLANE: (_SMALL, "plane", "plane"),
    PAPERS: (PAPER_SIZE, "rotation", "tool"),
}
"""Widths, inputs and entries of the networks."""

SLOW = ("svm-radial", "svm-sigmoid", "gaussian-process")
"""Methods whose training takes more than a few times as long for twice the rows."""

COLUMNS = ("configurations", "lower", "median", "upper")
TIMES: Any = {"timed": True, "unsteady": COLUMNS[1:]}
BRIEF: Any = {"rounds": 1, "seconds": 1e-3}
Rows = Iterator[dict[str, Any]]
Ways = dict[str, Callable[[Any], object]]


@experiment(smoke={"in_loops": 3})
def ways(seed: int, in_loops: int = 20) -> Rows:
    """Deviations of Jacobians from that by angles, and sizes of the paper's network and of the C file."""
    robot, numerical, analytic = _toolbox()
    links, T = _poses(robot, seed, in_loops)
    truth, poses = _by_angles(links, T), _raised(robot, T)
    theirs = np.array([robot.jacob0(analytic(pose).q) for pose in poses])
    found = {"toolbox": theirs, "torch": _closed_form()(links, T), "c": CompiledArm(links).solve(T).jacobian}
    yield {
        "solved": float(np.mean([numerical(pose).success for pose in poses])),
        **{name: (torch.as_tensor(J) - truth).abs().max() for name, J in found.items()},
        "source_bytes": len(compiled.c_source().encode()),
        "parameters": _untrained(PAPERS, seed).parameter_count,
    }


@experiment(keys=("rung", "way"), smoke={"in_loops": 3, "some": 20, "many": 40, **BRIEF}, **TIMES)
def ladder(
    seed: int,
    in_loops: int = 20,
    some: int = 2_000,
    many: int = 100_000,
    rounds: int = 7,
    seconds: float = 0.02,
) -> Rows:
    """Times per pose [s], from a toolbox that is called for each pose down to C on many poses at once."""
    robot, numerical, analytic = _toolbox()
    links, T = _poses(robot, seed, many)
    few, some_poses, arm = T[:in_loops], T[:some], CompiledArm(links)
    toolbox: Ways = {
        NUMERICAL: numerical,
        NUMERICAL_JACOBIAN: lambda pose: robot.jacob0(numerical(pose).q),
        ANALYTIC: analytic,
        ANALYTIC_JACOBIAN: lambda pose: robot.jacob0(analytic(pose).q),
    }
    exact: Ways = {ANGLES: partial(_by_angles, links), CLOSED: partial(_closed_form(), links)}
    every = exact | {name: partial(_untrained(name, seed).answer, links) for name in NETWORKS}
    small = {name: way for name, way in every.items() if name != PAPERS}
    in_c: Ways = {CLOSED: arm.solve, REACH: arm.manipulability}
    rungs = {
        TOOLBOX: _looping(toolbox, _raised(robot, few)),
        SINGLE: _looping(every, few),
        SOME: _at_once(every, some_poses),
        MANY: _at_once(small, T),
        C_FROM_PYTHON: _looping({CLOSED: arm.solve}, few),
        C_FROM_C: [Way(CLOSED, _in_c_one_by_one(links, some_poses), some)],
        C_SOME: _at_once(in_c, some_poses),
        C_MANY: _at_once(in_c, T),
    }
    for rung, timed in rungs.items():
        for timing in measure(timed, rounds, seconds):
            yield {"rung": rung, "way": timing.name, **_row(timing)}


@experiment(keys=("method",), smoke={"rows": 60, "slow_rows": 30, "tests": 10, **BRIEF}, **TIMES)
def others(
    seed: int,
    rows: int = 50_000,
    slow_rows: int = 3_000,
    tests: int = 2_000,
    rounds: int = 3,
    seconds: float = 0.02,
) -> Rows:
    """Times per row [s] with which the other methods of both tables predict all test rows at once."""
    confidence = dataset.confidence_data(rows + tests, seed)
    jacobians = dataset.jacobian_data(rows + tests, seed)
    for task, samples, y, methods in (
        ("confidence", confidence.samples, confidence.reachable, CLASSIFIERS),
        ("estimation", jacobians.samples, jacobians.in_frame("tool").flatten(1), REGRESSORS),
    ):
        columns = dataset.features(samples)
        x = Scaling.to_unit_deviation(columns).apply(columns).numpy()
        for method in methods.values():
            name, count = f"{task}-{method.key}", slow_rows if method.key in SLOW else rows
            with warnings.catch_warnings():
                # Whether a fit on a part of the rows converges does not matter here.
                warnings.simplefilter("ignore")
                model = seeded(method, seed).fit(x[:count], y[:count].numpy())
            (timing,) = measure([Way(name, partial(model.predict, x[rows:]), tests)], rounds, seconds)
            yield {"method": name, "rows": count, **_row(timing)}


@experiment(keys=("side",), smoke={"sides": (2, 3), **BRIEF}, **TIMES)
def grids(seed: int, sides: tuple[int, ...] = (4, 6, 8, 10), rounds: int = 3, seconds: float = 0.02) -> Rows:  # noqa: ARG001
    """Times [s] of w on whole grids of so many steps for each of position and angles of orientation, compiled."""
    answer = maps.ByClosedForm((0.15, 0.4318, 0.4318, 0.0203), backend="c")
    for side in sides:
        steps = math.tau * torch.arange(side, dtype=torch.float64) / side
        R = dataset.rotation(torch.cartesian_prod(steps, steps, steps))
        grid = maps.Grid.cube(maps.TRAINED_HALF_SIDE, side)
        (timing,) = measure([Way("grid", partial(maps.survey, answer, grid, R), 1)], rounds, seconds)
        yield {"side": side, **_row(timing)}


def _row(timing: Timing) -> dict[str, float]:
    return {name: getattr(timing, name) for name in COLUMNS}


def _toolbox() -> tuple[Any, Callable[[Any], Any], Callable[[Any], Any]]:
    """Return the PUMA 560 of the Python toolbox, its numerical and its analytic inverse kinematics.

    The numerical one is by Levenberg's and Marquardt's steps from zero; its seed is for further starts.
    """
    with warnings.catch_warnings():
        # It writes LaTeX into plain strings.
        warnings.simplefilter("ignore")
        import roboticstoolbox
    robot = roboticstoolbox.models.DH.Puma560()
    return robot, partial(robot.ikine_LM, q0=np.zeros(6), seed=0), partial(robot.ikine_a, config="lun")


def _poses(robot: Any, seed: int, count: int) -> tuple[Tensor, Tensor]:
    """Return the links of the arm and poses of random angles within its limits, from its shoulder's height."""
    rows, random = robot.links, torch.Generator().manual_seed(seed)
    links = torch.tensor([rows[2].d, rows[3].d, rows[1].a, rows[2].a], dtype=torch.float64)
    lower, upper = torch.as_tensor(robot.qlim)
    unit = torch.rand(count, 6, generator=random, dtype=torch.float64)
    return links, reachability.forward(links, lower + (upper - lower) * unit)


def _raised(robot: Any, T: Tensor) -> list[Any]:
    """Return poses from the toolbox's base, which is lower."""
    raised = T.clone()
    raised[..., 2, 3] += robot.links[0].d
    return list(raised.numpy())


def _by_angles(links: Tensor, T: Tensor) -> Tensor:
    return reachability.geometric_jacobian(links, reachability.inverse(links, T)[0])


def _closed_form() -> Callable[[Tensor, Tensor], Tensor]:
    names = "cosines", "sines", "jacobian", "manipulability"
    compute, jacobian = closed_form.in_torch(reachability.NAMED_BRANCH, *names), closed_form.PARTS["jacobian"]
    return lambda links, T: compute(links, T)[..., jacobian].unflatten(-1, (6, 6))


def _untrained(name: str, seed: int) -> JacobianNet:
    """Return a network with random weights."""
    return training.network_for(
        *NETWORKS[name], dataset.jacobian_data(100, seed, dynamics=False), seed
    ).eval()


def _looping(functions: Ways, poses: Any) -> list[Way]:
    def loop(function: Callable[[Any], object]) -> object:
        return [function(T) for T in poses]

    return [Way(name, partial(loop, function), len(poses)) for name, function in functions.items()]


def _at_once(functions: Ways, T: Tensor) -> list[Way]:
    return [Way(name, partial(function, T), len(T)) for name, function in functions.items()]


def _in_c_one_by_one(links: Tensor, T: Tensor) -> Callable[[], object]:
    """Return a loop in C that calls the function for one pose."""
    run = compiled_library(_ONE_BY_ONE).one_by_one
    pointer, size = ctypes.c_void_p, ctypes.c_size_t
    run.argtypes = [pointer, pointer, pointer, size, size, pointer]
    function = ctypes.cast(compiled_library(compiled.c_source("arm")).arm, pointer)
    width = closed_form.PARTS["manipulability"].stop
    poses, values = T.contiguous(), T.new_empty(len(T), width)

    def compute() -> Tensor:
        run(function, links.data_ptr(), poses.data_ptr(), len(poses), width, values.data_ptr())
        return values

    return compute


_ONE_BY_ONE = """
#include <stddef.h>

typedef int (*function)(const double *links, const double *pose, double *values);

void one_by_one(
    function f, const double *links, const double *poses, size_t count, size_t width, double *values);
void one_by_one(
    function f, const double *links, const double *poses, size_t count, size_t width, double *values)
{
  for (size_t i = 0; i < count; ++i)
    f(links, poses + 16*i, values + width*i);
}
"""
