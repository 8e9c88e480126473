r"""Proofs that a network's relative error stays below a bound everywhere in a box of configurations.

A search finds bad points and cannot show that there is none worse. Here the box is bisected until, on each
part, a Taylor model of :math:`N(q)/w(q) - 1` is bounded by the wanted number: a polynomial in all joints with
a remainder that covers what the polynomial leaves out, rounding included
(:mod:`dexterity.codegen.taylor_models`). The parts make a tree, with which anybody can repeat the proof of
any part.

The bound holds for the index and the network in real arithmetic, with the stored weights as they are.
Evaluation in double precision adds its own rounding, some :math:`10^{-14}`
(:func:`dexterity.networks.rounding.rounding`).

Examples
--------
A planar arm with a bent elbow, and the straight line through two of its values:

>>> import torch
>>> import dexterity as dx
>>> from dexterity.networks import baselines, certificate
>>> from dexterity.sampling import Box, DataSet
>>> arm = dx.Chain.from_dh([{"a": 0.5}, {"a": 0.4}])
>>> index = dx.indices.Index("manipulability", "geometric", rows=("vx", "vy"))
>>> q = torch.tensor([[0.0, 0.8], [0.0, 1.2]]).double()
>>> line = baselines.polynomial(dx.networks.View(2, [1]), DataSet(q, index.bind(arm)(q)), 1)
>>> proof = certificate.certify(line, arm, index, Box([0.0, 0.8], [0.0, 1.2]), 0.025, progress=False)
>>> proof.complete, proof.bound <= 0.025
(True, True)

References
----------
Makino & Berz (2003), Taylor models and other validated functional inclusion methods.
"""

from __future__ import annotations

import ctypes
import hashlib
import math
import time
from collections.abc import Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TypeAlias

import numpy as np
import sympy
from jaxtyping import Float64, Int64, UInt8
from sympy import Expr
from tqdm import tqdm

from dexterity import checks
from dexterity.chain import Chain
from dexterity.codegen.taylor_models import OPEN, TaylorModels, exactly
from dexterity.derivation import Derivation, derive
from dexterity.elimination import dot
from dexterity.indices import Index
from dexterity.networks.baselines import Polynomial
from dexterity.networks.feed_forward import FeedForward
from dexterity.networks.folding import origin_program
from dexterity.networks.network import View
from dexterity.networks.radial_basis import BIAS, RadialBasis
from dexterity.program import Program, Recorder
from dexterity.sampling import Box

__all__ = ["Approximation", "Certificate", "certify", "recheck", "relative_error"]

Approximation: TypeAlias = FeedForward | RadialBasis | Polynomial
"""Networks whose readout is smooth, and polynomials, which can be certified."""

Array: TypeAlias = np.ndarray

SHARED_BISECTIONS = 7
"""Bisections after which the parts of a box are given to threads."""


@dataclass(frozen=True)
class Certificate:
    """What was proved about a box, and the bisections that prove it.

    Attributes
    ----------
    joints
        The m joints that vary and matter, counted from 0.
    lower, upper
        (m) limits of the box, [rad] or [m].
    wanted
        Bound of the relative error that was to be proved.
    degree
        Of the Taylor models.
    tree
        (k) bisections in preorder: number of the halved joint among the m, then its lower and its upper half;
        `LEAF` for a part where the wanted bound is proved, `OPEN` for one where it is not.
    bounds
        (k) proved bound of each part that is a leaf or open.
    reached
        A relative error that is proved to occur somewhere in the box.
    models
        Number of Taylor models that were made.
    seconds
        Time that it took.
    """

    joints: tuple[int, ...]
    lower: Float64[np.ndarray, " m"]
    upper: Float64[np.ndarray, " m"]
    wanted: float
    degree: int
    tree: UInt8[np.ndarray, " k"]
    bounds: Float64[np.ndarray, " k"]
    reached: float = 0.0
    models: int = 0
    seconds: float = 0.0

    @property
    def complete(self) -> bool:
        """Whether the wanted bound is proved everywhere."""
        return not (self.tree == OPEN).any()

    @property
    def bound(self) -> float:
        """Proved bound of the relative error in the whole box; infinite if some part has none."""
        return float(self.bounds[self.tree >= OPEN].max())

    @property
    def digest(self) -> str:
        """SHA-256 of box, wanted bound, degree and tree."""
        content = hashlib.sha256(repr((self.joints, float(self.wanted), self.degree)).encode())
        for array in (self.lower, self.upper, self.tree):
            content.update(np.ascontiguousarray(array).tobytes())
        return content.hexdigest()

    @cached_property
    def parts(self) -> tuple[Float64[np.ndarray, "p m"], Float64[np.ndarray, "p m"], Int64[np.ndarray, " p"]]:
        """Lower and upper limits and depths of all parts, in the order of the tree; they tile the box.

        Raises
        ------
        ValueError
            If the tree is not whole.
        """
        parts = []
        todo = [(self.lower, self.upper, 0)]
        for halved in self.tree:
            if not todo or OPEN > halved >= len(self.joints):
                raise ValueError("tree is not whole: its bisections do not end where it ends")
            lower, upper, depth = todo.pop()
            if halved >= OPEN:
                parts.append((lower, upper, depth))
                continue
            first_upper, second_lower = upper.copy(), lower.copy()
            first_upper[halved] = second_lower[halved] = 0.5 * lower[halved] + 0.5 * upper[halved]
            todo += [(second_lower, upper, depth + 1), (lower, first_upper, depth + 1)]
        if todo:
            raise ValueError("tree is not whole: parts of the box are missing")
        lowers, uppers, depths = zip(*parts, strict=True)
        return np.array(lowers), np.array(uppers), np.array(depths)


