"""The rigid crane from its strokes to the tip and back, and how far it amplifies.

Source: Rouvinen (1999), Appendices A and B. Linkages are checked by the lengths of their rods, the chain of
transforms by its product, the working area and the rules for the extension by a search over all extensions.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import torch
from torch import Tensor

from dexterity import crane, spatial
from dexterity.crane.description import Crane, Point
from dexterity.crane.kinematics import turned
from dexterity_study.crane.cases import BOX, CRANE, PAPER, Made, Rows, Values, seeded, with_jib_stroke
from dexterity_study.engine.experiment import experiment

NANOMETRE = 1e-9

STEADY = {"rtol": 1e-6, "atol": 1e-6}
STROKE = {"assumes": ("crane-jib-stroke",), "readings": ("crane-jib-stroke=0.75",), **PAPER, **STEADY}
DRAWN = {"seeds": 10, "reading_seeds": 3, "smoke": {"drawn": 1_000}}


@experiment(**CRANE, **STEADY, **DRAWN)
def formulas(seed: int, drawn: int = 20_000, mounts: Sequence[float] = (0.26, 0.105, 0.3025, 1.04)) -> Rows:
    """Relative misses of the printed formulas, and shifts of the tip [m] by other printed sizes."""
    own, links = crane.patu655(), crane.patu655().linkage
    strokes = random_strokes(own, drawn, seed)
    place, tip = crane.posture(strokes), crane.tip_position(strokes)
    lift_rod = strokes.new_tensor(links.lift_joint) + turned(place.lift, links.lift_cylinder_rod)
    rocker = place.jib - place.lift + math.atan2(links.coupler_pin[1], links.coupler_pin[0])
    coupler_pin = strokes.new_tensor(links.jib_joint) + turned(rocker, (links.rocker, 0.0))
    lift_length = _length(lift_rod, links.lift_cylinder_foot)
    jib_length = _length(place.crank_pin, links.jib_cylinder_foot)
    other_mounts = (
        _with_sizes(lift_cylinder_foot=signed[:2], lift_cylinder_rod=signed[2:])
        for signed in itertools.product(*((size, -size) for size in mounts))
    )
    closing = [one for one in other_mounts if crane.posture(strokes, one).lift_closes.all()]
    longer_rocker = _with_sizes(rocker=math.hypot(*links.coupler_pin))
    yield {
        "lift": _miss(lift_length, strokes[:, 0] + links.lift_cylinder_length),
        "jib": max(
            _miss(jib_length, strokes[:, 1] + links.jib_cylinder_length),
            _miss(_length(place.crank_pin, links.crank_joint), links.crank),
            _miss((place.crank_pin - coupler_pin).norm(dim=-1), links.coupler),
        ),
        "transforms": _apart(tip, _product(strokes)) / _length(tip, links.lift_joint).max().item(),
        "downwards": _apart(tip, _product(strokes, downwards=True)),
        "table": min(_apart(tip, crane.tip_position(strokes, one)) for one in closing),
        "rocker": _apart(tip, crane.tip_position(strokes, longer_rocker)),
    }


@experiment(**STROKE, **DRAWN)
def inverse(seed: int, reading: Values, drawn: int = 20_000) -> Rows:
    """Miss of the closed form [m], postures that it loses, and pairs of lift and jib stroke by extension."""
    machine = with_jib_stroke(reading)
    strokes = random_strokes(machine, drawn, seed)
    tip = crane.tip_position(strokes)
    back = crane.inverse(tip, strokes[:, 2], machine)
    arm = turned(crane.posture(strokes).lift, machine.linkage.jib_joint)
    rest = tip - tip.new_tensor(machine.linkage.lift_joint) - arm
    bend = (arm[:, 0] * rest[:, 1] - arm[:, 1] * rest[:, 0]) / (arm.norm(dim=-1) * rest.norm(dim=-1))
    # With both arms in line the two ways to bend the elbow are the same.
    clear = bend < -1e-3
    lost = clear & ~(back.within_limits & ((back.strokes - strokes).norm(dim=-1) < 1e-6))
    pairs = count_pairs(strokes[: max(200, drawn // 20)], machine)
    yield {
        "round_trip": max(
            _apart(crane.tip_position(one.strokes[one.reached]), tip[one.reached])
            for one in (back, crane.inverse(tip, crane=machine))
        ),
        "lost": (lost.sum() / clear.sum()).item(),
        "elbow_down": (bend >= 0).double().mean(),
        "pairs": (pairs > 1).double().mean(),
        "most": pairs.max(),
    }


@experiment(keys=("of",), **STROKE, **DRAWN)
def gains(seed: int, reading: Values, drawn: int = 20_000) -> Rows:
    """Displacement of the tip by a unit of each stroke, and of the best and the worst combination."""
    strokes = random_strokes(with_jib_stroke(reading), drawn, seed), crane.inverse(crane.TEST_POINTS).strokes
    jacobians = map(crane.tip_jacobian, strokes)
    drawn_gains, at_tests = (torch.cat([J.norm(dim=-2), torch.linalg.svdvals(J)], -1).mT for J in jacobians)
    names = ("lift", "jib", "extension", "largest singular value", "smallest singular value")
    for name, gain, of_tests in zip(names, drawn_gains, at_tests, strict=True):
        numbers = {"least": gain.min(), "median": gain.median(), "largest": gain.max()}
        yield {"of": name, **numbers, "at_tests": of_tests.max()}


@experiment(arrays=("extension", "amplification"), smoke={"spacing": 0.3, "extensions": 33}, **STROKE)
def working_area(reading: Values, spacing: float = 0.06, extensions: int = 321) -> Made:
    """Search of a grid through all extensions, the least extension, and whether three circles tell it.

    Its arrays hold the least extension [m] and the larger gain of lift and jib stroke with it, x by rows.
    """
    machine = with_jib_stroke(reading)
    points, shape = grid(spacing)
    first, last = torch.full((2, len(points)), torch.nan, dtype=torch.float64)
    for s3 in torch.linspace(0, machine.upper[2], extensions, dtype=torch.float64).tolist():
        there = crane.inverse(points, s3, machine).within_limits
        first, last = torch.where(there & first.isnan(), s3, first), torch.where(there, s3, last)
    rule = crane.inverse(points, crane=machine)
    inside = rule.within_limits | first.isfinite()
    spans = (last - first)[inside].nan_to_num(0.0)
    (joint, inner), (elbow, low), (_, outer) = circles(machine).values()
    distance, lowest = _length(points, joint), direction(elbow - joint)
    below = spatial.wrap_to_pi(direction(points - joint) - lowest) < 0
    needs = (distance < inner) | (distance > outer) | (below & (_length(points, elbow) > low))
    zero = crane.inverse(points, 0.0, machine).within_limits
    s2, folded = folding(machine)
    deciles = spans.quantile(spans.new_tensor([0.1, 0.5, 0.9]))
    row = {
        "jib_stroke": machine.upper[1],
        "vectors": len(crane.training_set(machine)),
        "area": spacing**2 * int(inside.sum()),
        "inner_at_end": folded[-1],
        "inner_least": folded.min(),
        "inner_least_at": s2[folded.argmin()],
        "several": (spans > 0).double().mean(),
        **dict(zip(("span_first_decile", "span_median", "span_last_decile"), deciles, strict=True)),
        "excess": (rule.strokes[:, 2] - first)[rule.within_limits].nan_to_num(0.0).clamp(min=0.0).max(),
        "overlooked": ((inside & ~rule.within_limits).sum() / inside.sum()).item(),
        "disagreement": (needs == zero)[inside].double().mean(),
    }
    strokes = torch.where(rule.within_limits[:, None], rule.strokes, 0.0)
    gain = crane.tip_jacobian(strokes).norm(dim=-2)[:, :2].amax(-1)
    arrays = {
        name: torch.where(rule.within_limits, values, torch.nan).reshape(shape).float().numpy().round(3)
        for name, values in (("extension", strokes[:, 2]), ("amplification", gain))
    }
    return [row], arrays


@experiment(keys=("circle",), smoke={"spacing": 0.3}, **CRANE, **STEADY)
def rules(spacing: float = 0.06) -> Rows:
    """Radii [m] with which the printed rules are exact, over the points that each circle decides."""
    points, _ = grid(spacing)
    points = points[crane.inverse(points).within_limits]
    least = crane.least_extension(points)
    length, offset = crane.patu655().linkage.extension_joint
    first = math.hypot(*crane.patu655().linkage.jib_joint)
    for name, (centre, radius) in circles(crane.patu655()).items():
        distance = _length(points, centre)
        side = {"folded": first - distance, "lift arm down": distance, "stretched": distance - first}[name]
        exact = (side.clamp(min=0).square() - offset**2).clamp(min=0).sqrt() - length
        decided = (least > 0) & ((least - exact).abs() < NANOMETRE)
        radii = (distance + least if name == "folded" else distance - least)[decided]
        by_squares = (distance.square() - radius**2).clamp(min=0).sqrt() - least
        yield {
            "circle": name,
            "points": len(radii),
            "radius": radius,
            "smallest": radii.min(),
            "largest": radii.max(),
            "by_squares": by_squares[decided].abs().max(),
        }


def random_strokes(machine: Crane, drawn: int, seed: int) -> Tensor:
    """Draw strokes (n, 3) within their limits, all corners of these among them."""
    corners = torch.cartesian_prod(*[torch.tensor([0.0, 1.0], dtype=torch.float64)] * 3)
    unit = torch.cat([corners, torch.rand(drawn, 3, generator=seeded(seed), dtype=torch.float64)])
    return unit * unit.new_tensor(machine.upper)


def grid(spacing: float) -> tuple[Tensor, tuple[int, int]]:
    """Return positions (k, 2) ahead of the pillar, and their numbers along x and y."""
    sides = [torch.linspace(a, b, round((b - a) / spacing) + 1, dtype=torch.float64) for a, b in BOX]
    return torch.cartesian_prod(*sides), (len(sides[0]), len(sides[1]))


def direction(points: Tensor) -> Tensor:
    """Return the angles (...) of points (..., 2) from the x axis [rad]."""
    return torch.atan2(points[..., 1], points[..., 0])


def folding(machine: Crane, steps: int = 7_801) -> tuple[Tensor, Tensor]:
    """Return jib strokes, and the tip's distance from the lift joint with them and no extension [m]."""
    s2 = torch.linspace(0, machine.upper[1], steps, dtype=torch.float64)
    tip = crane.tip_position(torch.stack([0 * s2, s2, 0 * s2], dim=-1))
    return s2, _length(tip, machine.linkage.lift_joint)


