"""Training of the networks of paper C: cycles of both heads, the optimisers of its figures, checkpoints.

A run is a list of epochs, each of one head, with the encoder free or frozen. After every epoch all that the
next one needs is in the checkpoint, and what an epoch draws follows from the seed and its number alone: a run
that was killed goes on to the very weights that it would have had.

Examples
--------
>>> from dexterity.workspace import dataset, jacobian_net, training
>>> data = dataset.jacobian_data(count=100, seed=0, dynamics=False)
>>> size = jacobian_net.Architecture(confidence=(8,), estimation=(8,))
>>> network = training.network_for(size, "rotation", "world", data, seed=0)
>>> rows = {"estimation": training.estimation_rows(network, data)}
>>> options = training.Options(training.epochs(estimation=2))
>>> len(training.train(network, rows, options, seed=0).losses)
2
"""

from __future__ import annotations

import json
import math
import os
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Literal, NamedTuple, get_args

import torch
from torch import Tensor
from torch.nn.functional import binary_cross_entropy_with_logits, mse_loss
from tqdm import tqdm

from dexterity import checks, store
from dexterity.checks import Choice, Flag, OrNone, Real, Whole
from dexterity.networks.threads import one_thread
from dexterity.workspace.archive import ArchiveError, read_archive, require_like, write_archive
from dexterity.workspace.dataset import ConfidenceData, JacobianData, Scaling
from dexterity.workspace.jacobian_net import Architecture, Entries, Inputs, JacobianNet, encode, inputs_of

__all__ = [
    "OPTIMISERS",
    "Epoch",
    "Loss",
    "Options",
    "Rows",
    "Training",
    "confidence_rows",
    "cycles",
    "epochs",
    "estimation_rows",
    "network_for",
    "train",
]

Head = Literal["confidence", "estimation"]

OPTIMISERS: Mapping[str, Callable[..., torch.optim.Optimizer]] = {
    "SGD": torch.optim.SGD,
    "Adam": torch.optim.Adam,
    "Adamax": torch.optim.Adamax,
    "Nadam": torch.optim.NAdam,
    "RMSprop": torch.optim.RMSprop,
    "Adagrad": torch.optim.Adagrad,
    "Adadelta": torch.optim.Adadelta,
}
"""Those that the paper compares, by its names."""


class Epoch(NamedTuple):
    """One pass over the training rows of a head.

    Attributes
    ----------
    head
        Which head is trained.
    frozen
        Whether the encoder stays as it is.
    """

    head: Head
    frozen: bool = False


def epochs(confidence: int = 0, estimation: int = 0) -> tuple[Epoch, ...]:
    """Return so many epochs of each head, one head after the other, for heads that share nothing."""
    confidence, estimation = (
        checks.whole(count, name, least=0)
        for count, name in ((confidence, "confidence"), (estimation, "estimation"))
    )
    return (Epoch("confidence"),) * confidence + (Epoch("estimation"),) * estimation


def cycles(pretraining: int, count: int) -> tuple[Epoch, ...]:
    """Return the schedule of the paper's section VI.B.

    The encoder is trained with the estimation head first. Then each cycle trains the confidence head twice
    with the encoder frozen, and the estimation head once with the encoder.

    Parameters
    ----------
    pretraining
        Epochs before the first cycle.
    count
        Cycles.
    """
    pretraining = checks.whole(pretraining, "pretraining", least=0)
    count = checks.whole(count, "count", least=0)
    cycle = (Epoch("confidence", frozen=True),) * 2 + (Epoch("estimation"),)
    return (Epoch("estimation"),) * pretraining + cycle * count


@dataclass(frozen=True)
class Options:
    """How a network is trained.

    Attributes
    ----------
    schedule
        The epochs.
    optimiser
        One of `OPTIMISERS`.
    rate
        Learning rate.
    decay
        Whether the rate falls to zero over the epochs of a head, along half a cosine wave.
    batch
        Rows a step.
    validation
        Share of the rows that is held out.
    patience
        Epochs without a better validation loss after which a run ends, with the best weights it had; None
        for a run through the whole schedule, which keeps the last ones.

    Raises
    ------
    ValueError, TypeError
        If the schedule is empty or holds what is no epoch, or an option is out of its range or no number.
    """

    schedule: tuple[Epoch, ...]
    optimiser: str = "Adam"
    rate: float = 1e-3
    decay: bool = True
    batch: int = 1024
    validation: float = 0.2
    patience: int | None = None

    def __post_init__(self) -> None:
        if not isinstance(self.schedule, Sequence) or isinstance(self.schedule, str):
            raise TypeError(f"schedule is {checks.shown(self.schedule)}; a sequence of epochs is needed")
        if not self.schedule:
            raise ValueError("schedule is empty; at least one epoch is needed")
        for i, epoch in enumerate(self.schedule):
            checks.instance(epoch, f"schedule[{i}]", Epoch)
            checks.choice(epoch.head, f"schedule[{i}].head", get_args(Head))
            checks.flag(epoch.frozen, f"schedule[{i}].frozen")
        object.__setattr__(self, "schedule", tuple(self.schedule))
        checks.fields(
            self,
            optimiser=Choice(tuple(OPTIMISERS)),
            rate=Real(above=0),
            decay=Flag(),
            batch=Whole(2),
            validation=_SHARE,
            patience=OrNone(Whole(1)),
        )


