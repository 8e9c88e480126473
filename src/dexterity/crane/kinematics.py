"""Rigid kinematics of a log crane: cylinder strokes to the tip and back.

Appendix A of Rouvinen (1999). The lift cylinder turns the lift arm through a triangle, the jib cylinder turns
the jib arm through a four-bar linkage, the extension slides along the jib. All is in the plane of the crane,
x ahead and y up, [m] and [rad], with the origin at the foot of the pillar.

Examples
--------
>>> import dexterity as dx
>>> tip = dx.crane.tip_position([0.25, 0.5, 1.0])
>>> reach = dx.crane.inverse(tip, extension=1.0)
>>> bool(reach.reached), [round(stroke, 6) for stroke in reach.strokes.tolist()]
(True, [0.25, 0.5, 1.0])
"""

from __future__ import annotations

import math
from typing import NamedTuple

import torch
from jaxtyping import Bool, Float64
from torch import Tensor

from dexterity import spatial
from dexterity.crane.description import Crane, Linkage, Point, given_crane
from dexterity.spatial import TensorLike
from dexterity.spatial.values import on_one_device

__all__ = [
    "Posture",
    "Reach",
    "inverse",
    "least_extension",
    "posture",
    "require_strokes",
    "tip_jacobian",
    "tip_position",
    "turned",
    "within_limits",
]

_EDGE = 1e-9  # [m]: what rounding may put beyond a limit, and what a solution may miss the position by

FARTHEST = 1e9  # [m]; the square of a much larger number is infinite


class Posture(NamedTuple):
    """Where the arms are; NaN where a linkage does not close.

    Attributes
    ----------
    lift, jib
        (...) angles of both arms from the x axis, counterclockwise [rad].
    crank_pin
        (..., 2) point H that jib cylinder, crank and coupler share, in the lift frame.
    lift_closes, jib_closes
        (...) whether the triangle of the lift cylinder and the linkage of the jib cylinder close.
    """

    lift: Tensor
    jib: Tensor
    crank_pin: Tensor
    lift_closes: Tensor
    jib_closes: Tensor


def tip_position(strokes: TensorLike, crane: Crane | None = None) -> Float64[Tensor, "*batch 2"]:
    """Return the position of the tip of the rigid crane.

    Strokes beyond their limits are no error as long as the linkages close; :func:`within_limits` flags them.

    Parameters
    ----------
    strokes
        (..., 3) strokes s1, s2, s3 of lift, jib and extension cylinder [m].
    crane
        Which crane; None for :func:`~dexterity.crane.description.patu655`.

    Returns
    -------
    x, y [m] in the plane of the crane, y up, from the foot of its pillar.

    Raises
    ------
    ValueError
        If the last axis is not 3, a stroke is not finite, or a linkage cannot close; the error names it.

    References
    ----------
    Rouvinen (1999), Appendix A.
    """
    crane = given_crane(crane)
    strokes = require_strokes(strokes)
    place = posture(strokes, crane)
    for closes, linkage, column in ((place.lift_closes, "lift", 0), (place.jib_closes, "jib", 1)):
        if spatial.are_readable(closes) and not closes.all():
            stroke = strokes[..., column][~closes][0].item()
            raise ValueError(
                f"strokes holds s{column + 1} = {stroke} m, where the {linkage} linkage cannot close"
            )
    return _tip(place, strokes[..., 2], crane.linkage)


def posture(strokes: TensorLike, crane: Crane | None = None) -> Posture:
    """Return the angles of the arms for strokes (..., 3) [m]; what cannot close is flagged.

    Raises
    ------
    ValueError
        If the last axis is not 3 or a stroke is not finite.

    References
    ----------
    Rouvinen (1999), Appendix A.
    """
    links = given_crane(crane).linkage
    s1, s2, _ = require_strokes(strokes).unbind(-1)
    lift = _lift_foot_angle(links) + _angle(*_lift_sides(links), s1 + links.lift_cylinder_length)
    crank_pin, relative = _four_bar(s2, links)
    return Posture(lift, lift + relative, crank_pin, lift.isfinite(), relative.isfinite())


def within_limits(strokes: TensorLike, crane: Crane | None = None) -> Bool[Tensor, "*batch 3"]:
    """Tell which strokes (..., 3) [m] the cylinders have, their ends included to a nanometre.

    Raises
    ------
    ValueError
        If the last axis is not 3 or a stroke is not finite.
    """
    crane = given_crane(crane)
    strokes = require_strokes(strokes)
    return (strokes >= strokes.new_tensor(crane.lower) - _EDGE) & (
        strokes <= strokes.new_tensor(crane.upper) + _EDGE
    )


def tip_jacobian(strokes: TensorLike, crane: Crane | None = None) -> Float64[Tensor, "*batch 2 3"]:
    """Map velocities of the cylinders at strokes (..., 3) [m] to the velocity of the rigid tip.

    Raises
    ------
    ValueError
        As :func:`tip_position`.
    """
    with spatial.differentiation():
        s = require_strokes(strokes).detach().clone().requires_grad_()
        tip = tip_position(s, crane)
        rows = [torch.autograd.grad(tip[..., i].sum(), s, retain_graph=True)[0] for i in range(2)]
    return torch.stack(rows, dim=-2)


