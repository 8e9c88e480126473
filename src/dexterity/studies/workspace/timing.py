"""Paper C, Tables VI and VII, Avg. Time, and section I: how long a pose takes, and what a whole grid costs.

Liao & Mao (2018). The ladder goes down from the Python toolbox of the author whose toolbox the paper used, by
numerical and by analytic inverse kinematics, over batches in torch to the closed form in C; each way gets the
same poses of the PUMA 560, which are in reach within its limits, and gives the Jacobian there, unless it says
otherwise. The networks have random weights, since trained ones take the same time: two small ones and one of
the paper's size. The other methods of the tables are trained on a part of the rows, so that those that
compare with every training row are faster here than they would be with all of them.

What decides a verdict was set beforehand. A time within the rounding of the printed one is *reproduced*, one
within a factor of three of it is *in shape*. The networks are faster than inverse kinematics (*reproduced*)
if that of the paper's size is faster, quartiles apart, than all exact ways; if it is faster than the
toolbox's two alone, and slower than another exact way in the same batches and language, that is
*contradicted*. An ordering of two times counts if their quartiles lie apart.
"""

from __future__ import annotations

import ctypes
import math
import time
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any

import numpy as np
import torch
from torch import Tensor

from dexterity.codegen.library import compiled_library
from dexterity.report.claims import Acceptance, Outcome, Paper, Verdict, load_paper
from dexterity.report.stored import Tolerance
from dexterity.studies.workspace import baselines
from dexterity.timing import Timing, Way, measure, ratio
from dexterity.workspace import closed_form, compiled, dataset, maps, reachability
from dexterity.workspace.compiled import CompiledArm
from dexterity.workspace.dataset import Scaling
from dexterity.workspace.jacobian_net import PAPER_SIZE, Architecture, Entries, Inputs, JacobianNet
from dexterity.workspace.reachability import NAMED_BRANCH

__all__ = [
    "CONFIGS",
    "TOLERANCE",
    "Config",
    "Result",
    "Scaled",
    "acceptance",
    "exponent",
    "grid_table",
    "ladder",
    "other_methods",
    "run",
    "toolbox_table",
    "verdicts",
]

TOLERANCE = Tolerance(rtol=1e-6, atol=1e-6)
"""What a probe may miss by; it takes no times."""

_PAPER = "liao2018"
_SHAPE = 3.0

LINKS = (0.15, 0.4318, 0.4318, 0.0203)
"""d₃, d₄, a₂ and a₃ of the PUMA 560 [m]; the toolbox's d₃ is 0.05 mm longer, which the ladder takes over."""

NUMERICAL, NUMERICAL_ANGLES_JACOBIAN = "numerical angles alone", "numerical angles, exact Jacobian"
NUMERICAL_JACOBIAN = "numerical angles, numerical Jacobian"
ANALYTIC, ANALYTIC_JACOBIAN = "analytic angles alone", "analytic angles, exact Jacobian"
ANGLES, CLOSED, REACH = "exact, by angles", "exact, closed form", "exact, w alone"
GENERAL, PLANE, PAPERS = "network, rotation", "network, plane", "network, paper's size"

TOOLBOX, SINGLE = "toolbox, one by one", "torch, one by one"
C_FROM_PYTHON, C_FROM_C = "C from Python, one by one", "C from C, one by one"


@dataclass(frozen=True)
class Config:
    """What is timed, and how long.

    Attributes
    ----------
    seed
        Of poses, weights and training sets.
    in_loops, some, many
        Poses that a loop gets, and those of a batch: the paper's test set, and one large enough that nothing
        but arithmetic counts.
    rows, slow_rows
        Of the training sets of the other methods: of most, and of those that compare with every row.
    tests
        Rows that these are timed on at once.
    sides
        Steps a side of the grids that show how the time grows.
    rounds, seconds
        How often each way gets its turn, and for how long at least [s]; no times without rounds.
    """

    seed: int = 0
    in_loops: int = 20
    some: int = 2_000
    many: int = 50_000
    rows: int = 20_000
    slow_rows: int = 1_000
    tests: int = 2_000
    sides: tuple[int, ...] = (4, 6, 8, 10)
    rounds: int = 3
    seconds: float = 0.02