def circles(machine: Crane) -> dict[str, tuple[Tensor, float]]:
    """Return centre and radius [m] of three circles: arms folded, the jib with the lift arm down, arms stretched."""
    links, lowest = machine.linkage, crane.posture(machine.lower).lift
    joint = lowest.new_tensor(links.lift_joint)
    first, second = math.hypot(*links.jib_joint), math.hypot(*links.extension_joint)
    folded = folding(machine)[1].min().item()
    elbow = joint + turned(lowest, links.jib_joint)
    return {"folded": (joint, folded), "lift arm down": (elbow, second), "stretched": (joint, first + second)}


def count_pairs(strokes: Tensor, machine: Crane, steps: int = 2_000) -> Tensor:
    """Count (n,) the pairs of lift and jib stroke that bring the tip to the same place with the same extension.

    The distance of the tip from the lift joint depends on jib and extension alone: each jib stroke where it is
    right is a pair, if the lift arm can turn as far as it then has to.
    """
    joint = strokes.new_tensor(machine.linkage.lift_joint)
    lowest, highest = (crane.posture(end).lift.item() for end in (machine.lower, machine.upper))
    # A little beyond both ends, so that a stroke at an end lies between two of these.
    jib = torch.linspace(-1e-6, machine.upper[1] + 1e-6, steps, dtype=torch.float64)
    s2, s3 = torch.broadcast_tensors(jib, strokes[:, 2:])
    target = (crane.tip_position(strokes) - joint)[:, None]
    tried = crane.tip_position(torch.stack([torch.zeros_like(s2), s2, s3], dim=-1)) - joint
    turn = spatial.wrap_to_pi(direction(target) - direction(tried))
    allowed = (turn >= -1e-3) & (turn <= highest - lowest + 1e-3)
    short = tried.norm(dim=-1) < target.norm(dim=-1)
    return ((short[:, 1:] != short[:, :-1]) & allowed[:, 1:]).sum(-1)


