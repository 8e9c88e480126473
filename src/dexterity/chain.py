"""Serial chains of revolute and prismatic joints: forward kinematics and the three Jacobians.

A chain is given by its screws and its tool pose at home (product of exponentials, Murray, Li &
Sastry 1994, section 3.2). Internally each joint carries a frame with z along its axis, so that the
product of exponentials becomes L₀ Z(q₁) L₁ Z(q₂) … Z(qₙ) Lₙ with constant links Lᵢ and motions Z
along or about z: a motion then mixes two columns of a rotation instead of multiplying 4×4 matrices.

Examples
--------
>>> import dexterity as dx
>>> arm = dx.Chain.from_dh([{"a": 0.5}, {"a": 0.25}])
>>> arm.forward([0, 0])[:3, 3].tolist()
[0.75, 0.0, 0.0]
>>> arm.geometric_jacobian([[0, 0], [0, 1], [1, 0]]).shape
torch.Size([3, 6, 2])
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import pairwise
from typing import Literal, TypeAlias

import torch
from jaxtyping import Float64
from torch import Tensor

from dexterity import spatial, urdf
from dexterity.spatial import TensorLike

__all__ = ["Chain", "JointKind"]

JointKind: TypeAlias = Literal["revolute", "prismatic"]
"""What a joint does, turn about its axis or slide along it."""

_VEHICLE_JOINTS = ("x", "y", "z", "θx", "θy", "θz")


class Chain:
    """An immutable serial chain of revolute and prismatic joints.

    Parameters
    ----------
    screws
        (n, 6), rows [v; ω] of each joint at home, in the world frame. Revolute: ‖ω‖ = 1 and v = -ω × p
        [m] for a point p on the axis. Prismatic: ω = 0 and ‖v‖ = 1.
    home
        (4, 4) tool pose in the world with all joints at zero, T_world_tool.
    name
        What the chain is called in pictures, files and errors.
    joint_names
        n names; ``joint 1`` … by default.
    lower, upper
        (n,) joint limits, [rad] or [m]; unlimited by default. Infinite limits are allowed.
    rates
        (n,) largest joint rates, [rad/s] or [m/s]; 1 by default, 0 locks a joint.

    Raises
    ------
    ValueError
        If a shape does not fit, a screw is neither revolute nor prismatic or its axis is not of unit
        length, `home` is not a rigid pose, a lower limit exceeds its upper one, or a rate is negative.
    """

    _screws: Tensor
    _home: Tensor
    _name: str
    _joint_names: tuple[str, ...]
    _kinds: tuple[JointKind, ...]
    _lower: Tensor
    _upper: Tensor
    _rates: Tensor
    _link_transforms: Tensor

    def __init__(
        self,
        screws: TensorLike,
        home: TensorLike,
        *,
        name: str = "chain",
        joint_names: Sequence[str] | None = None,
        lower: TensorLike | None = None,
        upper: TensorLike | None = None,
        rates: TensorLike | None = None,
    ) -> None:
        screws = spatial.to_float64(screws, "screws")
        if screws.ndim != 2 or screws.shape[1] != 6 or len(screws) == 0:
            raise ValueError(f"screws has shape {tuple(screws.shape)}; (n, 6) with n ≥ 1 is needed")
        n = len(screws)
        names = tuple(joint_names) if joint_names is not None else tuple(f"joint {i + 1}" for i in range(n))
        if len(names) != n or len(set(names)) != n:
            raise ValueError(f"joint_names holds {names}; {n} different names are needed")

        keep = super().__setattr__
        keep("_screws", screws.detach().cpu().clone())
        keep("_home", _one_pose(home, "home").clone())
        keep("_name", name)
        keep("_joint_names", names)
        keep("_kinds", tuple(_joint_kind(i, screw) for i, screw in enumerate(self._screws)))
        keep("_lower", _limits(lower, "lower", n, -torch.inf))
        keep("_upper", _limits(upper, "upper", n, torch.inf))
        keep("_rates", _limits(rates, "rates", n, 1.0))
        if (self._lower > self._upper).any():
            raise ValueError(f"lower exceeds upper at joint {_first(self._lower > self._upper)}")
        if (self._rates < 0).any() or not torch.isfinite(self._rates).all():
            raise ValueError(f"rates must be finite and not negative, they are {self._rates.tolist()}")
        keep("_link_transforms", _link_transforms(self._screws, self._kinds, self._home))

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError(f"a Chain cannot be changed; {name} was to be set")

    def __repr__(self) -> str:
        return f"Chain({self.name!r}, {self.joints} joints: {', '.join(self.joint_names)})"

    # ---- descriptions -----------------------------------------------------------------------------

    @property
    def name(self) -> str:
        """What the chain is called."""
        return self._name

    @property
    def joints(self) -> int:
        """Number of joints n."""
        return len(self._kinds)

    @property
    def joint_names(self) -> tuple[str, ...]:
        """One name a joint."""
        return self._joint_names

    @property
    def kinds(self) -> tuple[JointKind, ...]:
        """``"revolute"`` or ``"prismatic"`` for each joint."""
        return self._kinds

    @property
    def screws(self) -> Float64[Tensor, "n 6"]:
        """Screws [v; ω] at home in the world frame (a copy)."""
        return self._screws.clone()

    @property
    def home(self) -> Float64[Tensor, "4 4"]:
        """Tool pose T_world_tool with all joints at zero (a copy)."""
        return self._home.clone()

    @property
    def lower(self) -> Float64[Tensor, " n"]:
        """Lower joint limits, [rad] or [m] (a copy)."""
        return self._lower.clone()

    @property
    def upper(self) -> Float64[Tensor, " n"]:
        """Upper joint limits, [rad] or [m] (a copy)."""
        return self._upper.clone()

    @property
    def rates(self) -> Float64[Tensor, " n"]:
        """Largest joint rates, [rad/s] or [m/s] (a copy)."""
        return self._rates.clone()

    @property
    def link_transforms(self) -> Float64[Tensor, "links 4 4"]:
        """Constant links L₀ … Lₙ (n + 1 of them) between the joint frames (a copy)."""
        return self._link_transforms.clone()

    # ---- constructors -----------------------------------------------------------------------------

    @classmethod
    def from_dh(
        cls,
        rows: Sequence[Mapping[str, float | int | str]],
        modified: bool = False,
        *,
        base: TensorLike | None = None,
        tool: TensorLike | None = None,
        name: str = "chain",
        joint_names: Sequence[str] | None = None,
        lower: TensorLike | None = None,
        upper: TensorLike | None = None,
        rates: TensorLike | None = None,
    ) -> Chain:
        """Build a chain from Denavit–Hartenberg rows.

        Parameters
        ----------
        rows
            One mapping a joint with ``theta`` [rad], ``d`` [m], ``a`` [m], ``alpha`` [rad] (each 0 if
            left out) and ``kind`` (``"revolute"`` if left out). The joint value is added to ``theta``
            of a revolute and to ``d`` of a prismatic joint.
        modified
            False: Rz(theta) Tz(d) Tx(a) Rx(alpha) (Denavit & Hartenberg 1955). True: Rx(alpha) Tx(a)
            Rz(theta) Tz(d), where ``alpha`` and ``a`` belong to the link before (Craig 1989).
        base, tool
            (4, 4) poses of the first frame in the world and of the tool in the last frame.
        name, joint_names, lower, upper, rates
            As for :class:`Chain`.

        Raises
        ------
        ValueError
            If a row holds an unknown key, kind, or a value that is no finite number, or `base` or `tool`
            is not a rigid (4, 4) pose.
        """
        T = torch.eye(4, dtype=torch.float64) if base is None else _one_pose(base, "base")
        screws = []
        for i, row in enumerate(rows):
            kind, before, after = _dh_motions(i, row, modified)
            T = T @ before
            screws.append(_screw_along_z(T, kind))
            T = T @ after
        home = T if tool is None else T @ _one_pose(tool, "tool")
        if not screws:
            raise ValueError("rows is empty; one mapping a joint is needed")
        return cls(
            torch.stack(screws), home,
            name=name, joint_names=joint_names, lower=lower, upper=upper, rates=rates,
        )  # fmt: skip

    @classmethod
    def from_urdf(
        cls,
        source: str | os.PathLike[str] | urdf.Model,
        base: str | None = None,
        tip: str | None = None,
        *,
        name: str | None = None,
    ) -> Chain:
        """Build a chain from the joints between two links of a URDF.

        The world frame is that of the base link, the tool frame that of the tip link. Fixed, revolute,
        continuous and prismatic joints are read, with axes of any length, joints in any order. Limits are
        the joints' own, none for a continuous joint; rates are the limits' ``velocity``, 1 where it is
        missing. The masses of what moves with each joint become :attr:`inertias`.

        Parameters
        ----------
        source
            Path of a URDF file, its text, or what :func:`dexterity.urdf.read` returned for it.
        base
            Name of the link that stands still; the only link without a parent by default.
        tip
            Name of the link that carries the tool; the only moving link without children by default. It may
            lie anywhere in the tree: joints that are passed from child to parent move the other way.
        name
            Name of the chain; the robot's by default.

        Raises
        ------
        ValueError
            If the source is no URDF or a xacro file, the choice of base or tip is open, a link is unknown
            or not connected, or the path holds a joint of another type, a mimic joint, a closed loop, a
            name twice, or a missing or senseless value. The error names the file, the joint or link, and
            the attribute.
        TypeError
            If `source` is neither a path nor a text, or a link's name is no text.
        FileNotFoundError
            If there is no such file.

        Examples
        --------
        >>> text = '''<robot name="door"><link name="frame"/><link name="leaf"/>
        ...   <joint name="hinge" type="revolute"><parent link="frame"/><child link="leaf"/>
        ...   <axis xyz="0 0 1"/><limit lower="0" upper="1.5" velocity="2"/></joint></robot>'''
        >>> import dexterity as dx
        >>> dx.Chain.from_urdf(text).upper.tolist()
        [1.5]

        References
        ----------
        URDF: http://wiki.ros.org/urdf/XML/joint.
        """
        model = source if isinstance(source, urdf.Model) else urdf.read(source)
        path = model.path(base, tip)
        return cls(
            path.screws, path.home, name=path.name if name is None else name,
            joint_names=path.joint_names, lower=path.lower, upper=path.upper, rates=path.rates,
        )  # fmt: skip

    def on_vehicle(
        self, T_vehicle_arm: TensorLike, *, name: str | None = None, rates: TensorLike | None = None
    ) -> Chain:
        """Mount the chain on a free vehicle: six joints x, y, z, θx, θy, θz go in front.

        The vehicle frame lies on the world frame at home. It moves along the world's axes, then turns
        about its own x, then y, then z axis.

        Parameters
        ----------
        T_vehicle_arm
            (4, 4) pose of the arm's world frame in the vehicle.
        name
            Name of the new chain; the arm's name with ``on a vehicle`` by default.
        rates
            (6,) largest vehicle rates, [m/s] and [rad/s]; 1 by default.

        Raises
        ------
        ValueError
            If `T_vehicle_arm` is not a rigid (4, 4) pose or `rates` does not fit.
        """
        T = _one_pose(T_vehicle_arm, "T_vehicle_arm")
        unlimited = torch.full((6,), torch.inf, dtype=torch.float64)
        arm_screws = self._screws @ spatial.adjoint(T).mT
        return Chain(
            torch.cat([torch.eye(6, dtype=torch.float64), arm_screws]),
            T @ self._home,
            name=name or f"{self.name} on a vehicle",
            joint_names=_VEHICLE_JOINTS + self.joint_names,
            lower=torch.cat([-unlimited, self._lower]),
            upper=torch.cat([unlimited, self._upper]),
            rates=torch.cat([_limits(rates, "rates", 6, 1.0), self._rates]),
        )

    # ---- kinematics -------------------------------------------------------------------------------

    def forward(self, q: TensorLike) -> Float64[Tensor, "*batch 4 4"]:
        r"""Tool pose T_world_tool.

        :math:`T(q) = e^{\hat S_1 q_1} \cdots e^{\hat S_n q_n} M`.

        Parameters
        ----------
        q
            (..., n) joint values, [rad] for revolute and [m] for prismatic joints.

        Raises
        ------
        ValueError
            If the last axis of `q` is not the number of joints, or `q` is not finite.

        References
        ----------
        Murray, Li & Sastry (1994), Eq. 3.3.
        """
        return self._in_pieces(q, self._tool_pose)

    def joint_frames(self, q: TensorLike) -> Float64[Tensor, "*batch n 4 4"]:
        """Pose in the world of a frame on each joint after it has moved, z along the joint's axis.

        At home, the origin of the first frame is the point of its axis nearest to the world's origin. The
        origin of each further frame is the point of its axis nearest to the origin of the previous frame.

        Parameters
        ----------
        q
            (..., n) joint values, [rad] or [m].

        Raises
        ------
        ValueError
            If the last axis of `q` is not the number of joints, or `q` is not finite.
        """
        return self._in_pieces(q, self._moved_frames)

    def spatial_jacobian(self, q: TensorLike) -> Float64[Tensor, "*batch 6 n"]:
        r"""Map joint rates to the twist of the tool body about the world's origin, in world axes.

        Column i is :math:`\mathrm{Ad}(e^{\hat S_1 q_1} \cdots e^{\hat S_{i-1} q_{i-1}})\,S_i`.

        Parameters
        ----------
        q
            (..., n) joint values, [rad] or [m].

        Returns
        -------
        Rows 0–2 the velocity of the body point now at the world's origin [m/s], rows 3–5 angular
        [rad/s], per unit joint rate.

        Raises
        ------
        ValueError
            If the last axis of `q` is not the number of joints, or `q` is not finite.

        References
        ----------
        Murray, Li & Sastry (1994), Eq. 3.54.
        """
        return self._in_pieces(q, self._spatial_jacobian)

    def geometric_jacobian(self, q: TensorLike) -> Float64[Tensor, "*batch 6 n"]:
        """Map joint rates to the velocity of the tool point and the angular velocity, in world axes.

        Parameters
        ----------
        q
            (..., n) joint values, [rad] or [m].

        Returns
        -------
        Rows 0–2 velocity of the tool's origin [m/s], rows 3–5 angular [rad/s], per unit joint rate.

        Raises
        ------
        ValueError
            If the last axis of `q` is not the number of joints, or `q` is not finite.
        """
        return self._in_pieces(q, self._geometric_jacobian)

    def body_jacobian(self, q: TensorLike) -> Float64[Tensor, "*batch 6 n"]:
        r"""Map joint rates to the twist of the tool, expressed in the tool frame.

        Column i is :math:`\mathrm{Ad}^{-1}(e^{\hat S_i q_i} \cdots e^{\hat S_n q_n} M)\,S_i`.

        Parameters
        ----------
        q
            (..., n) joint values, [rad] or [m].

        Returns
        -------
        Rows 0–2 linear [m/s], rows 3–5 angular [rad/s], per unit joint rate.

        Raises
        ------
        ValueError
            If the last axis of `q` is not the number of joints, or `q` is not finite.

        References
        ----------
        Murray, Li & Sastry (1994), Eq. 3.55.
        """
        return self._in_pieces(q, self._body_jacobian)

    # ---- inside -----------------------------------------------------------------------------------

    def _in_pieces(self, q: TensorLike, work: Callable[[Tensor], Tensor]) -> Tensor:
        """Check `q`, hand it to `work` as (n, at most _PIECE) columns, and restore the batch axes."""
        q = spatial.require_joints(spatial.to_float64(q, "q"), self.joints, "chain")
        result = torch.cat([work(piece.T) for piece in q.reshape(-1, self.joints).split(_PIECE)])
        return result.reshape(*q.shape[:-1], *result.shape[1:])

    def _tool_pose(self, q: Tensor) -> Tensor:
        *_, tool = self._frames(q)
        return _homogeneous(tool)

    def _moved_frames(self, q: Tensor) -> Tensor:
        *joints, _ = self._frames(q)
        return torch.stack([_homogeneous(frame) for frame in joints], dim=1)

    def _spatial_jacobian(self, q: Tensor) -> Tensor:
        *joints, tool = self._frames(q)
        return _rows_first(*self._columns(joints, torch.zeros_like(tool[3])))

    def _geometric_jacobian(self, q: Tensor) -> Tensor:
        *joints, tool = self._frames(q)
        return _rows_first(*self._columns(joints, tool[3]))

    def _body_jacobian(self, q: Tensor) -> Tensor:
        *joints, tool = self._frames(q)
        columns = self._columns(joints, tool[3])
        in_tool_axes = (torch.stack([(axis[:, None] * part).sum(0) for axis in tool[:3]]) for part in columns)
        return _rows_first(*in_tool_axes)

    def _frames(self, q: Tensor) -> Iterator[Tensor]:
        """Yield each joint's moved frame and at last the tool's, as (4 columns, 3 rows, N).

        With the batch last every operation runs over contiguous memory, and multiplying by a constant
        link is one matrix product for the whole batch.
        """
        links = self._link_transforms.to(q.device)
        frame = links[0, :3].T[:, :, None].expand(4, 3, q.shape[1])
        for i, kind in enumerate(self._kinds):
            frame = _move_along_z(frame, q[i]) if kind == "prismatic" else _turn_about_z(frame, q[i])
            yield frame
            frame = (links[i + 1].T @ frame.reshape(4, -1)).reshape(frame.shape)
        yield frame

    def _columns(self, joints: Sequence[Tensor], reference: Tensor) -> tuple[Tensor, Tensor]:
        """Velocity of the reference point and angular velocity per unit rate, (3, n, N) each."""
        axes = torch.stack([frame[2] for frame in joints], dim=1)
        arms = reference[:, None] - torch.stack([frame[3] for frame in joints], dim=1)
        (wx, wy, wz), (x, y, z) = axes, arms
        # Written out, the cross product is faster than torch.linalg.cross.
        linear, angular = torch.stack([wy * z - wz * y, wz * x - wx * z, wx * y - wy * x]), axes
        if "prismatic" in self._kinds:
            slides = torch.tensor([kind == "prismatic" for kind in self._kinds], device=axes.device)
            slides = slides[:, None]
            linear, angular = torch.where(slides, axes, linear), torch.where(slides, 0.0, axes)
        return linear, angular


_PIECE = 2048  # configurations worked on at a time: what they need stays in a core's cache
_UNIT_TOLERANCE = 1e-9


def _joint_kind(i: int, screw: Tensor) -> JointKind:
    v, omega = screw[:3], screw[3:]
    if not omega.any():
        if abs(v.norm() - 1) > _UNIT_TOLERANCE:
            raise ValueError(f"screws[{i}] is prismatic with an axis of length {v.norm():.6g}; 1 is needed")
        return "prismatic"
    if abs(omega.norm() - 1) > _UNIT_TOLERANCE:
        raise ValueError(f"screws[{i}] has an axis of rotation of length {omega.norm():.6g}; 1 is needed")
    pitch = float(omega @ v)
    if abs(pitch) > _UNIT_TOLERANCE * max(1.0, float(v.norm())):
        raise ValueError(
            f"screws[{i}] has a pitch of {pitch:.6g} m/rad; it is neither revolute (0) nor prismatic"
        )
    return "revolute"


def _limits(values: TensorLike | None, name: str, n: int, default: float) -> Tensor:
    if values is None:
        return torch.full((n,), default, dtype=torch.float64)
    tensor = spatial.to_extended_float64(values, name).detach().cpu().clone()
    if tensor.shape != (n,):
        raise ValueError(f"{name} has shape {tuple(tensor.shape)}; ({n},) is needed")
    return tensor


def _one_pose(T: TensorLike, name: str) -> Tensor:
    T = spatial.to_float64(T, name)
    if T.shape != (4, 4):
        raise ValueError(f"{name} has shape {tuple(T.shape)}; (4, 4) is needed")
    return spatial.require_rigid(T, name).detach().cpu()


def _first(mask: Tensor) -> int:
    return int(mask.to(torch.int8).argmax()) + 1


def _link_transforms(screws: Tensor, kinds: Sequence[JointKind], home: Tensor) -> Tensor:
    """Constant transforms between successive joint frames at home, from the world to the tool."""
    frames = [torch.eye(4, dtype=screws.dtype)]
    for screw, kind in zip(screws, kinds, strict=True):
        frames.append(_joint_frame(screw, kind, near=frames[-1][:3, 3]))
    frames.append(home)
    return torch.stack([spatial.inverse(a) @ b for a, b in pairwise(frames)])


def _joint_frame(screw: Tensor, kind: JointKind, near: Tensor) -> Tensor:
    """Frame with z along the joint's axis and its origin at the axis point nearest to `near`."""
    v, omega = screw[:3], screw[3:]
    if kind == "prismatic":
        return spatial.pose(_rotation_with_z(v), near)
    on_axis = torch.linalg.cross(omega, v)
    return spatial.pose(_rotation_with_z(omega), on_axis + omega * (omega @ (near - on_axis)))


