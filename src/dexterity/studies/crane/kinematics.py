"""Paper D, Appendices A and B: the rigid crane from its strokes to the tip and back, and what it amplifies.

Rouvinen (1999). The linkages are checked by the distances that their rods have, the chain of transforms by
its product, the working area and the rules for the extension by a search over all strokes of the extension.

What decides a verdict was set beforehand. A formula holds if it is right to a nanometre. The crane amplifies
as claimed if a millimetre of some stroke moves the tip by two centimetres or more somewhere in the working
area, and *in shape* by one. A rule for the extension is *reproduced* if it gives the least one to a
millimetre, and *in shape* to two centimetres.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from dexterity import crane, spatial
from dexterity.crane.description import Crane, Point
from dexterity.crane.kinematics import Posture, turned
from dexterity.report.claims import Acceptance, Outcome, Verdict, load_paper
from dexterity.report.stored import Tolerance
from dexterity.scenes import Body, Slider

__all__ = [
    "BOX",
    "CONFIGS",
    "CYLINDERS",
    "TOLERANCE",
    "Circle",
    "Config",
    "Gain",
    "Result",
    "Rule",
    "acceptance",
    "circles",
    "fold_curves",
    "gain_table",
    "mechanism",
    "misprint_table",
    "run",
    "stroke_end_table",
    "training_tips",
    "verdicts",
]

CYLINDERS = ("lift", "jib", "extension")
"""Cylinders in the order of their strokes."""

BOX = ((0.0, 6.6), (-4.2, 7.8))
"""Ranges of x and y that hold the working area ahead of the pillar [m]."""

TOLERANCE = Tolerance(rtol=1e-6, atol=1e-6)
"""What a probe may miss by, since rounding errors come out a little different on every processor."""

_PAPER = "rouvinen1999"
_NANOMETRE = 1e-9
_SEVERAL, _ONE = 20.0, 10.0  # [mm of the tip a mm of stroke]


@dataclass(frozen=True)
class Config:
    """How finely the crane is looked at.

    Attributes
    ----------
    drawn
        Strokes that are drawn at random.
    spacing
        Of the grid of positions [m].
    extensions
        Strokes of the extension that are tried at each position.
    seed
        Of the draw.
    """

    drawn: int = 20_000
    spacing: float = 0.06
    extensions: int = 81
    seed: int = 0


CONFIGS: Mapping[str, Config] = {
    "smoke": Config(drawn=1_000, spacing=0.3, extensions=33),
    "book": Config(),
    "full": Config(drawn=200_000, extensions=321),
}
"""What runs at each scale."""


@dataclass(frozen=True)
class Gain:
    """How far the tip moves for each millimetre of a stroke [mm], over random strokes and the test points.

    Attributes
    ----------
    least, median, largest
        Over random strokes.
    at_tests
        The largest of the 25 test points, reached with the least extension.
    """

    least: float
    median: float
    largest: float
    at_tests: float


@dataclass(frozen=True)
class Rule:
    """What a printed rule makes of the extension, over the points that its circle decides.

    Attributes
    ----------
    points
        How many.
    shortest, longest
        Its stroke less the least possible one [m]; negative where the point is not reached.
    printed
        Largest error of the stroke that the printed equation of the circle gives [m].
    """

    points: int
    shortest: float
    longest: float
    printed: float


@dataclass(frozen=True)
class Result:
    """The rigid crane, looked at from all sides.

    Attributes
    ----------
    closure
        Largest miss of a rod's length in the lift and in the jib linkage [m].
    transforms
        Largest distance of the tip from the product of the seven transforms [m].
    downwards
        How far the tip is off if the last offset is taken for one downwards [m].
    table
        Smallest over all choices of signs, of the largest distance of the tip from the listing's if the
        mounts of the lift cylinder are those of the table [m].
    rocker
        How far the tip moves if the rocker is as long as its two sizes say [m].
    round_trip
        Largest miss of strokes from the inverse [m].
    lost
        Share of the postures with the elbow up that the inverse does not give back.
    elbow_down
        Share of random strokes whose elbow is down.
    pairs
        Share of random strokes whose tip is reached by a second pair of lift and jib stroke, the extension
        being the same.
    most
        Largest number of such pairs.
    several
        Share of the working area that is reached with several extensions.
    spans
        First decile, median and last decile of the range of extensions that reach a point [m].
    excess
        Largest difference of the least extension from the first one that a search finds [m]; it would be
        positive if the rule were beaten.
    overlooked
        Share of the working area that the least extension does not reach.
    disagreement
        Share of the working area where the three circles and the linkages disagree on whether an extension
        is needed.
    inner
        Distance of the tip from the lift joint with the extension in: with the jib stroke of the listing's
        end, of the training data's, and smallest of all [m].
    inner_stroke
        Jib stroke of the smallest one [m].
    gains, singular
        By cylinder, and of the singular values of the Jacobian.
    rules
        By the circle that decides.
    idle_limit
        Whether the printed limit on x leaves out no point inside the first circle.
    rows
        Training vectors with a positive x, by the end of the jib cylinder.
    areas
        Working area ahead of the pillar [m²], by the end of the jib cylinder.
    extension, amplification
        (nx, ny) least extension [m] and the larger gain of lift and jib stroke with it, x by rows; NaN out
        of reach.
    """

    closure: Mapping[str, float]
    transforms: float
    downwards: float
    table: float
    rocker: float
    round_trip: float
    lost: float
    elbow_down: float
    pairs: float
    most: int
    several: float
    spans: tuple[float, float, float]
    excess: float
    overlooked: float
    disagreement: float
    inner: tuple[float, float, float]
    inner_stroke: float
    gains: Mapping[str, Gain]
    singular: Mapping[str, Gain]
    rules: Mapping[str, Rule]
    idle_limit: bool
    rows: Mapping[str, int]
    areas: Mapping[str, float]
    extension: NDArray[np.float64]
    amplification: NDArray[np.float64]


def run(config: Config) -> Result:
    """Look at random strokes, and at a grid of positions."""
    strokes = _drawn(config)
    points, shape = _grid(config)
    area = _shortest(points, config)
    inside = area.isfinite()
    least = torch.where(inside, crane.least_extension(points), torch.nan)
    own = crane.inverse(points).within_limits
    zero = crane.inverse(points, 0.0).within_limits
    round_trip, lost, elbow_down = _there_and_back(strokes)
    pairs = _pairs(strokes[: max(200, config.drawn // 10)])
    spans = _spans(points[inside], config)
    gains = _gains(strokes)
    ends = _ends()
    return Result(
        closure=_closure(strokes),
        transforms=_apart(crane.tip_position(strokes), _product(strokes)),
        downwards=_apart(crane.tip_position(strokes), _product(strokes, flip=True)),
        table=_by_table(strokes),
        rocker=_with_longer_rocker(strokes),
        round_trip=round_trip,
        lost=lost,
        elbow_down=elbow_down,
        pairs=(pairs > 1).double().mean().item(),
        most=int(pairs.max()),
        several=(spans > 0).double().mean().item(),
        spans=tuple(spans.quantile(spans.new_tensor([0.1, 0.5, 0.9])).tolist()),
        excess=(least - area)[inside & own].max().item(),
        overlooked=(inside & ~own).sum().item() / inside.sum().item(),
        disagreement=((least <= 0) != zero)[inside].double().mean().item(),
        inner=(_inner(ends["listing"]), _inner(ends["training data"]), _smallest_inner()[0]),
        inner_stroke=_smallest_inner()[1],
        gains=dict(zip(CYLINDERS, gains[:3], strict=True)),
        singular=dict(zip(("largest", "smallest"), gains[3:], strict=True)),
        rules=_rules(points[inside]),
        idle_limit=_limit_is_idle(points),
        rows={name: _rows(_ending_at(end)) for name, end in ends.items()},
        areas={
            name: config.spacing**2 * int(_shortest(points, config, _ending_at(end)).isfinite().sum())
            for name, end in ends.items()
        },
        extension=torch.where(own, least, torch.nan).reshape(shape).numpy().round(4),
        amplification=_amplification(points, own).reshape(shape).numpy().round(3),
    )


def _drawn(config: Config) -> Tensor:
    """Random strokes (n, 3) within their limits, all corners of these among them."""
    random = torch.Generator().manual_seed(config.seed)
    upper = torch.tensor(crane.patu655().upper, dtype=torch.float64)
    unit = torch.rand(config.drawn, 3, generator=random, dtype=torch.float64)
    corners = torch.cartesian_prod(*[torch.tensor([0.0, 1.0], dtype=torch.float64)] * 3)
    return torch.cat([corners, unit]) * upper


def _grid(config: Config) -> tuple[Tensor, tuple[int, int]]:
    """Positions (k, 2) ahead of the pillar."""
    sides = [
        torch.linspace(low, high, round((high - low) / config.spacing) + 1, dtype=torch.float64)
        for low, high in BOX
    ]
    return torch.cartesian_prod(*sides), (len(sides[0]), len(sides[1]))


def _apart(a: Tensor, b: Tensor) -> float:
    return (a - b).norm(dim=-1).max().item()


# ---- linkages --------------------------------------------------------------------------------------


def _closure(strokes: Tensor) -> dict[str, float]:
    """Largest miss of the rods' lengths, by where their ends are."""
    links, place = crane.patu655().linkage, crane.posture(strokes)
    rod = strokes.new_tensor(links.lift_joint) + turned(place.lift, links.lift_cylinder_rod)
    lift = _length(rod, links.lift_cylinder_foot) - strokes[:, 0] - links.lift_cylinder_length
    rocker = math.atan2(links.coupler_pin[1], links.coupler_pin[0])
    coupler_pin = strokes.new_tensor(links.jib_joint) + turned(
        place.jib - place.lift + rocker, (links.rocker, 0.0)
    )
    jib = (
        _length(place.crank_pin, links.jib_cylinder_foot) - strokes[:, 1] - links.jib_cylinder_length,
        _length(place.crank_pin, links.crank_joint) - links.crank,
        (place.crank_pin - coupler_pin).norm(dim=-1) - links.coupler,
    )
    return {"lift": lift.abs().max().item(), "jib": max(miss.abs().max().item() for miss in jib)}


