"""The structure of the crane: deflections, the fit of two numbers and what it leaves open, and the training data.

Source: Rouvinen (1999), sections 1.2, 2.3, 3.1 to 3.3 and 4. The structure is not given beyond the numbers of its
elements. Two of its numbers are fitted to two printed statistics of the errors without compensation. Linear statics
is linear in the flexibilities, so that two numbers are fitted in no time: they are fitted again for other sections
and other test points.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np
import torch
from numpy.typing import NDArray
from scipy.optimize import root
from scipy.spatial import cKDTree
from torch import Tensor

from dexterity.crane import data, kinematics
from dexterity.crane.beams import Beams, flexibility, gravity_potential, stiffness
from dexterity.crane.description import Crane, Structure, patu655
from dexterity.crane.equilibrium import corotational_deflection, equilibrium
from dexterity.crane.structure import Assembly, deflection, flexible_tip, load_response
from dexterity.timing import Way, measure
from dexterity_study.crane.cases import BOX, CRANE, PAPER, Made, Rows, Values, seeded, with_jib_stroke
from dexterity_study.engine.experiment import experiment

STATISTICS = ("mean x", "mean y", "mean distance", "max x", "max y", "max distance")
"""Statistics of the errors without compensation [mm], in the order of all their arrays."""

TARGETS = {"mean distance": 31.9331, "max distance": 129.6755}
"""Statistics that two numbers are fitted to [mm]."""

UNTUNED = (1.0, 3e6)
"""Bending factor and ground stiffness [N·m/rad] from which the fit set out."""

NAMED = ((2.0, 2.0), (1.0, 7.0), (2.0, 7.0))
"""Points about which the thesis finds little or no training data [m]."""

GRID_PAYLOADS = tuple(range(50, 501, 50))
STEADY = {"rtol": 1e-6, "atol": 1e-6}


@experiment(**CRANE, **STEADY)
def beams(elements: int = 6) -> Rows:
    """Relative misses of the sag of a clamped beam under a force at its end, and under its own weight, by Eq. 1."""
    nodes = torch.cartesian_prod(torch.linspace(0, 1, elements + 1).double(), torch.zeros(1).double())
    first, one = torch.arange(elements), torch.ones(elements, dtype=torch.float64)
    row = Beams(torch.stack([first, first + 1], -1), axial=1e3 * one, bending=one, weight=one)
    q = torch.zeros(len(nodes), 3, dtype=torch.float64, requires_grad=True)
    (weight,) = torch.autograd.grad(gravity_potential(row, nodes, q), q)
    by_force = flexibility(stiffness(row, nodes), [0, 1, 2])[-2]
    yield {"force": 3 * by_force[-2] - 1, "own_weight": 8 * by_force @ weight.flatten() - 1}


@experiment(**CRANE, **STEADY)
def at_rest() -> Rows:
    """Forces left, as a share of all weight, and gaps [m] where test points come to rest; the slowest's Newton steps."""
    crane, strokes = patu655(), test_strokes()
    assembly = Assembly.of(crane)
    pose, weight = assembly.placed(strokes), max(data.TEST_PAYLOADS) * crane.structure.gravity

    def potential(q: Tensor, share: float) -> Tensor:
        raised = assembly.gravity_potential(pose, q) + weight * assembly.tip(q)[:, 1]
        return assembly.strain_energy(pose, q) + share * raised

    rest = equilibrium(potential, partial(assembly.constraints, pose), assembly.free, len(strokes))
    q = rest.q.clone().requires_grad_()
    held = (rest.forces * assembly.constraints(pose, q)).sum(-1)
    (left,) = torch.autograd.grad((potential(q, 1.0) + held).sum(), q)
    (carried,) = torch.autograd.grad(assembly.gravity_potential(pose, q).sum(), q)
    all_weight = carried[:, 1:-2:3].sum(-1) + carried[:, -1] + weight
    yield {
        "residual": (left[:, assembly.free].abs().amax(-1) / all_weight).max(),
        "gap": assembly.constraints(pose, rest.q).abs().max(),
        "steps": rest.iterations,
    }


