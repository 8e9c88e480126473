"""The data of paper C: manipulators of its family, poses, labels and Jacobians, in the paper's columns.

What is drawn follows the public sampler of the paper's authors. The numbers d₃, d₄, a₂, a₃ are uniform in
[0, 0.5] m, positions in a cube of ±0.4 m, and three angles in [0, 2π] make the orientation Rx Ry Rz.

A set is made of chunks, each from a generator of its own, so that it is the same however many processes share
the work.

Examples
--------
>>> from dexterity.workspace.dataset import confidence_data, features
>>> data = confidence_data(count=100, seed=0)
>>> features(data.samples).shape, data.reachable.shape
(torch.Size([100, 24]), torch.Size([100]))
"""

from __future__ import annotations

import io
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, Literal, NamedTuple, TypeAlias, TypeVar

import joblib
import numpy as np
import torch
from jaxtyping import Bool, Float64
from numpy.typing import NDArray
from torch import Tensor

from dexterity import checks, spatial, store
from dexterity.checks import Instance
from dexterity.spatial import TensorLike
from dexterity.workspace.dynamics import DynamicParameters, ratio_at
from dexterity.workspace.reachability import TWISTS, frames, in_tool_axes, inverse, reachable

__all__ = [
    "COLUMNS",
    "CONSTANT_COLUMNS",
    "CSV_SETS",
    "HALF_SIDE",
    "KINEMATIC_COLUMNS",
    "LARGEST_LENGTH",
    "RANGES",
    "ConfidenceData",
    "JacobianData",
    "Samples",
    "Scaling",
    "confidence_data",
    "features",
    "jacobian_data",
    "read_csv",
    "rotation",
    "write_csv",
]

Array: TypeAlias = NDArray[np.float64]

LARGEST_LENGTH = 0.5
"""Up to where d₃, d₄, a₂ and a₃ are drawn, [m]."""

HALF_SIDE = 0.4
"""Half the side of the cube about the base in which positions are drawn, [m]."""

_CHUNK = 50_000
_IN_VAIN = 1000  # poses in a row of which none is kept, after which some others are tried at once
_MOST_REDRAWN = 0.999  # some arms reach next to nothing: their poses would be drawn without an end
_MOST = 10**9  # samples

RANGES: Mapping[str, tuple[float, float]] = {
    "mass": (0.0, 10.0),
    "centre": (-0.05, 0.05),
    "inertia": (0.0, 1.0),
    "viscous": (0.0, 0.005),
    "coulomb": (0.0, 0.5),
    "gear": (-50.0, 50.0),
    "motor": (0.0, 5e-4),
}
"""Where the dynamic parameters are drawn; Coulomb friction backwards is negative."""

KINEMATIC_COLUMNS: Mapping[str, slice] = {
    "d": slice(0, 6),
    "a": slice(6, 12),
    "alpha": slice(12, 18),
    "position": slice(18, 21),
    "angles": slice(21, 24),
}
"""Columns of a manipulator without dynamic parameters, 24 in all."""

COLUMNS: Mapping[str, slice] = {
    "d": slice(0, 6),
    "a": slice(6, 12),
    "alpha": slice(12, 18),
    "mass": slice(18, 24),
    "centre": slice(24, 42),
    "inertia": slice(42, 60),
    "viscous": slice(60, 66),
    "coulomb": slice(66, 78),
    "gear": slice(78, 84),
    "motor": slice(84, 90),
    "position": slice(90, 93),
    "angles": slice(93, 96),
}
"""Columns of a manipulator with dynamic parameters, 96 in all."""

CONSTANT_COLUMNS = (0, 1, *range(4, 7), *range(9, 18))
"""Columns that are the same for all manipulators."""