def _length(points: Tensor, end: Point) -> Tensor:
    return (points - points.new_tensor(end)).norm(dim=-1)


def _product(strokes: Tensor, flip: bool = False) -> Tensor:
    """Tip (n, 2) by the seven transforms of Appendix A; `flip` turns the last offset upside down."""
    links, place = crane.patu655().linkage, crane.posture(strokes)
    along, across = (j - i for j, i in zip(links.extension_joint, links.coupler_pin, strict=True))
    offset = _pose(0.0, along, -across if not flip else across, plane=False)
    T = _quarter(links.lift_joint) @ _joint(place.lift)
    T = T @ _quarter(links.jib_joint) @ _joint(place.jib - place.lift)
    T = T @ _quarter(links.coupler_pin) @ offset @ _joint(torch.zeros(()).double())
    extended = torch.stack([strokes[:, 2], torch.zeros_like(strokes[:, 2])], dim=-1)
    return T[..., :2, 3] + (T[..., :2, :2] @ extended[..., None])[..., 0]


def _quarter(offset: Point) -> Tensor:
    """Offset in the plane, then a quarter of a turn about x: the third axis now lies in the plane."""
    return _pose(math.pi / 2, *offset)


def _joint(angle: Tensor) -> Tensor:
    """Quarter of a turn back, then the joint's about the third axis."""
    back = _pose(-math.pi / 2, 0.0, 0.0)
    turn = torch.zeros(*angle.shape, 6, dtype=torch.float64)
    turn[..., 5] = angle
    return back @ spatial.exp(turn)