CONFIGS: Mapping[str, Config] = {
    "smoke": Config(in_loops=3, some=20, many=40, rows=60, slow_rows=30, tests=10, sides=(2, 3), rounds=0),
    "book": Config(),
    "full": Config(
        in_loops=100, many=200_000, rows=100_000, slow_rows=5_000, sides=(4, 6, 8, 10, 12), rounds=15
    ),
}
"""What runs at each scale."""


@dataclass(frozen=True)
class Scaled:
    """How long a whole grid of positions and orientations takes.

    Attributes
    ----------
    side
        Steps a side, the same for each of six dimensions.
    poses
        Their number.
    seconds
        For w at all of them, compiled, in slabs [s].
    """

    side: int
    poses: int
    seconds: float


@dataclass(frozen=True)
class Result:
    """Times.

    Attributes
    ----------
    parameters
        How many numbers each network has.
    ladder
        By rung, the ways on it; empty if no times were taken.
    others
        Of the other methods of the tables, by the name of their claim, for one sample.
    rows
        How many rows each of them was trained on.
    grids
        Of growing sides; empty if no times were taken.
    source_bytes
        Length of the C file.
    solved
        Share of the poses that the toolbox's numerical inverse kinematics solves.
    errors
        Largest difference of a way's Jacobian from that of the closed form.
    """

    parameters: Mapping[str, int]
    ladder: Mapping[str, tuple[Timing, ...]]
    others: Mapping[str, Timing]
    rows: Mapping[str, int]
    grids: tuple[Scaled, ...]
    source_bytes: int
    solved: float
    errors: Mapping[str, float]


def run(config: Config) -> Result:
    """Build all ways, compare what they compute, and time them."""
    contest = _Contest(config)
    others = _others(config)
    return Result(
        parameters={name: network.parameter_count for name, network in contest.networks.items()},
        ladder={rung: _timed(ways, config) for rung, ways in contest.rungs().items()},
        others={name: timing for name, way in others.items() for timing in _timed([way], config)},
        rows={name: config.slow_rows if name in _SLOW else config.rows for name in others},
        grids=tuple(_whole_grid(side) for side in config.sides if config.rounds),
        source_bytes=len(compiled.c_source().encode()),
        solved=contest.solved(),
        errors=contest.errors(),
    )


def _timed(ways: Sequence[Way], config: Config) -> tuple[Timing, ...]:
    return measure(ways, config.rounds, config.seconds) if config.rounds else ()


# ---- the ladder ------------------------------------------------------------------------------------


class _Toolbox:
    """The PUMA 560 of the Python toolbox, with its base at its shoulder's height."""

    def __init__(self) -> None:
        with warnings.catch_warnings():
            # It writes LaTeX into plain strings.
            warnings.simplefilter("ignore")
            import roboticstoolbox
            from roboticstoolbox.tools.numerical import jacobian_numerical
        self._differences = jacobian_numerical
        self._robot = roboticstoolbox.models.DH.Puma560()
        rows = self._robot.links
        self.links = (rows[2].d, rows[3].d, rows[1].a, rows[2].a)
        self.lower, self.upper = torch.as_tensor(self._robot.qlim)
        self._height = rows[0].d

    def raised(self, T: Tensor) -> list[Any]:
        """Poses in the toolbox's base, which is lower."""
        raised = T.clone()
        raised[..., 2, 3] += self._height
        return list(raised.numpy())

    def numerical(self, T: Any) -> Any:
        """Solve for angles (6) by Levenberg's and Marquardt's steps, from zero, with the default settings."""
        # A seed for the starts that follow if the first one does not lead there.
        return self._robot.ikine_LM(T, q0=np.zeros(6), seed=0)

    def analytic(self, T: Any) -> Any:
        """Solve for angles (6) of the named branch."""
        return self._robot.ikine_a(T, config="lun")

    def jacobian(self, q: Any) -> Any:
        """Geometric Jacobian (6, 6)."""
        return self._robot.jacob0(q)

    def numerical_jacobian(self, q: Any) -> Any:
        """Geometric Jacobian (6, 6) from differences of forward kinematics."""
        return self._differences(lambda angles: self._robot.fkine(angles).A, q, N=3)


