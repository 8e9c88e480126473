"""The networks of paper C: how sure one can be that a pose is in reach, and the Jacobian there.

An encoder is shared by two heads, one for the confidence that a pose is in reach and one for the entries of
the Jacobian. What a network sees of a manipulator and its pose, and which numbers it predicts, can be chosen:
the paper's columns and entries are one choice, and others learn the same with much less error.

A gate stands between the heads: below its threshold no Jacobian is given. That is said by a mask; the paper
has infinite entries there.

Examples
--------
>>> from dexterity.workspace import dataset, jacobian_net, training
>>> data = dataset.jacobian_data(count=100, seed=0, dynamics=False)
>>> architecture = jacobian_net.Architecture(confidence=(8,), estimation=(8,))
>>> network = training.network_for(architecture, "rotation", "world", data, seed=0)
>>> network.estimate(data.samples).jacobian.shape
torch.Size([100, 6, 6])
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from itertools import pairwise
from typing import Any, Literal, NamedTuple, get_args

import torch
from jaxtyping import Bool, Float64
from torch import Tensor

from dexterity import checks, spatial
from dexterity.checks import Instance, Real, Whole
from dexterity.spatial import TensorLike
from dexterity.spatial.values import on_cpu
from dexterity.workspace.archive import ArchiveError, read_archive, require_like, write_archive
from dexterity.workspace.dataset import Samples, Scaling, features
from dexterity.workspace.reachability import in_tool_axes

__all__ = [
    "PAPER_SIZE",
    "Architecture",
    "Entries",
    "Estimate",
    "Inputs",
    "JacobianNet",
    "decode",
    "encode",
    "inputs_of",
]

Inputs = Literal["columns", "relevant", "rotation", "plane"]
"""What a head sees. It is the paper's columns; those that vary and matter (links, position, angles); the same
with the rotation matrix instead of its angles; or the links, how far the position is from the first axis, and
its height."""

Entries = Literal["tool", "world", "plane"]
"""What is predicted. It is the 23 entries of the body Jacobian that vary; the 21 of the geometric one, which
is turned into the axes of the tool exactly; or 11 that the first four joints decide, with the arm turned
about its first axis until the position has y = 0. All others follow from these, the position and the
orientation of the tool."""


# ---- what goes in ----------------------------------------------------------------------------------


def inputs_of(samples: Samples, kind: Inputs) -> Float64[Tensor, "n width"]:
    """Return what a head sees of samples.

    Raises
    ------
    ValueError
        If the kind is unknown.
    TypeError
        If `samples` are none.
    """
    checks.instance(samples, "samples", Samples)
    checks.choice(kind, "kind", get_args(Inputs))
    if kind == "columns":
        return features(samples)
    if kind == "relevant":
        return torch.cat([samples.links, samples.position, samples.angles], -1)
    return _pose_inputs(samples.links, samples.position, samples.rotation(), kind)


def _pose_inputs(links: Tensor, position: Tensor, R: Tensor, kind: Inputs) -> Tensor:
    if kind == "plane":
        across = position[..., :2].norm(dim=-1, keepdim=True)
        return torch.cat([links, across, position[..., 2:]], -1)
    if kind == "rotation":
        return torch.cat([links, position, R.flatten(-2)], -1)
    raise ValueError(f"inputs are {kind!r}; of a pose alone 'rotation' and 'plane' can be made")


# ---- what comes out --------------------------------------------------------------------------------

_FULL = [(i, j) for i in range(6) for j in range(6) if i > 2 or j < 3]
# The first axis is upright, those of joints 2 and 3 are level.
_WORLD = [entry for entry in _FULL if entry not in {(2, 0), (3, 0), (4, 0), (5, 0), (5, 1), (5, 2)}]
# The last axis is the tool's own, and that of joint 5 is square to it.
_TOOL = [entry for entry in _FULL if entry not in {(3, 5), (4, 5), (5, 5), (5, 4)}]
# What the first joint does follows from the position. Joint 3 has the axis of joint 2, joint 4 the forearm's.
_PLANE = [(0, 1), (1, 1), (2, 1), (0, 2), (1, 2), (2, 2), (3, 1), (4, 1), (3, 3), (4, 3), (5, 3)]


def encode(J: Float64[Tensor, "n 6 6"], samples: Samples, entries: Entries) -> Float64[Tensor, "n k"]:
    """Return the entries of Jacobians that are to be predicted.

    Parameters
    ----------
    J
        Geometric Jacobians, in the axes of the base.
    samples
        Where they belong.
    entries
        Which.
    """
    if entries == "tool":
        J = in_tool_axes(J, samples.rotation())
    elif entries == "plane":
        J = in_tool_axes(J, _plane(samples.position))
    return J[(slice(None), *_places(entries))]


def decode(
    y: Float64[Tensor, "n k"], position: Tensor, R: Tensor, entries: Entries
) -> Float64[Tensor, "n 6 6"]:
    """Return geometric Jacobians from their predicted entries; what is constant is filled in.

    Parameters
    ----------
    y
        What :func:`encode` returns, or an estimate of it.
    position, R
        (n, 3) of the tool in the base [m], and (n, 3, 3) its rotation to the base.
    entries
        Which.
    """
    J = y.new_zeros(len(y), 6, 6)
    J[(slice(None), *_places(entries))] = y
    if entries == "tool":
        J[:, 5, 5] = 1
        return in_tool_axes(J, R.mT)
    J[:, 5, 0] = 1
    if entries == "world":
        return J
    J[:, 3:5, 2] = J[:, 3:5, 1]
    J = in_tool_axes(J, _plane(position).mT)
    J[:, 0, 0], J[:, 1, 0] = -position[:, 1], position[:, 0]
    forearm, last = J[:, 3:, 3], R[..., 2]
    J[:, 3:, 3] = torch.nn.functional.normalize(forearm, dim=-1)
    J[:, 3:, 4] = torch.nn.functional.normalize(torch.linalg.cross(last, forearm), dim=-1)
    J[:, 3:, 5] = last
    return J


def _places(entries: Entries) -> tuple[list[int], list[int]]:
    checks.choice(entries, "entries", get_args(Entries))
    rows, columns = zip(*{"tool": _TOOL, "world": _WORLD, "plane": _PLANE}[entries], strict=True)
    return list(rows), list(columns)


def _plane(position: Tensor) -> Tensor:
    """Rotations (n, 3, 3) about the first axis that carry x to where a position is."""
    x, y, z = position.unbind(-1)
    along = torch.stack([x, y, 0 * z], -1)
    ahead = torch.nn.functional.normalize(along, dim=-1)
    # On the axis itself any direction will do.
    ahead = torch.where((x == 0) & (y == 0), 1.0, 0.0)[:, None] * _X.to(ahead) + ahead
    up = _Z.to(ahead).expand_as(ahead)
    return torch.stack([ahead, torch.linalg.cross(up, ahead), up], -1)


_X, _Z = torch.tensor([1.0, 0.0, 0.0]), torch.tensor([0.0, 0.0, 1.0])


# ---- the network -----------------------------------------------------------------------------------


@dataclass(frozen=True)
class Architecture:
    """Widths and parts of a network.

    Attributes
    ----------
    encoder, confidence, estimation
        Widths of the dense layers of the encoder, which may have none, and of the hidden ones of the heads.
    normalised
        How many layers are followed by batch normalisation: the last ones of the encoder, and the first ones
        of a head.
    dropout
        Share of values that is dropped behind a normalised layer in training.

    Raises
    ------
    ValueError, TypeError
        If a width is no whole number of at least 1, a number of layers none of at least 0, or `dropout` no
        share below 1.
    """

    encoder: tuple[int, ...] = ()
    confidence: tuple[int, ...] = (128, 128, 128)
    estimation: tuple[int, ...] = (256, 256, 256)
    normalised: tuple[int, int] = (0, 0)
    dropout: float = 0.0

    def __post_init__(self) -> None:
        for name, least in (("encoder", 1), ("confidence", 1), ("estimation", 1), ("normalised", 0)):
            widths = Instance((tuple, list))(getattr(self, name), name)
            whole = tuple(Whole(least)(width, f"{name}[{i}]") for i, width in enumerate(widths))
            object.__setattr__(self, name, whole)
        if len(self.normalised) != 2:
            raise ValueError(f"normalised has {len(self.normalised)} numbers; 2 are needed")
        checks.fields(self, dropout=Real(least=0, below=1))


PAPER_SIZE = Architecture(
    encoder=(128, 256, 512, 512, 768, 768, 1024, 1024, 2150),
    confidence=(256, 128, 128, 64, 64, 32, 32),
    estimation=(256, 128, 128, 64, 64, 64, 64),
    normalised=(5, 4),
    dropout=0.5,
)
"""As many layers, and about as many parameters, as the paper and its code tell of; the widths between the
input and the code of 2150 numbers are ours."""


class Estimate(NamedTuple):
    """What a network says of poses.

    Attributes
    ----------
    confidence
        (...) from 0 to 1 that the pose is in reach.
    jacobian
        (..., 6, 6) geometric Jacobian; it means nothing where `mask` is false.
    mask
        (...) whether the confidence is at least the threshold.
    """

    confidence: Float64[Tensor, "*batch"]
    jacobian: Float64[Tensor, "*batch 6 6"]
    mask: Bool[Tensor, "*batch"]


class _Dropout(torch.nn.Module):
    """Dropout whose draws come from a generator that is handed to it, and not from torch's own."""

    def __init__(self, share: float) -> None:
        super().__init__()
        self.share = share
        self.random: torch.Generator | None = None

    def forward(self, x: Tensor) -> Tensor:
        if not self.training or self.share == 0:
            return x
        kept = torch.rand(x.shape, generator=self.random, dtype=x.dtype) >= self.share
        return x * kept / (1 - self.share)


