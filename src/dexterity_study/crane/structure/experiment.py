"""The structure of the crane: deflections, the fit of two numbers and what it leaves open, and the training data.

Source: Rouvinen (1999), sections 1.2, 2.3, 3.1 to 3.3 and 4. The structure is not given beyond the numbers of its
elements. Two of its numbers are fitted to two printed statistics of the errors without compensation. Linear statics
is linear in the flexibilities, so that any two numbers are fitted in no time: they are fitted again for other
sections, other pairs of numbers and other test points.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
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
from dexterity.crane.shape import PARTS
from dexterity.crane.structure import Assembly, deflection, load_response
from dexterity_study.engine.experiment import experiment

STATISTICS = ("mean x", "mean y", "mean distance", "max x", "max y", "max distance")
"""Statistics of the errors without compensation [mm], in the order of all their arrays."""

TARGETS = {"mean distance": 31.9331, "max distance": 129.6755}
"""Statistics that two numbers are fitted to [mm]."""

NAMED = ((2.0, 2.0), (1.0, 7.0), (2.0, 7.0))
"""Points about which the thesis finds little or no training data [m]."""

BOX = ((0.0, 6.6), (-4.2, 7.8))
"""Ranges of x and y ahead of the foot that hold all that is in reach [m]."""

UNTUNED = (1.0, 3e6)
"""Bending factor and ground stiffness [N·m/rad] from which the fit set out."""

GROUND, ARMS = "ground", PARTS[:4]
GRID_PAYLOADS = tuple(range(50, 501, 50))

STEADY = {"data": ("robots/patu655.toml",), "rtol": 1e-6, "atol": 1e-6}
PAPER = {"paper": "rouvinen1999"}


# ---- beams and loads -------------------------------------------------------------------------------


@experiment(**STEADY)
def beams(seed: int, elements: int = 6) -> Iterator[dict[str, Any]]:
    """Relative misses of the sag of a clamped beam under a force at its end, and under its own weight, by Eq. 1."""
    del seed  # nothing is drawn
    nodes = torch.cartesian_prod(torch.linspace(0, 1, elements + 1).double(), torch.zeros(1).double())
    first, one = torch.arange(elements), torch.ones(elements, dtype=torch.float64)
    row = Beams(torch.stack([first, first + 1], -1), axial=1e3 * one, bending=one, weight=one)
    q = torch.zeros(len(nodes), 3, dtype=torch.float64, requires_grad=True)
    (weight,) = torch.autograd.grad(gravity_potential(row, nodes, q), q)
    force = torch.zeros_like(weight)
    force[-1, 1] = 1.0
    matrix = flexibility(stiffness(row, nodes), [0, 1, 2])
    sags = [(matrix @ load.flatten())[-2].item() for load in (force, weight)]
    yield {"force": 3 * sags[0] - 1, "own_weight": 8 * sags[1] - 1}


@experiment(keys=("part",), **STEADY)
def energies(seed: int) -> Iterator[dict[str, Any]]:
    """Shares of the stored energy, mean over the test."""
    del seed  # nothing is drawn
    crane = patu655()
    loads = torch.stack([_loads(payload, crane) for payload in data.TEST_PAYLOADS])
    works = {
        part: ((loads @ own) * loads).sum(-1) for part, own in _compliances(_test_strokes(), crane).items()
    }
    whole = torch.stack(list(works.values())).sum(0)
    for part, work in works.items():
        yield {"part": part, "share": (work / whole).mean()}


def _loads(payload: float, crane: Crane) -> Tensor:
    """Shares of the three loads of `Assembly.compliance`: own weight, and forces along x and y [N]."""
    return torch.tensor([1.0, 0.0, -payload * crane.structure.gravity], dtype=torch.float64)


def _compliances(strokes: Tensor, crane: Crane) -> dict[str, Tensor]:
    """Compliance (N, 3, 3) of each part and of the ground; their sum is the crane's."""
    soft, firm = Assembly.of(crane), Assembly.of(_with(crane, crane.structure.bending_factor, 1e12))
    pose = soft.placed(strokes)
    rigid = [torch.zeros_like(matrix) for matrix in soft.flexibilities]
    own = {part: (*rigid[:i], firm.flexibilities[i], *rigid[i + 1 :]) for i, part in enumerate(ARMS)}
    own[GROUND] = (soft.flexibilities[0] - firm.flexibilities[0], *rigid[1:])
    return {part: replace(soft, flexibilities=matrices).compliance(pose) for part, matrices in own.items()}