class Reach(NamedTuple):
    """Strokes that bring the tip to a position.

    Attributes
    ----------
    strokes
        (..., 3) [m]; NaN where the position is not reached.
    reached
        (...) whether the strokes solve the forward kinematics, to a nanometre.
    within_limits
        (...) whether all three are within their limits besides.
    """

    strokes: Tensor
    reached: Tensor
    within_limits: Tensor


def inverse(position: TensorLike, extension: TensorLike | None = None, crane: Crane | None = None) -> Reach:
    """Find the strokes that bring the rigid tip to a position with the elbow up, in closed form.

    Parameters
    ----------
    position
        (..., 2) x, y [m].
    extension
        (...) stroke s3 [m]; None for :func:`least_extension`.
    crane
        Which crane; None for :func:`~dexterity.crane.description.patu655`.

    Raises
    ------
    ValueError
        If the last axis of the position is not 2, a number is not finite, or batch axes do not fit.

    References
    ----------
    Both arms and the line from the lift joint to the tip are a triangle; Spong, Hutchinson & Vidyasagar
    (2006), section 3.3. The linkages are then undone by the law of cosines.
    """
    crane = given_crane(crane)
    links = crane.linkage
    position = _require_position(position)
    s3 = least_extension(position, crane) if extension is None else spatial.to_float64(extension, "extension")
    s3, position = on_one_device(extension=s3, position=position)
    spatial.common_batch(extension=s3.shape, position=position.shape[:-1])
    lift, relative = _elbow_up(position, s3, links)
    s1 = _side(*_lift_sides(links), lift - _lift_foot_angle(links)) - links.lift_cylinder_length
    strokes = torch.stack(torch.broadcast_tensors(s1, _jib_stroke(relative, links), s3), dim=-1)
    finite = strokes.isfinite().all(-1)
    candidate = torch.where(finite[..., None], strokes, 0.0)
    place = posture(candidate, crane)
    miss = (_tip(place, candidate[..., 2], links) - position).norm(dim=-1)
    reached = finite & place.lift_closes & place.jib_closes & (miss <= _EDGE)
    within = reached & within_limits(candidate, crane).all(-1)
    return Reach(torch.where(reached[..., None], strokes, torch.nan), reached, within)


def least_extension(position: TensorLike, crane: Crane | None = None) -> Float64[Tensor, "*batch"]:
    """Find the shortest stroke s3 [m] that lets the tip come to positions (..., 2) with the elbow up.

    The idea of Appendix B: the extension should be out as little as possible, and where it must be out is
    told by three circles. Two are about the lift joint, where the jib is folded back against the lift arm
    and where it is stretched ahead of it; one is about the jib joint with the lift cylinder all the way in.
    The thesis adds s3 to their radii; here they grow as they do with an extension beside the joint's line.
    Beyond the upper limit the stroke is returned as it is: :func:`inverse` flags it.

    Raises
    ------
    ValueError
        If the last axis is not 2 or the position is not finite.

    References
    ----------
    Rouvinen (1999), Appendix B.
    """
    crane = given_crane(crane)
    links = crane.linkage
    position = _require_position(position)
    first = math.hypot(*links.jib_joint)
    away = position - position.new_tensor(links.lift_joint)
    distance, direction = away.norm(dim=-1), torch.atan2(away[..., 1], away[..., 0])
    lowest = posture(position.new_tensor(crane.lower), crane).lift
    elbow = turned(lowest, links.jib_joint)
    below = spatial.wrap_to_pi(direction - torch.atan2(elbow[1], elbow[0])) < 0
    from_elbow = (away - elbow).norm(dim=-1)
    needed = torch.maximum((distance - first).abs(), torch.where(below, from_elbow, 0.0))
    length, offset = links.extension_joint
    return ((needed.square() - offset**2).clamp(min=0).sqrt() - length).clamp(min=0)


def require_strokes(strokes: TensorLike) -> Float64[Tensor, "*batch 3"]:
    """Return strokes as a tensor if there are three.

    Raises
    ------
    ValueError
        If the last axis is not 3 or a stroke is not finite.
    """
    return spatial.batch_of(strokes, "strokes", (3,))


def turned(angle: Tensor, point: Tensor | Point) -> Float64[Tensor, "*batch 2"]:
    """Turn points (..., 2) counterclockwise about the origin by angles (...) [rad]."""
    x, y = point.unbind(-1) if isinstance(point, Tensor) else point
    cosine, sine = angle.cos(), angle.sin()
    return torch.stack([cosine * x - sine * y, sine * x + cosine * y], dim=-1)


# ---- the linkages ----------------------------------------------------------------------------------


