"""Proved bounds of relative errors: the shipped network for w, polynomials beside it, and how far KCI's goes.

Bounds hold on the whole box of the network, seven joints between −15° and 15°. KCI has kinks where singular values
meet, and so has its network: there nothing is proved, and elsewhere bounds of the eigenvalues are compared.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from typing import Any

import numpy as np
import sympy
import torch
from sympy import Expr
from torch import Tensor

from dexterity import checks, networks, robots, sampling
from dexterity.codegen.taylor_models import TaylorModels, exactly
from dexterity.derivation import Derivation, derive
from dexterity.elimination import Matrix, dot, gram
from dexterity.indices import Index
from dexterity.networks.baselines import Polynomial, polynomial
from dexterity.networks.certificate import Approximation, Certificate, certify, recheck, relative_error
from dexterity.networks.certificate_check import is_bounded
from dexterity.networks.feed_forward import FeedForward
from dexterity.networks.folding import Sigmoids, folded, origin_program
from dexterity.networks.network import Network
from dexterity.networks.worst_case import Search, worst_case
from dexterity.program import Program, Recorder
from dexterity.sampling import Box
from dexterity_study.engine.experiment import experiment
from dexterity_study.engine.table import Row

NETWORK = "uvms-manipulability-feed-forward"
OF_KCI = "uvms-kinematic-conditioning-feed-forward"
OF_DATA = {"data": ("robots/uvms.toml", f"networks/{NETWORK}.npz")}
FACTORS = {"network": (1.3, 1.1, 1.01), "cubic": (1.3, 1.01), "quadratic": (1.3,)}
"""Bounds to prove, as multiples of the largest error that ascent finds."""

CHECKED = 1.01
"""The factor of the certificate whose parts are proved again by other arithmetic."""

DEGREE = 5
"""Of the Taylor models of the certificate that is checked; the parts are smaller than at degree 6."""

ULPS_OF_TANH = 32
"""Error of a hyperbolic tangent that is allowed for, in units of 2^-53."""

PARAMETERS = 36 + 9
"""Eigenvectors that a box brings along: of a matrix of six rows and of one of three."""

HALF_WIDTHS = (0.001, 0.002, 0.004, 0.008, 0.016, 0.032)
"""Half widths of boxes for KCI, [rad] and [m]; those of the network's space are 0.26 rad and up to 0.4 m."""

LIMIT = 0.02
"""Relative error that paper A accepts."""

_W = Index("manipulability")
_SMALL_SEARCH = Search(samples=500, starts=8, steps=50)


@experiment(
    keys=("approximation", "factor"),
    arrays=tuple(f"{name}_{what}" for name in FACTORS for what in ("tree", "bounds")),
    smoke={"factors": {"network": (1.3,), "quadratic": (1.5,)}, "share": 0.2, "search": _SMALL_SEARCH},
    timed=True,
    rtol=1e-3,
    unsteady=("seconds", "models", "parts", "digest"),
    **OF_DATA,
)
def proofs(
    factors: Mapping[str, Sequence[float]] = FACTORS, share: float = 1.0, search: Search | None = None
) -> tuple[list[dict[str, Any]], dict[str, Any]]:
    """Bounds proved on a share of the box about its middle, the work that it took, and the closest bound's tree."""
    rows: list[dict[str, Any]] = []
    arrays: dict[str, Any] = {}
    box = _share_of_box(share)
    for name, of_name in factors.items():
        approximation = _approximation(name)
        found = worst_case(approximation, _W.bind(robots.uvms()), box, search or Search()).error
        for factor in of_name:
            # Six digits, so that the stored number is the one that was proved and that the digest covers.
            wanted = float(f"{factor * found:.6g}")
            one = certify(approximation, robots.uvms(), _W, box, wanted, threads=1, progress=False)
            rows.append({"approximation": name, "factor": factor, "found": found, **_facts(one)})
            arrays |= {f"{name}_tree": one.tree, f"{name}_bounds": one.bounds}
    return rows, arrays