def _pose(about_x: float, along: float, across: float, plane: bool = True) -> Tensor:
    T = spatial.exp([0.0, 0.0, 0.0, about_x, 0.0, 0.0])
    T[0, 3], T[1 if plane else 2, 3] = along, across
    return T


def _by_table(strokes: Tensor) -> float:
    """Read the mounts of the lift cylinder from the table, whose sizes have no signs."""
    sizes = _values("crane-cylinder-mounts")
    tip, best = crane.tip_position(strokes), math.inf
    for signs in itertools.product((1, -1), repeat=4):
        foot_x, foot_y, rod_x, rod_y = (sign * size for sign, size in zip(signs, sizes, strict=True))
        other = _with(lift_cylinder_foot=(foot_x, foot_y), lift_cylinder_rod=(rod_x, rod_y))
        if crane.posture(strokes, other).lift_closes.all():
            best = min(best, _apart(crane.tip_position(strokes, other), tip))
    return best


def _with_longer_rocker(strokes: Tensor) -> float:
    other = _with(rocker=math.hypot(*crane.patu655().linkage.coupler_pin))
    return _apart(crane.tip_position(strokes, other), crane.tip_position(strokes))


def _with(**sizes: object) -> Crane:
    own = crane.patu655()
    return replace(own, linkage=replace(own.linkage, **sizes))  # type: ignore[arg-type]


# ---- there and back --------------------------------------------------------------------------------


def _there_and_back(strokes: Tensor) -> tuple[float, float, float]:
    """Miss of the inverse, share of the elbow-up postures that it loses, and share with the elbow down."""
    tip = crane.tip_position(strokes)
    misses = []
    for extension in (strokes[:, 2], None):
        back = crane.inverse(tip, extension)
        misses.append(_apart(crane.tip_position(back.strokes[back.reached]), tip[back.reached]))
    bend = _bend(strokes)
    up, clear = (bend < 0) & (bend > -math.pi), (torch.sin(bend)).abs() > 1e-3
    back = crane.inverse(tip, strokes[:, 2])
    found = back.within_limits & ((back.strokes - strokes).norm(dim=-1) < 1e-6)
    lost = (up & clear & ~found).sum().item() / (up & clear).sum().item()
    return max(misses), lost, (~up).double().mean().item()


def _bend(strokes: Tensor) -> Tensor:
    """Angle (n,) at the jib joint from the lift arm's line to the tip's; 0 where both are stretched."""
    links, place = crane.patu655().linkage, crane.posture(strokes)
    length, offset = links.extension_joint
    to_tip = torch.atan2(torch.full_like(strokes[:, 2], offset), length + strokes[:, 2])
    return place.jib - place.lift + to_tip - math.atan2(links.jib_joint[1], links.jib_joint[0])


def _pairs(strokes: Tensor, steps: int = 2_000) -> Tensor:
    """Count (n,) the pairs of lift and jib stroke that bring the tip to the same place with the same s3.

    The distance of the tip from the lift joint is a matter of jib and extension alone: each jib stroke where
    it is right is a pair, if the lift arm can turn as far as it then has to.
    """
    own, links = crane.patu655(), crane.patu655().linkage
    joint = strokes.new_tensor(links.lift_joint)
    away = crane.tip_position(strokes) - joint
    level = _lift_stroke_of_zero()
    jib = torch.linspace(0, own.upper[1], steps, dtype=torch.float64)
    counts = []
    lowest, highest = (crane.posture(end).lift.item() for end in (own.lower, own.upper))
    for part, target in zip(strokes.split(200), away.split(200), strict=True):
        s2, s3 = torch.broadcast_tensors(jib, part[:, 2:])
        tried = crane.tip_position(torch.stack([torch.full_like(s2, level), s2, s3], -1)) - joint
        turn = _direction(target)[:, None] - _direction(tried)
        allowed = (spatial.wrap_to_pi(turn) >= lowest - 1e-3) & (spatial.wrap_to_pi(turn) <= highest + 1e-3)
        short = tried.norm(dim=-1) < target.norm(dim=-1, keepdim=True)
        counts.append(((short[:, 1:] != short[:, :-1]) & allowed[:, 1:]).sum(-1))
    return torch.cat(counts)


