"""Bodies on a chain: how far they are from each other at configurations, and whether they collide.

Examples
--------
>>> import dexterity as dx
>>> from dexterity.collision import Bodies, Body, Box, capsules
>>> arm = dx.robots.docking_arm()
>>> floor = Body(Box((2, 2, 1), centre=(0, 0, -0.6)), "world", "floor")
>>> bodies = Bodies(arm, [*capsules(arm, radius=0.04), floor], excluded=[("link 1", "floor")])
>>> bodies.pairs
(('link 1', 'link 4'), ('link 2', 'floor'), ('link 4', 'floor'))
>>> bodies.collides([[0, 0.5, 0, 0, 0, 0], [0, -0.5, 0, 0, 0, 0]]).tolist()
[False, True]
>>> round(float(bodies.clearance([0, 0, 0, 0, 0, 0])), 3)
0.16
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import torch
from jaxtyping import Bool, Float64
from torch import Tensor

from dexterity import checks, spatial
from dexterity.chain import Chain
from dexterity.collision.distances import box_box, segment_box, segment_segment
from dexterity.collision.shapes import Body, Box, Link, Sphere
from dexterity.spatial import TensorLike

__all__ = ["TOUCH", "Bodies"]

TOUCH = 1e-9
"""Depth [m] down to which bodies that touch do not collide, so that rounding does not decide it."""


class _Group(NamedTuple):
    """Pairs of one kind: the numbers of their first and their second bodies, and their places among all."""

    first: list[int]
    second: list[int]
    places: list[int]


class Bodies:
    """Bodies on the links of a chain, on its base and in the world around it.

    A pair of bodies is looked at if they can move against each other and are no neighbours. The links that
    carry bodies are neighbours one after the other along the chain, the base first: in between may be links
    without a body, as within a spherical wrist. A body of the world has no neighbour.

    **Exact are** the distances of spheres, capsules and boxes from each other, to rounding, and the depths of
    all pairs that include a box. Of two capsules the depth is exact unless their lines cross; there it is the
    sum of the radii.

    Parameters
    ----------
    chain
        The chain that moves them.
    bodies
        Bodies with different names.
    excluded
        Pairs of names that are not looked at either.

    Raises
    ------
    ValueError
        If there is no body or no pair to look at, a link is none of the chain's, a name is there twice, an
        excluded name is unknown, or two bodies of the robot that would be looked at overlap at home.
    TypeError
        If an argument is of another type.
    """

    @torch.inference_mode(False)  # its tensors serve in every mode
    def __init__(
        self, chain: Chain, bodies: Iterable[Body], excluded: Iterable[tuple[str, str]] = ()
    ) -> None:
        self._chain = checks.instance(chain, "chain", Chain)
        self._bodies: tuple[Body, ...] = checks.Each(checks.Instance(Body))(bodies, "bodies")
        self._check_bodies()
        self._pairs = self._open_pairs(_excluded(excluded, self.names))
        if not self._pairs:
            raise ValueError(
                "bodies leaves no pair to look at: all are neighbours, excluded, or stand still to each other"
            )
        is_box = [isinstance(body.shape, Box) for body in self._bodies]
        # In a pair of two kinds the box comes second.
        self._pairs = tuple((b, a) if is_box[a] and not is_box[b] else (a, b) for a, b in self._pairs)
        self._groups = tuple(
            _group(self._pairs, [(is_box[a], is_box[b]) == kinds for a, b in self._pairs])
            for kinds in ((False, False), (False, True), (True, True))
        )
        self._frames_at_home = chain.joint_frames(torch.zeros(chain.joints, dtype=torch.float64))
        self._lines, self._boxes = self._at_home()
        self._check_home()

    def __repr__(self) -> str:
        return f"Bodies({self._chain.name!r}: {', '.join(self.names)}; {len(self._pairs)} pairs)"

    def _check_bodies(self) -> None:
        if not self._bodies:
            raise ValueError("bodies is empty; one or more are needed")
        checks.names(self.names, "bodies")
        for body in self._bodies:
            if body.link != "world" and body.link > self._chain.joints:
                raise ValueError(
                    f"bodies holds {body.name!r} on link {body.link}; {self._chain.name} has links 0 to "
                    f"{self._chain.joints}"
                )

    def _open_pairs(self, excluded: set[frozenset[str]]) -> tuple[tuple[int, int], ...]:
        carriers = sorted({body.link for body in self._bodies if body.link != "world"})
        place: dict[Link, int] = {link: i for i, link in enumerate(carriers)}

        def is_open(a: Body, b: Body) -> bool:
            if a.link == b.link or frozenset((a.name, b.name)) in excluded:
                return False
            return "world" in (a.link, b.link) or abs(place[a.link] - place[b.link]) > 1

        numbered = itertools.combinations(enumerate(self._bodies), 2)
        return tuple((i, j) for (i, a), (j, b) in numbered if is_open(a, b))

    def _at_home(self) -> tuple[Tensor, Tensor]:
        """Return lines (bodies, 2, 3) and boxes' poses (bodies, 4, 4) in the frames that carry them."""
        lines = torch.zeros(len(self._bodies), 2, 3, dtype=torch.float64)
        boxes = torch.eye(4, dtype=torch.float64).repeat(len(self._bodies), 1, 1)
        for i, body in enumerate(self._bodies):
            line, box = line_of(body), box_of(body)
            if isinstance(body.link, int) and body.link > 0:
                back = spatial.inverse(self._frames_at_home[body.link - 1])
                line, box = spatial.apply(back, line), back @ box
            lines[i], boxes[i] = line, box
        return lines, boxes

    def _check_home(self) -> None:
        robot = [k for k, (a, b) in enumerate(self._pairs) if not self._in_world(a, b)]
        if not robot:
            return
        distances = self.distances(torch.zeros(self._chain.joints, dtype=torch.float64))[robot]
        if distances.min() < -TOUCH:
            k = int(distances.argmin())
            a, b = (self._bodies[i].name for i in self._pairs[robot[k]])
            raise ValueError(
                f"bodies holds {a!r} and {b!r}, which overlap by {-float(distances[k]):.3g} m at home; "
                "mend them, or exclude the pair"
            )

    def _in_world(self, *numbers: int) -> bool:
        return any(self._bodies[i].link == "world" for i in numbers)

    # ---- descriptions ------------------------------------------------------------------------------

    @property
    def chain(self) -> Chain:
        """The chain that moves the bodies."""
        return self._chain

    @property
    def bodies(self) -> tuple[Body, ...]:
        """All bodies, as they were given."""
        return self._bodies

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all bodies."""
        return tuple(body.name for body in self._bodies)

    @property
    def pairs(self) -> tuple[tuple[str, str], ...]:
        """Names of the bodies of each pair that is looked at."""
        return tuple((self.names[min(pair)], self.names[max(pair)]) for pair in self._pairs)

    @property
    def numbered_pairs(self) -> tuple[tuple[int, int], ...]:
        """Numbers of the bodies of each pair, a box behind what is none."""
        return self._pairs

    # ---- distances ---------------------------------------------------------------------------------

    def distances(
        self, q: TensorLike, T_world_base: TensorLike | None = None
    ) -> Float64[Tensor, "*batch pairs"]:
        """Signed distance of each pair [m], below zero the depth of an overlap.

        Torch can differentiate it by both arguments where it is smooth: where the nearest points and the
        deepest axis are the only ones.

        Parameters
        ----------
        q
            (..., n) joint values, [rad] or [m].
        T_world_base
            (..., 4, 4) poses of the base, the chain's world frame, in the world; None if the two are the
            same.

        Returns
        -------
        (..., pairs) in the order of :attr:`pairs`.

        Raises
        ------
        ValueError
            If a shape does not fit, something is not finite, or a pose is not rigid.
        """
        q, T = self.checked(q, T_world_base)
        rows, poses = q.reshape(-1, q.shape[-1]), None if T is None else T.reshape(-1, 4, 4)
        # While torch traces, pieces would fix the size of the batch.
        size = max(1, len(rows)) if torch.compiler.is_compiling() else _PIECE
        pieces = rows.split(size)
        bases = [None] * len(pieces) if poses is None else poses.split(size)
        found = torch.cat([self._distances(*piece) for piece in zip(pieces, bases, strict=True)])
        return found.reshape(*q.shape[:-1], len(self._pairs))

    def _distances(self, q: Tensor, T: Tensor | None) -> Tensor:
        frames = self._frames(q, T)
        lines = spatial.apply(frames[..., None, :, :], self._lines.to(q.device))
        boxes = frames @ self._boxes.to(q.device)
        radii, halves = (part.to(q.device) for part in self._sizes)
        parts = [
            _capsules(lines, radii, *self._groups[0][:2]),
            _capsules_boxes(lines, radii, boxes, halves, *self._groups[1][:2]),
            _boxes(boxes, halves, *self._groups[2][:2]),
        ]
        places = [place for group in self._groups for place in group.places]
        back = sorted(range(len(places)), key=places.__getitem__)
        return torch.cat(parts, dim=-1)[..., back]

    def clearance(self, q: TensorLike, T_world_base: TensorLike | None = None) -> Float64[Tensor, "*batch"]:
        """Smallest signed distance of all pairs [m], below zero the depth of the deepest overlap.

        Parameters, derivatives and errors are those of :meth:`distances`.
        """
        return self.distances(q, T_world_base).amin(-1)

    def collides(
        self, q: TensorLike, T_world_base: TensorLike | None = None, margin: float = 0.0
    ) -> Bool[Tensor, "*batch"]:
        """Tell which configurations (...) bring two bodies nearer to each other than a margin.

        Bodies that touch do not collide: with a margin of 0, an overlap of up to 1e-9 m is a touch.

        Parameters
        ----------
        q, T_world_base
            As for :meth:`distances`.
        margin
            Distance that is to be kept [m].

        Raises
        ------
        ValueError
            As :meth:`distances`, or if the margin is negative or not finite.
        """
        margin = checks.real(margin, "margin", least=0.0)
        return self.clearance(q, T_world_base) < margin - TOUCH

    def checked(
        self, q: TensorLike, T_world_base: TensorLike | None
    ) -> tuple[Float64[Tensor, "*batch n"], Float64[Tensor, "*batch 4 4"] | None]:
        """Return the arguments of :meth:`distances` as tensors with the same batch axes.

        Raises
        ------
        ValueError
            As :meth:`distances`.
        """
        q = spatial.require_joints(spatial.to_float64(q, "q"), self._chain.joints, "chain")
        if T_world_base is None:
            return q, None
        T = spatial.require_rigid(spatial.to_float64(T_world_base, "T_world_base"), "T_world_base")
        batch = spatial.common_batch(q=q.shape[:-1], T_world_base=T.shape[:-2])
        return q.expand(*batch, q.shape[-1]), T.expand(*batch, 4, 4)

    def _frames(self, q: Tensor, T_world_base: Tensor | None) -> Tensor:
        """Poses (..., bodies, 4, 4) in the base of what carries each body."""
        base = torch.eye(4, dtype=q.dtype, device=q.device).expand(*q.shape[:-1], 4, 4)
        world = base if T_world_base is None else spatial.inverse(T_world_base)
        frames = torch.cat([base[..., None, :, :], self._chain.joint_frames(q), world[..., None, :, :]], -3)
        return frames[..., [-1 if body.link == "world" else body.link for body in self._bodies], :, :]

    @property
    def _sizes(self) -> tuple[Tensor, Tensor]:
        """Radii (bodies) and half edges (bodies, 3), zero for what has none."""
        radii = [0.0 if isinstance(body.shape, Box) else body.shape.radius for body in self._bodies]
        halves = [
            [length / 2 for length in body.shape.size] if isinstance(body.shape, Box) else [0.0] * 3
            for body in self._bodies
        ]
        return torch.tensor(radii, dtype=torch.float64), torch.tensor(halves, dtype=torch.float64)


_PIECE = 1024  # configurations worked on at a time: what they need stays in a core's cache


def line_of(body: Body) -> Tensor:
    """Return both ends (2, 3) of a sphere's or a capsule's line at home; zeros for a box."""
    shape = body.shape
    if isinstance(shape, Box):
        return torch.zeros(2, 3, dtype=torch.float64)
    ends = (shape.centre, shape.centre) if isinstance(shape, Sphere) else (shape.start, shape.end)
    return torch.tensor(ends, dtype=torch.float64)


def box_of(body: Body) -> Tensor:
    """Return the pose (4, 4) of a box at home; the identity for another shape."""
    T = torch.eye(4, dtype=torch.float64)
    if isinstance(body.shape, Box):
        T[:3, 3] = torch.tensor(body.shape.centre, dtype=torch.float64)
        if body.shape.rotation is not None:
            T[:3, :3] = torch.tensor(body.shape.rotation, dtype=torch.float64)
    return T


def _group(pairs: Sequence[tuple[int, int]], chosen: Sequence[bool]) -> _Group:
    places = [k for k, taken in enumerate(chosen) if taken]
    return _Group([pairs[k][0] for k in places], [pairs[k][1] for k in places], places)


def _excluded(excluded: Any, names: Sequence[str]) -> set[frozenset[str]]:
    pairs = set()
    for i, pair in enumerate(checks.Each(checks.Each(checks.Choice(names)))(excluded, "excluded")):
        if len(pair) != 2:
            raise ValueError(f"excluded[{i}] is {checks.shown(pair)}; a pair of names is needed")
        pairs.add(frozenset(pair))
    return pairs


def _capsules(lines: Tensor, radii: Tensor, first: list[int], second: list[int]) -> Tensor:
    (p, p_end), (q, q_end) = (lines[..., some, :, :].unbind(-2) for some in (first, second))
    return segment_segment(p, p_end - p, q, q_end - q) - radii[first] - radii[second]


def _capsules_boxes(
    lines: Tensor, radii: Tensor, boxes: Tensor, halves: Tensor, first: list[int], second: list[int]
) -> Tensor:
    back = spatial.inverse(boxes[..., second, :, :])[..., None, :, :]
    start, end = spatial.apply(back, lines[..., first, :, :]).unbind(-2)
    return segment_box(start, end - start, halves[second].expand_as(start)) - radii[first]


def _boxes(boxes: Tensor, halves: Tensor, first: list[int], second: list[int]) -> Tensor:
    T = spatial.inverse(boxes[..., second, :, :]) @ boxes[..., first, :, :]
    c = T[..., :3, 3]
    return box_box(T[..., :3, :3], c, halves[first].expand_as(c), halves[second].expand_as(c))
