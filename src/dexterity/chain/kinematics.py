"""What a serial chain computes: forward kinematics, the three Jacobians, the mass matrix.

Examples
--------
>>> import dexterity as dx
>>> arm = dx.robots.docking_arm()
>>> q = [0.1, 0.5, -0.9, 0, 0.4, 0]
>>> moved = dx.spatial.adjoint(arm.forward(q)) @ arm.body_jacobian(q)
>>> moved.allclose(arm.spatial_jacobian(q))
True
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial

import torch
from jaxtyping import Float64
from torch import Tensor

from dexterity import spatial
from dexterity.chain import geometry
from dexterity.chain.geometry import JointKind
from dexterity.chain.inertias import Inertias, mass_matrices
from dexterity.spatial import TensorLike

__all__ = ["Kinematics"]


class Kinematics:
    """Properties and kinematics of a chain, see :class:`dexterity.chain.Chain`."""

    _screws: Tensor
    _home: Tensor
    _name: str
    _joint_names: tuple[str, ...]
    _kinds: tuple[JointKind, ...]
    _lower: Tensor
    _upper: Tensor
    _rates: Tensor
    _inertias: Inertias | None
    _adjusted: float
    _link_transforms: Tensor

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
    def inertias(self) -> Inertias | None:
        """Masses, centres of mass and inertias of the links (a copy); None if they are not known."""
        return None if self._inertias is None else Inertias(*(part.clone() for part in self._inertias))

    @property
    def adjusted(self) -> float:
        """Largest miss of the screws and the home pose as they were given, 0 where it was rounding only.

        The miss of an axis is that of its length, or of its pitch relative to its moment; that of the home
        pose is :func:`dexterity.spatial.rotation_miss`. What missed by up to 1e-5 was replaced by its nearest
        form.
        """
        return self._adjusted

    @property
    def link_transforms(self) -> Float64[Tensor, "links 4 4"]:
        """Constant links L₀ … Lₙ (n + 1 of them) between the joint frames (a copy)."""
        return self._link_transforms.clone()

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

    def mass_matrix(self, q: TensorLike) -> Float64[Tensor, "*batch n n"]:
        r"""Mass matrix, the quadratic form of the kinetic energy :math:`\tfrac12 \dot q^\top M(q)\,\dot q`.

        Parameters
        ----------
        q
            (..., n) joint values, [rad] or [m].

        Returns
        -------
        Symmetric matrices in kg, kg m and kg m², by the kinds of the joints.

        Raises
        ------
        ValueError
            If the chain has no inertias, the last axis of `q` is not the number of joints, or `q` is not
            finite.

        References
        ----------
        Featherstone (2008), section 6.2.
        """
        if self._inertias is None:
            raise ValueError(
                f"{self.name} has no inertias; give them to the chain, or read a URDF that has them"
            )
        return self._in_pieces(q, partial(self._mass_matrix, self._inertias))

    # ---- inside -----------------------------------------------------------------------------------

    def _in_pieces(self, q: TensorLike, work: Callable[[Tensor], Tensor]) -> Tensor:
        """Check `q`, hand it to `work` as (n, at most _PIECE) columns, and restore the batch axes."""
        q = spatial.require_joints(spatial.to_float64(q, "q"), self.joints, "chain")
        rows = q.reshape(-1, self.joints)
        # While torch traces, pieces would fix the size of the batch.
        pieces = [rows] if torch.compiler.is_compiling() else rows.split(_PIECE)
        result = torch.cat([work(piece.T) for piece in pieces])
        return result.reshape(*q.shape[:-1], *result.shape[1:])

    def _tool_pose(self, q: Tensor) -> Tensor:
        *_, tool = self._frames(q)
        return geometry.homogeneous(tool)

    def _moved_frames(self, q: Tensor) -> Tensor:
        *joints, _ = self._frames(q)
        return torch.stack([geometry.homogeneous(frame) for frame in joints], dim=1)

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

    def _mass_matrix(self, inertias: Inertias, q: Tensor) -> Tensor:
        *joints, tool = self._frames(q)
        home = torch.stack(_products(self._link_transforms[:-1]))
        columns = torch.cat(self._columns(joints, tool[3]))
        return mass_matrices(inertias, home, joints, columns, tool[3])

    def _frames(self, q: Tensor) -> Iterator[Tensor]:
        """Yield each joint's moved frame and at last the tool's, as (4 columns, 3 rows, N).

        With the batch last every operation runs over contiguous memory, and multiplying by a constant
        link is one matrix product for the whole batch.
        """
        links = self._link_transforms.to(q.device)
        frame = links[0, :3].T[:, :, None].expand(4, 3, q.shape[1])
        for i, kind in enumerate(self._kinds):
            frame = (
                geometry.move_along_z(frame, q[i])
                if kind == "prismatic"
                else geometry.turn_about_z(frame, q[i])
            )
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


def _products(links: Tensor) -> list[Tensor]:
    products = [links[0]]
    for link in links[1:]:
        products.append(products[-1] @ link)
    return products


def _rows_first(linear: Tensor, angular: Tensor) -> Tensor:
    """Turn two (3, n, N) blocks into N Jacobians (N, 6, n)."""
    return torch.cat([linear, angular]).permute(2, 0, 1)