def _lift_stroke_of_zero() -> float:
    """Lift stroke at which the lift frame is not turned."""
    links = crane.patu655().linkage
    x, y = links.lift_joint
    rod = (x + links.lift_cylinder_rod[0], y + links.lift_cylinder_rod[1])
    return math.dist(rod, links.lift_cylinder_foot) - links.lift_cylinder_length


def _direction(points: Tensor) -> Tensor:
    return torch.atan2(points[..., 1], points[..., 0])


# ---- the working area ------------------------------------------------------------------------------


def _shortest(points: Tensor, config: Config, machine: Crane | None = None) -> Tensor:
    """Shortest of the tried extensions (k,) that reach points, or the rule's; NaN where none does."""
    machine = machine or crane.patu655()
    by_rule = crane.inverse(points, crane=machine)
    shortest = torch.where(by_rule.within_limits, by_rule.strokes[:, 2], torch.inf)
    for s3 in _tried(config):
        there = crane.inverse(points, s3, machine).within_limits
        shortest = torch.where(there, shortest.clamp(max=s3), shortest)
    return torch.where(shortest.isfinite(), shortest, torch.nan)


def _tried(config: Config) -> list[float]:
    return torch.linspace(0, crane.patu655().upper[2], config.extensions, dtype=torch.float64).tolist()


def _spans(points: Tensor, config: Config) -> Tensor:
    """How far apart [m] the extensions are with which each point is reached."""
    first, last = torch.full((2, len(points)), torch.nan, dtype=torch.float64)
    for s3 in _tried(config):
        there = crane.inverse(points, s3).within_limits
        first = torch.where(there & first.isnan(), s3, first)
        last = torch.where(there, s3, last)
    return (last - first).nan_to_num(0.0)


@dataclass(frozen=True)
class Circle:
    """One of the three circles.

    Attributes
    ----------
    centre
        Joint that it is about (x, y) [m].
    radius
        With the extension in [m].
    """

    centre: Point
    radius: float


def circles() -> dict[str, Circle]:
    """Return the three circles: arms folded, arms stretched, and the jib turning with the lift arm down."""
    own, links = crane.patu655(), crane.patu655().linkage
    first, second = math.hypot(*links.jib_joint), math.hypot(*links.extension_joint)
    lowest = crane.posture(own.lower).lift
    elbow = lowest.new_tensor(links.lift_joint) + turned(lowest, links.jib_joint)
    return {
        "folded": Circle(links.lift_joint, first - second),
        "lift arm down": Circle((elbow[0].item(), elbow[1].item()), second),
        "stretched": Circle(links.lift_joint, first + second),
    }


def _rules(points: Tensor) -> dict[str, Rule]:
    """Set the printed rules beside the least extension, each where its circle decides."""
    length, offset = crane.patu655().linkage.extension_joint
    least, around = crane.least_extension(points), circles()
    distance = {name: _length(points, circle.centre) for name, circle in around.items()}
    first = math.hypot(*crane.patu655().linkage.jib_joint)
    reach = {
        "folded": first - distance["folded"],
        "lift arm down": distance["lift arm down"],
        "stretched": distance["stretched"] - first,
    }
    printed = _value("crane-inner-radius")
    rules = {}
    for name, circle in around.items():
        exact = (reach[name].clamp(min=0).square() - offset**2).clamp(min=0).sqrt() - length
        decides = (least > 0) & ((least - exact).abs() < _NANOMETRE)
        radius = printed if name == "folded" else circle.radius
        by_rule = (distance[name] - radius) * (-1 if name == "folded" else 1)
        by_circle = (distance[name].square() - radius**2).clamp(min=0).sqrt()
        off = (by_rule - least)[decides]
        rules[name] = Rule(
            points=int(decides.sum()),
            shortest=off.min().item(),
            longest=off.max().item(),
            printed=(by_circle - least)[decides].abs().max().item(),
        )
    return rules


def _limit_is_idle(points: Tensor) -> bool:
    """Whether all points inside the first circle, as printed, have the printed limit on x anyway."""
    centre, radius = crane.patu655().linkage.lift_joint, _value("crane-inner-radius")
    return bool((points[_length(points, centre) < radius][:, 0] < radius + centre[0]).all())


def _ends() -> dict[str, float]:
    """Return ends of the jib cylinder, in the listing and in the training data [m]."""
    return {
        "listing": _values("crane-stroke-ends")[1],
        "training data": _values("crane-grid-stroke-ends")[1],
    }


def _inner(jib: float) -> float:
    """Distance of the tip from the lift joint with the extension in, for a jib stroke."""
    tip = crane.tip_position([0.0, jib, 0.0])
    return _length(tip, crane.patu655().linkage.lift_joint).item()


def _smallest_inner() -> tuple[float, float]:
    """Smallest distance of the tip from the lift joint with the extension in, and its jib stroke."""
    s2, distance, _ = fold_curves(7_801)
    return float(distance.min()), float(s2[distance.argmin()])


