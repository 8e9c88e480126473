"""A reach map: which poses a chain reaches, how well, with a configuration for each, and what may be missed.

Each pose that is said to be reached has its configuration in the map, so that anybody can check it by forward
kinematics; :meth:`ReachMap.load` does so. Poses that are said to be out of reach rest on the method: see
:attr:`ReachMap.missed`.

Examples
--------
>>> import dexterity as dx
>>> from dexterity import reach
>>> puma = dx.robots.puma560()
>>> grid = reach.box([0.2, 0.0, -0.4], [0.8, 0.0, 0.4], spacing=0.2)
>>> surveyed = reach.survey(puma, grid, reach.rotations(24), index="w")
>>> surveyed.method, surveyed.missed.upper
('closed form', 0.0)
>>> surveyed.share.shape, float(surveyed.share.max())
(torch.Size([20]), 1.0)
"""

from __future__ import annotations

import dataclasses
import math
import os
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple, get_args

import numpy as np
import torch
from jaxtyping import Bool, Float64, Int64
from scipy.spatial import cKDTree
from torch import Tensor

from dexterity import checks, sealed, spatial, store
from dexterity.chain import Chain
from dexterity.descent import RowFrame, TwistRows
from dexterity.reach.inverse_map import InverseReachMap
from dexterity.reach.missed import Missed
from dexterity.spatial import TensorLike
from dexterity.spatial.tolerances import LIMIT
from dexterity.spatial.values import on_cpu

__all__ = ["Nearest", "ReachMap", "ReachMapFileError"]

_KIND, _VERSION = "reach map", 2
_FIELDS = {
    "reached": torch.bool, "examined": torch.bool, "count": torch.int64, "hits": torch.int64,
    "best": torch.float64,
}  # fmt: skip
_MISS = 1e-6  # by which forward kinematics of a stored configuration may miss its pose, [m] and [rad]


class ReachMapFileError(ValueError):
    """A file holds no reach map, not all of one, or one that contradicts itself."""


class Nearest(NamedTuple):
    """Poses of a map that are nearest to others.

    Attributes
    ----------
    position, rotation
        (...) numbers of the nearest position and of the nearest rotation.
    distance, angle
        (...) how far they are [m] and [rad].
    """

    position: Tensor
    rotation: Tensor
    distance: Tensor
    angle: Tensor


