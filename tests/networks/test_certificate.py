"""Bounds of relative errors are proved: no point is above them, and every part can be repeated."""

import itertools
import shutil
from dataclasses import replace

import numpy as np
import pytest
import torch

import dexterity as dx
from dexterity.chain import Chain
from dexterity.codegen.taylor_models import LEAF, OPEN
from dexterity.indices import Index
from dexterity.networks import FeedForward, RadialBasis, View, baselines, certificate
from dexterity.networks.certificate import Approximation, Certificate, certify, recheck, relative_error
from dexterity.sampling import Box, DataSet, sobol
from program_values import values_of

pytestmark = pytest.mark.skipif(
    not any(map(shutil.which, ("cc", "gcc", "clang"))), reason="there is no C compiler"
)

ARM = Chain.from_dh([{"a": 0.5}, {"a": 0.4}, {"a": 0.2}])
W = Index("manipulability", "geometric", rows=("vx", "vy"))
BOX = Box([0.0, 0.6, 0.3], [0.0, 1.2, 0.8])
VIEW = View(3, [1, 2])


def fitted(readout: str = "identity", seed: int = 0) -> Approximation:
    """A network, or a polynomial, roughly fitted to w of the arm."""
    q = sobol(BOX, 200, seed)
    values = W.bind(ARM)(q)
    random = torch.Generator().manual_seed(seed)
    if readout == "polynomial":
        return baselines.polynomial(VIEW, DataSet(q, values), 2)
    if readout == "radial basis":
        from dexterity.networks.growth import fit

        return fit(VIEW, DataSet(q, values), VIEW(q)[:12], 1.0, torch.ones(2).double())
    network = FeedForward.untrained(VIEW, 4, q, values, random, readout)
    with torch.no_grad():
        network.output_weights *= 0.1
    return network


def largest_error(approximation: Approximation) -> float:
    """Largest error on a fine grid with the corners, which is a little below the largest."""
    second, third = (torch.linspace(a, b, 200).double() for a, b in ((0.6, 1.2), (0.3, 0.8)))
    q = torch.cartesian_prod(torch.zeros(1).double(), second, third)
    with torch.no_grad():
        return float((approximation(q) / W.bind(ARM)(q) - 1).abs().max())


@pytest.mark.parametrize("readout", ["identity", "reciprocal", "logarithm", "polynomial", "radial basis"])
def test_the_program_is_the_relative_error(readout: str) -> None:
    approximation, q = fitted(readout), sobol(BOX, 50, 2)
    program = relative_error(approximation, ARM, W, BOX)
    columns = {symbol: q[:, int(symbol.name[1:]) - 1].numpy() for symbol in program.inputs}
    with torch.no_grad():
        expected = (approximation(q) / W.bind(ARM)(q) - 1).numpy()
    np.testing.assert_allclose(values_of(program, columns)[:, 0], expected, atol=1e-12)


@pytest.mark.parametrize("readout", ["identity", "reciprocal", "logarithm", "polynomial", "radial basis"])
def test_a_bound_is_proved_a_little_above_the_largest_error_and_not_below(readout: str) -> None:
    approximation = fitted(readout)
    error = largest_error(approximation)
    proof = certify(approximation, ARM, W, BOX, 1.02 * error, degree=5, progress=False)
    assert proof.complete
    assert error <= proof.bound <= 1.02 * error
    assert recheck(proof, approximation, ARM, W, BOX)
    assert 0.9 * error < proof.reached <= proof.bound
    below = certify(approximation, ARM, W, BOX, 0.98 * error, degree=5, progress=False)
    assert not below.complete
    assert 0.98 * error < below.reached
    assert error <= below.bound


def test_an_index_with_tool_rates_and_joint_rates() -> None:
    fast = Index("manipulability", "geometric", rows=("vx", "vy"), tool_rates=(2.0, 3.0, 1.0, 1.0, 1.0, 1.0))
    arm = Chain.from_dh([{"a": 0.5}, {"a": 0.4}, {"a": 0.2}], rates=[1.0, 2.0, 3.0])
    line, q = fitted("polynomial"), sobol(BOX, 50, 2)
    program = relative_error(line, arm, fast, BOX)
    columns = {symbol: q[:, int(symbol.name[1:]) - 1].numpy() for symbol in program.inputs}
    np.testing.assert_allclose(values_of(program, columns)[:, 0], line(q) / fast.bind(arm)(q) - 1, atol=1e-12)


def test_another_index_that_is_recorded() -> None:
    isotropy = Index("isotropy", "geometric", rows=("vx", "vy"))
    q = sobol(BOX, 200, 0)
    fit = baselines.polynomial(VIEW, DataSet(q, isotropy.bind(ARM)(q)), 3)
    error = float((fit(q) / isotropy.bind(ARM)(q) - 1).abs().max())
    proof = certify(fit, ARM, isotropy, BOX, 2 * error, progress=False)
    assert proof.complete
    assert error <= proof.bound


# ---- the tree ----


def proof_of_a_box() -> tuple[Approximation, float, Certificate]:
    network = fitted()
    wanted = 1.01 * largest_error(network)
    return network, wanted, certify(network, ARM, W, BOX, wanted, degree=3, progress=False)


def test_the_parts_are_the_box() -> None:
    _, _, proof = proof_of_a_box()
    lower, upper, depths = proof.parts
    volumes = (upper - lower).prod(1)
    np.testing.assert_allclose(volumes.sum(), (proof.upper - proof.lower).prod())
    np.testing.assert_allclose(volumes, (proof.upper - proof.lower).prod() * 0.5**depths)
    # No two overlap: between any two there is a joint in which one ends before the other begins.
    for (a, b), (c, d) in itertools.combinations(zip(lower, upper, strict=True), 2):
        assert ((b <= c) | (d <= a)).any()