def fold_curves(steps: int = 400) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return jib strokes [m], the tip's distance from the lift joint with them [m], and θ₂ [degrees]."""
    s2 = torch.linspace(0, crane.patu655().upper[1], steps, dtype=torch.float64)
    strokes = torch.stack([0 * s2, s2, 0 * s2], dim=-1)
    distance = _length(crane.tip_position(strokes), crane.patu655().linkage.lift_joint)
    place = crane.posture(strokes)
    return s2.numpy(), distance.numpy(), torch.rad2deg(place.jib - place.lift).numpy()


def _ending_at(jib: float) -> Crane:
    own = crane.patu655()
    return replace(own, upper=(own.upper[0], jib, own.upper[2]))


def training_tips(machine: Crane | None = None) -> Tensor:
    """Rigid tips (k, 2) of the poses of the training data [m], those left out whose x is negative."""
    machine = machine or crane.patu655()
    counts = [round(number) for number in _values("crane-grid-values")[:3]]
    steps = [
        torch.linspace(low, high, n, dtype=torch.float64)
        for low, high, n in zip(machine.lower, machine.upper, counts, strict=True)
    ]
    tip = crane.tip_position(torch.cartesian_prod(*steps), machine)
    return tip[tip[:, 0] >= 0]


def _rows(machine: Crane) -> int:
    return len(training_tips(machine)) * round(_values("crane-grid-values")[3])


# ---- amplification ---------------------------------------------------------------------------------


def _gains(strokes: Tensor) -> list[Gain]:
    """Of the three columns of the Jacobian, and of its two singular values."""
    tests = crane.inverse(crane.TEST_POINTS).strokes
    return [
        Gain(at.min().item(), at.median().item(), at.max().item(), at_tests.max().item())
        for at, at_tests in zip(_columns(strokes).mT, _columns(tests).mT, strict=True)
    ]


def _columns(strokes: Tensor) -> Tensor:
    J = crane.tip_jacobian(strokes)
    return torch.cat([J.norm(dim=-2), torch.linalg.svdvals(J)], dim=-1)


def _amplification(points: Tensor, own: Tensor) -> Tensor:
    gains = torch.full((len(points),), torch.nan, dtype=torch.float64)
    strokes = crane.inverse(points[own]).strokes
    gains[own] = crane.tip_jacobian(strokes).norm(dim=-2)[:, :2].amax(-1)
    return gains


# ---- the crane as a mechanism ----------------------------------------------------------------------


def mechanism(
    strokes: tuple[float, float, float] = (0.25, 0.3, 0.5), steps: int = 61
) -> tuple[list[Body], list[Slider]]:
    """Return bodies and sliders of the crane for :meth:`dexterity.scenes.scene.Scene.add_mechanism`.

    Parameters
    ----------
    strokes
        Where the sliders stand [m].
    steps
        Values of a stroke at which poses are computed.
    """
    values = [torch.linspace(0, upper, steps, dtype=torch.float64) for upper in crane.patu655().upper]
    sliders = [
        Slider(label, own.numpy(), start) for label, own, start in zip(_LABELS, values, strokes, strict=True)
    ]
    # Neither angle, that of the jib being taken from the lift arm, depends on another's stroke.
    place = crane.posture(torch.stack(values, dim=-1))
    return [*_arms(place, values[2]), *_linkage(place), *_cylinders(place)], sliders


_LABELS = ("s₁ lift [m]", "s₂ jib [m]", "s₃ extension [m]")


def _arms(place: Posture, s3: Tensor) -> list[Body]:
    links = crane.patu655().linkage
    along, across = links.extension_joint
    jib = _planar(place.jib - place.lift, links.jib_joint)
    mounts = (links.lift_cylinder_rod, links.jib_cylinder_foot, links.crank_joint)
    brackets = [end for pin in mounts for end in (_on_line(links.jib_joint, pin), pin)]
    slid = torch.stack([along + s3, torch.full_like(s3, across)], dim=-1)
    return [
        Body("pillar", rods=_rods((0, 0), links.lift_joint, (-0.006, 0.075), links.lift_cylinder_foot)),
        Body(
            "lift arm", on="pillar", slider=_LABELS[0], poses=_planar(place.lift, links.lift_joint),
            rods=_rods((0, 0), links.jib_joint, *brackets), pins=_pins((0, 0), links.jib_joint),
            radius=0.055, color="blue",
        ),
        Body(
            "jib arm", on="lift arm", slider=_LABELS[1], poses=jib,
            rods=_rods(links.coupler_pin, (along, across), (0, 0), (0, across), (0, 0), links.coupler_pin),
            radius=0.055, color="sky blue",
        ),
        Body(
            "extension", on="jib arm", slider=_LABELS[2], poses=_planar(torch.zeros_like(s3), slid),
            rods=_rods((-1.95, 0), (0, 0)), pins=_pins((0, 0)), color="vermillion",
        ),
    ]  # fmt: skip


def _linkage(place: Posture) -> list[Body]:
    """Crank and coupler of the jib's four-bar linkage."""
    links, pin = crane.patu655().linkage, place.crank_pin
    crank_joint = pin.new_tensor(links.crank_joint).expand_as(pin)
    coupler_pin = pin.new_tensor(links.jib_joint) + turned(place.jib - place.lift, links.coupler_pin)
    return [
        Body(
            name, on="lift arm", slider=_LABELS[1], poses=_planar(_direction(end - start), start),
            rods=_rods((0, 0), (length, 0)), pins=_pins((0, 0), (length, 0)), color="bluish green",
        )
        for name, start, end, length in (
            ("crank", crank_joint, pin, links.crank), ("coupler", pin, coupler_pin, links.coupler)
        )
    ]  # fmt: skip