@experiment(
    seeds=10,
    smoke={"share": 0.2, "count": 2},
    unsteady=("seconds", "parts", "digest"),
    **OF_DATA,
)
def checked(seed: int, count: int = 110, share: float = 1.0) -> Iterator[Row]:
    """Parts of a certificate of the network for w that are proved again, of those that were tried."""
    box, network = _share_of_box(share), _approximation("network")
    wanted = CHECKED * networks.load_shipped(NETWORK).card["worst_case"]["error"]
    one = certify(network, robots.uvms(), _W, box, wanted, DEGREE, threads=1, progress=False)
    program = relative_error(network, robots.uvms(), _W, box)
    lowers, uppers, _ = one.parts
    order = np.random.default_rng(0).permutation(len(lowers))
    chosen = order[seed * count % len(order) :][:count].tolist()
    confirmed = [is_bounded(program, lowers[i], uppers[i], one.wanted, DEGREE) for i in chosen]
    again = recheck(one, network, robots.uvms(), _W, box, chosen)
    yield {**_facts(one), "tried": len(chosen), "confirmed": sum(confirmed), "compiled_again": again}


@experiment(smoke={"share": 0.2}, rtol=1e-3, **OF_DATA)
def evaluation(share: float = 1.0) -> Iterator[Row]:
    """Bound of what double precision adds to the relative error, and the bound of w from below that it takes."""
    network, box = _feed_forward(), _share_of_box(share)
    own = {name: array.numpy() for name, array in network.state_dict().items()}
    x = (np.abs(box_of_network().upper)[list(network.inputs)] + np.abs(own["input_centre"])) / own[
        "input_half_range"
    ]
    # Sums of magnitudes; the slope of tanh is at most 1. A sum of n rounded products errs by (n + 1) units of it.
    entering = np.abs(own["hidden_weights"]) @ x + np.abs(own["hidden_biases"])
    neurons, inputs = own["hidden_weights"].shape
    weights = np.abs(own["output_weights"][0])
    target = own["target_half_range"] * (weights @ (1 + entering) + np.abs(own["output_biases"][0]))
    units = ULPS_OF_TANH + inputs + neurons + 8
    error = units * 2.0**-53 * float(target + np.abs(own["target_centre"][0]))
    middle = float(own["target_centre"][0])
    constant = Polynomial(
        network.view, network.input_centre, network.input_half_range,
        torch.tensor([[network.view.width]]), torch.tensor([middle], dtype=torch.float64),
    )  # fmt: skip
    away = certify(constant, robots.uvms(), _W, box, 0.5, degree=4, threads=1, progress=False)
    least = middle / (1 + away.bound)
    yield {"least_w": least, "rounding": error / least}


def _facts(one: Certificate) -> dict[str, Any]:
    names = ("wanted", "bound", "reached", "complete", "models", "seconds", "digest")
    return {**{name: getattr(one, name) for name in names}, "parts": len(one.parts[0])}


def _approximation(name: str) -> Approximation:
    """The shipped network, or a polynomial fitted to the rows that such a network is trained on."""
    network = _feed_forward()
    if name == "network":
        return network
    train = sampling.data_sets(
        _W.bind(robots.uvms()), box_of_network(), train=5000, test=100, validation=100, seed=0
    ).train
    return polynomial(network.view, train, {"quadratic": 2, "cubic": 3}[name])


def _feed_forward() -> FeedForward:
    return checks.instance(networks.load_shipped(NETWORK), "network", FeedForward)


def box_of_network() -> Box:
    """The box on the card of the network for w."""
    return checks.instance(networks.load_shipped(NETWORK).card.space(), "space", Box)


def _share_of_box(share: float) -> Box:
    """The network's box, or a smaller one about its middle, which is the robot at home."""
    box = box_of_network()
    return Box([share * low for low in box.lower], [share * high for high in box.upper])


# ---- KCI ----