_SHARE = Real(above=0, below=1)


class Rows(NamedTuple):
    """What a head is trained with: scaled inputs (n, width) and targets (n, k), in float32."""

    x: Tensor
    y: Tensor


class Loss(NamedTuple):
    """Mean loss of a head in an epoch, over its training steps and on the held-out rows after them."""

    head: Head
    train: float
    validation: float


class Training(NamedTuple):
    """A trained network.

    Attributes
    ----------
    network
        The network.
    losses
        Losses of the epochs that led to it.
    stopped_early
        Whether it ran out of patience.
    diverged
        Whether a loss was no longer finite. The run then ended before that epoch: the network has the weights
        that it had there, or the best ones.
    """

    network: JacobianNet
    losses: tuple[Loss, ...]
    stopped_early: bool
    diverged: bool


def network_for(
    architecture: Architecture,
    inputs: Inputs,
    entries: Entries,
    data: JacobianData,
    seed: int,
    validation: float = 0.2,
) -> JacobianNet:
    """Return an untrained network whose scalings are fitted to the training part of Jacobian data.

    Parameters
    ----------
    architecture, inputs, entries
        As for :class:`dexterity.workspace.jacobian_net.JacobianNet`.
    data
        Jacobian data.
    seed
        Of the initial weights.
    validation
        Share of the rows at the end that is held out.
    """
    checks.instance(data, "data", JacobianData)
    checks.choice(inputs, "inputs", get_args(Inputs))
    checks.choice(entries, "entries", get_args(Entries))
    train, _ = _parted(len(data.jacobian), _SHARE(validation, "validation"))
    x = inputs_of(data.samples, inputs)[train]
    y = encode(data.jacobian, data.samples, entries)[train]
    random = torch.Generator().manual_seed(checks.seed(seed))
    scalings = Scaling.to_unit_deviation(x), Scaling.to_range(y)
    return JacobianNet(architecture, inputs, entries, *scalings, random)


@checks.arguments(network=checks.Instance(JacobianNet), data=checks.Instance(ConfidenceData))
def confidence_rows(network: JacobianNet, data: ConfidenceData) -> Rows:
    """Return rows of the confidence head; errors are those of :meth:`.JacobianNet.scaled_inputs`."""
    checks.instance(data, "data", ConfidenceData)
    return Rows(network.scaled_inputs(data.samples), data.reachable[:, None].float())


@checks.arguments(network=checks.Instance(JacobianNet), data=checks.Instance(JacobianData))
def estimation_rows(network: JacobianNet, data: JacobianData) -> Rows:
    """Return rows of the estimation head; errors are those of :meth:`.JacobianNet.scaled_inputs`."""
    checks.instance(data, "data", JacobianData)
    y = encode(data.jacobian, data.samples, network.entries)
    return Rows(network.scaled_inputs(data.samples), network.scaling("out").apply(y).float())