def _cylinders(place: Posture) -> list[Body]:
    """Barrels that turn about their feet, and rods that slide in them."""
    links, upper = crane.patu655().linkage, crane.patu655().upper
    lift_rod = turned(place.lift, links.lift_cylinder_rod) + place.lift.new_tensor(links.lift_joint)
    bodies = []
    for i, (name, on, foot, end, shortest) in enumerate(
        (
            ("lift", "pillar", links.lift_cylinder_foot, lift_rod, links.lift_cylinder_length),
            ("jib", "lift arm", links.jib_cylinder_foot, place.crank_pin, links.jib_cylinder_length),
        )
    ):
        angle, barrel = _direction(end - end.new_tensor(foot)), 0.92 * shortest
        rod = 0.1 * shortest + upper[i]  # long enough to stay in the barrel
        bodies += [
            Body(
                f"{name} cylinder", on=on, slider=_LABELS[i], poses=_planar(angle, foot),
                rods=_rods((0, 0), (barrel, 0)), pins=_pins((0, 0)), radius=0.055, color="black",
            ),
            Body(
                f"{name} cylinder's rod", on=on, slider=_LABELS[i], poses=_planar(angle, end),
                rods=_rods((-rod, 0), (0, 0)), pins=_pins((0, 0)), radius=0.03,
            ),
        ]  # fmt: skip
    return bodies


def _planar(angle: Tensor, origin: Tensor | Point) -> NDArray[np.float64]:
    """Poses (k, 4, 4) of frames in the plane of their carrier."""
    T = torch.eye(4, dtype=torch.float64).repeat(len(angle), 1, 1)
    T[:, :2, 3] = origin if isinstance(origin, Tensor) else T.new_tensor(origin)
    T[:, :2, :2] = torch.stack([turned(angle, (1.0, 0.0)), turned(angle, (0.0, 1.0))], dim=-1)
    return T.numpy()


def _on_line(end: Point, pin: Point) -> Point:
    """Foot of the perpendicular from a pin to the line from the origin to an end."""
    share = (pin[0] * end[0] + pin[1] * end[1]) / (end[0] ** 2 + end[1] ** 2)
    return share * end[0], share * end[1]


def _pins(*points: Point) -> NDArray[np.float64]:
    return np.array([(x, y, 0.0) for x, y in points])


def _rods(*ends: Point) -> NDArray[np.float64]:
    """Rods (m, 2, 3) from each second end to the next one."""
    return _pins(*ends).reshape(-1, 2, 3)


# ---- tables ----------------------------------------------------------------------------------------


def gain_table(result: Result) -> dict[str, dict[str, float]]:
    """Millimetres of the tip for a millimetre of each stroke, and by singular values."""
    rows = {**result.gains, **{f"{name} singular value": gain for name, gain in result.singular.items()}}
    return {
        name: {
            "least": gain.least,
            "median": gain.median,
            "largest": gain.largest,
            "largest at the test points": gain.at_tests,
        }
        for name, gain in rows.items()
    }


def misprint_table(result: Result) -> dict[str, dict[str, str]]:
    """Set what is printed where the thesis disagrees with itself beside what follows from the rest of it."""
    folded, stretched = result.rules["folded"], result.rules["stretched"]
    rocker = math.hypot(*crane.patu655().linkage.coupler_pin)
    return {
        "mounts of the lift cylinder, table": {
            "printed": _printed("crane-cylinder-mounts"),
            "elsewhere": "the listing has the same sizes in other pairs",
            "at stake": f"{result.table:.1f} m, with the best signs",
        },
        "height of IJ": {
            "printed": f"{_values('crane-joints')[-1]:g} m",
            "elsewhere": "−0.008 along an axis that points down",
            "at stake": f"{1e3 * result.downwards:.0f} mm, if taken for down",
        },
        "length of GI": {
            "printed": _printed("crane-rocker"),
            "elsewhere": f"{rocker:.5f} m from its two sizes",
            "at stake": f"{1e3 * result.rocker:.2f} mm",
        },
        "end of the jib cylinder": {
            "printed": f"{_ends()['listing']:g} m",
            "elsewhere": f"{_ends()['training data']:g} m in the training data",
            "at stake": f"{1e3 * (result.inner[0] - result.inner[1]):.0f} mm, folded",
        },
        "inner radius": {
            "printed": _printed("crane-inner-radius"),
            "elsewhere": f"{result.inner[2]:.3f} m at least, {result.inner[1]:.3f} m at the end",
            "at stake": f"{1e3 * folded.longest:.0f} mm of extension",
        },
        "circle with an extension": {
            "printed": "r² + s₃²",
            "elsewhere": "(r + s₃)² in the rule that follows",
            "at stake": f"{stretched.printed:.1f} m of extension",
        },
    }


def stroke_end_table(result: Result) -> dict[str, dict[str, float]]:
    """Compare both ends of the jib cylinder."""
    return {
        name: {
            "s₂ [m]": end,
            "rows of training data": result.rows[name],
            "working area [m²]": result.areas[name],
            "tip from lift joint, folded [m]": inner,
        }
        for (name, end), inner in zip(_ends().items(), result.inner, strict=False)
    }