class _Contest:
    """All ways to the Jacobian of a pose, with the poses that they get."""

    def __init__(self, config: Config) -> None:
        self._toolbox = _Toolbox()
        self._links = torch.tensor(self._toolbox.links, dtype=torch.float64)
        random = torch.Generator().manual_seed(config.seed)
        unit = torch.rand(config.many, 6, generator=random, dtype=torch.float64)
        lower, upper = self._toolbox.lower, self._toolbox.upper
        T = reachability.forward(self._links, lower + (upper - lower) * unit)
        self._many, self._some, self._few = T, T[: config.some], T[: config.in_loops]
        self._arm = CompiledArm(self._links)
        self.networks = {
            GENERAL: _untrained("rotation", "tool", _SMALL, config.seed),
            PLANE: _untrained("plane", "plane", _SMALL, config.seed),
            PAPERS: _untrained("rotation", "tool", PAPER_SIZE, config.seed),
        }

    def rungs(self) -> dict[str, tuple[Way, ...]]:
        """Ways from a toolbox that is called for each pose to C on many poses."""
        exact = {ANGLES: self._by_angles, CLOSED: self._closed_form}
        networks = {name: self._asking(network) for name, network in self.networks.items()}
        small = {name: way for name, way in networks.items() if name != PAPERS}
        some, many = f"{len(self._some):,} at once", f"{len(self._many):,} at once"
        solving = {CLOSED: self._arm.solve}
        return {
            TOOLBOX: _looping(self._of_toolbox(), self._toolbox.raised(self._few)),
            SINGLE: _looping(exact | networks, self._few),
            f"torch, {some}": _at_once(exact | networks, self._some),
            f"torch, {many}": _at_once(exact | small, self._many),
            C_FROM_PYTHON: _looping(solving, self._few),
            C_FROM_C: (Way(CLOSED, _in_c_one_by_one(self._links, self._some), len(self._some)),),
            f"C, {some}": _at_once(solving | {REACH: self._arm.manipulability}, self._some),
            f"C, {many}": _at_once(solving | {REACH: self._arm.manipulability}, self._many),
        }

    def _of_toolbox(self) -> dict[str, Callable[[Any], object]]:
        own = self._toolbox
        return {
            NUMERICAL: own.numerical,
            NUMERICAL_ANGLES_JACOBIAN: lambda T: own.jacobian(own.numerical(T).q),
            NUMERICAL_JACOBIAN: lambda T: own.numerical_jacobian(own.numerical(T).q),
            ANALYTIC: own.analytic,
            ANALYTIC_JACOBIAN: lambda T: own.jacobian(own.analytic(T).q),
        }

    def _by_angles(self, T: Tensor) -> Tensor:
        q, _ = reachability.inverse(self._links, T)
        return reachability.geometric_jacobian(self._links, q)

    @cached_property
    def _closed_form(self) -> Callable[[Tensor], Tensor]:
        compute = closed_form.in_torch(NAMED_BRANCH, "cosines", "sines", "jacobian", "manipulability")
        return lambda T: compute(self._links, T)[..., closed_form.PARTS["jacobian"]].unflatten(-1, (6, 6))

    def _asking(self, network: JacobianNet) -> Callable[[Tensor], object]:
        return lambda T: network.answer(self._links, T)

    @cached_property
    def _answers(self) -> dict[str, list[Any]]:
        """What the toolbox says of a few poses."""
        poses = self._toolbox.raised(self._few)
        return {
            NUMERICAL: [self._toolbox.numerical(T) for T in poses],
            ANALYTIC: [self._toolbox.analytic(T) for T in poses],
        }

    def solved(self) -> float:
        """Share of a few poses that the toolbox's numerical inverse kinematics solves."""
        return float(np.mean([answer.success for answer in self._answers[NUMERICAL]]))

    def errors(self) -> dict[str, float]:
        """Largest difference of a way's Jacobian from that of the angles it belongs to, or of its branch."""
        wanted = self._by_angles(self._few)
        angles = [answer.q for answer in self._answers[ANALYTIC]]
        theirs = torch.as_tensor(np.array([self._toolbox.jacobian(q) for q in angles]))
        differences = torch.as_tensor(np.array([self._toolbox.numerical_jacobian(q) for q in angles]))
        found = {
            "toolbox": theirs,
            "closed form in torch": self._closed_form(self._few),
            "closed form in C": self._arm.solve(self._few).jacobian,
        }
        errors = {name: (J - wanted).abs().max().item() for name, J in found.items()}
        return errors | {"toolbox, by differences": (differences - theirs).abs().max().item()}