@checks.arguments(
    rows=checks.Instance(Mapping), checkpoint=checks.OrNone(checks.path), progress=checks.Flag()
)
def train(
    network: JacobianNet,
    rows: Mapping[Head, Rows],
    options: Options,
    seed: int,
    checkpoint: Path | str | None = None,
    progress: bool = False,
) -> Training:
    """Train a network in place, on one thread.

    Parameters
    ----------
    network
        With its initial weights.
    rows
        Of each head in the schedule; the last ones are held out.
    options
        Schedule, optimiser and the rest.
    seed
        Of the order of the rows and of dropout.
    checkpoint
        File that the run is kept in after every epoch, and from which it goes on if it is there. If it can
        no longer be written later on, that is a warning: what has been learned is not lost by it.
    progress
        Whether a bar is shown.

    Raises
    ------
    ValueError
        If a head of the schedule has no rows, or too few to hold some out.
    OSError
        If the checkpoint cannot be written at the start.
    ArchiveError
        If the checkpoint is damaged, or of a run with another architecture, other options or other data.
    """
    checks.instance(network, "network", JacobianNet)
    checks.instance(options, "options", Options)
    run = _Run(network, rows, options, checks.seed(seed))
    if checkpoint is not None:
        run.resume(checkpoint)
        run.keep(checkpoint)  # where it cannot be written, this is known before an epoch is lost
    with (
        one_thread(),
        tqdm(total=len(options.schedule), initial=len(run.losses), disable=not progress) as bar,
    ):
        while not run.is_over:
            run.advance()
            if run.diverged:
                break
            if checkpoint is not None:
                try:
                    run.keep(checkpoint)
                except OSError as error:
                    warnings.warn(
                        f"checkpoint could not be written, the training goes on: {error}", stacklevel=2
                    )
            bar.update()
            bar.set_postfix_str(f"{run.losses[-1].head} {run.losses[-1].validation:.2e}")
    run.settle()
    return Training(network, tuple(run.losses), run.is_out_of_patience, run.diverged)