def _printed(claim: str) -> str:
    return load_paper(_PAPER).claim(claim).printed


def _values(claim: str) -> tuple[float, ...]:
    value = load_paper(_PAPER).claim(claim).value
    return tuple(value) if isinstance(value, tuple) else (float(value),)  # type: ignore[arg-type]


def _value(claim: str) -> float:
    return _values(claim)[0]


# ---- verdicts --------------------------------------------------------------------------------------

_SETTING = "Taken over as a setting; nothing can be tested."


def verdicts(result: Result) -> tuple[Verdict, ...]:
    """Judge the claims of the ledger that this study answers for."""
    return (*_on_sizes(result), *_on_formulas(result), *_on_inverse(result), *_on_area(result))


def _on_sizes(result: Result) -> tuple[Verdict, ...]:
    links = crane.patu655().linkage
    upper = crane.patu655().upper
    foot, crank, joint = links.jib_cylinder_foot, links.crank_joint, links.jib_joint
    (short, long), printed = (result.rows[name] for name in _ends()), _value("crane-training-vectors")
    disagree = long == printed != short
    return (
        _setting(
            "crane-joints",
            (*links.lift_joint, *joint, *links.coupler_pin, *_less(links.extension_joint, links.coupler_pin)),
            "Signs come from the transforms.",
        ),
        _verdict(
            "crane-cylinder-mounts",
            Outcome.OUT_OF_SCOPE if result.table < _NANOMETRE else Outcome.CONTRADICTED,
            "The listing has the same four sizes in other pairs: 0.26 and 1.04 lie between B and C, 0.3025 "
            "and 0.105 between B and D. With the table's pairs no choice of signs gives that crane.",
            f"{result.table:.2f} m off", "the tip, with the best choice of signs",
        ),
        _setting("crane-four-bar-mounts", (*_less(foot, crank), *_less(joint, crank))),
        _setting(
            "crane-rods",
            (links.crank, links.coupler, links.lift_cylinder_length, links.jib_cylinder_length),
        ),
        _setting(
            "crane-rocker", (links.rocker,),
            f"Its two sizes make it {math.hypot(*links.coupler_pin):.5f} m, which moves the tip by up to "
            f"{1e3 * result.rocker:.2f} mm.",
        ),
        _verdict(
            "crane-stroke-ends", Outcome.CONTRADICTED if disagree else Outcome.OUT_OF_SCOPE,
            f"The training data takes the jib cylinder to {upper[1]:g} m, and only that leaves the stated "
            f"number of rows: {long}, against {short} with the listing's end.",
            f"{', '.join(f'{end:g}' for end in upper)} m", "the jib cylinder's from the training data",
        ),
    )  # fmt: skip


def _on_formulas(result: Result) -> tuple[Verdict, ...]:
    return (
        _verdict(
            "crane-lift-angle", _exactly(result.closure["lift"]),
            "Checked by the length of the cylinder at every posture.",
            f"{result.closure['lift']:.0e} m", "largest miss of a length",
        ),
        _verdict(
            "crane-jib-angle", _exactly(result.closure["jib"]),
            "Checked by the lengths of cylinder, crank and coupler at every posture.",
            f"{result.closure['jib']:.0e} m", "largest miss of a length",
        ),
        _verdict(
            "crane-transforms", _exactly(result.transforms),
            "The quarters of a turn cancel in pairs. The third axis of frame 5 points down in the plane, so "
            f"that −0.008 is up; taken for down, the tip is {1e3 * result.downwards:.0f} mm off.",
            f"{result.transforms:.0e} m", "largest distance from the plane's two turns",
        ),
        _verdict(
            "crane-amplification", _amplifies(result),
            f"A millimetre of the lift cylinder moves the tip by {result.gains['lift'].median:.0f} mm in the "
            f"median, one of the jib cylinder by {result.gains['jib'].median:.0f} mm; at the test points by "
            f"up to {max(result.gains[name].at_tests for name in CYLINDERS):.0f} mm.",
            f"up to {_largest_gain(result):.0f} mm", "for a millimetre of one stroke, all over the strokes",
        ),
    )  # fmt: skip


def _on_inverse(result: Result) -> tuple[Verdict, ...]:
    closed = result.round_trip < _NANOMETRE and result.lost == 0
    low, middle, high = result.spans
    return (
        _verdict(
            "crane-redundant", Outcome.of(result.several > 0.5),
            f"The range of extensions that reach a point is {middle:.2f} m in the median; a tenth of the "
            f"points have less than {low:.2f} m, a tenth more than {high:.2f} m.",
            f"{100 * result.several:.0f} %", "share of the working area with several extensions",
        ),
        _verdict(
            "crane-no-closed-form", Outcome.NOT_REPRODUCED if closed else Outcome.REPRODUCED,
            "Not for this crane: with an extension given, or the least one, the strokes follow by the law of "
            "cosines, and no posture with the elbow up is lost. The other way to bend is its mirror image; "
            f"{100 * result.elbow_down:.0f} % of random strokes have it.",
            f"{result.round_trip:.0e} m", "largest miss of the closed form",
        ),
        _verdict(
            "crane-one-joint-given", Outcome.of(result.most == 2 and result.pairs > 0),
            f"Given the extension, there are two ways to bend the elbow; the cylinders have both for "
            f"{100 * result.pairs:.0f} % of random strokes, and never more.",
            f"{result.most}", "pairs of lift and jib stroke at most",
        ),
        _verdict(
            "crane-least-extension",
            Outcome.of(result.excess < _NANOMETRE and result.overlooked == 0),
            "A closed form gives it. A search through all extensions finds none that is shorter, and no "
            "point that the closed form does not reach.",
            f"{max(0.0, result.excess):.0e} m", "by which the search is shorter",
        ),
    )  # fmt: skip