# ---- equilibrium -----------------------------------------------------------------------------------


@experiment(**STEADY)
def at_rest(seed: int) -> Iterator[dict[str, Any]]:
    """Forces left, as a share of all weight, and gaps [m] where test points come to rest; the slowest's Newton steps."""
    del seed  # nothing is drawn
    crane, strokes = patu655(), _test_strokes()
    assembly = Assembly.of(crane)
    pose, weight = assembly.placed(strokes), max(data.TEST_PAYLOADS) * crane.structure.gravity

    def potential(q: Tensor, share: float) -> Tensor:
        raised = assembly.gravity_potential(pose, q) + weight * assembly.tip(q)[:, 1]
        return assembly.strain_energy(pose, q) + share * raised

    rest = equilibrium(potential, lambda q: assembly.constraints(pose, q), assembly.free, len(strokes))
    q = rest.q.clone().requires_grad_()
    held = (rest.forces * assembly.constraints(pose, q)).sum(-1)
    (left,) = torch.autograd.grad((potential(q, 1.0) + held).sum(), q)
    (carried,) = torch.autograd.grad(assembly.gravity_potential(pose, q).sum(), q)
    all_weight = carried[:, :-2].unflatten(-1, (-1, 3))[..., 1].sum(-1) + carried[:, -1] + weight
    yield {
        "residual": (left[:, assembly.free].abs().amax(-1) / all_weight).max(),
        "gap": assembly.constraints(pose, rest.q).abs().max(),
        "steps": rest.iterations,
    }


@experiment(keys=("on",), smoke={"judged": 10}, **STEADY)
def linear_statics(seed: int, judged: int = 3670) -> Iterator[dict[str, Any]]:
    """Difference of linear statics from the co-rotational solution [mm], on the test and on training vectors."""
    rows, random = data.training_set(), torch.Generator().manual_seed(seed)
    some = torch.randperm(len(rows), generator=random)[:judged].sort().values
    for name, strokes, payload in (
        ("test", _test_strokes()[:, None], torch.tensor(data.TEST_PAYLOADS, dtype=torch.float64)),
        ("training", rows.strokes[some], rows.payload[some]),
    ):
        solved = corotational_deflection(strokes, payload)
        apart = 1e3 * (solved.deflection - deflection(strokes, payload)).norm(dim=-1)
        missing = int((~solved.converged).sum())
        yield {"on": name, "mean": apart.mean(), "largest": apart.max(), "missing": missing}