_SMALL = Architecture(confidence=(192, 192, 192), estimation=(256, 256, 256))


def _untrained(inputs: Inputs, entries: Entries, architecture: Architecture, seed: int) -> JacobianNet:
    """Network with random weights, and scaling that leaves everything as it is."""
    widths = {"rotation": 16, "plane": 6, "tool": 23}
    into, out = widths[inputs], 11 if entries == "plane" else widths[entries]
    same = [
        Scaling(torch.zeros(k, dtype=torch.float64), torch.ones(k, dtype=torch.float64)) for k in (into, out)
    ]
    return JacobianNet(
        architecture, inputs, entries, same[0], same[1], torch.Generator().manual_seed(seed)
    ).eval()


def _looping(
    functions: Mapping[str, Callable[[Any], object]], poses: Sequence[Any] | Tensor
) -> tuple[Way, ...]:
    def loop(function: Callable[[Any], object]) -> Callable[[], object]:
        return lambda: [function(T) for T in poses]

    return tuple(Way(name, loop(function), len(poses)) for name, function in functions.items())


def _at_once(functions: Mapping[str, Callable[[Tensor], object]], T: Tensor) -> tuple[Way, ...]:
    def call(function: Callable[[Tensor], object]) -> Callable[[], object]:
        return lambda: function(T)

    return tuple(Way(name, call(function), len(T)) for name, function in functions.items())


def _in_c_one_by_one(links: Tensor, T: Tensor) -> Callable[[], object]:
    """Return how a loop in C calls the function for one pose."""
    run = compiled_library(_ONE_BY_ONE).one_by_one
    pointer, size = ctypes.c_void_p, ctypes.c_size_t
    run.argtypes = [pointer, pointer, pointer, size, size, pointer]
    function = ctypes.cast(compiled_library(compiled.c_source("arm")).arm, pointer)
    poses = T.contiguous()
    width = closed_form.PARTS["manipulability"].stop
    values = poses.new_empty(len(poses), width)

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


# ---- whole grids -----------------------------------------------------------------------------------


def _whole_grid(side: int) -> Scaled:
    """Time w on a grid of so many steps a side, three of position and three of the orientation's angles."""
    answer = maps.ByClosedForm(LINKS, backend="c")
    grid = maps.Grid.cube(maps.TRAINED_HALF_SIDE, side)
    steps = math.tau * torch.arange(side, dtype=torch.float64) / side
    R = dataset.rotation(torch.cartesian_prod(steps, steps, steps))
    best = math.inf
    for _ in range(3):
        started = time.perf_counter()
        maps.survey(answer, grid, R)
        best = min(best, time.perf_counter() - started)
    return Scaled(side, side**6, best)


# ---- the other methods -----------------------------------------------------------------------------

_SLOW = (
    "time-confidence-svm-radial",
    "time-confidence-svm-sigmoid",
    "time-confidence-gaussian-process",
    "time-estimation-gaussian-process",
)
"""Claims on methods whose training takes more than a few times as long for twice the rows."""


def _others(config: Config) -> dict[str, Way]:
    """Predict the test rows with each of the other methods of Tables VI and VII, by the claim on its time."""
    confidence = dataset.confidence_data(config.rows + config.tests, config.seed)
    jacobians = dataset.jacobian_data(config.rows + config.tests, config.seed)
    tasks = {
        "confidence": (_scaled(dataset.features(confidence.samples)), confidence.reachable.numpy()),
        "estimation": (
            _scaled(dataset.features(jacobians.samples)),
            jacobians.in_frame("tool").flatten(1).numpy(),
        ),
    }
    ways = {}
    for claim, method in _methods(config.seed).items():
        x, y = tasks[claim.split("-")[1]]
        rows = config.slow_rows if claim in _SLOW else config.rows
        with warnings.catch_warnings():
            # Whether a fit on a part of the rows converges does not matter here.
            warnings.simplefilter("ignore")
            method.fit(x[:rows], y[:rows])
        ways[claim] = Way(claim, _predicting(method, x[config.rows :]), config.tests)
    return ways


def _scaled(x: Tensor) -> Any:
    return Scaling.to_unit_deviation(x).apply(x).numpy()


def _predicting(method: Any, x: Any) -> Callable[[], object]:
    return lambda: method.predict(x)