@dataclass(frozen=True, eq=False)
class ReachMap:
    """What a chain reaches of p positions with r rotations each.

    Attributes
    ----------
    chain
        The chain.
    positions, rotations
        (p, 3) positions [m] and (r, 3, 3) rotations of the tool, in the chain's world frame.
    reached
        (p, r) whether the pose is in reach within the limits, or a pose of its cell where `cell` is not 0.
    examined
        (p, r) whether the pose has been looked at; all of them unless a survey was interrupted.
    count
        (p, r) number of different configurations that were found, copies by full turns counted once. There
        are infinitely many where the chain has more joints than the pose has conditions.
    hits
        (p, r) how many independent starts of a search, or draws of a sampling, ended there.
    best
        (p, r) best index of the configurations that were found; 1 without an index, NaN out of reach.
    configurations
        (p, r, n) configuration with the best index, [rad] or [m]; NaN out of reach.
    method
        How they were found: ``"closed form"``, ``"search"`` or ``"sampling"``.
    rows
        Components of the tool's pose that fit.
    frame
        Axes of the rows, ``"body"`` for those of the tool or ``"geometric"`` for those of the world.
    cell
        Half the side [m] of a position's cell and half the width [rad] of a rotation's, from a sampling;
        zeros where poses are met exactly.
    index
        The index, as text; None without one.
    larger_is_better
        Whether the best index is the largest.
    missed
        What may be in reach although the map does not say so.
    """

    chain: Chain
    positions: Float64[Tensor, "p 3"]
    rotations: Float64[Tensor, "r 3 3"]
    reached: Bool[Tensor, "p r"]
    examined: Bool[Tensor, "p r"]
    count: Int64[Tensor, "p r"]
    hits: Int64[Tensor, "p r"]
    best: Float64[Tensor, "p r"]
    configurations: Float64[Tensor, "p r n"]
    method: str
    rows: tuple[int, ...]
    frame: RowFrame
    cell: tuple[float, float]
    index: str | None
    larger_is_better: bool
    missed: Missed

    def __post_init__(self) -> None:
        p, r, n = len(self.positions), len(self.rotations), self.chain.joints
        shapes = dict.fromkeys(_FIELDS, (p, r)) | {
            "positions": (p, 3), "rotations": (r, 3, 3), "configurations": (p, r, n)
        }  # fmt: skip
        for name, shape in shapes.items():
            if tuple(getattr(self, name).shape) != shape:
                raise ValueError(f"{name} has shape {tuple(getattr(self, name).shape)}; {shape} is needed")
        contradictions = {
            "reached and not examined": self.reached & ~self.examined,
            "reached without a configuration": self.reached & ~self.configurations.isfinite().all(-1),
            "reached and counted as 0, or the other way round": self.reached != (self.count > 0),
            "reached without an index, or the other way round": self.reached == self.best.isnan(),
        }
        for what, holds in contradictions.items():
            if holds.any():
                raise ValueError(f"{int(holds.sum())} poses are {what}")

    def __repr__(self) -> str:
        share = float(self.reached.sum()) / max(1, int(self.examined.sum()))
        return (
            f"ReachMap({self.chain.name!r}, {len(self.positions)} positions × {len(self.rotations)} "
            f"rotations, {self.method}, {100 * share:.1f} % reached)"
        )

    # ---- what it says --------------------------------------------------------------------------------

    @property
    def finished(self) -> bool:
        """Whether all poses have been looked at."""
        return bool(self.examined.all())

    @property
    def share(self) -> Float64[Tensor, " p"]:
        """Share of the rotations that a position is reached with (p), of those that have been looked at."""
        return self.reached.sum(1) / self.examined.sum(1).clamp(min=1).double()

    @property
    def dexterous(self) -> Bool[Tensor, " p"]:
        """Whether a position is reached with all rotations (p)."""
        return self.reached.all(1)

    @property
    def best_at_position(self) -> Float64[Tensor, " p"]:
        """Best index over the rotations (p), NaN where a position is out of reach."""
        sign = 1.0 if self.larger_is_better else -1.0
        best = sign * (sign * self.best).nan_to_num(nan=-math.inf, posinf=math.inf, neginf=-math.inf).amax(1)
        return torch.where(self.reached.any(1), best, math.nan)

    @property
    def capability(self) -> Float64[Tensor, " p"]:
        """Mean of the best index over the rotations that were looked at (p), 0 for those out of reach.

        Raises
        ------
        ValueError
            If a smaller index is better, so that 0 would be the best.
        """
        if not self.larger_is_better:
            raise ValueError(
                f"index is {self.index}, of which smaller is better; a capability has no meaning"
            )
        return self.best.nan_to_num(nan=0.0).sum(1) / self.examined.sum(1).clamp(min=1).double()

    def poses(self) -> Float64[Tensor, "p r 4 4"]:
        """Return all poses of the tool."""
        return spatial.pose(self.rotations, self.positions[:, None])

    def summary(self) -> dict[str, Any]:
        """Return what the map says in a few numbers, by name."""
        examined, reached = int(self.examined.sum()), int(self.reached.sum())
        best = self.best[self.reached]
        return {
            "robot": self.chain.name,
            "method": self.method,
            "poses": self.reached.numel(),
            "poses looked at": examined,
            "poses reached": reached,
            "share of poses reached": reached / max(1, examined),
            "poses missed, estimate": self.missed.estimate,
            "poses missed, at most (95 %)": self.missed.upper,
            "share of configurations missed, at most (95 %)": self.missed.share,
            "positions reached": int(self.reached.any(1).sum()),
            "positions reached with all rotations": int(self.dexterous.sum()),
            "index": self.index,
            "best index": float(best.max() if self.larger_is_better else best.min()) if reached else None,
            "median index of reached poses": float(best.median()) if reached else None,
            "finished": self.finished,
            "basis": self.missed.basis,
        }

    def __str__(self) -> str:
        width = max(map(len, self.summary()))
        return "\n".join(f"{name:{width}}  {_said(value)}" for name, value in self.summary().items())

    # ---- parts ---------------------------------------------------------------------------------------

    def where(self, positions: TensorLike) -> ReachMap:
        """Return the map of some positions.

        Parameters
        ----------
        positions
            (p,) truth values, or numbers of positions from 0.

        Raises
        ------
        ValueError
            If they do not fit, or none is chosen.
        """
        try:
            chosen = torch.as_tensor(np.asarray(positions))
        except (TypeError, ValueError) as error:
            raise TypeError(f"positions cannot be read as an array: {error}") from error
        if chosen.is_floating_point() or chosen.is_complex():
            raise TypeError(f"positions holds {chosen.dtype}; truth values or whole numbers are needed")
        if chosen.dtype == torch.bool:
            if chosen.shape != (len(self.positions),):
                raise ValueError(
                    f"positions has shape {tuple(chosen.shape)}; ({len(self.positions)},) is needed"
                )
            chosen = chosen.nonzero()[:, 0]
        chosen = chosen.long().reshape(-1)
        if not len(chosen) or chosen.min() < 0 or chosen.max() >= len(self.positions):
            raise ValueError(
                f"positions chooses {len(chosen)} of {len(self.positions)}; one or more are needed"
            )
        parts = {name: getattr(self, name)[chosen] for name in (*_FIELDS, "positions", "configurations")}
        return dataclasses.replace(self, **parts)

    def slice(self, axis: str, value: float) -> ReachMap:
        """Return the map of the positions in a plane across x, y or z, the one nearest to a coordinate [m].

        Raises
        ------
        ValueError
            If the axis is none of these, or the coordinate is not finite.
        """
        number = ("x", "y", "z").index(checks.choice(axis, "axis", ("x", "y", "z")))
        away = (self.positions[:, number] - checks.real(value, "value")).abs()
        return self.where(away <= away.min() + 1e-9)

    def nearest(self, T_world_tool: TensorLike) -> Nearest:
        """Return the poses of the map nearest to others (..., 4, 4), position and rotation by themselves.

        Raises
        ------
        ValueError
            If a pose is not rigid or not finite.
        """
        T = spatial.require_rigid(on_cpu(T_world_tool, "T_world_tool"), "T_world_tool").detach()
        distance, position = cKDTree(self.positions.numpy()).query(T[..., :3, 3].numpy())
        # The Frobenius distance of rotations grows with the angle between them: 2√2 sin(angle / 2).
        chord, rotation = cKDTree(self.rotations.flatten(1).numpy()).query(T[..., :3, :3].flatten(-2).numpy())
        angle = 2 * np.arcsin(np.clip(chord / (2 * math.sqrt(2)), 0, 1))
        return Nearest(*(torch.as_tensor(x) for x in (position, rotation, distance, angle)))

    def inverted(self) -> InverseReachMap:
        """Return the poses of the base from which the poses of the map are reached."""
        return InverseReachMap(self)

    def compared(self, other: ReachMap) -> dict[str, float]:
        """Return how another map of the same poses differs, as numbers of poses by name.

        Raises
        ------
        ValueError
            If the maps have different positions or rotations.
        """
        checks.instance(other, "other", ReachMap)
        pairs = ((self.positions, other.positions), (self.rotations, other.rotations))
        if not all(a.shape == b.shape and torch.equal(a, b) for a, b in pairs):
            raise ValueError(f"other is {other!r}; a map of the same positions and rotations is needed")
        both = self.reached & other.reached
        ratio = other.best[both] / self.best[both]
        return {
            "reached in both": int(both.sum()),
            "reached here only": int((self.reached & ~other.reached).sum()),
            "reached there only": int((other.reached & ~self.reached).sum()),
            "reached in neither": int((~self.reached & ~other.reached).sum()),
            "median ratio of the index, there to here": float(ratio.median()) if len(ratio) else math.nan,
        }

    # ---- files ---------------------------------------------------------------------------------------

    @checks.arguments(path=checks.path)
    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the map to a file, by custom with the ending ``.npz``, whole or not at all.

        Raises
        ------
        OSError
            If the file cannot be written.
        """
        chain = self.chain
        header = {
            "format": "dexterity-reach-map", "version": _VERSION, "robot": chain.name,
            "joint_names": list(chain.joint_names), "method": self.method, "rows": list(self.rows),
            "frame": self.frame, "cell": list(self.cell), "index": self.index,
            "larger_is_better": self.larger_is_better, "missed": dataclasses.asdict(self.missed),
        }  # fmt: skip
        names = (*_FIELDS, "positions", "rotations", "configurations")
        arrays = {name: getattr(self, name).numpy() for name in names}
        arrays |= {name: getattr(chain, name).numpy() for name in _CHAIN}
        arrays |= {name: part.numpy() for name, part in zip(_INERTIAS, chain.inertias or (), strict=False)}
        store.write_atomically(path, sealed.packed(_KIND, header, arrays))

    @classmethod
    @checks.arguments(path=checks.path)
    def load(cls, path: str | os.PathLike[str]) -> ReachMap:
        """Return the map of a file; each configuration is put through forward kinematics.

        Raises
        ------
        FileNotFoundError
            If there is no such file.
        ReachMapFileError
            If the file is not whole, holds no reach map or one of a later version, or contradicts itself: a
            configuration that leaves the limits or misses its pose, or numbers that do not fit together.
        """
        try:
            content = store.read_bytes(path)
        except ValueError as error:
            raise ReachMapFileError(str(error)) from error
        try:
            header, arrays = sealed.unpacked(content, _KIND)
            if header.get("version") != _VERSION:
                raise ValueError(f"it has version {header.get('version')}; this release reads {_VERSION}")
            loaded = cls(**_parts(header, arrays))
            loaded._require_witnesses()
        except sealed.SealedFileError as error:
            raise ReachMapFileError(f"{os.fspath(path)} {error}") from error
        except (KeyError, TypeError, ValueError, AttributeError) as error:
            raise ReachMapFileError(f"{os.fspath(path)} holds no reach map: {error}") from error
        return loaded

    def _require_witnesses(self) -> None:
        """Refuse a map whose configurations do not reach its poses."""
        at = self.reached.nonzero()
        q = self.configurations[self.reached]
        lower, upper = self.chain.lower - 1e3 * LIMIT, self.chain.upper + 1e3 * LIMIT
        if ((q < lower) | (q > upper)).any():
            raise ValueError("a configuration leaves the limits of the chain")
        T = self.chain.forward(q)
        shift, turn = self._misses(T, at[:, 0], at[:, 1])
        side, angle = self.cell
        if (shift > side + _MISS).any() or (turn > angle + _MISS).any():
            raise ValueError("a configuration misses the pose that it stands for")

    def _misses(self, T: Tensor, position: Tensor, rotation: Tensor) -> tuple[Tensor, Tensor]:
        """Return the largest components of translations (k) and rotation vectors (k) that remain."""
        wanted = spatial.pose(self.rotations[rotation], self.positions[position])
        # Cells of positions are cubes along the axes of the world.
        axes = TwistRows(self.rows, self.frame if max(self.cell) == 0 else "geometric")
        twist = axes.remaining(T, wanted).abs()
        parts = [[row for row in self.rows if (row < 3) is linear] for linear in (True, False)]
        linear, angular = (twist[:, rows].amax(1) if rows else twist.new_zeros(len(twist)) for rows in parts)
        return linear, twist[:, 3:].norm(dim=1) if max(self.cell) > 0 else angular


_CHAIN = ("screws", "home", "lower", "upper", "rates")
_INERTIAS = ("masses", "centres of mass", "inertias")


def _parts(header: Mapping[str, Any], arrays: Mapping[str, np.ndarray]) -> dict[str, Any]:
    """Arguments of a map out of a file."""
    if header.get("format") != "dexterity-reach-map":
        raise ValueError(f"its header says {header.get('format')!r}")
    tensors = {name: torch.from_numpy(array.copy()) for name, array in arrays.items()}
    inertias = [tensors[name] for name in _INERTIAS if name in tensors]
    chain = Chain(
        tensors["screws"],
        tensors["home"],
        name=header["robot"],
        joint_names=header["joint_names"],
        lower=tensors["lower"],
        upper=tensors["upper"],
        rates=tensors["rates"],
        inertias=(inertias[0], inertias[1], inertias[2]) if inertias else None,
    )
    wanted = {**_FIELDS, **dict.fromkeys(("positions", "rotations", "configurations"), torch.float64)}
    for name, dtype in wanted.items():
        if tensors[name].dtype != dtype:
            raise ValueError(f"{name} is {tensors[name].dtype}; {dtype} is needed")
    return {
        "chain": chain,
        **{name: tensors[name] for name in wanted},
        "rotations": spatial.require_rotation(tensors["rotations"], "rotations"),
        "method": checks.name(header["method"], "method"),
        "rows": tuple(checks.whole(row, "rows", least=0, most=5) for row in header["rows"]),
        "frame": checks.choice(header["frame"], "frame", get_args(RowFrame)),
        "cell": tuple(checks.real(width, "cell", least=0.0) for width in header["cell"]),
        "index": None if header["index"] is None else checks.name(header["index"], "index"),
        "larger_is_better": checks.flag(header["larger_is_better"], "larger_is_better"),
        "missed": Missed(**header["missed"]),
    }


def _said(value: Any) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)