def _lift_sides(links: Linkage) -> tuple[float, float]:
    """BC and BD."""
    return math.dist(links.lift_joint, links.lift_cylinder_foot), math.hypot(*links.lift_cylinder_rod)


def _lift_foot_angle(links: Linkage) -> float:
    """Lift angle at which D would lie on the line from B to C."""
    (x, y), (foot_x, foot_y) = links.lift_joint, links.lift_cylinder_foot
    rod_x, rod_y = links.lift_cylinder_rod
    return math.atan2(foot_y - y, foot_x - x) - math.atan2(rod_y, rod_x)


def _four_bar(s2: Tensor, links: Linkage) -> tuple[Tensor, Tensor]:
    """Crank pin H (..., 2) in the lift frame and angle (...) of the jib from the lift arm."""
    foot, pivot = links.jib_cylinder_foot, links.crank_joint
    at_crank = _angle(math.dist(foot, pivot), links.crank, s2 + links.jib_cylinder_length)
    direction = math.atan2(foot[1] - pivot[1], foot[0] - pivot[0]) - at_crank
    pin = s2.new_tensor(pivot) + turned(direction, (links.crank, 0.0))
    diagonal = pin - pin.new_tensor(links.jib_joint)
    at_joint = _angle(diagonal.norm(dim=-1), links.rocker, links.coupler)
    rocker = torch.atan2(diagonal[..., 1], diagonal[..., 0]) - at_joint
    # On its way H passes behind the joint at no stroke, so that atan2 does not jump.
    return pin, rocker - math.atan2(links.coupler_pin[1], links.coupler_pin[0])


def _jib_stroke(relative: Tensor, links: Linkage) -> Tensor:
    """Stroke s2 (...) for an angle of the jib from the lift arm."""
    foot, pivot = links.jib_cylinder_foot, links.crank_joint
    rocker = relative + math.atan2(links.coupler_pin[1], links.coupler_pin[0])
    joint = relative.new_tensor([links.jib_joint[0] - pivot[0], links.jib_joint[1] - pivot[1]])
    diagonal = joint + turned(rocker, (links.rocker, 0.0))
    at_crank = _angle(diagonal.norm(dim=-1), links.crank, links.coupler)
    crank = torch.atan2(diagonal[..., 1], diagonal[..., 0]) + at_crank
    opening = math.atan2(foot[1] - pivot[1], foot[0] - pivot[0]) - crank
    return _side(math.dist(foot, pivot), links.crank, opening) - links.jib_cylinder_length


def _angle(a: Tensor | float, b: float, opposite: Tensor | float) -> Tensor:
    """Angle of a triangle between two sides; NaN where there is no such triangle."""
    return torch.acos((a**2 + b**2 - opposite**2) / (2 * a * b))  # type: ignore[arg-type]


def _side(a: float, b: float, angle: Tensor) -> Tensor:
    """Side of a triangle opposite to an angle."""
    return (a**2 + b**2 - 2 * a * b * angle.cos()).sqrt()


# ---- the arms --------------------------------------------------------------------------------------


def _tip(place: Posture, s3: Tensor, links: Linkage) -> Tensor:
    elbow = s3.new_tensor(links.lift_joint) + turned(place.lift, links.jib_joint)
    length, offset = links.extension_joint
    return elbow + turned(place.jib, torch.stack([length + s3, torch.full_like(s3, offset)], dim=-1))


def _elbow_up(position: Tensor, s3: Tensor, links: Linkage) -> tuple[Tensor, Tensor]:
    """Angle of the lift arm and of the jib from it, (...) each; NaN where the arms do not reach."""
    length, offset = links.extension_joint
    first = math.hypot(*links.jib_joint)
    second = torch.hypot(length + s3, torch.full_like(s3, offset))
    away = position - position.new_tensor(links.lift_joint)
    distance = away.norm(dim=-1)
    cosine = (first**2 + distance.square() - second.square()) / (2 * first * distance)
    # Stretched or folded arms are reached to rounding.
    cosine = torch.where((cosine.abs() > 1) & (cosine.abs() < 1 + 1e-12), cosine.sign(), cosine)
    to_elbow = torch.atan2(away[..., 1], away[..., 0]) + torch.acos(cosine)
    lift = spatial.wrap_to_pi(to_elbow - math.atan2(links.jib_joint[1], links.jib_joint[0]))
    ahead = away - turned(lift, links.jib_joint)
    jib = torch.atan2(ahead[..., 1], ahead[..., 0]) - torch.atan2(torch.full_like(s3, offset), length + s3)
    # The jib hangs from a little above the lift arm down to where it is folded back under it.
    relative = spatial.wrap_to_pi(jib - lift + math.pi / 2) - math.pi / 2
    return lift, relative


def _require_position(position: TensorLike) -> Tensor:
    position = spatial.batch_of(position, "position", (2,))
    if spatial.are_readable(position) and (position.abs() > FARTHEST).any():
        raise ValueError(f"position holds numbers beyond {FARTHEST:g} m")
    return position