def _rotation_with_z(axis: Tensor) -> Tensor:
    """Rotation whose third column is `axis`; a signed permutation where the axis is a coordinate axis."""
    z = axis / axis.norm()
    across = torch.zeros_like(z)
    across[(int(z.abs().argmax()) + 1) % 3] = 1.0
    x = across - z * (z @ across)
    x = x / x.norm()
    return torch.stack([x, torch.linalg.cross(z, x), z], dim=1)


def _turn_about_z(frame: Tensor, angle: Tensor) -> Tensor:
    x, y, z, p = frame
    c, s = angle.cos(), angle.sin()
    return torch.stack([c * x + s * y, c * y - s * x, z, p])


def _move_along_z(frame: Tensor, distance: Tensor) -> Tensor:
    x, y, z, p = frame
    return torch.stack([x, y, z, p + distance * z])


def _rows_first(linear: Tensor, angular: Tensor) -> Tensor:
    """Turn two (3, n, N) blocks into N Jacobians (N, 6, n)."""
    return torch.cat([linear, angular]).permute(2, 0, 1)


def _homogeneous(frame: Tensor) -> Tensor:
    """Turn (4 columns, 3 rows, N) into N poses (N, 4, 4)."""
    top = frame.permute(2, 1, 0)
    last_row = top.new_tensor([0.0, 0.0, 0.0, 1.0]).expand(len(top), 1, 4)
    return torch.cat([top, last_row], dim=1)