class _Run:
    """A run between two epochs."""

    def __init__(self, network: JacobianNet, rows: Mapping[Head, Rows], options: Options, seed: int) -> None:
        self.network, self.options, self.seed = network, options, seed
        heads = dict.fromkeys(epoch.head for epoch in options.schedule)
        if missing := [head for head in heads if head not in rows]:
            raise ValueError(f"rows lack {', '.join(missing)}, which the schedule trains")
        self.parts = {head: _split(rows[head], options.validation) for head in heads}
        make = OPTIMISERS[options.optimiser]
        self.optimisers = {head: make(self._parameters(head), lr=options.rate) for head in heads}
        self.losses: list[Loss] = []
        self.best = math.inf
        self.best_epoch = 0
        self.best_weights: dict[str, Tensor] = {}
        self.diverged = False
        self.key = {
            "network": network.header(),
            "options": asdict(options) | {"schedule": [list(epoch) for epoch in options.schedule]},
            "seed": seed,
            "data": store.content_key({head: tuple(rows[head]) for head in heads}),
            "initial weights": store.content_key(network.state_dict()),
        }

    def _parameters(self, head: Head) -> list[Tensor]:
        return [*self.network.encoder.parameters(), *self.network.get_submodule(head).parameters()]

    @property
    def is_out_of_patience(self) -> bool:
        patience = self.options.patience
        return patience is not None and len(self.losses) - self.best_epoch >= patience

    @property
    def is_over(self) -> bool:
        return len(self.losses) == len(self.options.schedule) or self.is_out_of_patience

    def advance(self) -> None:
        """Train one epoch and look at the held-out rows; where a loss is not finite, take the epoch back."""
        number = len(self.losses)
        head, frozen = self.options.schedule[number]
        random = torch.Generator().manual_seed(int(store.content_key(self.seed, number), 16) % 2**63)
        train, held_out = self.parts[head]
        before = self._weights()
        loss = Loss(head, self._epoch(head, frozen, train, random), self._loss_on(head, held_out))
        if not (math.isfinite(loss.train) and math.isfinite(loss.validation)):
            self.network.load_state_dict(before)
            self.diverged = True
            return
        self.losses.append(loss)
        last = {loss.head: loss.validation for loss in self.losses}
        score = sum(last.values()) if last.keys() == self.parts.keys() else math.inf
        if self.options.patience is not None and score < self.best:
            self.best, self.best_epoch = score, len(self.losses)
            self.best_weights = self._weights()
        elif math.isinf(score):
            self.best_epoch = len(self.losses)

    def _weights(self) -> dict[str, Tensor]:
        return {name: part.clone() for name, part in self.network.state_dict().items()}

    def _epoch(self, head: Head, frozen: bool, rows: Rows, random: torch.Generator) -> float:
        network, optimiser = self.network, self.optimisers[head]
        network.train()
        network.encoder.train(not frozen)
        network.encoder.requires_grad_(not frozen)
        network.draw_from(random)
        order = torch.randperm(len(rows.x), generator=random).split(self.options.batch)
        # Batch normalisation cannot do with one row.
        order = [batch for batch in order if len(batch) > 1]
        total = 0.0
        for step, batch in enumerate(order):
            for group in optimiser.param_groups:
                group["lr"] = self._rate(head, step / len(order))
            optimiser.zero_grad()
            loss = self._loss(head, Rows(rows.x[batch], rows.y[batch]))
            loss.backward()
            optimiser.step()
            total += loss.item()
        network.encoder.requires_grad_(True)
        return total / len(order)

    def _rate(self, head: Head, part: float) -> float:
        if not self.options.decay:
            return self.options.rate
        done = sum(loss.head == head for loss in self.losses) + part
        every = sum(epoch.head == head for epoch in self.options.schedule)
        return self.options.rate * (1 + math.cos(math.pi * done / every)) / 2

    def _loss(self, head: Head, rows: Rows) -> Tensor:
        y = self.network.get_submodule(head)(self.network.encoder(rows.x))
        return binary_cross_entropy_with_logits(y, rows.y) if head == "confidence" else mse_loss(y, rows.y)

    @torch.no_grad()
    def _loss_on(self, head: Head, rows: Rows) -> float:
        self.network.eval()
        parts = [
            self._loss(head, Rows(x, y)).double() * len(x)
            for x, y in zip(rows.x.split(_ROWS), rows.y.split(_ROWS), strict=True)
        ]
        return (torch.stack(parts).sum() / len(rows.x)).item()

    def settle(self) -> None:
        """Take the best weights, where patience has kept them."""
        if self.best_weights:
            self.network.load_state_dict(self.best_weights)
        self.network.eval()

    # ---- checkpoints ------------------------------------------------------------------------------

    def keep(self, path: Path | str) -> None:
        header = {
            "run": self.key,
            "losses": [list(loss) for loss in self.losses],
            "best": None if math.isinf(self.best) else self.best,
            "best epoch": self.best_epoch,
        }
        write_archive(path, _KIND, header, dict(self._tensors()))

    def _tensors(self) -> Iterator[tuple[str, Tensor]]:
        yield from ((f"weights/{name}", part) for name, part in self.network.state_dict().items())
        yield from ((f"best/{name}", part) for name, part in self.best_weights.items())
        for head, optimiser in self.optimisers.items():
            for number, state in optimiser.state_dict()["state"].items():
                for name, part in state.items():
                    if part is not None:
                        yield f"{head}/{number}/{name}", part

    def resume(self, path: Path | str) -> None:
        """Go on where a checkpoint is; do nothing if there is none."""
        try:
            header, tensors = read_archive(path, _KIND)
        except FileNotFoundError:
            return
        self._require_own(header, path)
        try:
            self._restore(header, tensors)
        except (KeyError, TypeError, ValueError, AttributeError, RuntimeError) as error:
            raise ArchiveError(f"{os.fspath(path)} holds no run that can go on: {error}") from error

    def _restore(self, header: Mapping[str, Any], tensors: Mapping[str, Tensor]) -> None:
        self.losses = [Loss(*loss) for loss in header["losses"]]
        self.best = math.inf if header["best"] is None else header["best"]
        self.best_epoch = header["best epoch"]
        weights, self.best_weights = _below("weights", tensors), _below("best", tensors)
        require_like(weights, self.network.state_dict())
        if header["best"] is not None:
            require_like(self.best_weights, self.network.state_dict())
        self.network.load_state_dict(weights)
        for head, optimiser in self.optimisers.items():
            own: dict[int, dict[str, Any]] = {}
            for name, part in _below(head, tensors).items():
                number, _, field = name.partition("/")
                own.setdefault(int(number), {})[field] = part
            optimiser.load_state_dict(optimiser.state_dict() | {"state": own})

    def _require_own(self, header: Mapping[str, Any], path: Path | str) -> None:
        theirs = header.get("run")
        if not isinstance(theirs, dict):
            raise ArchiveError(f"{os.fspath(path)} does not say of which run it is")
        own = json.loads(json.dumps(self.key))  # as a header gives it back, with lists for tuples
        if other := [name for name, value in own.items() if theirs.get(name) != value]:
            raise ArchiveError(
                f"{os.fspath(path)} is the checkpoint of another run: its {', '.join(other)} differ; "
                "give each run a file of its own"
            )


_ROWS = 65_536
_KIND = "training"


def _below(prefix: str, tensors: Mapping[str, Tensor]) -> dict[str, Tensor]:
    start = f"{prefix}/"
    return {name.removeprefix(start): part for name, part in tensors.items() if name.startswith(start)}


def _split(rows: Rows, validation: float) -> tuple[Rows, Rows]:
    train, held_out = _parted(len(rows.x), validation)
    return Rows(rows.x[train], rows.y[train]), Rows(rows.x[held_out], rows.y[held_out])


def _parted(count: int, validation: float) -> tuple[slice, slice]:
    held_out = round(validation * count)
    if held_out < 1 or count - held_out < 2:
        raise ValueError(f"there are {count} rows, too few to hold out a share of {validation}")
    return slice(count - held_out), slice(count - held_out, None)