def _methods(seed: int) -> dict[str, Any]:
    """Methods of Tables VI and VII, by the claim on their time."""
    classifiers, regressors = baselines.classifiers(seed), baselines.regressors(seed)
    return {
        f"time-confidence-{claim}": classifiers[name] for name, claim in baselines.CLASSIFIERS.items()
    } | {f"time-estimation-{claim}": regressors[name] for name, claim in baselines.REGRESSORS.items()}


# ---- what is shown ---------------------------------------------------------------------------------


def ladder(result: Result) -> dict[tuple[str, str], dict[str, str]]:
    """Nanoseconds for a pose, with quartiles, and how many times as long as compiled in the largest batch."""
    if not result.ladder[TOOLBOX]:
        return {}
    foot = _foot(result)
    rows = {}
    for rung, timings in result.ladder.items():
        for timing in timings:
            median, lower, upper = (1e9 * t for t in (timing.median, timing.lower, timing.upper))
            rows[rung, timing.name] = {
                "median [ns]": f"{median:,.3g}" if median < 1e3 else f"{median:,.0f}",
                "quartiles [ns]": f"{lower:,.0f}–{upper:,.0f}",
                "times compiled": "1" if timing == foot else str(ratio(timing, foot)),
            }
    return rows


def toolbox_table(result: Result) -> dict[str, dict[str, float]]:
    """Set times of inverse kinematics, Jacobians and networks [µs] beside the paper's."""
    return {
        name: {"paper": 1e6 * _seconds(claim), "ours": 1e6 * timing.median}
        for name, claim, timing in (
            ("inverse kinematics, numerical", "time-ikine", _of(result, TOOLBOX, NUMERICAL)),
            ("inverse kinematics, analytic", "time-ikine6s", _of(result, TOOLBOX, ANALYTIC)),
            (
                "Jacobian, numerical",
                "time-jacobian-numerical",
                _of(result, TOOLBOX, NUMERICAL_ANGLES_JACOBIAN),
            ),
            ("Jacobian, analytic", "time-jacobian-analytic", _of(result, TOOLBOX, ANALYTIC_JACOBIAN)),
            ("network, one by one", "time-estimation-network", _of(result, SINGLE, PAPERS)),
            ("network, test set at once", "time-estimation-network", _of(result, _some(result), PAPERS)),
        )
        if timing is not None
    }


def other_methods(result: Result) -> dict[str, dict[str, float]]:
    """Set times of the other methods for a sample [µs] beside the paper's, with the rows of training."""
    return {
        claim.removeprefix("time-").replace("-", ", ", 1).replace("-", " "): {
            "paper": 1e6 * _seconds(claim),
            "ours": 1e6 * timing.median,
            "rows": result.rows[claim],
        }
        for claim, timing in result.others.items()
    }


def grid_table(result: Result) -> dict[str, dict[str, str]]:
    """How long grids of so many steps a side take, by way, from the ladder's times for a pose."""
    if not result.grids:
        return {}
    ways = {
        "toolbox, numerical": _of(result, TOOLBOX, NUMERICAL_ANGLES_JACOBIAN),
        "toolbox, analytic": _of(result, TOOLBOX, ANALYTIC_JACOBIAN),
        "network of the paper's size": _of(result, _some(result), PAPERS),
        "small network": _of(result, _many(result), PLANE),
        "compiled, Jacobian and all": _foot(result),
        "compiled, w alone": _of(result, list(result.ladder)[-1], REACH),
    }
    rows = {
        name: {f"{side} steps": _duration(side**6 * timing.median) for side in _SIDES}
        for name, timing in ways.items()
        if timing is not None
    }
    alone = _of(result, list(result.ladder)[-1], REACH)
    if alone is not None:
        rows["positions alone, which suffice"] = {
            f"{side} steps": _duration(side**3 * alone.median) for side in _SIDES
        }
    return rows


_SIDES = (10, 20, 50)
_UNITS = (
    ("years", 31_557_600.0),
    ("days", 86_400.0),
    ("h", 3_600.0),
    ("min", 60.0),
    ("s", 1.0),
    ("ms", 1e-3),
)


def _duration(seconds: float) -> str:
    for unit, length in _UNITS:
        if seconds >= length:
            return f"{seconds / length:,.3g} {unit}"
    return f"{1e6 * seconds:,.3g} µs"