@experiment(keys=("on",), smoke={"judged": 10}, **CRANE, **STEADY)
def linear_statics(seed: int, judged: int = 3670) -> Rows:
    """Difference of linear statics from the co-rotational solution [mm], on the test and on training vectors."""
    rows = data.training_set()
    some = torch.randperm(len(rows), generator=seeded(seed))[:judged].sort().values
    for name, strokes, payload in (
        ("test", test_strokes()[:, None], torch.tensor(data.TEST_PAYLOADS, dtype=torch.float64)),
        ("training", rows.strokes[some], rows.payload[some]),
    ):
        solved = corotational_deflection(strokes, payload)
        apart = 1e3 * (solved.deflection - deflection(strokes, payload)).norm(dim=-1)
        missing = int((~solved.converged).sum())
        yield {"on": name, "mean": apart.mean(), "largest": apart.max(), "missing": missing}


@experiment(
    keys=("x", "y", "payload"),
    assumes=("crane-fitted-stiffness", "crane-linear-statics", "crane-beyond-the-end"),
    readings=(
        "crane-fitted-stiffness=unfitted",
        "crane-linear-statics=co-rotational",
        "crane-beyond-the-end=end-stop",
    ),
    **PAPER,
    **STEADY,
)
def uncompensated(reading: Values) -> Rows:
    """Errors [m] without compensation: the point that is wanted less the loaded tip."""
    crane, strokes = _with(patu655(), *reading["crane-fitted-stiffness"]), test_strokes()
    if not reading["crane-beyond-the-end"]:
        strokes = strokes.minimum(strokes.new_tensor(crane.upper))
    sag = deflection(strokes[:, None], data.TEST_PAYLOADS, crane)
    if reading["crane-linear-statics"] != "linear":
        sag = corotational_deflection(strokes[:, None], data.TEST_PAYLOADS, crane).deflection
    wanted = torch.tensor(data.TEST_POINTS, dtype=torch.float64)
    errors = (wanted - kinematics.tip_position(strokes))[:, None] - sag
    for (x, y), of_point in zip(data.TEST_POINTS, errors.tolist(), strict=True):
        for payload, (dx, dy) in zip(data.TEST_PAYLOADS, of_point, strict=True):
            yield {"x": x, "y": y, "payload": payload, "error_x": dx, "error_y": dy}


def statistics(errors: Any) -> dict[str, float]:
    """Return mean and largest errors (..., 2) [m] in x, in y and in distance [mm]."""
    rows = 1e3 * np.asarray(errors).reshape(-1, 2)
    columns = np.column_stack([np.abs(rows), np.hypot(*rows.T)])
    return dict(zip(STATISTICS, [*columns.mean(axis=0).tolist(), *columns.max(axis=0).tolist()], strict=True))


@experiment(keys=("changed", "to"), **CRANE, **STEADY)
def fits() -> Rows:
    """Two numbers that meet the targets, with the statistics [mm] that they give, after one change of the crane each.

    The numbers are factors of the untuned ones.
    """
    crane, strokes = patu655(), test_strokes()
    own = Flexibilities.of(strokes, crane)
    yield {"changed": "nothing", "to": "untuned", **statistics(own.errors(1.0, 1.0))}
    yield {"changed": "nothing", "to": "fitted", **own.fit()}
    others = {
        name: Flexibilities.of(strokes, replace(crane, structure=structure))
        for name, structure in other_structures(crane.structure).items()
    }
    others["strokes rounded to the centimetre"] = Flexibilities.of((100 * strokes).round() / 100, crane)
    for name, other in others.items():
        yield {"changed": "sections, masses, pads, strokes", "to": name, **other.fit()}
    for i, point in enumerate(data.TEST_POINTS):
        yield {"changed": "a test point left out", "to": named(point), **own.without(i).fit()}