def _with_sizes(**sizes: Any) -> Crane:
    return replace(crane.patu655(), linkage=replace(crane.patu655().linkage, **sizes))


def _apart(a: Tensor, b: Tensor) -> float:
    return (a - b).norm(dim=-1).max().item()


def _length(points: Tensor, end: Point | Tensor) -> Tensor:
    return (points - torch.as_tensor(end, dtype=torch.float64)).norm(dim=-1)


def _miss(lengths: Tensor, exact: Tensor | float) -> float:
    return (lengths / exact - 1).abs().max().item()


def _product(strokes: Tensor, downwards: bool = False) -> Tensor:
    """Tip (n, 2) by the seven transforms of Appendix A, the last offset taken for up or down."""
    links, place = crane.patu655().linkage, crane.posture(strokes)
    along, across = (j - i for j, i in zip(links.extension_joint, links.coupler_pin, strict=True))
    quarter = spatial.exp([0.0, 0.0, 0.0, math.pi / 2, 0.0, 0.0])
    T = torch.eye(4, dtype=torch.float64)
    for joint, angle in ((links.lift_joint, place.lift), (links.jib_joint, place.jib - place.lift)):
        turn = spatial.exp(angle[:, None] * angle.new_tensor([0.0, 0.0, 0.0, 0.0, 0.0, 1.0]))
        T = T @ _shift(*joint, 0.0) @ quarter @ quarter.mT @ turn
    # After the third quarter turn, the third axis lies in the plane and points down.
    offset = _shift(along, 0.0, across if downwards else -across)
    T = T @ _shift(*links.coupler_pin, 0.0) @ quarter @ offset @ quarter.mT
    return T[:, :2, 3] + strokes[:, 2:] * T[:, :2, 0]


def _shift(x: float, y: float, z: float) -> Tensor:
    return spatial.exp([x, y, z, 0.0, 0.0, 0.0])