class Samples(NamedTuple):
    """Manipulators with a pose each.

    Attributes
    ----------
    links
        (n, 4) d₃, d₄, a₂, a₃ [m].
    position
        (n, 3) of the tool in the base [m].
    angles
        (n, 3) about x, y and z [rad].
    dynamics
        Dynamic parameters, where there are any.
    """

    links: Tensor
    position: Tensor
    angles: Tensor
    dynamics: DynamicParameters | None = None

    def rotation(self) -> Tensor:
        """Rotations (n, 3, 3) of the tool to the base."""
        return rotation(self.angles)

    def rows(self, where: Tensor) -> Samples:
        """Return some of the samples, by their numbers or by a mask."""
        dynamics = None if self.dynamics is None else self.dynamics.rows(where)
        return Samples(self.links[where], self.position[where], self.angles[where], dynamics)


class ConfidenceData(NamedTuple):
    """Samples, and whether each pose is in reach."""

    samples: Samples
    reachable: Bool[Tensor, " n"]


class JacobianData(NamedTuple):
    """Samples in reach, and the geometric Jacobian (n, 6, 6) of the branch left, up, no flip."""

    samples: Samples
    jacobian: Float64[Tensor, "n 6 6"]

    @checks.arguments(frame=checks.Choice(("world", "tool")))
    def in_frame(self, frame: Literal["world", "tool"]) -> Tensor:
        """Jacobians (n, 6, 6) in the axes of the base or of the tool."""
        return self.jacobian if frame == "world" else in_tool_axes(self.jacobian, self.samples.rotation())


def rotation(angles: TensorLike) -> Float64[Tensor, "*batch 3 3"]:
    """Rotation Rx Ry Rz of three angles (..., 3) [rad].

    Raises
    ------
    ValueError
        If the last axis is not 3, or an angle is not finite.
    """
    angles = spatial.batch_of(angles, "angles", (3,))
    (cx, cy, cz), (sx, sy, sz) = angles.cos().unbind(-1), angles.sin().unbind(-1)
    rows = [
        [cy * cz, -cy * sz, sy],
        [cx * sz + sx * sy * cz, cx * cz - sx * sy * sz, -sx * cy],
        [sx * sz - cx * sy * cz, sx * cz + cx * sy * sz, cx * cy],
    ]
    return torch.stack([torch.stack(row, -1) for row in rows], -2)


# ---- drawing ---------------------------------------------------------------------------------------


def confidence_data(
    count: int, seed: int, dynamics: bool = False, redraw: float = 0.75, workers: int = 1
) -> ConfidenceData:
    """Draw manipulators and poses, and tell which poses are in reach.

    Parameters
    ----------
    count
        Number of samples.
    seed
        Of all draws; the same seed gives the same set, whatever `workers` is.
    dynamics
        Whether the manipulators have dynamic parameters.
    redraw
        Probability that a pose out of reach is replaced by another one, again and again, by which the set
        comes to hold more poses in reach.
    workers
        Processes that share the work; −1 for all cores.

    Raises
    ------
    ValueError, TypeError
        If `count` is no whole number from 1 to 10⁹, `redraw` no number in [0, 0.999], `seed` or `workers` no
        whole number, or `workers` is 0.
    """
    redraw = checks.real(redraw, "redraw", least=0, most=_MOST_REDRAWN)
    chunk = partial(_confidence_chunk, dynamics=checks.flag(dynamics, "dynamics"), redraw=redraw)
    return _joined(_in_chunks(chunk, count, seed, workers))


def _confidence_chunk(size: int, random: torch.Generator, dynamics: bool, redraw: float) -> ConfidenceData:
    links, parameters = _manipulators(size, random, dynamics)
    samples = Samples(links, *_poses(size, random), parameters)
    reach = reachable(links, samples.position)
    again = (~reach).nonzero()[:, 0]
    while len(again := again[_uniform(random, len(again)) < redraw]):
        position, angles = _poses(len(again), random)
        samples.position[again], samples.angles[again] = position, angles
        reach[again] = reachable(links[again], position)
        again = again[~reach[again]]
    return ConfidenceData(samples, reach)


