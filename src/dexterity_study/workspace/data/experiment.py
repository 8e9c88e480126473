"""The worked example of paper C, its data sets, the rule behind their labels, and their maps.

Liao & Mao (2018), Eqs. 1–12, Tables I–V, Figs. 2–4.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from scipy import stats
from sklearn.manifold import TSNE
from sklearn.model_selection import cross_val_score
from sklearn.neighbors import KNeighborsRegressor
from torch import Tensor

from dexterity import robots, spatial
from dexterity.chain import Chain
from dexterity.inverse_kinematics import spherical_wrist
from dexterity.workspace import dataset, reachability
from dexterity.workspace.dataset import ConfidenceData, JacobianData, Samples, Scaling
from dexterity.workspace.dynamics import DynamicParameters, asada_ratio
from dexterity.workspace.reachability import LINK_NAMES
from dexterity_study.engine.experiment import experiment

SIZES = {"conf": (3000, 297_000), "conf_dyna": (2000, 198_000), "jacob": (2000, 198_000)}
"""Samples of the test and of the training set of each kind, Table I; Jacobians are written in two frames."""

SAME = 1e-9
"""Up to where entries are the same, which differ by rounding."""

ANGLES, QUANTITIES = "three angles", (*LINK_NAMES, "x", "y", "z")

Row = dict[str, Any]
STEADY = {"rtol": 1e-5, "atol": 1e-6}
REDRAWN = {"paper": "liao2018", "assumes": ("redraw",)}


def fanuc_arm() -> Chain:
    """Return the arm of the paper's Fig. 1, with its flange for a tool."""
    return robots.build(robots.describe("fanuc_am120ib"))


@experiment(
    arrays=("pose", "jacobian", "steps", "forward", "central"),
    smoke={"decades": 7},
    data=("robots/fanuc_am120ib.toml",),
    **STEADY,
)
def fanuc(seed: int, step: float = 1e-9, decades: int = 14) -> tuple[list[Row], Row]:
    """Differences of the pose of the Fanuc arm over steps of its joints, and its exact Jacobian.

    Errors of entries: with the paper's step at zero; by step at random configurations. Deviations along random rates
    of the joints: of the sum over the joints from the derivative of the pose, and of the twist from the Jacobian's.
    """
    arm, zero, eye = fanuc_arm(), torch.zeros(6, dtype=torch.float64), torch.eye(6, dtype=torch.float64)
    random = torch.Generator().manual_seed(seed)
    drawn = 2 * torch.rand(101, 6, generator=random, dtype=torch.float64) - 1
    rates, q = drawn[0], math.pi * drawn[1:]
    steps = torch.logspace(-1, -decades, 4 * (decades - 1) + 1, dtype=torch.float64).numpy()
    exact, at_zero = arm.geometric_jacobian(q), arm.geometric_jacobian(zero)

    def along(direction: Tensor) -> Tensor:
        return (arm.forward(1e-6 * direction) - arm.forward(-1e-6 * direction)) / 2e-6

    parts = torch.stack([along(unit) * rate for unit, rate in zip(eye, rates, strict=True)])
    row = {
        "printed_step": (by_difference(arm.forward, zero, step, central=False) - at_zero).abs().max(),
        "sum": (along(rates) - parts.sum(0)).abs().max(),
        "twist": (_twist(along(rates), arm.forward(zero)) - at_zero @ rates).abs().max(),
    }
    curves = {
        kind: np.array(
            [(by_difference(arm.forward, q, h, kind == "central") - exact).abs().max() for h in steps]
        )
        for kind in ("forward", "central")
    }
    pose = (arm.forward(step * eye[0]) - arm.forward(zero)) / step
    return [row], {"pose": pose.numpy(), "jacobian": at_zero.numpy(), "steps": steps, **curves}


def by_difference(forward: Callable[[Tensor], Tensor], q: Tensor, step: float, central: bool) -> Tensor:
    """Return the geometric Jacobian (..., 6, n) by Eqs. 1 and 7."""
    moves = step * torch.eye(q.shape[-1], dtype=torch.float64)
    here = forward(q)[..., None, :, :]
    if central:
        rates = (forward(q[..., None, :] + moves) - forward(q[..., None, :] - moves)) / (2 * step)
    else:
        rates = (forward(q[..., None, :] + moves) - here) / step
    return _twist(rates, here).mT


def _twist(rate: Tensor, here: Tensor) -> Tensor:
    """Return velocity and angular velocity (..., 6) from the rate of a pose."""
    spin = rate[..., :3, :3] @ here[..., :3, :3].mT
    pairs = ((2, 1), (0, 2), (1, 0))
    omega = torch.stack([(spin[..., i, j] - spin[..., j, i]) / 2 for i, j in pairs], -1)
    return torch.cat([rate[..., :3, 3], omega], -1)


