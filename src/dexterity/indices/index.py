"""A dexterity index: a measure with the frame, the rows and the limits that give it a meaning.

Examples
--------
Four joints of a SCARA arm move the tool along x, y and z and about z; over these rows w = a₁ a₂ |sin q₂|:

>>> import math
>>> import dexterity as dx
>>> rows = [{"a": 0.3}, {"a": 0.25, "alpha": math.pi}, {"kind": "prismatic"}, {}]
>>> scara = dx.Chain.from_dh(rows, name="scara")
>>> w = dx.indices.Index("w", "geometric", rows=("vx", "vy", "vz", "wz"))
>>> round(float(w(scara, [0.1, 1.0, 0.05, 0.2])), 7)
0.0631103
>>> w
Index('manipulability', 'geometric', rows=('vx', 'vy', 'vz', 'wz'))
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence
from dataclasses import KW_ONLY, dataclass
from types import MethodType
from typing import Any, get_args

import torch
from jaxtyping import Float64
from torch import Tensor

from dexterity import checks, spatial
from dexterity.chain import Chain
from dexterity.indices.jacobians import with_finite_powers
from dexterity.indices.measure import Frame, Measure, Situation
from dexterity.indices.registry import describe
from dexterity.indices.rows import Rows, direction_of, one_dimensional, row_numbers, shortest_name
from dexterity.spatial import TensorLike
from dexterity.spatial.values import on_cpu

__all__ = ["Frame", "Index"]


@dataclass(frozen=True, repr=False)
class Index:
    """A dexterity index together with the frame and the limits that give it a meaning.

    Parameters
    ----------
    name
        Name or alias of a measure, see :func:`dexterity.indices.names`: ``"manipulability"`` or ``"w"``,
        ``"kinematic_conditioning"`` or ``"kci"``, and so on. Kept as the name in full.
    frame
        Which Jacobian: ``"spatial"`` (the papers'), ``"body"`` or ``"geometric"``. The manipulability of
        all six rows is the same in all three; KCI in the body frame is that in the geometric one while the
        tool rates are equal within each block of three, and in the spatial frame it is another.
    joint_rates
        n largest joint rates, [rad/s] or [m/s]; those of the chain by default, and 0 locks a joint. They
        scale the columns of the Jacobian, so that the value is not that of the bare Jacobian.
    tool_rates
        6 largest tool rates, [m/s] and [rad/s], in the axes of the frame; 1 by default.
    rows
        Rows of the Jacobian that count: ``"full"``, ``"translational"``, ``"rotational"``, or a selection by
        numbers from 0 or by the names vx, vy, vz, wx, wy, wz, in the axes of the frame. Velocities along
        rows that are left out are free.
    direction
        For a measure along a direction: one number for each row, or a row's name.
    characteristic_length
        Length [m] that velocities are divided by, so that they compare with angular velocities.
    joint_noise
        For a measure of accuracy: n standard deviations of the joint values, [rad] or [m]; by default 1 for
        each joint that is not locked.

    Raises
    ------
    ValueError
        If the name, the frame or a row is unknown, a number is out of its range or not finite, the
        direction does not fit the rows, or the measure needs a direction and there is none.
    TypeError
        If rates, a length or noise are no real numbers.
    """

    name: str
    frame: Frame = "spatial"
    joint_rates: tuple[float, ...] | None = None
    tool_rates: tuple[float, ...] | None = None
    _: KW_ONLY
    rows: Rows = "full"
    direction: tuple[float, ...] | str | None = None
    characteristic_length: float | None = None
    joint_noise: tuple[float, ...] | None = None

    def __post_init__(self) -> None:
        keep = object.__setattr__
        keep(self, "name", describe(self.name).name)
        keep(self, "frame", checks.choice(self.frame, "frame", get_args(Frame)))
        keep(self, "rows", shortest_name(row_numbers(self.rows)))
        for field in ("joint_rates", "tool_rates", "joint_noise"):
            if (values := getattr(self, field)) is not None:
                keep(self, field, one_dimensional(values, field))
        _require_not_negative(self.joint_rates, "joint_rates")
        _require_not_negative(self.joint_noise, "joint_noise")
        if self.tool_rates is not None and len(self.tool_rates) != 6:
            raise ValueError(f"tool_rates has shape ({len(self.tool_rates)},); (6,) is needed")
        if self.tool_rates is not None and min(self.tool_rates) <= 0:
            raise ValueError(f"tool_rates must be positive: {list(self.tool_rates)}")
        if self.characteristic_length is not None:
            keep(self, "characteristic_length", _length(self.characteristic_length))
        self._check_direction()

    def _check_direction(self) -> None:
        needed = "direction" in self.measure.needs
        if self.direction is None and needed:
            raise ValueError(
                f"direction is missing: the {self.measure.title.lower()} is that along a direction; give one "
                "number for each row, or a row's name such as direction='vz'"
            )
        if self.direction is not None and not needed:
            raise ValueError(f"direction is {self.direction!r}; {self.measure.name} has none")
        if self.joint_noise is not None and self.measure.columns != "noise":
            raise ValueError(f"joint_noise is {self.joint_noise}; {self.measure.name} depends on none")
        if self.direction is not None:
            object.__setattr__(self, "direction", direction_of(self.direction, self.row_numbers))

    def __repr__(self) -> str:
        values = {field.name: getattr(self, field.name) for field in dataclasses.fields(self)[2:]}
        defaults = {field.name: field.default for field in dataclasses.fields(self)[2:]}
        given = "".join(f", {key}={value!r}" for key, value in values.items() if value != defaults[key])
        return f"Index({self.name!r}, {self.frame!r}{given})"

    @property
    def measure(self) -> Measure:
        """Measure: title, formula, unit, bounds, meaning, and how it is computed."""
        return describe(self.name)

    @property
    def title(self) -> str:
        """Title of the measure, with the rows where they are not all six."""
        rows = self.rows if isinstance(self.rows, str) else " ".join(map(str, self.rows))
        return self.measure.title if rows == "full" else f"{self.measure.title}, {rows}"

    @property
    def row_numbers(self) -> tuple[int, ...]:
        """Numbers, from 0, of the rows that count."""
        return row_numbers(self.rows)

    @property
    def row_scales(self) -> tuple[float, ...]:
        """Largest rates of the six rows, times the characteristic length for velocities."""
        rates = self.tool_rates or (1.0,) * 6
        length = self.characteristic_length or 1.0
        return tuple(rate * (length if row < 3 else 1.0) for row, rate in enumerate(rates))

    def column_weights(self, rates: Sequence[float]) -> tuple[float, ...]:
        """Return what the columns of the Jacobian are multiplied by, for a chain with such joint rates.

        Raises
        ------
        ValueError
            If the rates or the noise of the index do not fit the chain.
        """
        rates = one_dimensional(rates, "rates")
        own = rates if self.joint_rates is None else self.joint_rates
        for values, name in ((self.joint_rates, "joint_rates"), (self.joint_noise, "joint_noise")):
            if values is not None and len(values) != len(rates):
                raise ValueError(f"{name} has shape ({len(values)},); ({len(rates)},) is needed")
        if self.measure.columns == "rates":
            return own
        if self.joint_noise is not None:
            return self.joint_noise
        return tuple(float(rate > 0) for rate in own)

    @checks.arguments(chain=checks.Instance(Chain))
    def normalised_jacobian(
        self, chain: Chain, q: TensorLike, rows: Sequence[int] | None = None
    ) -> Float64[Tensor, "*batch m n"]:
        """Return the Jacobian of the frame, its rows chosen and scaled, its columns weighed.

        Parameters
        ----------
        chain
            The robot.
        q
            (..., n) joint values, [rad] or [m].
        rows
            Numbers of the rows; those of the index by default.

        Raises
        ------
        ValueError
            If `q` or the rates do not fit the chain.
        """
        numbers = checks.OrNone(checks.Each(checks.Whole(0, 5)))(rows, "rows")
        if numbers == ():
            raise ValueError("rows is empty; at least one row is needed")
        return self._jacobian_function(chain, numbers or self.row_numbers)(q)

    def _jacobian_function(self, chain: Chain, rows: tuple[int, ...]) -> Callable[[TensorLike], Tensor]:
        weights = _constant(self.column_weights(chain.rates.tolist()))
        scales = _constant([self.row_scales[row] for row in rows])[:, None]
        jacobian = getattr(chain, f"{self.frame}_jacobian")
        every = rows == tuple(range(6))

        def value(q: TensorLike) -> Tensor:
            J = jacobian(q)
            J = J if every else torch.stack([J[..., row, :] for row in rows], dim=-2)
            return J * weights.to(J.device) / scales.to(J.device)

        return value

    @torch.inference_mode(False)  # its constants serve in every mode
    def bind(self, chain: Chain) -> Callable[[TensorLike], Float64[Tensor, "*batch"]]:
        """Return the index as a function of the chain's joint values: (..., n) → (...).

        It is differentiable by torch as often as one likes, and works on batches of any size in pieces.

        Raises
        ------
        ValueError
            If the rates or the noise do not fit the chain, or the chain lacks what the measure needs.
        TypeError
            If `chain` is no chain.
        """
        if not isinstance(chain, Chain):
            raise TypeError(f"chain is {chain!r}; a Chain is needed")
        value = self._function(chain)
        return value if torch.compiler.is_compiling() else _Bound(self, chain, value).value

    def _function(self, chain: Chain) -> Callable[[TensorLike], Tensor]:
        measure = self.measure
        jacobian = self._jacobian_function(chain, self.row_numbers)
        if "inertias" in measure.needs and chain.inertias is None:
            raise ValueError(
                f"{chain.name} has no inertias, which the {measure.name.replace('_', ' ')} needs"
            )
        direction = _constant(self.direction) if isinstance(self.direction, tuple) else None
        moving = _constant(self.column_weights(chain.rates.tolist())) > 0

        def of_piece(q: Tensor) -> Tensor:
            along = None if direction is None else direction.to(q.device)
            return measure.evaluate(jacobian(q), Situation(chain, q, moving.to(q.device), along))

        def value(q: TensorLike) -> Tensor:
            q = spatial.require_joints(spatial.to_float64(q, "q"), chain.joints, "chain")
            q = with_finite_powers(q, "q")
            pieces = [of_piece(piece) for piece in q.reshape(-1, chain.joints).split(_PIECE)]
            return (pieces[0] if len(pieces) == 1 else torch.cat(pieces)).reshape(q.shape[:-1])

        return value

    def __call__(self, chain: Chain, q: TensorLike) -> Float64[Tensor, "*batch"]:
        """Value of the index of a chain at joint values (..., n), [rad] or [m].

        Raises
        ------
        ValueError
            As :meth:`bind`, or if `q` does not fit the chain or is not finite.
        """
        return self.bind(chain)(q)


class _Bound:
    """An index with its chain. What is bound is a method of it: pickle takes methods, and no closures."""

    def __init__(self, index: Index, chain: Chain, value: Callable[[TensorLike], Tensor]) -> None:
        self._arguments = index, chain

        def method(_: object, q: TensorLike) -> Tensor:
            return value(q)

        # torch.compile counts what it compiled by code, and gives up after eight: each index has its own.
        method.__code__ = method.__code__.replace()
        method.__name__ = "value"
        self._method = method

    @property
    def value(self) -> Callable[[TensorLike], Tensor]:
        return MethodType(self._method, self)

    def __repr__(self) -> str:
        index, chain = self._arguments
        return f"{index!r} of {chain.name!r}"

    def __reduce__(self) -> tuple[Any, ...]:
        return _bound, self._arguments


def _bound(index: Index, chain: Chain) -> _Bound:
    value: Any = index.bind(chain)
    bound: _Bound = value.__self__
    return bound


_PIECE = 2048  # configurations worked on at a time, so that no more Jacobians lie in memory


def _constant(values: Sequence[float]) -> Tensor:
    """Return numbers on the CPU, whatever torch's default device is."""
    return torch.tensor(values, dtype=torch.float64, device="cpu")


def _require_not_negative(values: tuple[float, ...] | None, name: str) -> None:
    if values is not None and any(value < 0 for value in values):
        what = "rate" if name == "joint_rates" else "value"
        raise ValueError(f"{name} holds a negative {what}: {list(values)}")


def _length(value: float) -> float:
    if isinstance(value, bool | str | complex) or value is None:
        raise TypeError(f"characteristic_length is {value!r}; a number is needed")
    length = on_cpu(value, "characteristic_length")
    if length.ndim != 0 or not 0 < float(length) < math.inf:
        raise ValueError(f"characteristic_length is {value!r}; a positive number is needed")
    return float(length)