# ---- errors without compensation -------------------------------------------------------------------


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
def uncompensated(seed: int, reading: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    """Errors [m] without compensation: the point that is wanted less the loaded tip."""
    del seed  # nothing is drawn
    bending, ground = reading["crane-fitted-stiffness"]
    crane, strokes = _with(patu655(), bending, ground), _test_strokes()
    if not reading["crane-beyond-the-end"]:
        strokes = strokes.minimum(strokes.new_tensor(crane.upper))
    wanted = torch.tensor(data.TEST_POINTS, dtype=torch.float64)[:, None]
    if reading["crane-linear-statics"] == "linear":
        sag = deflection(strokes[:, None], data.TEST_PAYLOADS, crane)
    else:
        sag = corotational_deflection(strokes[:, None], data.TEST_PAYLOADS, crane).deflection
    errors = wanted - kinematics.tip_position(strokes)[:, None] - sag
    for (x, y), of_point in zip(data.TEST_POINTS, errors.tolist(), strict=True):
        for payload, (dx, dy) in zip(data.TEST_PAYLOADS, of_point, strict=True):
            yield {"x": x, "y": y, "payload": payload, "error_x": dx, "error_y": dy}


def statistics(errors: Any) -> dict[str, float]:
    """Return mean and largest errors (..., 2) [m] in x, in y and in distance [mm]."""
    rows = 1e3 * np.asarray(errors).reshape(-1, 2)
    columns = np.column_stack([np.abs(rows), np.hypot(*rows.T)])
    return dict(zip(STATISTICS, [*columns.mean(axis=0).tolist(), *columns.max(axis=0).tolist()], strict=True))


# ---- the fit ---------------------------------------------------------------------------------------


@experiment(keys=("changed", "to"), **STEADY)
def fits(seed: int) -> Iterator[dict[str, Any]]:
    """Two numbers that meet the targets, with the statistics [mm] that they give, after one change of the crane each.

    The numbers are factors of the untuned ones.
    """
    del seed  # nothing is drawn
    crane, strokes = patu655(), _test_strokes()
    own = Flexibilities.of(strokes, crane)
    yield {"changed": "nothing", "to": "untuned", **statistics(own.errors(1.0, 1.0))}
    yield {"changed": "nothing", "to": "fitted", **own.fit()}
    for name, change in SECTIONS.items():
        other = replace(crane, structure=change(crane.structure))
        yield {
            "changed": "sections, masses, pads, strokes",
            "to": name,
            **Flexibilities.of(strokes, other).fit(),
        }
    rounded = Flexibilities.of((100 * strokes).round() / 100, crane).fit()
    yield {"changed": "sections, masses, pads, strokes", "to": "strokes rounded to the centimetre", **rounded}
    loads = torch.stack([_loads(payload, crane) for payload in data.TEST_PAYLOADS])
    compliances = _compliances(strokes, _with(crane, *UNTUNED))
    sags = {part: (loads[None] @ of_part)[..., 1:].numpy() for part, of_part in compliances.items()}
    for name, (first, second) in PAIRS.items():
        rest = [part for part in sags if part not in first + second]
        groups = (sum((sags[part] for part in group), 0 * sags[GROUND]) for group in (rest, first, second))
        yield {"changed": "pairs of numbers", "to": name, **Flexibilities(*groups).fit()}
    for i, point in enumerate(data.TEST_POINTS):
        yield {"changed": "a test point left out", "to": named(point), **own.without(i).fit()}


@experiment(arrays=("swapped", "statistics"), smoke={"candidates": 3}, **STEADY)
def swaps(seed: int, candidates: int = 25) -> tuple[list[dict[str, Any]], dict[str, Any]]:
    """Statistics [mm] with a test point swapped for another one of whole coordinates and a new fit, all that have one.

    Points that are swapped are x, y of the point left out, then of the point that is taken.
    """
    del seed  # nothing is drawn
    whole = torch.cartesian_prod(torch.arange(1.0, 7.0), torch.arange(-4.0, 8.0)).double()
    reach = kinematics.inverse(whole)
    new = torch.tensor([tuple(point) not in data.TEST_POINTS for point in whole.tolist()])
    some = (reach.within_limits & new).nonzero()[:, 0]
    some = some[torch.linspace(0, len(some) - 1, min(candidates, len(some))).round().long()]
    own = Flexibilities.of(_test_strokes(), patu655())
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


@experiment(arrays=("bending", "ground"), **STEADY)
def fit_lines(seed: int, steps: int = 61) -> tuple[list[dict[str, Any]], dict[str, Any]]:
    """Ground stiffnesses (2, n) [N·m/rad] that meet the mean and the largest distance, along bending factors."""
    del seed  # nothing is drawn
    own = Flexibilities.of(_test_strokes(), patu655())
    bends, grounds = np.linspace(0.85, 1.45, steps), np.full((2, steps), np.nan)
    for row, (name, target) in zip(grounds, TARGETS.items(), strict=True):
        for i, bend in enumerate(bends):

            def miss(
                z: NDArray[np.float64], bend: float = bend, name: str = name, aim: float = target
            ) -> float:
                return statistics(own.errors(bend, math.exp(z[0])))[name] / aim - 1

            solved = root(miss, [0.1])
            if solved.success:
                row[i] = UNTUNED[1] * math.exp(solved.x[0])
    arrays = {"bending": UNTUNED[0] * bends, "ground": grounds}
    return [{"met": np.isfinite(grounds).mean()}], {
        name: own.astype(np.float32) for name, own in arrays.items()
    }


class Flexibilities(NamedTuple):
    """Deflections (n, 5, 2) [m] of which two parts are divided by a number each, and one is not."""

    fixed: NDArray[np.float64]
    first: NDArray[np.float64]
    second: NDArray[np.float64]

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

    def errors(self, first: float, second: float) -> NDArray[np.float64]:
        """Return the errors without compensation [m] for two factors."""
        return -(self.fixed + self.first / first + self.second / second)

    def fit(self) -> dict[str, Any]:
        """Find the two factors that meet the targets, and the statistics that they give."""

        def missed(logarithms: NDArray[np.float64]) -> NDArray[np.float64]:
            reached = statistics(self.errors(*np.exp(np.clip(logarithms, -20, 20))))
            return np.array([reached[name] / target - 1 for name, target in TARGETS.items()])

        solved = root(missed, [0.1, 0.1], tol=1e-12)
        first, second = np.exp(np.clip(solved.x, -20, 20))
        found = bool(np.abs(missed(solved.x)).max() < 1e-6)
        return {"found": found, "first": first, "second": second, **statistics(self.errors(first, second))}


def _scaled(structure: Structure, parts: str, height: float = 1.0, wall: float = 1.0) -> Structure:
    for part in parts.split():
        member = getattr(structure, part)
        tubes = tuple((b, h * height, t * wall) for b, h, t in member.tubes)
        structure = replace(structure, **{part: replace(member, tubes=tubes)})
    return structure


def _with_masses(structure: Structure, factor: float, density: float = 1.0) -> Structure:
    names = ("lift_cylinder_mass", "jib_cylinder_mass", "linkage_mass")
    masses = {name: factor * getattr(structure, name) for name in names}
    return replace(structure, density=density * structure.density, **masses)


def _shorter_overlap(structure: Structure) -> Structure:
    nodes = tuple((x * 1.8 / 1.95, y) for x, y in structure.extension.nodes)
    return replace(structure, extension=replace(structure.extension, nodes=nodes))


_MEMBERS = "pillar lift jib extension"
SECTIONS: Mapping[str, Callable[[Structure], Structure]] = {
    **{
        f"{name} 15 % {'higher' if factor > 1 else 'lower'}": partial(_scaled, parts=part, height=factor)
        for part, name in zip(_MEMBERS.split(), ARMS, strict=True)
        for factor in (0.85, 1.15)
    },
    "walls a third thinner": partial(_scaled, parts=_MEMBERS, wall=2 / 3),
    "walls a third thicker": partial(_scaled, parts=_MEMBERS, wall=4 / 3),
    "cylinders and linkage without mass": partial(_with_masses, factor=0.0),
    "cylinders and linkage twice as heavy": partial(_with_masses, factor=2.0),
    "own weight left out": partial(_with_masses, factor=0.0, density=0.0),
    "extension 0.15 m shorter in the jib": _shorter_overlap,
}
"""Changes of the structure after which the two numbers are fitted again."""

PAIRS: Mapping[str, tuple[tuple[str, ...], tuple[str, ...]]] = {
    "all members; ground": (ARMS, (GROUND,)),
    "lift arm; jib arm with extension": (ARMS[1:2], ARMS[2:]),
    "jib arm with extension; ground": (ARMS[2:], (GROUND,)),
    "pillar with ground; arms": ((ARMS[0], GROUND), ARMS[1:]),
    "lift arm; ground": (ARMS[1:2], (GROUND,)),
    "pillar; arms": (ARMS[:1], ARMS[1:]),
}
"""Parts whose stiffness is multiplied by the first and by the second number."""


# ---- the working area ------------------------------------------------------------------------------


@experiment(arrays=("deflection",), smoke={"spacing": 0.4}, **STEADY)
def sag_map(seed: int, spacing: float = 0.05) -> tuple[list[dict[str, Any]], dict[str, Any]]:
    """Deflection [m] at the rating over the working area with the least extension; x by rows, NaN out of reach."""
    del seed  # nothing is drawn
    x, y = grid(spacing)
    reach = kinematics.inverse(torch.cartesian_prod(x, y))
    sag = torch.full((len(x) * len(y),), torch.nan)
    inside = reach.within_limits
    sag[inside] = deflection(reach.strokes[inside], patu655().rating).norm(dim=-1).float()
    return [{"reached": inside.sum()}], {"deflection": sag.reshape(len(x), len(y)).numpy().round(5)}


@experiment(keys=("x", "y"), smoke={"extensions": 9}, **STEADY)
def ways(seed: int, extensions: int = 65) -> Iterator[dict[str, Any]]:
    """Least and largest deflection [m] at the rating of the ways to reach each test point that is in reach."""
    del seed  # nothing is drawn
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
def coverage(seed: int, reading: Mapping[str, Any], spacing: float = 0.05) -> Iterator[dict[str, Any]]:
    """Training vectors about the points that the text names, and over all points in reach.

    `within` and `ways` are shares of the points in reach: with a vector's tip within half a metre, and with two or
    more of the grid's extensions. `rank` is the share that has a nearer vector than the named point. They and the
    numbers of vectors are the same for all named points.
    """
    del seed  # nothing is drawn
    crane = replace(patu655(), upper=(patu655().upper[0], reading["crane-jib-stroke"], patu655().upper[2]))
    training = data.training_set(crane)
    loaded = cKDTree(training.tip.numpy())
    poses = cKDTree((training.tip - training.deflection).numpy()[:: len(GRID_PAYLOADS)])
    steps = [
        torch.linspace(a, b, n, dtype=torch.float64)
        for a, b, n in zip(crane.lower, crane.upper, (9, 9, 5), strict=True)
    ]
    strokes, payloads = torch.cartesian_prod(*steps), torch.tensor(GRID_PAYLOADS, dtype=torch.float64)
    response = load_response(strokes, crane)
    sag = response.own_weight[:, None] + payloads[:, None] * response.per_kilogram[:, None]
    tips = kinematics.tip_position(strokes, crane)[:, None] + sag
    points = torch.cartesian_prod(*grid(spacing))
    count = kinematics.inverse(points[:, None], steps[2], crane).within_limits.sum(1)
    in_reach = kinematics.inverse(points, crane=crane).within_limits | (count > 0)
    gaps = loaded.query(points[in_reach].numpy())[0]
    whole = {
        "vectors": len(training),
        "by_loaded_tip": (tips[..., 0] >= 0).sum(),
        "grid": len(strokes) * len(payloads),
        "within": (gaps <= 0.5).mean(),
        "ways": (count[in_reach] >= 2).double().mean(),
        "nearest_test": loaded.query(data.TEST_POINTS)[0].min(),
    }
    for x, y in NAMED:
        distance, near = loaded.query((x, y))[0], len(poses.query_ball_point((x, y), 1.0))
        here = {"distance": distance, "rank": (gaps < distance).mean(), "neighbours": near}
        yield {"x": x, "y": y, **here, **whole}


@experiment(keys=("way",), timed=True, unsteady=("lower", "median", "upper"), smoke={"rounds": 1}, **STEADY)
def rates(seed: int, rounds: int = 15) -> Iterator[dict[str, Any]]:
    """Processor time of a solve [s] on one thread, all ways in turn."""
    random, crane = torch.Generator().manual_seed(seed), patu655()
    strokes = torch.rand(4096, 3, generator=random, dtype=torch.float64) * torch.tensor(crane.upper)
    solves: dict[str, tuple[int, Callable[[], object]]] = {
        "linear, 4,096 poses at once": (4096, lambda: load_response(strokes, crane)),
        "linear, one by one": (20, lambda: [load_response(row, crane) for row in strokes[:20]]),
        "co-rotational, 64 at once": (64, lambda: corotational_deflection(strokes[:64], crane.rating, crane)),
    }
    times: dict[str, list[float]] = {name: [] for name in solves}
    for name, (_, solve) in [*solves.items()] * (rounds + 1):
        started = time.process_time()
        solve()
        times[name].append(time.process_time() - started)
    for name, (count, _) in solves.items():
        # The first turn of each is for warming up.
        lower, median, upper = np.quantile(times[name][1:], [0.25, 0.5, 0.75]) / count
        yield {"way": name, "lower": lower, "median": median, "upper": upper}


# ---- points and cranes -----------------------------------------------------------------------------


def grid(spacing: float) -> tuple[Tensor, Tensor]:
    """Return x and y [m] of points ahead of the foot."""
    x, y = (torch.arange(a, b, spacing, dtype=torch.float64) for a, b in BOX)
    return x, y


def named(point: Sequence[float]) -> str:
    """Return the name of a point of whole coordinates."""
    return f"({point[0]:.0f}, {point[1]:.0f})".replace("-", "−")


def _test_strokes() -> Tensor:
    return kinematics.inverse(data.TEST_POINTS).strokes


def _with(crane: Crane, bending_factor: float, ground_stiffness: float) -> Crane:
    structure = replace(crane.structure, bending_factor=bending_factor, ground_stiffness=ground_stiffness)
    return replace(crane, structure=structure)