@experiment(arrays=("swapped", "statistics"), smoke={"candidates": 3}, **CRANE, **STEADY)
def swaps(candidates: int = 25) -> Made:
    """Statistics [mm] with a test point swapped for another one of whole coordinates and a new fit, all that have one.

    Points that are swapped are x, y of the point left out, then of the point that is taken.
    """
    whole = torch.cartesian_prod(torch.arange(1.0, 7.0), torch.arange(-4.0, 8.0)).double()
    reach = kinematics.inverse(whole)
    new = torch.tensor([tuple(point) not in data.TEST_POINTS for point in whole.tolist()])
    some = (reach.within_limits & new).nonzero()[:, 0]
    some = some[torch.linspace(0, len(some) - 1, min(candidates, len(some))).round().long()]
    own = Flexibilities.of(test_strokes(), patu655())
    others = Flexibilities.of(reach.strokes[some], patu655())
    fitted = []
    for i, left in enumerate(data.TEST_POINTS):
        for j, taken in enumerate(whole[some].tolist()):
            pairs = zip(own.without(i), others, strict=True)
            swapped = Flexibilities(*(np.concatenate([a, b[j : j + 1]]) for a, b in pairs))
            fitted.append((*left, *taken, *swapped.fit().values()))
    # After the two points come whether there is a fit, its two numbers, and the statistics.
    rows = np.array([row for row in fitted if row[4]], dtype=np.float32)
    return [{"tried": len(fitted), "found": len(rows)}], {"swapped": rows[:, :4], "statistics": rows[:, 7:]}


class Flexibilities(NamedTuple):
    """Deflections (n, 5, 2) [m] of which two parts are divided by a number each, and one is not."""

    fixed: NDArray[np.float64]
    bending: NDArray[np.float64]
    ground: NDArray[np.float64]

    @classmethod
    def of(cls, strokes: Tensor, crane: Crane) -> Flexibilities:
        """Take them apart by bending and ground, with the untuned numbers."""
        bending, ground = UNTUNED
        whole, stiff, firm = (
            deflection(strokes[:, None], data.TEST_PAYLOADS, _with(crane, *numbers)).numpy()
            for numbers in ((bending, ground), (2 * bending, ground), (bending, 2 * ground))
        )
        by_bending, by_ground = 2 * (whole - stiff), 2 * (whole - firm)
        return cls(whole - by_bending - by_ground, by_bending, by_ground)

    def without(self, point: int) -> Flexibilities:
        """Leave a test point out."""
        return Flexibilities(*(np.delete(own, point, axis=0) for own in self))

    def errors(self, first: Any, second: Any) -> NDArray[np.float64]:
        """Return the errors without compensation [m] for factors of both numbers, which are broadcast."""
        return -(self.fixed + self.bending / first + self.ground / second)

    def fit(self) -> dict[str, Any]:
        """Find the two factors that meet the targets, and the statistics that they give."""

        def missed(logarithms: NDArray[np.float64]) -> NDArray[np.float64]:
            reached = statistics(self.errors(*np.exp(np.clip(logarithms, -20, 20))))
            return np.array([reached[name] / target - 1 for name, target in TARGETS.items()])

        solved = root(missed, [0.1, 0.1], tol=1e-12)
        first, second = np.exp(np.clip(solved.x, -20, 20))
        found = bool(np.abs(missed(solved.x)).max() < 1e-6)
        return {"found": found, "first": first, "second": second, **statistics(self.errors(first, second))}


def other_structures(own: Structure) -> dict[str, Structure]:
    """Return structures with other sections, masses and pads, by what is changed."""
    members = {"pillar": "pillar", "lift": "lift arm", "jib": "jib arm", "extension": "extension"}
    masses = ("lift_cylinder_mass", "jib_cylinder_mass", "linkage_mass")
    without, double = ({name: factor * getattr(own, name) for name in masses} for factor in (0.0, 2.0))
    nodes = tuple((x * 1.8 / 1.95, y) for x, y in own.extension.nodes)

    def scaled(*parts: str, height: float = 1.0, wall: float = 1.0) -> Structure:
        tubes = {part: [(b, h * height, t * wall) for b, h, t in getattr(own, part).tubes] for part in parts}
        return replace(
            own, **{part: replace(getattr(own, part), tubes=tuple(new)) for part, new in tubes.items()}
        )

    return {
        **{
            f"{name} 15 % {change}": scaled(part, height=height)
            for part, name in members.items()
            for height, change in ((0.85, "lower"), (1.15, "higher"))
        },
        "walls a third thinner": scaled(*members, wall=2 / 3),
        "walls a third thicker": scaled(*members, wall=4 / 3),
        "cylinders and linkage without mass": replace(own, **without),
        "cylinders and linkage twice as heavy": replace(own, **double),
        "own weight left out": replace(own, **without, density=0.0),
        "extension 0.15 m shorter in the jib": replace(own, extension=replace(own.extension, nodes=nodes)),
    }