def certify(
    approximation: Approximation,
    chain: Chain,
    index: Index,
    box: Box,
    wanted: float,
    degree: int = 6,
    models: int = 100_000,
    threads: int | None = None,
    start: Certificate | None = None,
    progress: bool = True,
) -> Certificate:
    """Prove a bound of the relative error of a network, or of a polynomial, everywhere in a box.

    Parameters
    ----------
    approximation
        A network or a polynomial of :func:`dexterity.networks.baselines.polynomial`.
    chain, index
        What it approximates; an index that is smooth and not zero in the box.
    box
        Configurations.
    wanted
        Bound to prove. The closer it is to the largest error, the more parts it takes. The work ends where a
        larger error is found.
    degree
        Of the Taylor models; 5 or 6 are good for seven joints, less for more joints.
    models
        Number of models to make at most. What is not proved by then stays open, with the bound that was.
    threads
        Number of threads, by default one for each processor that this process may use.
    start
        An unfinished certificate of the same task, to go on from.
    progress
        Whether to show a bar with the time that remains.

    Returns
    -------
    A certificate, which says whether it is complete. Ctrl-C ends the work early; what was proved stays.

    Raises
    ------
    TypeError
        If an argument is of another kind.
    ValueError
        If joints do not agree, the index or the network has kinks or no recorded form, a number is out of
        range, or `start` belongs to another task.
    CompilationFailed
        If there is no C compiler.
    """
    wanted = checks.real(wanted, "wanted", above=0)
    models = checks.whole(models, "models", least=1)
    threads = checks.thread_count(threads, "threads")
    program = relative_error(approximation, chain, index, box)
    taylor = TaylorModels(program, degree)
    begun = _begun(program, box, wanted, degree)
    if start is not None and _task(start) != _task(begun):
        raise ValueError("start is a certificate of another box, bound or degree")
    return _continued(begun if start is None else start, taylor, models, threads, progress)


def recheck(
    certificate: Certificate,
    approximation: Approximation,
    chain: Chain,
    index: Index,
    box: Box,
    parts: Sequence[int] | None = None,
) -> bool:
    """Repeat the proof of some parts of a certificate, each in one step, and see that its tree is whole.

    Parameters
    ----------
    certificate
        A certificate.
    approximation, chain, index, box
        What it is about.
    parts
        Numbers of parts in :attr:`Certificate.parts`; all by default.

    Returns
    -------
    Whether the box is the certificate's, and the wanted bound was proved again on each of these parts.

    Raises
    ------
    TypeError, ValueError
        As :func:`certify`, and if the tree is not whole.
    """
    program = relative_error(approximation, chain, index, box)
    if _task(_begun(program, box, certificate.wanted, certificate.degree)) != _task(certificate):
        return False
    taylor = TaylorModels(program, certificate.degree)
    lowers, uppers, _ = certificate.parts
    chosen = range(len(lowers)) if parts is None else parts
    # A part that was bounded in a hurry elsewhere may need a few bisections where rounding differs.
    return all(_proved(taylor, lowers[i], uppers[i], certificate.wanted) for i in chosen)