@experiment(keys=("file", "columns"), readings=("redraw=0",), smoke={"share": 0.01}, **REDRAWN, **STEADY)
def files(seed: int, reading: Mapping[str, Any], share: float = 1.0) -> Iterator[Row]:
    """Contents of the files of Table I, the range of each group of columns, and its distance from uniform draws."""
    for file, (samples, targets) in sets(seed, share, reading["redraw"]).items():
        x = dataset.features(samples)
        constant = (x.amax(0) == x.amin(0)).nonzero()[:, 0].tolist()
        yield {
            "file": file,
            "columns": "all",
            "targets": targets.shape[1],
            "varying_targets": int((targets.amax(0) - targets.amin(0) > SAME).sum()),
            "features": x.shape[1],
            "varying_features": x.shape[1] - len(constant),
            "constant": ", ".join(map(str, constant)),
            "samples": len(x),
            "is_binary": bool(((targets == 0) | (targets == 1)).all()),
            "mean_target": targets.mean(),
        }
        distances = _distances(samples)
        groups = column_groups(samples.dynamics is not None)
        for name in distances | groups:
            row: Row = {"distance": distances[name]} if name in distances else {}
            if name in groups:
                row |= {"low": x[:, groups[name]].min(), "high": x[:, groups[name]].max()}
            yield {"file": file, "columns": name, **row}


def sets(seed: int, share: float = 1.0, redraw: float = 0.75) -> dict[str, tuple[Samples, Tensor]]:
    """Draw samples and targets (n, columns) of each file; training sets have a share of the paper's sizes."""
    random = torch.Generator().manual_seed(seed + 9)
    found = {}
    for number, (name, (test, whole)) in enumerate(SIZES.items()):
        train = round(share * whole)
        data: ConfidenceData | JacobianData
        if name == "jacob":
            data = dataset.jacobian_data(test + train, seed + number)
            targets = {"jacob": data.in_frame("tool").flatten(1), "jacob0": data.jacobian.flatten(1)}
        else:
            data = dataset.confidence_data(test + train, seed + number, name == "conf_dyna", redraw)
            targets = {name: data.reachable.double()[:, None]}
        # Jacobians come in the order in which they were found, and the first ones are of arms that reach far.
        parts = torch.randperm(test + train, generator=random).split([test, train])
        for file, own in targets.items():
            for part, rows in zip(("test", "train"), parts, strict=True):
                found[f"{file}, {part}"] = data.samples.rows(rows), own[rows]
    return found


def column_groups(dynamic: bool) -> dict[str, list[int]]:
    """Return the columns that are not twists, by the groups of Tables II to V."""
    known = dataset.COLUMNS if dynamic else dataset.KINEMATIC_COLUMNS
    columns = {name: list(range(96))[own] for name, own in known.items()}
    groups = {"links": [*columns.pop("d")[2:4], *columns.pop("a")[1:3]]}
    del columns["alpha"]
    if "coulomb" in columns:
        own = columns.pop("coulomb")
        columns |= {"friction forwards": own[0::2], "friction backwards": own[1::2]}
    return groups | columns


def _distances(samples: Samples) -> dict[str, float]:
    """Return Kolmogorov and Smirnov's distance from the uniform distribution, the largest of a group's columns."""
    groups = {
        "links": samples.links / dataset.LARGEST_LENGTH,
        "position": (samples.position + 0.4) / 0.8,
        "angles": samples.angles / math.tau,
        # For orientations that are uniform, the sine of the middle angle would be.
        "sine of the middle angle": (samples.angles[:, 1:2].sin() + 1) / 2,
    }
    tests = {name: stats.kstest(columns, "uniform", axis=0) for name, columns in groups.items()}
    return {name: test.statistic.max().item() for name, test in tests.items()}