def exponent(result: Result) -> float:
    """Slope of the logarithm of a grid's time over that of its side; NaN if no times were taken."""
    if len(result.grids) < 2:
        return math.nan
    sides, seconds = zip(*((grid.side, grid.seconds) for grid in result.grids), strict=True)
    return float(np.polyfit(np.log(sides), np.log(seconds), 1)[0])


def _of(result: Result, rung: str, name: str) -> Timing | None:
    return next((timing for timing in result.ladder[rung] if timing.name == name), None)


def _some(result: Result) -> str:
    return list(result.ladder)[2]


def _many(result: Result) -> str:
    return list(result.ladder)[3]


def _foot(result: Result) -> Timing:
    """Time of the compiled closed form in the largest batches."""
    return list(result.ladder.values())[-1][0]


# ---- verdicts --------------------------------------------------------------------------------------


def verdicts(result: Result) -> tuple[Verdict, ...]:
    """Judge the claims of the ledger that this study answers for."""
    own = [claim.id for claim in _paper().claims if claim.study == "workspace.timing"]
    if not result.ladder[TOOLBOX]:
        return tuple(_verdict(claim, Outcome.UNDERSPECIFIED, "No times were taken.") for claim in own)
    return (
        *_on_complexity(result),
        *_on_inverse_kinematics(result),
        *_on_networks(result),
        *_on_others(result),
    )


def _on_complexity(result: Result) -> tuple[Verdict, ...]:
    slope = exponent(result)
    numerical, foot = _named(result, TOOLBOX, NUMERICAL_ANGLES_JACOBIAN), _foot(result)
    slow = numerical.median / foot.median
    days = _duration(20**6 * numerical.median)
    return (
        _verdict(
            "complexity", Outcome.NOT_REPRODUCED,
            f"A grid of n steps a side has n⁶ poses, and the time of a pose knows nothing of n: fitted over "
            f"{', '.join(str(grid.side) for grid in result.grids)} steps the time grows with the power "
            f"{slope:.2f}. For the paper's arms, whose reach leaves orientation aside, n³ positions suffice.",
            f"{slope:.2f}",
        ),
        _verdict(
            "workspaces-are-slow", Outcome.IN_SHAPE if slow >= 10 else Outcome.NOT_REPRODUCED,
            f"Slow they are: 20 steps a side take the toolbox {days} numerically, and the closed form in C "
            f"{_duration(20**6 * foot.median)}. But that is a factor for each pose, not a complexity.",
            f"{slow:,.0f} times as long as compiled",
        ),
    )  # fmt: skip


def _on_inverse_kinematics(result: Result) -> tuple[Verdict, ...]:
    rows = {
        "time-ikine": NUMERICAL, "time-ikine6s": ANALYTIC,
        "time-jacobian-numerical": NUMERICAL_ANGLES_JACOBIAN, "time-jacobian-analytic": ANALYTIC_JACOBIAN,
    }  # fmt: skip
    times = [_named(result, TOOLBOX, name) for name in (NUMERICAL, NUMERICAL_ANGLES_JACOBIAN)]
    others = [_named(result, TOOLBOX, name) for name in (ANALYTIC, ANALYTIC_JACOBIAN)]
    order = all(b.upper < a.lower for a, b in zip(times, others, strict=True))
    factors = [a.median / b.median for a, b in zip(times, others, strict=True)]
    return (
        *(
            _on_time(
                claim, _named(result, TOOLBOX, name),
                "The author's toolbox for Python, which computes in part in C, stands for that for MATLAB."
            )
            for claim, name in rows.items()
        ),
        _verdict(
            "analytic-faster-than-numerical", Outcome.of(order),
            f"{factors[0]:.0f} times faster for the angles, {factors[1]:.0f} times with the Jacobian.",
            f"{factors[0]:.0f} and {factors[1]:.0f} times",
        ),
    )  # fmt: skip


