"""The class of serial chains: how chains are made, and made out of others.

Examples
--------
>>> import dexterity as dx
>>> panda = dx.robots.panda()
>>> six = panda.lock({"panda_joint3": 0.2})
>>> six.joints, panda.forward([0, 0, 0.2, -1, 0, 1, 0]).allclose(six.forward([0, 0, -1, 0, 1, 0]))
(6, True)
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import torch
from torch import Tensor

from dexterity import checks, spatial, urdf
from dexterity.chain import dh, geometry, mounting
from dexterity.chain.geometry import JointKind
from dexterity.chain.inertias import Inertias, checked_inertias
from dexterity.chain.kinematics import Kinematics
from dexterity.spatial import TensorLike
from dexterity.spatial.tolerances import LIMIT, ROUNDING
from dexterity.spatial.values import on_cpu

__all__ = ["Chain"]


class Chain(Kinematics):
    """An immutable serial chain of revolute and prismatic joints.

    A description that is right to six digits is taken and mended, see :mod:`dexterity.spatial.tolerances`;
    :attr:`adjusted` says by how much. Values are read when the chain is made: later changes of the caller's
    arrays do not change it, and it lies on the CPU whatever torch's default device is. Kinematics are
    computed on the device of the joint values.

    Parameters
    ----------
    screws
        (n, 6), rows [v; ω] of each joint at home, in the world frame. Revolute: ‖ω‖ = 1 and v = -ω × p
        [m] for a point p on the axis. Prismatic: ω = 0 and ‖v‖ = 1.
    home
        (4, 4) tool pose in the world with all joints at zero, T_world_tool.
    name
        What the chain is called in pictures, files and errors; printable text.
    joint_names
        n names; ``joint 1`` … by default.
    lower, upper
        (n,) joint limits, [rad] or [m]; unlimited by default. Infinite limits are allowed.
    rates
        (n,) largest joint rates, [rad/s] or [m/s]; 1 by default. A rate of 0 locks a joint: it has a value,
        but it contributes nothing to an index that counts the rates. :meth:`lock` removes a joint.
    inertias
        Masses (n,) [kg], centres of mass (n, 3) [m] and inertias about them (n, 3, 3) [kg m²] of what moves
        with each joint but not with the next one, at home in the world frame; see :class:`Inertias`.

    Raises
    ------
    ValueError
        If a shape does not fit, a screw is neither revolute nor prismatic or its axis is not of unit
        length, `home` is not a rigid pose, a lower limit exceeds its upper one, a rate is negative, a name
        is blank, not printable or there twice, a mass is negative, a principal moment of inertia is so and
        the mass matrix at home not positive, or a value is not finite.
    TypeError
        If an argument is of another type.
    """

    @torch.inference_mode(False)  # its tensors serve in every mode
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
        inertias: tuple[TensorLike, TensorLike, TensorLike] | None = None,
    ) -> None:
        screws = on_cpu(screws, "screws").detach()
        if screws.ndim != 2 or screws.shape[1] != 6 or len(screws) == 0:
            raise ValueError(f"screws has shape {tuple(screws.shape)}; (n, 6) with n ≥ 1 is needed")
        n = len(screws)
        joint_names = [f"joint {i + 1}" for i in range(n)] if joint_names is None else joint_names
        kinds, mended, misses = zip(
            *(geometry.checked_screw(s, i) for i, s in enumerate(screws)), strict=True
        )
        pose, home_miss = _one_pose(home, "home")

        keep = super().__setattr__
        keep("_screws", torch.stack(mended))
        keep("_home", pose)
        keep("_name", checks.name(name, "name"))
        keep("_joint_names", checks.names(joint_names, "joint_names", n))
        keep("_kinds", kinds)
        keep("_lower", _limits(lower, "lower", n, -torch.inf))
        keep("_upper", _limits(upper, "upper", n, torch.inf))
        keep("_rates", _limits(rates, "rates", n, 1.0))
        keep("_inertias", None if inertias is None else checked_inertias(inertias, n))
        keep("_adjusted", max(*misses, home_miss))
        self._check_limits()
        keep("_link_transforms", geometry.link_transforms(self._screws, self._kinds, self._home))
        self._check_inertias()

    def _check_limits(self) -> None:
        empty = (self._lower > self._upper) | (self._lower == torch.inf) | (self._upper == -torch.inf)
        if empty.any():
            i = int(empty.to(torch.int8).argmax())
            raise ValueError(
                f"lower exceeds upper at joint {i + 1}: "
                f"{self._lower[i]:g} and {self._upper[i]:g} leave no value"
            )
        if (self._rates < 0).any() or not torch.isfinite(self._rates).all():
            raise ValueError(f"rates must be finite and not negative, they are {self._rates.tolist()}")

    def _check_inertias(self) -> None:
        """Refuse tensors that no body has if they spoil the mass matrix: published robots have others."""
        if self._inertias is not None and (strange := self._inertias.no_body()):
            moments = torch.linalg.eigvalsh(self.mass_matrix(torch.zeros_like(self._rates)))
            if moments[0] < -1e-9 * moments[-1].abs():
                raise ValueError(strange)

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError(f"a Chain cannot be changed; {name} was to be set")

    def __repr__(self) -> str:
        tool = ", ".join(f"{round(x, 12) + 0:.4g}" for x in self._home[:3, 3].tolist())
        columns = [
            self._joint_names,
            self._kinds,
            [
                _range(*row)
                for row in zip(self._lower.tolist(), self._upper.tolist(), self._kinds, strict=True)
            ],
            [_rate(*row) for row in zip(self._rates.tolist(), self._kinds, strict=True)],
        ]
        widths = [max(map(len, column)) for column in columns]
        rows = (
            "  ".join(text.ljust(width) for text, width in zip(row, widths, strict=True)).rstrip()
            for row in zip(*columns, strict=True)
        )
        title = f"Chain({self.name!r}, {self.joints} joint{'s'[: self.joints > 1]}, tool at ({tool}) m)"
        return "\n  ".join([title, *rows])

    # ---- constructors -----------------------------------------------------------------------------

    @classmethod
    def from_dh(
        cls,
        rows: Sequence[dh.Row],
        modified: bool = False,
        *,
        base: TensorLike | None = None,
        tool: TensorLike | None = None,
        name: str = "chain",
        joint_names: Sequence[str] | None = None,
        lower: TensorLike | None = None,
        upper: TensorLike | None = None,
        rates: TensorLike | None = None,
        inertias: tuple[TensorLike, TensorLike, TensorLike] | None = None,
    ) -> Chain:
        """Build a chain from Denavit–Hartenberg rows.

        Parameters
        ----------
        rows
            One mapping a joint with ``theta`` [rad], ``d`` [m], ``a`` [m], ``alpha`` [rad] (each 0 if
            left out) and ``kind`` (``"revolute"`` if left out). The joint value is added to ``theta``
            of a revolute and to ``d`` of a prismatic joint. Angles of more than a turn are refused, and
            robots of more than 100 m, which seem to be in millimetres, warned of.
        modified
            False: Rz(theta) Tz(d) Tx(a) Rx(alpha) (Denavit & Hartenberg 1955). True: Rx(alpha) Tx(a)
            Rz(theta) Tz(d), where ``alpha`` and ``a`` belong to the link before (Craig 1989).
        base, tool
            (4, 4) poses of the first frame in the world and of the tool in the last frame, such as
            ``dx.spatial.translation(0, 0, 0.107)``.
        name, joint_names, lower, upper, rates, inertias
            As for :class:`Chain`.

        Raises
        ------
        ValueError
            If a row holds an unknown key or kind, a value is not finite or out of range, or `base` or `tool`
            is not a rigid (4, 4) pose.
        TypeError
            If `rows` is no sequence of mappings, or a value is no number.
        """
        first = (
            torch.eye(4, dtype=torch.float64, device="cpu") if base is None else _one_pose(base, "base")[0]
        )
        screws, frames = dh.screws_and_frames(rows, first, checks.flag(modified, "modified"))
        geometry.warn_of_millimetres(name, screws, frames[-1], first)
        return cls(
            screws, frames[-1] if tool is None else frames[-1] @ _one_pose(tool, "tool")[0],
            name=name, joint_names=joint_names, lower=lower, upper=upper, rates=rates, inertias=inertias,
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
        missing. The masses of what moves with each joint become :attr:`inertias`. A robot of more than 100 m
        seems to be in millimetres, and is warned of.

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
        name = path.name if name is None else name
        screws, home = torch.from_numpy(path.screws), torch.from_numpy(path.home)
        geometry.warn_of_millimetres(name, screws, home, torch.eye(4, dtype=torch.float64, device="cpu"))
        return cls(
            screws, home, name=name,
            joint_names=path.joint_names, lower=path.lower, upper=path.upper, rates=path.rates,
            inertias=path.inertias,
        )  # fmt: skip

    # ---- chains made of this one --------------------------------------------------------------------

    def on_vehicle(
        self,
        T_vehicle_arm: TensorLike,
        *,
        joints: Sequence[str] = mounting.VEHICLE_JOINTS,
        axes: str = "world",
        rates: TensorLike | None = None,
        lower: TensorLike | None = None,
        upper: TensorLike | None = None,
        inertia: tuple[TensorLike, TensorLike, TensorLike] | None = None,
        name: str | None = None,
        prefix: str = "",
    ) -> Chain:
        """Mount the chain on a free vehicle: up to six joints go in front.

        The vehicle frame lies on the world frame at home. A degree of freedom that is left out stays at zero;
        one with a rate of 0 is passive: it has a value, but the vehicle does not drive it, as roll and pitch
        of most underwater vehicles.

        Parameters
        ----------
        T_vehicle_arm
            (4, 4) pose of the arm's world frame in the vehicle.
        joints
            Degrees of freedom: ``x``, ``y``, ``z`` (or ``surge``, ``sway``, ``heave``) and ``θx``, ``θy``,
            ``θz`` (or ``rx``, ``ry``, ``rz``, or ``roll``, ``pitch``, ``yaw``); the joints bear the names as
            they are given here.
        axes
            ``"world"``: the vehicle moves along the world's x, y, z, then turns about its x, then its y, then
            its z axis. ``"body"``: it turns first, and moves along its own axes after that; x, y, z are then
            distances along the axes of the turned vehicle. Rates along its own axes are exact where x, y and
            z are 0; a vehicle that stands elsewhere is placed there by :meth:`with_base`. Joints ``x`` and
            ``yaw`` along its own axes are a base on wheels, see also :meth:`on_wheels`.
        rates
            (k,) largest vehicle rates in the order of `joints`, [m/s] and [rad/s]; 1 by default.
        lower, upper
            (k,) limits in the order of `joints`, [m] and [rad]; unlimited by default.
        inertia
            Mass [kg], centre of mass (3,) [m] and inertia about it (3, 3) [kg m²] of the vehicle in its own
            frame, without the water that moves with it. Without it the new chain has no inertias.
        name
            Name of the new chain; the arm's name with ``on a vehicle`` by default.
        prefix
            Text before the names of the vehicle's joints, for two vehicles in one chain.

        Raises
        ------
        ValueError
            If `T_vehicle_arm` is not a rigid (4, 4) pose, a degree of freedom is unknown or there twice,
            `rates` or limits do not fit, a joint of the arm has the name of a vehicle's joint, or `inertia`
            is given for an arm without inertias.
        TypeError
            If an argument is of another type.
        """
        mount = mounting.vehicle_joints(joints, axes, prefix)
        order, k = list(mount.order), len(mount.order)
        return self._mounted(
            _one_pose(T_vehicle_arm, "T_vehicle_arm")[0],
            mount.names,
            mount.screws,
            _limits(rates, "rates", k, 1.0)[order],
            _limits(lower, "lower", k, -torch.inf)[order],
            _limits(upper, "upper", k, torch.inf)[order],
            inertia,
            f"{self.name} on a vehicle" if name is None else name,
        )

    def on_planar_base(
        self,
        T_base_arm: TensorLike,
        *,
        axes: str = "world",
        rates: TensorLike | None = None,
        lower: TensorLike | None = None,
        upper: TensorLike | None = None,
        inertia: tuple[TensorLike, TensorLike, TensorLike] | None = None,
        name: str | None = None,
        prefix: str = "",
    ) -> Chain:
        """Mount the chain on a base that moves freely in the plane: joints x, y and yaw go in front.

        Parameters
        ----------
        T_base_arm
            (4, 4) pose of the arm's world frame in the base, whose z axis points up.
        axes, rates, lower, upper, inertia, name, prefix
            As for :meth:`on_vehicle`, three values each, in the order x, y, yaw.

        Raises
        ------
        ValueError, TypeError
            As :meth:`on_vehicle`.
        """
        return self.on_vehicle(
            _one_pose(T_base_arm, "T_base_arm")[0], joints=("x", "y", "yaw"), axes=axes,
            rates=rates, lower=lower, upper=upper, inertia=inertia,
            name=f"{self.name} on a planar base" if name is None else name, prefix=prefix,
        )  # fmt: skip

    def on_wheels(
        self,
        T_base_arm: TensorLike,
        *,
        rates: TensorLike | None = None,
        lower: TensorLike | None = None,
        upper: TensorLike | None = None,
        inertia: tuple[TensorLike, TensorLike, TensorLike] | None = None,
        name: str | None = None,
        prefix: str = "",
    ) -> Chain:
        """Mount the chain on a base that drives ahead and turns but does not slip sideways.

        Four joints go in front: x, y and yaw say where the base stands, and ``forward`` drives it along its
        own x axis. x and y have a rate of 0, since no wheel moves the base along the world's axes.
        ``forward`` has limits 0 and 0, since a distance that was driven belongs to x and y. Poses are exact,
        and any x, y and yaw can be reached by manoeuvres. Rates are exact at every pose: the base that stands
        there drives ahead and turns.

        Parameters
        ----------
        T_base_arm
            (4, 4) pose of the arm's world frame in the base, whose origin lies in the middle of the driven
            axle, x ahead and z up.
        rates
            (2,) largest forward speed [m/s] and yaw rate [rad/s]; 1 by default.
        lower, upper
            (3,) limits of x, y [m] and yaw [rad]; unlimited by default.
        inertia, name, prefix
            As for :meth:`on_vehicle`.

        Raises
        ------
        ValueError, TypeError
            As :meth:`on_vehicle`.

        References
        ----------
        Bayle, Fourquet & Renaud (2003), Manipulability of wheeled mobile manipulators: application to motion
        generation, International Journal of Robotics Research 22(7-8).
        """
        plane = mounting.vehicle_joints(("x", "y", "yaw"), "world", prefix)
        forward, turning = _limits(rates, "rates", 2, 1.0).tolist()
        zero = torch.zeros(1, dtype=torch.float64, device="cpu")
        return self._mounted(
            _one_pose(T_base_arm, "T_base_arm")[0],
            (*plane.names, f"{prefix}forward"),
            torch.cat([plane.screws, plane.screws[:1]]),
            torch.tensor([0.0, 0.0, turning, forward], dtype=torch.float64, device="cpu"),
            torch.cat([_limits(lower, "lower", 3, -torch.inf), zero]),
            torch.cat([_limits(upper, "upper", 3, torch.inf), zero]),
            inertia,
            f"{self.name} on wheels" if name is None else name,
        )

    def _mounted(
        self,
        T: Tensor,
        names: tuple[str, ...],
        screws: Tensor,
        rates: Tensor,
        lower: Tensor,
        upper: Tensor,
        inertia: tuple[TensorLike, TensorLike, TensorLike] | None,
        name: str,
    ) -> Chain:
        """Return the chain moved by T, with joints in front of which the last one carries the inertia."""
        taken = sorted(set(names) & set(self.joint_names))
        if taken:
            raise ValueError(
                f"the arm has joints named {', '.join(taken)} too; prefix='base ' renames the vehicle's"
            )
        return Chain(
            torch.cat([screws, self._screws @ spatial.adjoint(T).mT]),
            T @ self._home,
            name=name,
            joint_names=names + self.joint_names,
            lower=torch.cat([lower, self._lower]),
            upper=torch.cat([upper, self._upper]),
            rates=torch.cat([rates, self._rates]),
            inertias=self._carried_inertias(T, len(names), inertia),
        )

    def _carried_inertias(
        self, T: Tensor, joints: int, inertia: tuple[TensorLike, TensorLike, TensorLike] | None
    ) -> Inertias | None:
        if inertia is None:
            return None
        if self._inertias is None:
            raise ValueError(f"inertia is given, but {self.name} has no inertias of its links")
        if not isinstance(inertia, Sequence) or len(inertia) != 3:
            raise TypeError(f"inertia is {checks.shown(inertia)}; a mass, a centre and a tensor are needed")
        mass, centre, tensor = (on_cpu(part, "inertia").detach()[None] for part in inertia)
        body = checked_inertias((mass, centre, tensor), 1, "inertia")
        parts = zip(body, self._inertias.moved(T), strict=True)
        return Inertias(
            *(torch.cat([torch.zeros_like(a).expand(joints - 1, *a.shape[1:]), a, b]) for a, b in parts)
        )

    def with_base(self, T_world_base: TensorLike, *, name: str | None = None) -> Chain:
        """Return the chain with its world frame, and all that stands in it, placed in another world frame.

        Parameters
        ----------
        T_world_base
            (4, 4) pose of the present world frame in the new one.
        name
            Name of the new chain; the present one by default.

        Raises
        ------
        ValueError
            If `T_world_base` is not a rigid (4, 4) pose.
        """
        T = _one_pose(T_world_base, "T_world_base")[0]
        return self._changed(
            name=name,
            screws=self._screws @ spatial.adjoint(T).mT,
            home=T @ self._home,
            inertias=None if self._inertias is None else self._inertias.moved(T),
        )

    def with_tool(self, T_tool_new: TensorLike, *, name: str | None = None) -> Chain:
        """Return the chain with another tool frame.

        Parameters
        ----------
        T_tool_new
            (4, 4) pose of the new tool frame in the present one.
        name
            Name of the new chain; the present one by default.

        Raises
        ------
        ValueError
            If `T_tool_new` is not a rigid (4, 4) pose.
        """
        return self._changed(name=name, home=self._home @ _one_pose(T_tool_new, "T_tool_new")[0])

    def with_limits(
        self,
        *,
        lower: TensorLike | None = None,
        upper: TensorLike | None = None,
        rates: TensorLike | None = None,
    ) -> Chain:
        """Return the chain with other joint limits and rates; what is left out stays as it is.

        Parameters
        ----------
        lower, upper
            (n,) joint limits, [rad] or [m].
        rates
            (n,) largest joint rates, [rad/s] or [m/s].

        Raises
        ------
        ValueError
            If a shape does not fit, a lower limit exceeds its upper one, or a rate is negative.
        TypeError
            If the values are no numbers.
        """
        given: dict[str, Any] = {"lower": lower, "upper": upper, "rates": rates}
        return self._changed(**{name: values for name, values in given.items() if values is not None})

    def _changed(self, *, name: str | None = None, **changes: Any) -> Chain:
        """Return the chain with other arguments of its constructor."""
        same = ("screws", "home", "joint_names", "lower", "upper", "rates", "inertias")
        arguments = {argument: getattr(self, f"_{argument}") for argument in same}
        return Chain(**arguments | changes, name=self.name if name is None else name)

    def lock(self, joints: Mapping[str, float] | Iterable[str], *, name: str | None = None) -> Chain:
        """Return the chain with joints fixed; what they carry moves with the joints before them.

        Parameters
        ----------
        joints
            Values [rad] or [m] by the names of the joints, or names alone for the value 0. Degrees of freedom
            of a vehicle answer to all names that :meth:`on_vehicle` knows, such as ``rx`` for ``θx``.
        name
            Name of the new chain; the present one by default.

        Raises
        ------
        ValueError
            If a joint is unknown, a value lies outside its limits or is not finite, or no joint is left.
        TypeError
            If `joints` is neither a mapping nor a sequence of names, or a value is no number.
        """
        values = self._locked_values(joints)
        free = [i for i in range(self.joints) if i not in values]
        if not free:
            raise ValueError(f"joints holds all {self.joints} joints; a chain needs one that moves")
        T = torch.eye(4, dtype=torch.float64, device="cpu")
        screws: list[Tensor] = []
        moves: list[Tensor] = []
        groups: list[list[int]] = []
        for i, screw in enumerate(self._screws):
            if i in values:
                T = T @ spatial.exp(screw * values[i])
            else:
                screws.append(spatial.adjoint(T) @ screw)
                groups.append([])
            moves.append(T)
            if groups:
                groups[-1].append(i)
        inertias = None
        if self._inertias is not None:
            inertias = self._inertias.moved(torch.stack(moves)).merged(groups)
        return self._changed(
            name=name,
            screws=torch.stack(screws),
            home=T @ self._home,
            joint_names=[self.joint_names[i] for i in free],
            lower=self._lower[free],
            upper=self._upper[free],
            rates=self._rates[free],
            inertias=inertias,
        )

    def _number_of(self, joint: str) -> int:
        """Place of a joint by its name, or by another name of the same degree of freedom of a vehicle."""
        if joint not in self.joint_names:
            others = [mounting.freedom(name) for name in self.joint_names]
            if mounting.freedom(joint) is not None and others.count(mounting.freedom(joint)) == 1:
                return others.index(mounting.freedom(joint))
        return self.joint_names.index(checks.choice(joint, "joints", self.joint_names))

    def _locked_values(self, joints: Mapping[str, float] | Iterable[str]) -> dict[int, float]:
        if not isinstance(joints, Mapping):
            joints = dict.fromkeys(checks.names(joints, "joints"), 0.0)
        values = {}
        for joint, value in joints.items():
            i = self._number_of(joint)
            values[i] = checks.real(value, f"joints[{joint!r}]")
            low, high = float(self._lower[i]), float(self._upper[i])
            if not low - LIMIT <= values[i] <= high + LIMIT:
                raise ValueError(
                    f"joints[{joint!r}] is {values[i]:g}; the joint's limits are {low:g} and {high:g}"
                )
        return values


def _limits(values: TensorLike | None, name: str, n: int, default: float) -> Tensor:
    if values is None:
        return torch.full((n,), default, dtype=torch.float64, device="cpu")
    tensor = on_cpu(values, name, spatial.to_extended_float64).detach().clone()
    if tensor.shape != (n,):
        raise ValueError(f"{name} has shape {tuple(tensor.shape)}; ({n},) is needed")
    return tensor


def _one_pose(T: TensorLike, name: str) -> tuple[Tensor, float]:
    """Return a pose on the CPU, and by how much it missed being rigid, 0 for rounding."""
    T = on_cpu(T, name).detach()
    if T.shape != (4, 4):
        hint = ", such as dexterity.spatial.translation(x, y, z)" if T.shape == (3,) else ""
        raise ValueError(f"{name} has shape {tuple(T.shape)}; (4, 4) is needed{hint}")
    rigid = spatial.require_rigid(T, name).clone()
    miss = float(spatial.rotation_miss(T))
    return rigid, miss if miss > ROUNDING else 0.0


def _range(lower: float, upper: float, kind: JointKind) -> str:
    unit = "rad" if kind == "revolute" else "m"
    if lower == -torch.inf and upper == torch.inf:
        return "without limits"
    return f"{lower:.4g} to {upper:.4g} {unit}"


def _rate(rate: float, kind: JointKind) -> str:
    return f"{rate:.4g} {'rad/s' if kind == 'revolute' else 'm/s'}" if rate else "locked (rate 0)"