@experiment(
    keys=("half_width",),
    seeds=10,
    smoke={"half_widths": (0.001,), "draws": 1, "degree": 2},
    rtol=1e-3,
    data=("robots/uvms.toml", f"networks/{OF_KCI}.npz"),
)
def conditioning(
    seed: int, half_widths: Sequence[float] = HALF_WIDTHS, draws: int = 10, degree: int = 3
) -> Iterator[Row]:
    """Bound for KCI on boxes about drawn configurations: eleven joints, half widths in rad and m alike."""
    network = networks.load_shipped(OF_KCI)
    sides = [TaylorModels(program, degree, PARAMETERS) for program in sides_of_error(network)]
    q = sampling.uniform(network.card.space(), draws, torch.Generator().manual_seed(seed))
    of_boxes, gaps = [axes(network, centre) for centre in q], [relative_gap(network, centre) for centre in q]
    for half_width in half_widths:
        bounds = [
            max(bound_on(side, centre, half_width, given) for side in sides)
            for centre, given in zip(q, of_boxes, strict=True)
        ]
        shown = [bound for bound in bounds if math.isfinite(bound)]
        refused = [gap for gap, bound in zip(gaps, bounds, strict=True) if not math.isfinite(bound)]
        yield {
            "half_width": half_width,
            "draws": draws,
            "bounded": len(shown),
            "within_limit": sum(bound <= LIMIT for bound in bounds),
            "median": float(np.median(shown)) if shown else None,
            "largest_gap_refused": max(refused) if refused else None,
        }


def bound_on(side: TaylorModels, q: Tensor, half_width: float, given: np.ndarray) -> float:
    """Bound on one box with one model, above or below, from eigenvectors at its middle."""
    centre = q.numpy()[: side.inputs]
    proof = side.prove(centre - half_width, centre + half_width, LIMIT, boxes=1, given=given)
    # The eigenvectors are orthonormal up to some 1e-15, and move all eigenvalues by as much of themselves.
    return float(proof.bounds[0]) + 1e-12


def axes(network: Network, q: Tensor) -> np.ndarray:
    """Eigenvectors (36 + 9) at a configuration, of J·Jᵀ and of the network's matrix, smallest eigenvalue first."""
    J, M = _jacobian(network, q), _network_matrix(network, q)
    return np.concatenate([np.linalg.eigh(matrix)[1].T.ravel() for matrix in (J @ J.T, M)])


def relative_gap(network: Network, q: Tensor) -> float:
    """Distance of the two smallest singular values from each other, relative to the smallest."""
    sigma = np.linalg.svd(_jacobian(network, q), compute_uv=False)
    return float(sigma[-2] / sigma[-1] - 1)


def _jacobian(network: Network, q: Tensor) -> np.ndarray:
    """Rows of the Jacobian in the axes and about the point of the derivation."""
    derivation = _derivation(network)
    values = dict(zip(derivation.joint_values, q.tolist(), strict=True))
    for symbol, expression in derivation.jacobian.steps:
        values[symbol] = float(expression.xreplace(values))
    entries = [float(entry.xreplace(values)) for entry in derivation.jacobian.outputs]
    return np.array(entries).reshape(6, -1)