def test_threads_change_nothing() -> None:
    network, wanted, proof = proof_of_a_box()
    other = certify(network, ARM, W, BOX, wanted, degree=3, threads=3, progress=False)
    assert other.digest == proof.digest
    np.testing.assert_array_equal(other.bounds, proof.bounds)


def test_work_that_was_limited_goes_on() -> None:
    network, wanted, proof = proof_of_a_box()
    short = certify(network, ARM, W, BOX, wanted, degree=3, models=4, progress=False)
    assert not short.complete
    assert short.models < proof.models
    resumed = certify(network, ARM, W, BOX, wanted, degree=3, start=short, progress=False)
    assert resumed.complete
    assert resumed.seconds > short.seconds
    assert (resumed.tree == LEAF).sum() >= (short.tree == LEAF).sum()
    with pytest.raises(ValueError, match="start is a certificate of another"):
        certify(network, ARM, W, BOX, 2 * wanted, degree=3, start=short, progress=False)


def test_ctrl_c_keeps_what_is_proved(monkeypatch: pytest.MonkeyPatch) -> None:
    network, wanted, proof = proof_of_a_box()

    def interrupted(work: dict) -> itertools.chain:
        def stop() -> None:
            raise KeyboardInterrupt

        finished = certificate_as_completed(work)
        return itertools.chain([next(finished)], (stop() for _ in range(1)))

    certificate_as_completed = certificate.as_completed
    monkeypatch.setattr(certificate, "as_completed", interrupted)
    stopped = certify(network, ARM, W, BOX, wanted, degree=3, threads=1, progress=False)
    assert not stopped.complete
    assert (stopped.tree == LEAF).any()
    monkeypatch.undo()
    resumed = certify(network, ARM, W, BOX, wanted, degree=3, start=stopped, progress=False)
    assert resumed.digest == proof.digest


def test_a_certificate_that_was_changed_is_not_confirmed() -> None:
    network, _, proof = proof_of_a_box()
    other = FeedForward(
        VIEW, "identity", {k: v for k, v in network.state_dict().items() if k != "view.carriers"}
    )
    with torch.no_grad():
        other.output_biases += 0.2
    assert not recheck(proof, other, ARM, W, BOX)
    assert not recheck(proof, network, ARM, W, Box([0.0, 0.6, 0.3], [0.0, 1.2, 0.9]))
    assert replace(proof, wanted=0.5).digest != proof.digest
    for tree in (proof.tree[:-1], np.append(proof.tree, np.uint8(LEAF)), np.full_like(proof.tree, 2)):
        with pytest.raises(ValueError, match="tree is not whole"):
            _ = replace(proof, tree=tree, bounds=np.zeros(len(tree))).parts


# ---- the shipped network ----


def test_the_shipped_network_where_its_error_is_largest() -> None:
    """An eighth of its range in each joint, about the worst point that ascent has found."""
    network = dx.networks.load_shipped("uvms-manipulability-feed-forward")
    box, worst = network.card.space(), network.card["worst_case"]
    lower, upper, q = map(np.array, (box.lower, box.upper, worst["q"]))
    near = (upper - lower) / 8
    corner = Box(np.maximum(lower, q - near), np.minimum(upper, q + near))
    proof = certify(network, dx.robots.uvms(), network.card.index(), corner, 0.00199, progress=False)
    assert proof.complete
    assert worst["error"] - 1e-12 <= proof.bound <= 0.00199


# ---- what is refused ----


def test_what_has_kinks_is_refused() -> None:
    conditioning = Index("kinematic_conditioning", "geometric", rows=("vx", "vy"))
    with pytest.raises(ValueError, match="not recorded as a smooth program"):
        certify(fitted(), ARM, conditioning, BOX, 0.1)
    network = dx.networks.load_shipped("uvms-kinematic-conditioning-feed-forward")
    uvms, box = dx.robots.uvms(), Box.around(dx.robots.uvms(), half_range=0.1)
    with pytest.raises(ValueError, match="the readout 'triple'"):
        certify(network, uvms, Index("manipulability"), box, 0.1)


def test_a_singularity_in_the_box_leaves_it_open() -> None:
    box = Box([0.0, -0.5, -0.5], [0.0, 1.2, 0.8])
    proof = certify(fitted(), ARM, W, box, 0.5, models=50, progress=False)
    assert not proof.complete
    assert proof.bound == np.inf
    assert (proof.tree == OPEN).any()


def test_bad_arguments() -> None:
    network = fitted()
    with pytest.raises(TypeError, match="approximation"):
        certify(baselines.Constant(1.0, 3), ARM, W, BOX, 0.1)
    with pytest.raises(TypeError, match="box"):
        certify(network, ARM, W, dx.sampling.uvms_space("kinematic_conditioning"), 0.1)
    with pytest.raises(ValueError, match="box has 2 joints and the chain 3"):
        certify(network, ARM, W, Box([0.0, 0.5], [0.0, 1.0]), 0.1)
    with pytest.raises(ValueError, match="approximation has 3 joints and the chain 12"):
        certify(network, dx.robots.uvms(), W, BOX, 0.1)
    with pytest.raises(ValueError, match="box holds all joints that matter"):
        certify(network, ARM, W, Box([0.1, 0.6, 0.3], [0.1, 0.6, 0.3]), 0.1)
    for name, value in (("wanted", 0.0), ("models", 0), ("threads", 0)):
        with pytest.raises(ValueError, match=name):
            certify(
                **{"approximation": network, "chain": ARM, "index": W, "box": BOX, "wanted": 0.1, name: value}
            )


def test_radial_basis_network_is_of_the_kind() -> None:
    assert isinstance(fitted("radial basis"), RadialBasis)