def _on_area(result: Result) -> tuple[Verdict, ...]:
    printed, rules = _value("crane-inner-radius"), result.rules
    listing, training, least = result.inner
    apart = min(abs(radius - printed) for radius in result.inner[:2])
    folded, outer = rules["folded"], [rules[name] for name in ("lift arm down", "stretched")]
    return (
        _verdict(
            "crane-three-circles", _nearly(result.disagreement, 0.0, 0.01),
            "With the radii that the linkage gives. In all of the working area an extension is needed inside "
            "the first, outside the third, and outside the second below the lift arm's lowest line.",
            f"{100 * result.disagreement:.2g} %", "share of the working area that they get wrong",
        ),
        _verdict(
            "crane-circle",
            Outcome.CONTRADICTED if all(rule.printed > 0.02 for rule in rules.values()) else Outcome.IN_SHAPE,
            "As printed it gives a stroke that is wrong by so much. The thesis's own rule for the extension "
            "is that of the square of a sum, (r + s₃)².",
            f"up to {max(rule.printed for rule in rules.values()):.1f} m", "error of the extension",
        ),
        _verdict(
            "crane-inner-radius", _nearly(apart, 0.0005, 0.005),
            f"With the listing's end of the jib cylinder it is {listing:.3f} m, with the training data's "
            f"{training:.3f} m; it is least, {least:.4f} m, at {result.inner_stroke:.3f} m, where the arms "
            "are folded. The printed one belongs to no end.",
            f"{training:.3f} m", "all the way out",
        ),
        _verdict(
            "crane-inner-rule",
            Outcome.NOT_REPRODUCED if folded.shortest < 0 else _nearly(folded.longest, 1e-3, 0.02),
            f"Where the circle decides, the rule gives {1e3 * folded.shortest:.0f} to "
            f"{1e3 * folded.longest:.0f} mm too much"
            + (", and so always reaches. " if folded.shortest >= 0 else ". ")
            + ("Its limit on x leaves no point out. " if result.idle_limit else "")
            + "Below the lift arm's lowest line the second circle asks for more.",
            f"{1e3 * folded.longest:.0f} mm", "largest excess",
        ),
        _verdict(
            "crane-extension-rule", _nearly(max(-rule.shortest for rule in outer), 1e-3, 0.02),
            "The extension slides beside the line from the joint, so that the reach grows by a little less "
            f"than the stroke: the rule stops up to {-1e3 * min(rule.shortest for rule in outer):.1f} mm "
            "short of the point.",
            f"{-1e3 * min(rule.shortest for rule in outer):.1f} mm", "by which the stroke is too short",
        ),
    )  # fmt: skip


def _exactly(miss: float) -> Outcome:
    return Outcome.of(miss < _NANOMETRE)


def _nearly(miss: float, exact: float, near: float) -> Outcome:
    if miss <= exact:
        return Outcome.REPRODUCED
    return Outcome.IN_SHAPE if miss <= near else Outcome.NOT_REPRODUCED


def _largest_gain(result: Result) -> float:
    return max(gain.largest for gain in result.gains.values())


def _amplifies(result: Result) -> Outcome:
    largest = _largest_gain(result)
    if largest >= _SEVERAL:
        return Outcome.REPRODUCED
    return Outcome.IN_SHAPE if largest >= _ONE else Outcome.NOT_REPRODUCED


def _less(a: Point, b: Point) -> Point:
    return a[0] - b[0], a[1] - b[1]


def _setting(claim: str, ours: tuple[float, ...], more: str = "") -> Verdict:
    """Judge sizes that were taken over, but for their signs."""
    same = np.allclose(np.abs(ours), _values(claim), rtol=0, atol=1e-12)
    outcome = Outcome.OUT_OF_SCOPE if same else Outcome.CONTRADICTED
    return _verdict(claim, outcome, f"{_SETTING} {more}".strip())


def _verdict(claim: str, outcome: Outcome, sentence: str, ours: str = "", spread: str = "") -> Verdict:
    return Verdict(_PAPER, claim, outcome, ours, spread, sentence)


def acceptance(result: Result) -> tuple[Acceptance, ...]:
    """Figures that must hold for the book to be built."""
    return (
        Acceptance("tip of the rigid crane from strokes of the inverse [m]", result.round_trip, 1e-9),
        Acceptance("lengths of the lift linkage [m]", result.closure["lift"], 1e-9),
        Acceptance("lengths of the jib linkage [m]", result.closure["jib"], 1e-9),
        Acceptance("tip from the product of the transforms [m]", result.transforms, 1e-9),
        Acceptance("least extension beyond a shorter one that reaches [m]", result.excess, 1e-9),
    )