def sides_of_error(network: Network) -> tuple[Program, Program]:
    r"""Programs of a function above N/KCI − 1 and of one below, given eigenvectors at the middle of a box.

    With the first axis along an eigenvector, a symmetric matrix is :math:`\begin{pmatrix} a & b^\top \\ b & C
    \end{pmatrix}` with a small b. Its smallest eigenvalue is the fixed point of :math:`f(\mu) = a - b^\top
    (C - \mu)^{-1} b`, which falls. So f(a) is below it and f(f(a)) above, as long as C − a is positive, which it is
    until the next eigenvalue comes near. The largest eigenvalue is minus the smallest of the negative matrix.
    """
    derivation = _derivation(network)
    record, q = Recorder("r"), derivation.joint_values
    given = sympy.symbols(f"v:{PARAMETERS}", real=True)
    entries = record.replay(derivation.jacobian)
    columns = len(entries) // 6
    rows = [entries[i * columns : (i + 1) * columns] for i in range(6)]
    turned = [
        [record(dot(given[6 * i : 6 * i + 6], column)) for column in zip(*rows, strict=True)]
        for i in range(6)
    ]
    A = gram(record, turned)
    low, high = _smallest(record, A)
    least, most = (-x for x in _smallest(record, [[-x for x in row[::-1]] for row in A[::-1]])[::-1])
    bottom, top = _smallest(record, _turned_network_matrix(record, network, q, given[36:]))
    above = record(sympy.exp(top)) * record(sympy.sqrt(record(most / low)))
    below = record(sympy.exp(bottom)) * record(sympy.sqrt(record(least / high)))
    above, below = (record.program((*q, *given), [record(side - 1)]) for side in (above, below))
    used = [symbol for symbol in q if symbol in above.used_inputs]
    first, second = (Program((*used, *given), side.steps, side.outputs) for side in (above, below))
    return first, second


def _smallest(record: Recorder, A: Matrix) -> tuple[Expr, Expr]:
    """Functions below and above the smallest eigenvalue."""
    below = _falling(record, A, A[0][0])
    return below, _falling(record, A, below)


def _falling(record: Recorder, A: Matrix, shift: Expr) -> Expr:
    """f(shift) by Cholesky's factors of C − shift, which exist where it is positive."""
    n = len(A)
    C = [[record(A[i][j] - (shift if i == j else 0)) for j in range(1, n)] for i in range(1, n)]
    L: Matrix = []
    z: list[Expr] = []
    value = A[0][0]
    for i in range(n - 1):
        row: list[Expr] = []
        for j in range(i):
            row.append(record(record(C[i][j] - dot(row, L[j][:j])) * L[j][j]))
        pivot = record(C[i][i] - dot(row, row))
        row.append(record(pivot ** sympy.Rational(-1, 2)))
        z.append(record(record(A[0][1 + i] - dot(row[:i], z)) * row[i]))
        L.append(row)
        value = value - record(z[i] ** 2)
    return record(value)


def _turned_network_matrix(
    record: Recorder, network: Network, q: Sequence[Expr], given: Sequence[Expr]
) -> Matrix:
    """The matrix whose smallest eigenvalue the network answers with, in given axes."""
    weights, origin = _sigmoids(network), origin_program(network.view)
    seen = [
        *record.replay(origin, dict(zip(origin.inputs, q, strict=False))),
        *(q[i] for i in network.inputs),
    ]
    hidden = [
        record(sympy.tanh(record(_weighted(row, seen) + exactly(bias))))
        for row, bias in zip(weights.hidden, weights.hidden_biases, strict=True)
    ]
    a, b, c, d, e, f = (
        record(_weighted(row, hidden) + exactly(bias))
        for row, bias in zip(weights.output, weights.output_biases, strict=True)
    )
    M = [[a, d, e], [d, b, f], [e, f, c]]
    V = [given[3 * i : 3 * i + 3] for i in range(3)]
    half = [[record(dot(axis, row)) for row in M] for axis in V]
    return [[record(dot(row, axis)) for axis in V] for row in half]


def _network_matrix(network: Network, q: Tensor) -> np.ndarray:
    weights = _sigmoids(network)
    hidden = np.tanh(weights.hidden @ network.view(q).numpy() + weights.hidden_biases)
    a, b, c, d, e, f = weights.output @ hidden + weights.output_biases
    return np.array([[a, d, e], [d, b, f], [e, f, c]])


def _sigmoids(network: Network) -> Sigmoids:
    weights = folded(network)
    if not isinstance(weights, Sigmoids):
        raise TypeError(f"network is a {type(network).__name__}; a FeedForward is needed")
    return weights


@cache
def _derivation(network: Network) -> Derivation:
    return derive(robots.uvms(), network.card.index())


def _weighted(weights: Sequence[float], values: Sequence[Expr]) -> Expr:
    return dot([exactly(weight) for weight in weights], values)