@experiment(smoke={"manipulators": 10, "poses": 100}, **STEADY)
def rule(seed: int, manipulators: int = 1000, poses: int = 1000) -> Iterator[Row]:
    """The rule for what is in reach against all branches of the inverse kinematics.

    Counts poses on which they disagree, and those that are won or lost when the tool is turned; shares of the poses in
    reach with eight different configurations, and with eight different Jacobians.
    """
    samples, _ = dataset.confidence_data(manipulators * poses, seed + 30, redraw=0.0)
    T = spatial.pose(samples.rotation(), samples.position).unflatten(0, (manipulators, -1))
    turned_T = spatial.pose(T[..., :3, :3].roll(1, dims=1), T[..., :3, 3])
    disagreements, turned, reached, eight, different = 0, 0, 0, 0, []
    for number, (links, own) in enumerate(zip(samples.links[: len(T)], T, strict=True)):
        arm = reachability.arm(links)
        q, valid = spherical_wrist(arm, own)
        found = valid.any(-1)
        disagreements += int((reachability.reachable(links, own[:, :3, 3]) != found).sum())
        reached += int(found.sum())
        eight += int(_all_apart(spatial.wrap_to_pi, q[valid.all(-1)]).sum())
        # A tenth is enough for what is beside the point.
        if number < max(1, manipulators // 10):
            turned += int((spherical_wrist(arm, turned_T[number])[1].any(-1) != found).sum())
            J = arm.geometric_jacobian(q[valid.all(-1)])
            different.append(_all_apart(torch.Tensor.abs, J.flatten(-2)))
    yield {
        "tried": manipulators * poses,
        "disagreements": disagreements,
        "turned": turned,
        "eight": eight / reached,
        "jacobians": torch.cat(different).double().mean(),
    }


def _all_apart(gap: Callable[[Tensor], Tensor], values: Tensor) -> Tensor:
    """Return whether no two of eight vectors (n, 8, m) are the same, for each of n."""
    gaps = gap(values[:, :, None] - values[:, None]).abs().amax(-1)
    return (gaps + torch.eye(8, dtype=values.dtype)).amin((1, 2)) > 1e-6


@experiment(
    keys=("map", "quantity"),
    arrays=("features", "features_links", "Jacobians", "Jacobians_links"),
    smoke={"share": 0.01, "points": 60},
    **REDRAWN,
    **STEADY,
)
def maps(
    seed: int, reading: Mapping[str, Any], share: float = 1.0, points: int = 2000
) -> tuple[list[Row], Row]:
    """Maps of test sets by t-SNE, and R² with which ten neighbours on a map predict lengths and position.

    A map of ten columns of uniform numbers, as many as features vary, stands beside them.
    """
    own = sets(seed, share, reading["redraw"])
    features, (samples, jacobians) = own["conf, test"][0], own["jacob0, test"]
    noise = torch.rand(points, 10, generator=torch.Generator().manual_seed(seed + 50), dtype=torch.float64)
    drawn = {
        "features": (dataset.features(features), _columns(features)),
        "Jacobians": (jacobians, _columns(samples)),
        "noise": (noise, noise[:, :7]),
    }
    rows, arrays = [], dict[str, Any]()
    for name, (x, asked) in drawn.items():
        places = embedded(x[:points], seed)
        for quantity, values in zip(QUANTITIES, asked[:points].mT.numpy(), strict=True):
            found = cross_val_score(KNeighborsRegressor(10), places, values, scoring="r2", cv=5)
            rows.append({"map": name, "quantity": quantity, "determination": found.mean()})
        if name != "noise":
            arrays |= {name: places, f"{name}_links": asked[:points, :4].numpy().astype(np.float32)}
    return rows, arrays


def _columns(samples: Samples) -> Tensor:
    return torch.cat([samples.links, samples.position], 1)


def embedded(rows: Tensor, seed: int) -> NDArray[np.float32]:
    """Lay points (n, columns), more than 30, in the plane by t-SNE; columns are scaled, constant ones left out.

    Source: van der Maaten & Hinton (2008), Visualizing data using t-SNE.
    """
    varying = rows.amax(0) - rows.amin(0) > SAME
    scaled = Scaling.to_unit_deviation(rows).apply(rows)[:, varying]
    places: NDArray[np.float64] = TSNE(init="pca", random_state=seed).fit_transform(scaled.numpy())
    return places.astype(np.float32)


@experiment(keys=("columns",), smoke={"count": 1000}, **STEADY)
def influence(seed: int, count: int = 500_000) -> Iterator[Row]:
    """Shares of the variance of the label, the Jacobian and the choice of a pose that need a group of columns.

    The columns of a group are shuffled among the samples. Half the mean square of the change, over the variance, is
    the share that needs these columns, where columns are independent (Jansen 1999). A tenth of the samples is used
    for the poses that are kept for their inertia.
    """
    samples, label = dataset.confidence_data(count, seed + 20, redraw=0.0)
    dynamic = dataset.confidence_data(count, seed + 40, dynamics=True, redraw=0.0)
    arms = dynamic.samples.rows(dynamic.reachable.nonzero()[: count // 10, 0])
    kept, reached = _is_kept(arms), samples.rows(label)
    J = _jacobian(reached)
    random = torch.Generator().manual_seed(seed + 6)
    order = [torch.randperm(len(own), generator=random) for own in (label, J, kept)]
    for name in _groups(arms):
        # Neither label nor Jacobian is a function of the dynamics.
        row = {"label": 0.0, "jacobian": 0.0}
        if name not in DynamicParameters._fields:
            other = shuffled(reached, name, order[1])
            still = _is_reachable(other)
            row["label"] = needed(label, _is_reachable(shuffled(samples, name, order[0])))
            row["jacobian"] = needed(J[still], _jacobian(other.rows(still)))
        yield {"columns": name, "kept": needed(kept, _is_kept(shuffled(arms, name, order[2]))), **row}


def needed(one: Tensor, other: Tensor) -> float:
    """Return half the mean square of the changes, over the variance, of all outputs together."""
    one, other = one.double(), other.double()
    variance = torch.cat([one, other]).var(0, correction=0).sum()
    return (0.5 * (one - other).square().mean(0).sum() / variance).item()


def _groups(samples: Samples) -> dict[str, Tensor]:
    single = dict(zip(QUANTITIES, _columns(samples).split(1, 1), strict=True))
    return single | {ANGLES: samples.angles} | (samples.dynamics._asdict() if samples.dynamics else {})


def shuffled(samples: Samples, name: str, order: Tensor) -> Samples:
    """Return samples with a group of columns in another order."""
    own = _groups(samples)
    own[name] = own[name][order]
    links, position = torch.cat([own[column] for column in QUANTITIES], 1).split([4, 3], 1)
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
