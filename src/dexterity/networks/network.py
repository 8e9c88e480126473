"""What every network of the package is: an index as a function of a chain's joint values.

A network looks at some of the joints and, if it is told to, at the world's origin as one of the links sees
it. What it looks at is the same for all kinds of networks; how it answers is their own. Weights and scaling
are parameters and buffers of a torch module, so that they move between devices and are saved together.

Examples
--------
>>> import dexterity as dx
>>> from dexterity.networks.network import View
>>> view = View(12, [8, 10])
>>> view.width, view([[0.0] * 8 + [0.5, 0.0, 1.0, 0.0]]).tolist()
(2, [[0.5, 1.0]])
>>> dx.networks.load_shipped("uvms-manipulability-feed-forward").inputs
(4, 5, 6, 7, 8, 9, 10)
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import torch
from jaxtyping import Float64
from torch import Tensor

from dexterity import checks, spatial
from dexterity.networks.card import Card
from dexterity.spatial import TensorLike

__all__ = ["Network", "View"]


class View(torch.nn.Module):
    """What a network sees of a configuration.

    Parameters
    ----------
    joints
        Number of joints n of the chain.
    inputs
        Joints whose values are seen, from 0, in rising order.
    carriers
        (c, 6) screws [v; ω] of the first c joints. Where there are any, the coordinates [m] of the world's
        origin in the link that they carry stand before the joint values. A spatial index depends on the
        first joints of a floating base through them alone.

    Raises
    ------
    ValueError
        If the inputs are no different joints in rising order, or the carriers are not screws of at most n
        joints.
    """

    carriers: Tensor

    # Its screws serve in every mode; some views are made when a module is imported.
    @torch.inference_mode(False)
    def __init__(self, joints: int, inputs: Sequence[int], carriers: TensorLike = ()) -> None:
        super().__init__()
        joints = checks.whole(joints, "joints", least=1)
        if not isinstance(inputs, Iterable) or isinstance(inputs, str | bytes):
            raise TypeError(f"inputs is {checks.shown(inputs)}; numbers of joints are needed")
        inputs = tuple(checks.whole(joint, f"inputs[{i}]") for i, joint in enumerate(inputs))
        if not inputs or list(inputs) != sorted(set(inputs)) or inputs[0] < 0 or inputs[-1] >= joints:
            raise ValueError(
                f"inputs is {inputs}; different joints from 0 to {joints - 1} in rising order are needed"
            )
        screws = _screws(carriers)
        if len(screws) > joints:
            raise ValueError(f"carriers has {len(screws)} screws; the chain has {joints} joints")
        self.joints = joints
        self.inputs = inputs
        self.register_buffer("carriers", screws)

    @property
    def width(self) -> int:
        """Number r of values that are seen."""
        return len(self.inputs) + (3 if len(self.carriers) else 0)

    def forward(self, q: TensorLike) -> Float64[Tensor, "*batch r"]:
        """Return what is seen of joint values (..., n), [rad] or [m].

        Raises
        ------
        ValueError
            If the last axis of `q` is not the number of joints, or `q` is not finite.
        """
        return self.seen(self.checked(q))

    def checked(self, q: TensorLike) -> Float64[Tensor, "*batch n"]:
        """Return joint values as a tensor if they are finite and as many as there are joints.

        Raises
        ------
        ValueError
            As :meth:`forward`.
        """
        return spatial.require_joints(self._here(q), self.joints, "chain")

    def seen(self, q: Float64[Tensor, "*batch n"]) -> Float64[Tensor, "*batch r"]:
        """Return what is seen of checked joint values."""
        seen = q[..., list(self.inputs)]
        return torch.cat([self._origin(q), seen], dim=-1) if len(self.carriers) else seen

    def _here(self, q: TensorLike) -> Tensor:
        """Joint values on the device of the network."""
        if self.carriers.dtype != torch.float64:
            raise TypeError(
                f"the network was converted to {self.carriers.dtype}; networks compute in double precision "
                'whatever they are given, and c_files with precision="float" is for processors without'
            )
        here = self.carriers.device
        if not isinstance(q, Tensor):
            with here:  # whatever the default device is
                return spatial.to_float64(q, "q")
        if q.device != here:
            raise ValueError(
                f"q is on the device {q.device} and the network on {here}; bring both together by to()"
            )
        return spatial.to_float64(q, "q")

    def _origin(self, q: Tensor) -> Tensor:
        """World's origin (..., 3) in the coordinates of the carried link, which lies on the world at home."""
        origin = q.new_zeros(*q.shape[:-1], 3)
        for joint, screw in enumerate(self.carriers):
            back = spatial.exp(-screw * q[..., joint, None])
            origin = spatial.apply(back, origin)
        return origin