def _proved(taylor: TaylorModels, lower: Array, upper: Array, wanted: float) -> bool:
    return not (taylor.prove(lower, upper, wanted, boxes=100).tree == OPEN).any()


# ---- the tree ----


def _task(certificate: Certificate) -> tuple[object, ...]:
    box = (tuple(certificate.lower), tuple(certificate.upper))
    return certificate.joints, *box, certificate.wanted, certificate.degree


def _begun(program: Program, box: Box, wanted: float, degree: int) -> Certificate:
    """Return a certificate of nothing, halved a few times so that threads can share the parts."""
    joints = tuple(int(symbol.name[1:]) - 1 for symbol in program.inputs)
    tree = [OPEN]
    for i in reversed(range(min(SHARED_BISECTIONS, len(joints)))):
        tree = [i, *tree, *tree]
    return Certificate(
        joints,
        np.array([box.lower[joint] for joint in joints]),
        np.array([box.upper[joint] for joint in joints]),
        wanted,
        degree,
        np.array(tree, np.uint8),
        np.full(len(tree), math.inf),
    )


def _continued(
    certificate: Certificate, taylor: TaylorModels, models: int, threads: int, progress: bool
) -> Certificate:
    lowers, uppers, _ = certificate.parts
    ends = np.flatnonzero(certificate.tree >= OPEN)
    todo = np.flatnonzero(certificate.tree[ends] == OPEN)
    share, stop = -(-models // max(1, len(todo))), ctypes.c_int(0)
    trees: list[Array] = [certificate.tree[i : i + 1] for i in range(len(certificate.tree))]
    bounds: list[Array] = [certificate.bounds[i : i + 1] for i in range(len(certificate.tree))]
    made, reached, start = certificate.models, certificate.reached, time.perf_counter()
    pool = ThreadPoolExecutor(threads)
    work = {
        pool.submit(taylor.prove, lowers[i], uppers[i], certificate.wanted, share, stop=stop): ends[i]
        for i in todo
    }
    try:
        for done in tqdm(as_completed(work), total=len(work), unit="part", disable=not progress):
            proof, place = done.result(), work[done]
            trees[place], bounds[place] = proof.tree, proof.bounds
            made, reached = made + int((proof.tree != OPEN).sum()), max(reached, proof.reached)
            stop.value |= reached > certificate.wanted
    except KeyboardInterrupt:
        stop.value = 1
    finally:
        pool.shutdown(cancel_futures=True)
    return replace(
        certificate,
        tree=np.concatenate(trees),
        bounds=np.concatenate(bounds),
        reached=reached,
        models=made,
        seconds=certificate.seconds + time.perf_counter() - start,
    )


# ---- the relative error as a program ----


def relative_error(approximation: Approximation, chain: Chain, index: Index, box: Box) -> Program:
    """Record N/w − 1 as a program of the joints that vary in a box and matter.

    All numbers in it are the fractions that the doubles of the network and the box are.

    Raises
    ------
    TypeError
        If an argument is of another kind.
    ValueError
        If joints do not agree, or the index or the network has kinks or no recorded form.
    """
    for kind, value, name in ((Chain, chain, "chain"), (Index, index, "index"), (Box, box, "box")):
        checks.instance(value, name, kind)
    if not isinstance(approximation, FeedForward | RadialBasis | Polynomial):
        raise TypeError(
            f"approximation is a {type(approximation).__name__}; a FeedForward or RadialBasis network or a "
            "Polynomial is needed"
        )
    for name, joints in (("approximation", approximation.view.joints), ("box", box.joints)):
        if joints != chain.joints:
            raise ValueError(
                f"{name} has {joints} joints and the chain {chain.joints}; equal numbers are needed"
            )
    derivation = derive(chain, index)
    record, q = Recorder("r"), derivation.joint_values
    limits = zip(q, box.lower, box.upper, strict=True)
    values = {joint: exactly(low) if low == high else joint for joint, low, high in limits}
    exact = _exact(record, derivation, values)
    seen = _seen(record, approximation.view, [values[joint] for joint in q])
    answer = _answer(record, approximation, seen)
    error = record(record(answer * exact**-1) - 1)
    program = record.program(q, [error])
    if not program.used_inputs:
        raise ValueError("box holds all joints that matter: there is one configuration and nothing to prove")
    return replace(program, inputs=program.used_inputs)


def _exact(record: Recorder, derivation: Derivation, values: dict[Expr, Expr]) -> Expr:
    """Record the index; w through its square, which takes no eliminations."""
    derivation.require_computable()
    if derivation.measure.name == "manipulability":
        (square,) = record.replay(derivation.squared_manipulability, values)
        rates = math.prod(exactly(derivation.tool_rates[row]) for row in derivation.index.row_numbers)
        return sympy.sqrt(square) / rates
    if derivation.kind != "closed" or derivation.values_as_given:
        raise ValueError(
            f"index is {derivation.measure.name}, which is not recorded as a smooth program of the joints"
        )
    return record.replay(derivation.value, values)[0]


def _seen(record: Recorder, view: View, q: Sequence[Expr]) -> list[Expr]:
    joints = [q[joint] for joint in view.inputs]
    if not len(view.carriers):
        return joints
    origin = origin_program(view)
    return [*record.replay(origin, dict(zip(origin.inputs, q, strict=False))), *joints]


def _answer(record: Recorder, approximation: Approximation, seen: list[Expr]) -> Expr:
    if isinstance(approximation, Polynomial):
        return _polynomial(record, approximation, seen)
    own = {name: array.cpu().numpy() for name, array in approximation.state_dict().items()}
    if isinstance(approximation, RadialBasis):
        return _radial_basis(record, own, seen)
    return _feed_forward(record, approximation, own, seen)


def _feed_forward(record: Recorder, network: FeedForward, own: dict[str, Array], seen: list[Expr]) -> Expr:
    if network.values != 1 or network.readout not in _SMOOTH:
        raise ValueError(
            f"approximation has {network.values} values and the readout {network.readout!r}; one value and a "
            f"smooth readout, {' or '.join(_SMOOTH)}, are needed"
        )
    x = _affine(seen, own["input_centre"], own["input_half_range"])
    hidden = [
        record(sympy.tanh(record(sympy.expand(_weighted(row, x) + exactly(bias)))))
        for row, bias in zip(own["hidden_weights"], own["hidden_biases"], strict=True)
    ]
    output = _weighted(own["output_weights"][0], hidden) + exactly(own["output_biases"][0])
    target = output * exactly(own["target_half_range"].item()) + exactly(own["target_centre"][0])
    target = record(sympy.expand(target))
    return {"identity": target, "reciprocal": 1 / target, "logarithm": sympy.exp(target)}[network.readout]


_SMOOTH = ("identity", "reciprocal", "logarithm")
"""Readouts without kinks."""


def _radial_basis(record: Recorder, own: dict[str, Array], seen: list[Expr]) -> Expr:
    scaled = [x * exactly(factor) for x, factor in zip(seen, own["input_scale"], strict=True)]
    sharpness = exactly(BIAS) ** 2 / exactly(own["spread"].item()) ** 2
    bells = []
    for centre in own["centres"]:
        squares = [record(record(x - exactly(c)) ** 2) for x, c in zip(scaled, centre, strict=True)]
        bells.append(record(sympy.exp(record(-sharpness * record(sympy.Add(*squares))))))
    return record(_weighted(own["output_weights"], bells) + exactly(own["output_bias"].item()))


def _polynomial(record: Recorder, polynomial: Polynomial, seen: list[Expr]) -> Expr:
    centre, half_range = polynomial.centre.cpu().numpy(), polynomial.half_range.cpu().numpy()
    x = [*record.all(map(sympy.expand, _affine(seen, centre, half_range))), sympy.S.One]
    terms: list[Expr] = []
    for factors in polynomial.factors.tolist():
        term = sympy.S.One
        for factor in factors:
            term = record(term * x[factor])
        terms.append(term)
    return record(_weighted(polynomial.coefficients.cpu().numpy(), terms))


def _affine(seen: list[Expr], centre: Array, half_range: Array) -> list[Expr]:
    parts = zip(seen, centre, half_range, strict=True)
    return [(x - exactly(middle)) / exactly(half) for x, middle, half in parts]


def _weighted(weights: Iterable[float], values: Sequence[Expr]) -> Expr:
    return dot([exactly(weight) for weight in weights], values)
