"""How much the label, the Jacobian and the choice of a pose depend on each group of columns.

The columns of a group are shuffled among the samples. Half the mean square of the change, over the variance, is the
share of the variance that needs these columns, where columns are independent (Jansen 1999).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
import torch
from torch import Tensor

from dexterity import spatial
from dexterity.workspace import dataset, reachability
from dexterity.workspace.dataset import Samples
from dexterity.workspace.dynamics import DynamicParameters, asada_ratio
from dexterity.workspace.reachability import LINK_NAMES
from dexterity_study.engine.experiment import experiment

ANGLES = "three angles"
SINGLE = (*LINK_NAMES, "x", "y", "z")
"""Groups of one column."""


@experiment(keys=("columns",), smoke={"count": 1000}, rtol=1e-5, atol=1e-6)
def influence(seed: int, count: int = 500_000) -> Iterator[dict[str, Any]]:
    """Shares of the variance that need a group of columns, and bits on the label in one column by itself.

    A tenth of the samples is used for the poses that are kept for their inertia.
    """
    samples, label = dataset.confidence_data(count, seed + 20, redraw=0.0)
    dynamic = dataset.confidence_data(count, seed + 40, dynamics=True, redraw=0.0)
    arms = dynamic.samples.rows(dynamic.reachable.nonzero()[: count // 10, 0])
    kept, reached = _is_kept(arms), samples.rows(label)
    J = _jacobian(reached)
    random = torch.Generator().manual_seed(seed + 6)
    order = [torch.randperm(len(own), generator=random) for own in (label, J, kept)]
    for name, columns in groups(dynamic.samples).items():
        row = {"columns": name, "kept": needed(kept, _is_kept(shuffled(arms, name, order[2])))}
        if name in DynamicParameters._fields:
            # Neither label nor Jacobian is a function of them.
            own = bits(columns.flatten(1), dynamic.reachable)
            yield {**row, "label": 0.0, "jacobian": 0.0, "bits": own}
        else:
            other = shuffled(reached, name, order[1])
            still = _is_reachable(other)
            yield {
                **row,
                "label": needed(label, _is_reachable(shuffled(samples, name, order[0]))),
                "jacobian": needed(J[still], _jacobian(other.rows(still))),
                "bits": bits(groups(samples)[name], label),
            }


def needed(one: Tensor, other: Tensor) -> float:
    """Return half the mean square of the changes, over the variance, of all outputs together."""
    one, other = one.double(), other.double()
    variance = torch.cat([one, other]).var(0, correction=0).sum()
    return (0.5 * (one - other).square().mean(0).sum() / variance).item()


def bits(columns: Tensor, label: Tensor) -> float:
    """Return the mutual information of a column, in 20 equal parts of its range, and a label; the mean over columns.

    The part that chance alone makes is taken off, (parts − 1) / 2n (Miller 1955).
    """
    from sklearn.metrics import mutual_info_score

    low, high = columns.amin(0), columns.amax(0)
    parts = (20 * (columns - low) / (high - low)).clamp(max=19.5).floor()
    found = [mutual_info_score(part, label) - 19 / (2 * len(label)) for part in parts.mT.numpy()]
    return float(np.mean(found) / math.log(2))


def groups(samples: Samples) -> dict[str, Tensor]:
    """Return the columns of samples (n, ...) by their group."""
    single = torch.cat([samples.links, samples.position], 1).split(1, 1)
    dynamics = {} if samples.dynamics is None else samples.dynamics._asdict()
    return {**dict(zip(SINGLE, single, strict=True)), ANGLES: samples.angles, **dynamics}


def shuffled(samples: Samples, name: str, order: Tensor) -> Samples:
    """Return samples with a group of columns in another order."""
    own = groups(samples)
    own[name] = own[name][order]
    links, position = (torch.cat([own[column] for column in part], 1) for part in (SINGLE[:4], SINGLE[4:]))
    dynamics = samples.dynamics and DynamicParameters(*(own[field] for field in DynamicParameters._fields))
    return Samples(links, position, own[ANGLES], dynamics)


def _is_reachable(samples: Samples) -> Tensor:
    return reachability.reachable(samples.links, samples.position)


def _joints(samples: Samples) -> Tensor:
    return reachability.inverse(samples.links, spatial.pose(samples.rotation(), samples.position))[0]


def _jacobian(samples: Samples) -> Tensor:
    return reachability.geometric_jacobian(samples.links, _joints(samples)).flatten(1)


def _is_kept(samples: Samples) -> Tensor:
    """Return whether poses are in reach and kept for their inertia."""
    parameters = DynamicParameters(*(samples.dynamics or ()))
    return _is_reachable(samples) & (asada_ratio(samples.links, parameters, _joints(samples)) > 0.03)
