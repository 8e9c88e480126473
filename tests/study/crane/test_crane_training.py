"""Training and sizes of the crane's networks: stacks of gains, poses held out, and what the rules ask for."""

import inspect
import math

import numpy as np
import pytest
import torch

from dexterity import crane
from dexterity_study.claims.ledger import load_paper
from dexterity_study.claims.outcome import Outcome
from dexterity_study.crane.training import experiment, verdicts
from dexterity_study.engine.evidence import Evidence
from dexterity_study.engine.table import Table

CHAPTER = "crane.training"


@pytest.fixture
def start():
    network, x, y = experiment.untrained("correction", 6, 0)
    return network, x[::37], y[::37]


def test_gains_side_by_side_are_each_alone_by_plain_torch(start):
    network, x, y = start
    own, gain, momentum = experiment.Descent(*start, momentum=0.9), experiment.GAINS[3], 0.9
    for _ in range(5):
        own.go(0, torch.Generator())
    optimiser = torch.optim.SGD(network.parameters(), lr=gain, momentum=momentum)
    for _ in range(5):
        optimiser.zero_grad()
        miss = (network(x) - y) / network.target_half_range
        (miss.square().sum(-1).mean() / 2).backward()
        optimiser.step()
    with torch.no_grad():
        alone = 1e3 * (network(x) - y).square().sum(-1).mean().sqrt()
    assert own.error()[3].item() == pytest.approx(alone.item(), rel=1e-9)


def test_the_gradient_is_that_of_equations_51_to_53(start):
    network, x, y = start
    own = experiment.Descent(network, x[:1], y[:1], momentum=0.9, gains=(1.0,))
    (own.squares().sum() / 2).backward()
    inner, inner_biases, outer, outer_biases = (weights.detach()[0] for weights in own.weights)
    hidden = torch.tanh(inner @ own.x[0] + inner_biases)
    # With a linear output the printed factor y(1 - y) is 1.
    delta = own.y[0] - (outer @ hidden + outer_biases)
    delta_hidden = (1 - hidden.square()) * (delta @ outer)
    written = (delta_hidden[:, None] * own.x[0], delta_hidden, delta[:, None] * hidden, delta)
    for value, weights in zip(written, own.weights, strict=True):
        np.testing.assert_allclose(value, -weights.grad[0], atol=1e-12)


def test_both_ways_begin_with_one_error():
    errors = experiment.descent(0, passes=(1, 1, 1, 1)).arrays["chosen", 0]
    starts = {way: own[..., 0] for way, own in errors.items()}
    for mode in experiment.AT_ONCE:
        np.testing.assert_allclose(starts[mode], starts[experiment.SECOND_ORDER], rtol=1e-5)


def test_what_diverges_is_infinite(start):
    own, before = experiment.Descent(*start, momentum=0.9), experiment.Descent(*start, momentum=0.9).error()
    for _ in range(40):
        own.go(1, torch.Generator().manual_seed(0))
    assert not own.error().isnan().any()
    assert own.error()[-1].isinf()
    assert own.error()[0] < before[0]


def test_whole_poses_are_held_out():
    out, strokes = experiment.held_out(0), experiment.lesson("direct")[0][:, :3]
    assert out.double().mean().item() == pytest.approx(0.2, abs=0.002)
    inside, outside = ({tuple(row) for row in strokes[rows].tolist()} for rows in (~out, out))
    assert not inside & outside
    assert not torch.equal(out, experiment.held_out(1))


def test_the_first_set_is_the_thesis_test():
    count, loads = len(crane.TEST_POINTS), len(crane.TEST_PAYLOADS)
    inputs, truth = experiment.points(2)
    assert len(inputs) == 3 * count * loads
    rigid = crane.tip_position(inputs[:, :3])
    np.testing.assert_allclose(rigid[: count * loads : loads], np.array(crane.TEST_POINTS), atol=1e-9)
    np.testing.assert_allclose(truth["direct"] - truth["correction"], rigid, atol=1e-12)
    assert crane.within_limits(inputs[count * loads :, :3]).all()


def test_the_bound_is_met_by_the_share_that_it_permits():
    table = experiment.rules()
    for row in table.rows.to_dict("records"):
        rows, weights = (
            table.rows["rows"].max(),
            row["neurons"] * (3 + 2 + (row["network"] != "modular, rigid")),
        )
        assert rows == pytest.approx(
            32 * weights / row["wrong"] * math.log(32 * row["neurons"] / row["wrong"]), rel=1e-9
        )
    biased = experiment.rules(reading="crane-weights-counted=with-biases")
    assert (biased.rows["wrong"] > table.rows["wrong"]).all()


def test_sizes_are_the_printed_ones():
    correction, direct, rigid, rest, inverse = (
        inspect.signature(experiment.rules.function).parameters["hidden"].default
    )
    printed = load_paper("rouvinen1999").printed
    assert (correction, direct) == tuple(printed(f"crane-{name}-neurons")[0] for name in experiment.NETWORKS)
    assert (rigid, rest) == printed("crane-modular-neurons")[:2]
    assert inverse == printed("crane-inverse-neurons")


@pytest.mark.parametrize(
    ("second", "outcome"),
    [
        ([5.0] * 10, Outcome.REPRODUCED),
        ([5.0] * 6 + [11.0] * 4, Outcome.IN_SHAPE),
        ([11.0] * 10, Outcome.NOT_REPRODUCED),
    ],
)
def test_the_better_training_leaves_less_in_the_same_time(second, outcome):
    stored = Evidence(CHAPTER)
    arrays = {
        run: {
            way: np.full_like(own, left if way == experiment.SECOND_ORDER else 10.0)
            for way, own in held.items()
        }
        for (run, held), left in zip(stored["descent"].arrays.items(), second, strict=True)
    }
    changed = Evidence(CHAPTER, {"descent": Table(stored["descent"].rows, stored["descent"].keys, arrays)})
    found = {one.claim: one.outcome for one in verdicts.verdicts(changed)}
    assert found["crane-lm-is-better"] is outcome