def jacobian_data(
    count: int,
    seed: int,
    dynamics: bool = True,
    poses: int = 50,
    threshold: float = 0.03,
    workers: int = 1,
) -> JacobianData:
    """Draw manipulators, each with a pose in reach, and their Jacobians.

    Samples come in the order in which poses are found, so that arms that reach far come first among each
    50 000: permute them before a part is held out.

    Parameters
    ----------
    count
        Number of samples.
    seed
        Of all draws; the same seed gives the same set, whatever `workers` is.
    dynamics
        Whether the manipulators have dynamic parameters, and a pose is kept only if their inertia at the tool
        point is even enough.
    poses
        How many poses a manipulator is tried with before another one is drawn.
    threshold
        Asada's ratio above which a pose is kept.
    workers
        Processes that share the work; −1 for all cores.

    Raises
    ------
    ValueError, TypeError
        If `count` or `poses` is no whole number from 1 to 10⁹, `threshold` no number in [0, 1), or so large
        that of 20 000 poses none is kept; if `seed` or `workers` is no whole number, or `workers` is 0.
    """
    poses = checks.whole(poses, "poses", least=1, most=_MOST)
    threshold = checks.real(threshold, "threshold", least=0, below=1)
    dynamics = checks.flag(dynamics, "dynamics")
    chunk = partial(_jacobian_chunk, dynamics=dynamics, poses=poses, threshold=threshold)
    return _joined(_in_chunks(chunk, count, seed, workers))


def _jacobian_chunk(
    size: int, random: torch.Generator, dynamics: bool, poses: int, threshold: float
) -> JacobianData:
    found: list[JacobianData] = []
    missing, in_vain = size, 0
    while missing > 0:
        links, parameters = _manipulators(missing, random, dynamics)
        found.extend(
            data for data in _tried(links, parameters, random, poses, threshold) if len(data.jacobian)
        )
        left = size - sum(len(data.jacobian) for data in found)
        in_vain = 0 if left < missing else in_vain + missing * poses
        if in_vain >= _IN_VAIN:
            _require_any(dynamics, threshold)
            in_vain = 0
        missing = left
    return _joined(found)


def _require_any(dynamics: bool, threshold: float) -> None:
    """Refuse a threshold that none of 20 000 other poses passes, 50 for each of 400 manipulators."""
    random = torch.Generator().manual_seed(0)
    found = _tried(*_manipulators(400, random, dynamics), random, 50, threshold)
    if not any(len(data.jacobian) for data in found):
        raise ValueError(
            f"threshold is {threshold}; of 20000 poses none has so even an inertia: a smaller one is needed"
        )


def _tried(
    links: Tensor, dynamics: DynamicParameters | None, random: torch.Generator, poses: int, threshold: float
) -> Iterator[JacobianData]:
    """Try manipulators with poses until each has one that is kept, or has had enough of them."""
    left = torch.arange(len(links))
    for _ in range(poses):
        if not len(left):
            return
        position, angles = _poses(len(left), random)
        reach = reachable(links[left], position)
        tried = left[reach]
        samples = Samples(
            links[tried],
            position[reach],
            angles[reach],
            None if dynamics is None else dynamics.rows(tried),
        )
        kept, data = _kept(samples, threshold)
        yield data
        still = torch.ones(len(links), dtype=torch.bool)
        still[tried[kept]] = False
        left = left[still[left]]


def _kept(samples: Samples, threshold: float) -> tuple[Tensor, JacobianData]:
    q, _ = inverse(samples.links, spatial.pose(samples.rotation(), samples.position))
    placed = frames(samples.links, q)
    J = placed.jacobian()
    if samples.dynamics is None:
        return torch.ones(len(J), dtype=torch.bool), JacobianData(samples, J)
    kept = ratio_at(placed, samples.dynamics) > threshold
    return kept, JacobianData(samples.rows(kept), J[kept])