@experiment(keys=("x", "y"), smoke={"extensions": 9}, **CRANE, **STEADY)
def ways(extensions: int = 65) -> Rows:
    """Least and largest deflection [m] at the rating of the ways to reach each test point that is in reach."""
    crane = patu655()
    s3 = torch.linspace(crane.lower[2], crane.upper[2], extensions, dtype=torch.float64)
    for x, y in data.TEST_POINTS:
        reach = kinematics.inverse([x, y], s3)
        if reach.within_limits.any():
            sag = deflection(reach.strokes[reach.within_limits], crane.rating).norm(dim=-1)
            yield {"x": x, "y": y, "least": sag.min(), "largest": sag.max()}


@experiment(
    keys=("x", "y"),
    assumes=("crane-jib-stroke",),
    readings=("crane-jib-stroke=0.75",),
    smoke={"spacing": 0.4},
    **PAPER,
    **STEADY,
)
def coverage(reading: Values, spacing: float = 0.05) -> Rows:
    """Training vectors about the points that the text names, and over all points in reach.

    `within` and `ways` are shares of the points in reach: with a vector's tip within half a metre, and with two or
    more of the grid's extensions. `rank` is the share that has a nearer vector than the named point. They and the
    numbers of vectors are the same for all named points.
    """
    crane = with_jib_stroke(reading)
    training = data.training_set(crane)
    loaded = cKDTree(training.tip.numpy())
    poses = cKDTree((training.tip - training.deflection).numpy()[:: len(GRID_PAYLOADS)])
    ends = zip(crane.lower, crane.upper, (9, 9, 5), strict=True)
    steps = [torch.linspace(*end, dtype=torch.float64) for end in ends]
    tips = flexible_tip(torch.cartesian_prod(*steps)[:, None], GRID_PAYLOADS, crane)
    points = torch.cartesian_prod(*(torch.arange(a, b, spacing, dtype=torch.float64) for a, b in BOX))
    count = kinematics.inverse(points[:, None], steps[2], crane).within_limits.sum(1)
    in_reach = kinematics.inverse(points, crane=crane).within_limits | (count > 0)
    gaps = loaded.query(points[in_reach].numpy())[0]
    whole = {
        "vectors": len(training),
        "by_loaded_tip": (tips[..., 0] >= 0).sum(),
        "grid": tips[..., 0].numel(),
        "within": (gaps <= 0.5).mean(),
        "ways": (count[in_reach] >= 2).double().mean(),
        "nearest_test": loaded.query(data.TEST_POINTS)[0].min(),
    }
    for x, y in NAMED:
        distance, near = loaded.query((x, y))[0], len(poses.query_ball_point((x, y), 1.0))
        here = {"distance": distance, "rank": (gaps < distance).mean(), "neighbours": near}
        yield {"x": x, "y": y, **here, **whole}


@experiment(
    keys=("way",), timed=True, unsteady=("lower", "median", "upper"), smoke={"rounds": 1}, **CRANE, **STEADY
)
def rates(seed: int, rounds: int = 15) -> Rows:
    """Processor time of a solve [s] on one thread, all ways in turn."""
    crane = patu655()
    strokes = torch.rand(4096, 3, generator=seeded(seed), dtype=torch.float64) * torch.tensor(crane.upper)
    few, judged = strokes[:20], partial(corotational_deflection, strokes[:64], crane.rating, crane)
    ways = (
        Way("linear, 4,096 poses at once", partial(load_response, strokes, crane), len(strokes)),
        Way("linear, one by one", lambda: [load_response(row, crane) for row in few], len(few)),
        Way("co-rotational, 64 at once", judged, 64),
    )
    for way in measure(ways, rounds, seconds=0.02, clock=time.process_time):
        yield {"way": way.name, "lower": way.lower, "median": way.median, "upper": way.upper}


def named(point: Sequence[float]) -> str:
    """Return the name of a point of whole coordinates."""
    return f"({point[0]:.0f}, {point[1]:.0f})".replace("-", "−")


def test_strokes() -> Tensor:
    """Return the rigid crane's strokes at the test points."""
    return kinematics.inverse(data.TEST_POINTS).strokes


def _with(crane: Crane, bending_factor: float, ground_stiffness: float) -> Crane:
    structure = replace(crane.structure, bending_factor=bending_factor, ground_stiffness=ground_stiffness)
    return replace(crane, structure=structure)