def _layers(widths: Sequence[int], normalised: Sequence[bool], dropout: float) -> torch.nn.Sequential:
    parts: list[torch.nn.Module] = []
    for (inner, outer), normal in zip(pairwise(widths), normalised, strict=True):
        parts.append(torch.nn.Linear(inner, outer))
        if normal:
            parts.append(torch.nn.BatchNorm1d(outer))
        parts.append(torch.nn.PReLU())
        if normal and dropout:
            parts.append(_Dropout(dropout))
    return torch.nn.Sequential(*parts)


class JacobianNet(torch.nn.Module):
    """Confidence and Jacobian of a pose, from an encoder and two heads, in float32.

    Parameters
    ----------
    architecture
        Widths and parts.
    inputs, entries
        What it sees and what it predicts.
    scaling_in, scaling_out
        Of what it sees and of what it predicts, fitted to the training set.
    random
        Of the initial weights.
    threshold
        Confidence from which on a Jacobian is given.

    Raises
    ------
    ValueError
        If a choice is unknown, the scalings do not fit each other, or the threshold is not in [0, 1].
    """

    @checks.arguments(scaling_in=checks.Instance(Scaling), scaling_out=checks.Instance(Scaling))
    def __init__(
        self,
        architecture: Architecture,
        inputs: Inputs,
        entries: Entries,
        scaling_in: Scaling,
        scaling_out: Scaling,
        random: torch.Generator,
        threshold: float = 0.5,
    ) -> None:
        super().__init__()
        checks.instance(architecture, "architecture", Architecture)
        checks.choice(inputs, "inputs", get_args(Inputs))
        checks.choice(entries, "entries", get_args(Entries))
        checks.instance(random, "random", torch.Generator)
        self.architecture, self.inputs, self.entries = architecture, inputs, entries
        self.threshold = checks.real(threshold, "threshold", least=0, most=1)
        for name, scaling in (("in", scaling_in), ("out", scaling_out)):
            self.register_buffer(f"centre_{name}", scaling.centre.clone())
            self.register_buffer(f"unit_{name}", scaling.unit.clone())
        width = len(scaling_in.centre)
        encoder = (width, *architecture.encoder)
        last = len(encoder) - 1 - architecture.normalised[0]
        self.encoder = _layers(encoder, [i >= last for i in range(len(encoder) - 1)], architecture.dropout)
        self.confidence = self._head(encoder[-1], architecture.confidence, 1)
        self.estimation = self._head(encoder[-1], architecture.estimation, len(scaling_out.centre))
        self._initialise(random)

    def _head(self, width: int, hidden: Sequence[int], outputs: int) -> torch.nn.Sequential:
        first = [i < self.architecture.normalised[1] for i in range(len(hidden))]
        layers = _layers((width, *hidden), first, self.architecture.dropout)
        return torch.nn.Sequential(*layers, torch.nn.Linear((width, *hidden)[-1], outputs))

    @torch.no_grad()
    def _initialise(self, random: torch.Generator) -> None:
        """Draw weights as He et al. (2015) do; torch's own draws come from a global generator."""
        for part in self.modules():
            if isinstance(part, torch.nn.Linear):
                part.weight.normal_(0, (2 / part.in_features) ** 0.5, generator=random)
                part.bias.zero_()

    @property
    def parameter_count(self) -> int:
        """Number of trained numbers."""
        return sum(parameter.numel() for parameter in self.parameters())

    def draw_from(self, random: torch.Generator) -> None:
        """Let dropout draw from this generator from now on."""
        for part in self.modules():
            if isinstance(part, _Dropout):
                part.random = random

    @checks.arguments(side=checks.Choice(("in", "out")))
    def scaling(self, side: Literal["in", "out"]) -> Scaling:
        """Scaling of what it sees or of what it predicts."""
        return Scaling(self.get_buffer(f"centre_{side}"), self.get_buffer(f"unit_{side}"))

    def scaled_inputs(self, samples: Samples) -> Tensor:
        """Return what the encoder gets of samples, (n, width) in float32.

        Raises
        ------
        ValueError
            If the samples have dynamic parameters and those that the network was made for have none, or the
            other way round.
        """
        x, scaling = inputs_of(samples, self.inputs), self.scaling("in")
        if x.shape[-1] != len(scaling.centre):
            has = "no dynamics" if samples.dynamics is None else "dynamics"
            raise ValueError(
                f"samples have {has} and {x.shape[-1]} columns; the network sees {len(scaling.centre)}: draw "
                f"them with dynamics={samples.dynamics is None}"
            )
        return scaling.apply(x).float()

    def estimate(self, samples: Samples) -> Estimate:
        """Return what it says of samples (n)."""
        return self._estimate(self.scaled_inputs(samples), samples.position, samples.rotation())

    def answer(self, links: TensorLike, T_base_tool: TensorLike) -> Estimate:
        """Return what it says of manipulators with these links at these poses.

        Parameters
        ----------
        links
            (..., 4) d₃, d₄, a₂, a₃ [m].
        T_base_tool
            (..., 4, 4) poses of the tool in the base; the batch axes of both are broadcast.

        Raises
        ------
        ValueError
            If the network sees angles or dynamic parameters, which a pose does not have; if a shape does not
            fit, a pose is not rigid, or something is not finite.
        """
        links = spatial.batch_of(on_cpu(links, "links"), "links", (4,))
        T = spatial.require_rigid(on_cpu(T_base_tool, "T_base_tool"), "T_base_tool")
        batch = spatial.common_batch(links=links.shape[:-1], T_base_tool=T.shape[:-2])
        links, T = links.expand(*batch, 4).reshape(-1, 4), T.expand(*batch, 4, 4).reshape(-1, 4, 4)
        R = T[:, :3, :3]
        x = self.scaling("in").apply(_pose_inputs(links, T[:, :3, 3], R, self.inputs)).float()
        confidence, J, mask = self._estimate(x, T[:, :3, 3], R)
        return Estimate(confidence.reshape(batch), J.reshape(*batch, 6, 6), mask.reshape(batch))

    @torch.no_grad()
    def _estimate(self, x: Tensor, position: Tensor, R: Tensor) -> Estimate:
        self.eval()
        confidences, entries = [], []
        for rows in x.split(_ROWS):
            code = self.encoder(rows)
            confidences.append(self.confidence(code)[:, 0].sigmoid().double())
            entries.append(self.estimation(code).double())
        confidence, y = torch.cat(confidences), self.scaling("out").undo(torch.cat(entries))
        return Estimate(confidence, decode(y, position, R, self.entries), confidence >= self.threshold)

    @checks.arguments(path=checks.path)
    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the network to a file; errors as for :func:`dexterity.workspace.archive.write_archive`."""
        write_archive(path, _KIND, self.header(), self.state_dict())

    def header(self) -> dict[str, Any]:
        """Return what a file says of the network beside its numbers."""
        return {
            "architecture": asdict(self.architecture),
            "inputs": self.inputs,
            "entries": self.entries,
            "threshold": self.threshold,
        }

    @classmethod
    @checks.arguments(path=checks.path)
    def load(cls, path: str | os.PathLike[str]) -> JacobianNet:
        """Read a network from a file.

        Raises
        ------
        FileNotFoundError
            If there is no such file.
        ArchiveError
            If the file is not whole, or is of something else.
        """
        header, tensors = read_archive(path, _KIND)
        try:
            network = cls(
                Architecture(**{name: _tuple(value) for name, value in header["architecture"].items()}),
                header["inputs"],
                header["entries"],
                Scaling(tensors["centre_in"], tensors["unit_in"]),
                Scaling(tensors["centre_out"], tensors["unit_out"]),
                torch.Generator(),
                header["threshold"],
            )
            require_like(tensors, network.state_dict())
            network.load_state_dict(tensors)
        except (KeyError, TypeError, ValueError, AttributeError, RuntimeError, MemoryError) as error:
            raise ArchiveError(f"{os.fspath(path)} holds no network that can be built: {error}") from error
        return network


_ROWS = 65_536
_KIND = "jacobian-net"


def _tuple(value: Any) -> Any:
    return tuple(value) if isinstance(value, list) else value