def _manipulators(
    count: int, random: torch.Generator, dynamics: bool
) -> tuple[Tensor, DynamicParameters | None]:
    links = LARGEST_LENGTH * _uniform(random, count, 4)
    if not dynamics:
        return links, None
    shapes = {name: (count, 6, 3) if name in ("centre", "inertia") else (count, 6) for name in RANGES}
    shapes["coulomb"] = (count, 6, 2)
    drawn = {
        name: low + (high - low) * _uniform(random, *shapes[name]) for name, (low, high) in RANGES.items()
    }
    drawn["coulomb"][..., 1] *= -1
    return links, DynamicParameters(**drawn)


def _poses(count: int, random: torch.Generator) -> tuple[Tensor, Tensor]:
    return HALF_SIDE * (2 * _uniform(random, count, 3) - 1), math.tau * _uniform(random, count, 3)


def _uniform(random: torch.Generator, *shape: int) -> Tensor:
    return torch.rand(*shape, generator=random, dtype=torch.float64)


_Data = TypeVar("_Data", ConfidenceData, JacobianData)


def _in_chunks(
    chunk: Callable[[int, torch.Generator], _Data], count: int, seed: int, workers: int
) -> list[_Data]:
    count, seed = checks.whole(count, "count", least=1, most=_MOST), checks.seed(seed)
    if (workers := checks.whole(workers, "workers")) == 0:
        raise ValueError("workers is 0; a number of processes, or -1 for all cores, is needed")
    sizes = [min(_CHUNK, count - start) for start in range(0, count, _CHUNK)]
    seeds = np.random.SeedSequence(seed).generate_state(len(sizes), np.uint64)
    calls = (
        joblib.delayed(chunk)(size, torch.Generator().manual_seed(int(own)))
        for size, own in zip(sizes, seeds, strict=True)
    )
    return list(joblib.Parallel(n_jobs=workers)(calls))


def _joined(parts: Sequence[Any]) -> Any:
    """Join the tensors of like tuples, one after the other."""
    first = parts[0]
    if first is None:
        return None
    if isinstance(first, Tensor):
        return torch.cat(list(parts))
    return type(first)(*map(_joined, zip(*parts, strict=True)))


# ---- columns ---------------------------------------------------------------------------------------


def features(samples: Samples) -> Float64[Tensor, "n columns"]:
    """Return samples in the paper's columns: 96 with dynamic parameters (`COLUMNS`), 24 without.

    Raises
    ------
    TypeError
        If `samples` are none.
    """
    checks.instance(samples, "samples", Samples)
    d3, d4, a2, a3 = samples.links.unbind(-1)
    nothing = torch.zeros_like(d3)
    rows = [nothing, nothing, d3, d4, nothing, nothing, nothing, a2, a3, *[nothing] * 3]
    rows += [torch.full_like(d3, twist) for twist in TWISTS]
    parameters = () if samples.dynamics is None else (part.flatten(1) for part in samples.dynamics)
    return torch.cat([torch.stack(rows, -1), *parameters, samples.position, samples.angles], -1)


@dataclass(frozen=True)
class Scaling:
    """A shift and a scale for each column, fitted to a training set.

    Attributes
    ----------
    centre
        (columns) what becomes zero.
    unit
        (columns) what becomes one beyond it; 1 where a column is constant, which becomes zero.
    """

    centre: Float64[Tensor, " columns"]
    unit: Float64[Tensor, " columns"]

    @classmethod
    @checks.arguments(train=checks.Instance(Tensor))
    def to_unit_deviation(cls, train: Float64[Tensor, "n columns"]) -> Scaling:
        """Scale to mean 0 and standard deviation 1."""
        return cls(train.mean(0), _or_one(train.std(0, correction=0), train))

    @classmethod
    @checks.arguments(train=checks.Instance(Tensor))
    def to_range(cls, train: Float64[Tensor, "n columns"]) -> Scaling:
        """Scale the smallest value to −1 and the largest to 1."""
        low, high = train.amin(0), train.amax(0)
        return cls((low + high) / 2, _or_one((high - low) / 2, train))

    def apply(self, x: Float64[Tensor, "n columns"]) -> Float64[Tensor, "n columns"]:
        """Scale rows."""
        return (x - self.centre) / self.unit

    def undo(self, x: Float64[Tensor, "n columns"]) -> Float64[Tensor, "n columns"]:
        """Return rows as they were before they were scaled."""
        return x * self.unit + self.centre


