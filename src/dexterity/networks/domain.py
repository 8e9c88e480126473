"""Where a network may be asked: inside the space that it was trained on, and nowhere else.

Outside it a network answers with a number like any other, and nothing in the number tells.

Examples
--------
>>> import dexterity as dx
>>> from dexterity.networks.domain import Guarded
>>> network = dx.networks.load_shipped("uvms-manipulability-feed-forward")
>>> guarded = Guarded.of(network)
>>> guarded.ask([[0.0] * 12, [0.0] * 8 + [1.5, 0.0, 0.0, 0.0]]).inside.tolist()
[True, False]
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import torch
from jaxtyping import Bool, Float64
from torch import Tensor

from dexterity import checks, sampling, spatial
from dexterity.networks.files import load
from dexterity.networks.network import Network
from dexterity.sampling import Space
from dexterity.spatial import TensorLike

__all__ = ["Answer", "Guarded", "OutsideTrainedSpace"]


class OutsideTrainedSpace(ValueError):  # noqa: N818 -- what is outside, not that it is an error
    """Configurations that a network was not trained for.

    Attributes
    ----------
    inside
        (...) which of them it was trained for.
    joints
        Joints, counted from 0, that leave the space.
    """

    def __init__(self, inside: Tensor, joints: tuple[int, ...]) -> None:
        self.inside = inside
        self.joints = joints
        numbers = ", ".join(str(joint + 1) for joint in joints)
        super().__init__(
            f"q has {int((~inside).sum())} of {inside.numel()} configurations outside the space that the "
            f"network was trained on, which joint{'s' * (len(joints) > 1)} {numbers} (counted from 1) left"
        )

    def __reduce__(self) -> tuple[Any, ...]:
        # The base class would call the class with the message, in the process that a worker sends it to.
        return type(self), (self.inside, self.joints)


@dataclass(frozen=True)
class Answer:
    """What a network says, and where it may be believed.

    Attributes
    ----------
    values
        (...) value of the network, as a number for every configuration.
    inside
        (...) whether the network was trained for the configuration.
    """

    values: Float64[Tensor, "*batch"]
    inside: Bool[Tensor, "*batch"]


@dataclass(frozen=True)
class Guarded:
    """A network that refuses what it was not trained for; called as the network is.

    Nothing is clipped. A joint that the network does not see and that the space holds still is free, since
    the index does not depend on it.

    Parameters
    ----------
    network
        A trained network.
    space
        What it was trained on.

    Raises
    ------
    ValueError
        If they have different numbers of joints.
    """

    network: Network
    space: Space

    @classmethod
    @checks.arguments(path=checks.path)
    def load(cls, path: str | os.PathLike[str]) -> Guarded:
        """Return the network of a file, guarded by the space on its card.

        Raises
        ------
        FileNotFoundError
            If there is no such file.
        NetworkFileError
            If the file is not whole or holds no network.
        ValueError
            If the card holds no space, or one that does not fit the network.
        """
        return cls.of(load(path))

    @classmethod
    def of(cls, network: Network) -> Guarded:
        """Guard a network by the space on its card.

        Raises
        ------
        ValueError
            If the card holds no space, or one that does not fit the network.
        """
        checks.Instance(Network)(network, "network")
        return cls(network, network.card.space())

    def __post_init__(self) -> None:
        checks.Instance(Network)(self.network, "network")
        checks.Instance(Space)(self.space, "space")
        if self.network.joints != self.space.joints:
            raise ValueError(
                f"network has {self.network.joints} joints and space {self.space.joints}; as many are needed"
            )

    def __call__(self, q: TensorLike) -> Float64[Tensor, "*batch"]:
        """Value of the index as the network knows it.

        Parameters
        ----------
        q
            (..., n) joint values, [rad] for revolute and [m] for prismatic joints.

        Raises
        ------
        OutsideTrainedSpace
            If a configuration is outside the space.
        ValueError
            If the last axis of `q` is not the number of joints, or `q` is not finite.
        """
        answer = self.ask(q)
        if not answer.inside.all():
            raise OutsideTrainedSpace(answer.inside, self._leaving(spatial.to_float64(q, "q")))
        return answer.values

    def ask(self, q: TensorLike) -> Answer:
        """Return values for all configurations and tell which are inside.

        Raises
        ------
        ValueError
            If the last axis of `q` is not the number of joints, or `q` is not finite.
        """
        values = self.network(q)
        return Answer(values, self.contains(q))

    def contains(self, q: TensorLike) -> Bool[Tensor, "*batch"]:
        """Tell for which configurations (..., n) the network was trained.

        Raises
        ------
        ValueError
            If the last axis of `q` is not the number of joints, or `q` is not finite.
        """
        q = spatial.require_joints(spatial.to_float64(q, "q"), self.space.joints, "space")
        return self.space.contains(self._without_free(q))

    def _without_free(self, q: Tensor) -> Tensor:
        """Put joints that are free where the space holds them."""
        return torch.where(self._free.to(q.device), self._somewhere[0].to(q.device), q)

    @cached_property
    @torch.inference_mode(False)  # kept for later calls in every mode
    def _somewhere(self) -> Tensor:
        """Some configurations of the space, in which every joint that varies has different values."""
        return sampling.uniform(self.space, 16, torch.Generator().manual_seed(0))

    @cached_property
    @torch.inference_mode(False)  # kept for later calls in every mode
    def _held(self) -> Tensor:
        return (self._somewhere == self._somewhere[0]).all(0)

    @cached_property
    @torch.inference_mode(False)  # kept for later calls in every mode
    def _free(self) -> Tensor:
        """Joints (n) that are held in the space and that the network does not see."""
        seen = {*range(len(self.network.view.carriers)), *self.network.inputs}
        unseen = torch.tensor([joint not in seen for joint in range(self.network.joints)])
        return unseen & self._held

    def _leaving(self, q: Tensor) -> tuple[int, ...]:
        """Joints that move a coordinate of the space which is left, or that should have been held."""
        q = self._without_free(q).reshape(-1, self.space.joints).cpu()
        q = q[~self.space.contains(q)]
        u = self.space.to_unit(q)
        left = ((u < 0) | (u > 1)).any(0)
        moved = self._held & (q != self._somewhere[0]).any(0)
        leaving = self._moved_by_coordinate()[left].any(0) | moved
        return tuple(leaving.nonzero().flatten().tolist())

    def _moved_by_coordinate(self) -> Tensor:
        """Which joints (m, n) each coordinate moves."""
        u = torch.full((self.space.dimensions,), 0.4, dtype=torch.float64)
        return torch.autograd.functional.jacobian(self.space.from_unit, u).mT != 0