def _dh_motions(
    i: int, row: Mapping[str, float | int | str], modified: bool
) -> tuple[JointKind, Tensor, Tensor]:
    """Kind of joint, motion before its axis (from the frame before) and after it."""
    unknown = set(row) - {"theta", "d", "a", "alpha", "kind"}
    if unknown:
        raise ValueError(f"rows[{i}] holds {sorted(unknown)}; theta, d, a, alpha and kind are known")
    kind: JointKind = "prismatic" if row.get("kind") == "prismatic" else "revolute"
    if row.get("kind", kind) != kind:
        raise ValueError(f"rows[{i}] has kind {row['kind']!r}; revolute or prismatic is needed")
    theta, d, a, alpha = (
        spatial.to_float64(_number(row.get(key, 0.0), f"rows[{i}].{key}"), f"rows[{i}].{key}")
        for key in ("theta", "d", "a", "alpha")
    )
    zero = torch.zeros((), dtype=torch.float64)
    along_z = spatial.exp(torch.stack([zero, zero, d, zero, zero, theta]))
    along_x = spatial.exp(torch.stack([a, zero, zero, alpha, zero, zero]))
    if modified:
        return kind, along_x, along_z
    return kind, torch.eye(4, dtype=torch.float64), along_z @ along_x


def _number(value: float | int | str, name: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ValueError(f"{name} is {value!r}; a number is needed")
    return float(value)


def _screw_along_z(T: Tensor, kind: JointKind) -> Tensor:
    z, p = T[:3, 2], T[:3, 3]
    if kind == "prismatic":
        return torch.cat([z, torch.zeros_like(z)])
    return torch.cat([torch.linalg.cross(p, z), z])