def _or_one(unit: Tensor, train: Tensor) -> Tensor:
    # The mean of equal numbers may be off by rounding, and so may their deviation.
    return torch.where(train.amax(0) > train.amin(0), unit, 1.0)


CSV_SETS = ("conf", "conf_dyna", "jacob", "jacob0")
"""Names of the paper's sets, confidence labels, the same with dynamic parameters, Jacobians in the axes of
the tool, and of the base."""


@checks.arguments(folder=checks.path)
def write_csv(
    folder: Path | str,
    train: ConfidenceData | JacobianData,
    test: ConfidenceData | JacobianData,
    frame: Literal["world", "tool"] = "tool",
) -> tuple[Path, ...]:
    """Write a set under the names of the paper's files, without headings: features and labels of both parts.

    The files begin with ``conf`` for confidence labels, with ``jacob`` for Jacobians in the axes of the tool
    and with ``jacob0`` for those in the axes of the base, written row by row.

    Parameters
    ----------
    folder
        Where to; it is made if it is missing, and older files of these names are replaced.
    train, test
        The parts.
    frame
        Axes of the Jacobians.

    Returns
    -------
    The four files. Beside them stands a list of their checksums, such as ``jacob.sha256``, which is written
    last, so that :func:`read_csv` and ``sha256sum --check`` notice files of two different sets.

    Raises
    ------
    ValueError
        If one part has Jacobians and the other one labels, one has dynamic parameters and the other none, or
        the frame is unknown.
    TypeError
        If a part is no data.
    """
    for argument, value in (("train", train), ("test", test)):
        Instance((ConfidenceData, JacobianData))(value, argument)
    checks.choice(frame, "frame", ("world", "tool"))
    if type(train) is not type(test) or (train.samples.dynamics is None) != (test.samples.dynamics is None):
        raise ValueError("train and test are sets of different kinds")
    if isinstance(train, ConfidenceData):
        name = "conf" if train.samples.dynamics is None else "conf_dyna"
    else:
        name = "jacob0" if frame == "world" else "jacob"
    files: dict[str, str] = {}
    for part, data in (("test", test), ("train", train)):
        labels = (
            data.reachable[:, None] if isinstance(data, ConfidenceData) else data.in_frame(frame).flatten(1)
        )
        for kind, values in (("feature", features(data.samples)), ("label", labels)):
            text = io.StringIO()
            np.savetxt(
                text, values.numpy(), fmt="%d" if values.dtype == torch.bool else "%.17g", delimiter=","
            )
            files[_file(name, kind, part)] = text.getvalue()
    return store.write_set(folder, f"{name}.sha256", files)


@checks.arguments(folder=checks.path)
def read_csv(folder: Path | str, name: str) -> dict[str, tuple[Array, Array]]:
    """Read a set that :func:`write_csv` wrote.

    Parameters
    ----------
    folder
        Where it lies.
    name
        One of `CSV_SETS`.

    Returns
    -------
    Features (n, columns) and labels (n, k) of ``"train"`` and of ``"test"``.

    Raises
    ------
    FileNotFoundError
        If a file or the list of checksums is missing, as after a writing that was stopped.
    ValueError
        If a file is not the one that was written last, or the name is unknown.
    """
    checks.choice(name, "name", CSV_SETS)
    texts = store.read_set(folder, f"{name}.sha256")
    read: dict[str, tuple[Array, Array]] = {}
    for part in ("train", "test"):
        features_, labels = (
            np.loadtxt(io.BytesIO(texts[_file(name, kind, part)]), delimiter=",", ndmin=2)
            for kind in ("feature", "label")
        )
        read[part] = (features_, labels)
    return read


def _file(name: str, kind: str, part: str) -> str:
    prefix, _, dynamic = name.partition("_")
    return f"{prefix}_{kind}{'_dyna' if dynamic else ''}_{part}.csv"