def _on_networks(result: Result) -> tuple[Verdict, ...]:
    single, batch = _named(result, SINGLE, PAPERS), _named(result, _some(result), PAPERS)
    toolbox = [_named(result, TOOLBOX, name) for name in (NUMERICAL_ANGLES_JACOBIAN, ANALYTIC_JACOBIAN)]
    alike = {
        rung: (_named(result, rung, PAPERS), _named(result, rung, CLOSED)) for rung in (SINGLE, _some(result))
    }
    slower = [rung for rung, (network, exact) in alike.items() if network.lower > exact.upper]
    before = all(batch.upper < timing.lower for timing in toolbox)
    outcome = Outcome.REPRODUCED if before and not slower else Outcome.NOT_REPRODUCED
    if before and slower:
        outcome = Outcome.CONTRADICTED
    foot, small, exact = _foot(result), _named(result, _many(result), PLANE), alike[_some(result)][1]
    weights = 4e-6 * result.parameters[PAPERS]
    why = (
        f"Random weights of the paper's number, {result.parameters[PAPERS] / 1e6:.1f} million, all test rows "
        f"at once; one by one it takes {1e6 * single.median:,.0f} µs. Both heads are computed."
    )
    return (
        _verdict(
            "faster-than-inverse-kinematics", outcome,
            f"The network of the paper's size takes {1e6 * batch.median:.3g} µs in batches, the toolbox "
            f"{1e6 * toolbox[0].median:,.0f} (numerical) and {1e6 * toolbox[1].median:,.0f} µs (analytic). "
            f"The exact answer takes {1e6 * exact.median:.3g} µs in torch in the same batches, and "
            f"{1e6 * foot.median:.2g} µs compiled; a small network takes {1e6 * small.median:.2g} µs.",
            f"{ratio(batch, foot)} times as long as compiled",
        ),
        _verdict(
            "portable", Outcome.UNDERSPECIFIED,
            f"What portable means is not said. The paper's weights take {weights:.0f} MB and a library for "
            f"networks; the exact answer is a C file of {result.source_bytes / 1024:.0f} kB beside math.h.",
            f"{weights:.0f} MB beside {result.source_bytes / 1024:.0f} kB",
        ),
        *(_on_time(claim, batch, why) for claim in ("time-confidence-networks", "time-estimation-network")),
    )  # fmt: skip


def _on_others(result: Result) -> tuple[Verdict, ...]:
    texts = {
        claim: f"Trained on {result.rows[claim]:,} rows and asked for all test rows at once."
        + (" It compares with training rows, and takes longer with more." if _compares(claim) else "")
        for claim in result.others
    }
    return tuple(_on_time(claim, timing, texts[claim]) for claim, timing in result.others.items())


def _compares(claim: str) -> bool:
    return claim in _SLOW or claim.endswith("nearest-neighbours")


def _on_time(claim: str, timing: Timing, why: str) -> Verdict:
    printed = _seconds(claim)
    unit, size = ("s", 1.0) if _paper().claim(claim).unit == "s" else ("µs", 1e-6)
    median, lower, upper = (t / size for t in (timing.median, timing.lower, timing.upper))
    return _verdict(
        claim, _closeness(timing.median, claim),
        f"The printed time is {printed / timing.median:.3g} times ours. {why}",
        f"{median:.3g} {unit}", f"quartiles {lower:.3g} and {upper:.3g} {unit}",
    )  # fmt: skip


def _closeness(seconds: float, claim: str) -> Outcome:
    printed, unit = _seconds(claim), 1.0 if _paper().claim(claim).unit == "s" else 1e-6
    if abs(seconds - printed) <= _paper().claim(claim).rounding * unit:
        return Outcome.REPRODUCED
    return Outcome.IN_SHAPE if printed / _SHAPE <= seconds <= printed * _SHAPE else Outcome.NOT_REPRODUCED


def _named(result: Result, rung: str, name: str) -> Timing:
    (found,) = (timing for timing in result.ladder[rung] if timing.name == name)
    return found


def _seconds(claim: str) -> float:
    """Return a printed time [s]; of several, which are all the same, the first."""
    own = _paper().claim(claim)
    value = own.value[0] if isinstance(own.value, tuple) else own.value
    if value is None:
        raise ValueError(f"the claim {claim} has no value")
    return value * (1.0 if own.unit == "s" else 1e-6)


@cache
def _paper() -> Paper:
    return load_paper(_PAPER)


def _verdict(claim: str, outcome: Outcome, sentence: str, ours: str = "", spread: str = "") -> Verdict:
    return Verdict(_PAPER, claim, outcome, ours, spread, sentence)


def acceptance(result: Result) -> tuple[Acceptance, ...]:
    """Figures that must hold for the book to be built."""
    return tuple(
        Acceptance(f"Jacobian, {name}", error, 1e-6 if "differences" in name else 1e-9)
        for name, error in result.errors.items()
    )