class Network(torch.nn.Module, ABC):
    """A function of joint values, called as what :meth:`dexterity.indices.Index.bind` returns is.

    Attributes
    ----------
    view
        What it sees of a configuration.
    """

    view: View

    def __init__(self, view: View) -> None:
        super().__init__()
        self.view = checks.instance(view, "view", View)
        self._card = Card()

    @property
    def card(self) -> Card:
        """What is known of the network, as a file keeps it; empty unless it came from one."""
        return self._card

    @card.setter
    def card(self, entries: Mapping[str, Any]) -> None:
        self._card = Card(entries)

    def __repr__(self) -> str:
        name = f" {self.card['name']!r}" if isinstance(self.card.get("name"), str) else ""
        origin = "the world's origin and " if len(self.view.carriers) else ""
        numbers = ", ".join(str(joint + 1) for joint in self.inputs)
        text = (
            f"{type(self).__name__}{name} of {self.neurons} neurons, {self._detail()}, sees {origin}joints "
        )
        text += f"{numbers} of {self.joints}"
        worst = self.card.get("worst_case")
        if isinstance(worst, Mapping) and isinstance(worst.get("error"), float):
            text += f", worst error found {worst['error']:.2g}"
        return f"<{text}>"

    def _detail(self) -> str:
        """Tell networks of a kind apart in a few words."""
        return f"{sum(parameter.numel() for parameter in self.parameters())} weights"

    @property
    def joints(self) -> int:
        """Number of joints of the chain."""
        return self.view.joints

    @property
    def inputs(self) -> tuple[int, ...]:
        """Joints whose values the network sees, from 0."""
        return self.view.inputs

    @property
    @abstractmethod
    def neurons(self) -> int:
        """Number of hidden neurons."""

    @abstractmethod
    def answer(self, x: Tensor) -> Tensor:
        """Return values (...) for what is seen (..., r) of configurations."""

    def forward(self, q: TensorLike) -> Tensor:
        """Value of the index as the network knows it.

        Where torch is to keep nothing for a gradient, as under ``torch.no_grad()``, many configurations are
        worked on in pieces, so that they need little memory beyond themselves.

        Parameters
        ----------
        q
            (..., n) joint values, [rad] for revolute and [m] for prismatic joints.

        Raises
        ------
        ValueError
            If the last axis of `q` is not the number of joints, or `q` is not finite.
        """
        q = self.view.checked(q)
        if not self._is_divisible(q):
            return self.answer(self.view.seen(q))
        pieces = q.reshape(-1, self.joints).split(_PIECE)
        values = torch.cat([self.answer(self.view.seen(piece)) for piece in pieces])
        return values.reshape(q.shape[:-1] + values.shape[1:])  # a network may answer with several values

    def _is_divisible(self, q: Tensor) -> bool:
        """Whether pieces save memory: on the CPU, where torch neither traces nor records for gradients."""
        if not (q.is_cpu and spatial.are_readable(q)) or q.numel() <= _PIECE * self.joints:
            return False
        weighed = q.requires_grad or any(parameter.requires_grad for parameter in self.parameters())
        return not (torch.is_grad_enabled() and weighed)


_PIECE = 8192
"""Configurations worked on at a time."""


def _screws(carriers: TensorLike) -> Tensor:
    """Return screws (c, 6): each turns by one radian per unit of its joint, or slides."""
    screws = spatial.to_float64(carriers, "carriers").detach().clone()
    if screws.numel() == 0:
        return screws.new_zeros(0, 6)
    if screws.ndim != 2 or screws.shape[1] != 6:
        raise ValueError(f"carriers has shape {tuple(screws.shape)}; screws (c, 6) are needed")
    for i, length in enumerate(torch.linalg.vector_norm(screws[:, 3:], dim=1).tolist()):
        if not (length == 0 or abs(length - 1) < UNIT_TOLERANCE) or not screws[i].any():
            raise ValueError(
                f"carriers[{i}] turns by {length:.12g} rad per unit of its joint; it must turn by 1, or slide"
            )
    return screws


UNIT_TOLERANCE = 1e-9
"""By how much the axis of a screw that turns may miss the length 1."""


def checked(arrays: Mapping[str, TensorLike], shapes: Mapping[str, tuple[int, ...]]) -> dict[str, Tensor]:
    """Return finite float64 copies of arrays that must have these names and shapes.

    Raises
    ------
    ValueError
        If one is missing, unknown, not finite or of another shape.
    """
    if not isinstance(arrays, Mapping) or arrays.keys() != shapes.keys():
        raise ValueError(f"there are arrays {sorted(map(str, arrays))}; {sorted(shapes)} are needed")
    tensors = {name: spatial.to_float64(arrays[name], name).detach().clone() for name in shapes}
    for name, shape in shapes.items():
        if tensors[name].shape != shape:
            raise ValueError(f"{name} has shape {tuple(tensors[name].shape)}; {shape} is needed")
    return tensors


def device_name(value: Any, name: str) -> str:
    """Check the name of a device of torch, before anything is moved there."""
    text = checks.instance(value, name, str)
    try:
        torch.device(text)
    except RuntimeError:
        raise ValueError(
            f"{name} is {checks.shown(text)}; a device such as cpu or cuda:0 is needed"
        ) from None
    return text
