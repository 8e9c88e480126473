"""The family of paper C in ECMAScript against torch: reach, a branch, frames, and a network's confidence."""

import itertools

import numpy as np
import pytest
import torch
from numpy.testing import assert_allclose
from torch.testing import assert_close

from dexterity import spatial
from dexterity.workspace import closed_form, dataset, export, reachability, training
from dexterity.workspace.export import Confidence
from dexterity.workspace.jacobian_net import Architecture, JacobianNet
from dexterity.workspace.reachability import Branch
from run_in_node import called, needs_node

BRANCHES = [Branch(*signs) for signs in itertools.product([True, False], repeat=3)]


def drawn(count: int) -> tuple[torch.Tensor, torch.Tensor]:
    samples = dataset.confidence_data(count, 0).samples
    return samples.links, spatial.pose(samples.rotation(), samples.position)


def pairs(links, T) -> list[list[list[object]]]:
    return [[[a, b]] for a, b in zip(links.tolist(), T.tolist(), strict=True)]


def network(inputs, architecture: Architecture) -> JacobianNet:
    jacobians = dataset.jacobian_data(400, 2, dynamics=inputs == "columns")
    made = training.network_for(architecture, inputs, "tool", jacobians, seed=0)
    rows = training.confidence_rows(made, dataset.confidence_data(2_000, 1, dynamics=inputs == "columns"))
    return training.train(
        made, {"confidence": rows}, training.Options(training.epochs(2), batch=64), seed=0
    ).network


@needs_node
def test_reach_is_that_of_the_rule(tmp_path):
    links, T = drawn(2_000)
    calls = [[a, b] for a, b in zip(links.tolist(), T[:, :3, 3].tolist(), strict=True)]
    answers = called(tmp_path, export.javascript_module(), "reachable", calls)
    wanted = reachability.reachable(links, T[:, :3, 3])
    assert answers == wanted.tolist()
    assert 500 < wanted.sum() < 1_500


@needs_node
def test_margins_are_zero_on_the_borders(tmp_path):
    links = [0.15, 0.4, 0.5, 0.3]  # the forearm is 0.5 m long
    on_the_cylinder = [0.15, 0.0, 0.2]
    stretched = [float(np.hypot(0.15, 0.6)), 0.0, 0.8]
    calls = [[[links, position]] for position in (on_the_cylinder, stretched)]
    first, second = called(tmp_path, export.javascript_module(), "margins", calls)
    assert_allclose(first, [0, 0.04, 0.96], atol=1e-15)
    assert_allclose(second, [0.36, 1, 0], atol=1e-15)


@needs_node
@pytest.mark.parametrize("branch", [BRANCHES[0], BRANCHES[5]])
@pytest.mark.parametrize(
    ("part", "shape"), [("cosines", (6,)), ("sines", (6,)), ("jacobian", (6, 6)), ("manipulability", ())]
)
def test_a_branch_is_that_of_torch(tmp_path, branch, part, shape):
    links, T = drawn(300)
    answers = np.array(called(tmp_path, export.javascript_module(branch), part, pairs(links, T)), dtype=float)
    wanted = closed_form.in_torch(branch, part)(links, T).reshape(-1, *shape)
    assert_allclose(answers, wanted, rtol=0, atol=1e-13)


@needs_node
@pytest.mark.parametrize("branch", [BRANCHES[0], BRANCHES[5]])
def test_origins_are_those_of_the_frames(tmp_path, branch):
    links, T = drawn(300)
    q, reach = reachability.inverse(links, T, branch)
    answers = called(tmp_path, export.javascript_module(branch), "origins", pairs(links[reach], T[reach]))
    wanted = reachability.frames(links[reach], q[reach]).origins
    assert_allclose(np.array(answers), wanted, rtol=0, atol=1e-12)


PLAIN = Architecture(confidence=(9, 8), estimation=())
WITH_ALL = Architecture((12, 10), (9, 8), (), normalised=(1, 1), dropout=0.2)


@needs_node
@pytest.mark.parametrize("inputs", ["rotation", "plane"])
@pytest.mark.parametrize("architecture", [PLAIN, WITH_ALL], ids=["plain", "all"])
def test_confidence_is_that_of_the_network(tmp_path, inputs, architecture):
    trained = network(inputs, architecture)
    confidence, (links, T) = Confidence.of(trained), drawn(300)
    # The network computes in single precision.
    assert_close(confidence(links, T), trained.answer(links, T).confidence, rtol=0, atol=1e-5)
    calls = [[a, b] for a, b in zip(links.tolist(), T.tolist(), strict=True)]
    answers = called(tmp_path, export.confidence_module(confidence), "confidence", calls)
    assert_allclose(answers, confidence(links, T), rtol=1e-12)


def test_a_network_of_more_than_a_pose_is_refused():
    with pytest.raises(ValueError, match=r"^inputs are 'relevant'; 'rotation' and 'plane' can be exported"):
        Confidence.of(network("relevant", PLAIN))
