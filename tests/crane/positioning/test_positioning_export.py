"""The exported JavaScript of the crane and of the four methods, run by node, against the package."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import torch
from numpy.testing import assert_allclose
from torch import Tensor

from dexterity import crane
from dexterity.crane import TrainingSet, positioning
from dexterity.crane.positioning import DescentOptions, Placement, Task
from dexterity.crane.positioning.export import Networks, javascript_module, task_at
from dexterity.crane.shape import bars
from run_in_node import called, needs_node

CRANE = crane.patu655()


@cache
def networks() -> Networks:
    data = TrainingSet(crane.training_set().rows[::17])
    own = [
        train(data, torch.Generator().manual_seed(0), neurons=neurons, epochs=20)
        for train, neurons in (
            (positioning.correction_network, 6),
            (positioning.direct_network, 6),
            (positioning.modular_network, (6, 6)),
            (positioning.inverse_network, 6),
        )
    ]
    task = positioning.thesis_task()
    options = [
        DescentOptions(rate=positioning.safe_rate(network, task), iterations=3000) for network in own[1:3]
    ]
    return Networks(*own, *options)


@cache
def module() -> str:
    return javascript_module(CRANE, networks())


@pytest.fixture
def strokes(rng) -> Tensor:
    return torch.from_numpy(rng.uniform(CRANE.lower, CRANE.upper, (200, 3)))


@pytest.fixture
def payload(rng) -> Tensor:
    return torch.from_numpy(rng.uniform(0, CRANE.rating, 200))


def rows(*parts: Tensor) -> list[list[list[float]]]:
    """Calls of a function with one array each, numbers of several tensors side by side."""
    return [[row] for row in torch.cat([part.reshape(len(part), -1) for part in parts], dim=1).tolist()]


def of_task(task: Task) -> Tensor:
    return torch.cat([task.targets, task.payload[:, None], task.starts], dim=1)


@needs_node
def test_the_rigid_tip_and_the_task(tmp_path, strokes, payload):
    results = called(tmp_path, module(), "tip", rows(strokes))
    assert_allclose(results, crane.tip_position(strokes), rtol=1e-11, atol=1e-12)
    results = called(tmp_path, module(), "task", rows(strokes, payload))
    assert_allclose(results, of_task(task_at(strokes, payload, CRANE)), rtol=1e-11, atol=1e-12)


@needs_node
def test_bars_bend_as_the_structure_does(tmp_path, strokes, payload):
    inputs = rows(strokes, payload, torch.full_like(payload, 10.0))
    results = np.array(called(tmp_path, module(), "bars", inputs))
    shape = bars(strokes)
    assert_allclose(results[:, 0], shape.ends, rtol=1e-11, atol=1e-12)
    assert_allclose(results[:, 1], shape.loaded(payload, 10.0), rtol=1e-9, atol=1e-11)


@needs_node
def test_strokes_for_a_place_of_the_tip(tmp_path, strokes):
    tip = crane.tip_position(strokes)
    for name, inputs, reach, atol in (
        ("reach", rows(tip, strokes[:, 2:]), crane.inverse(tip, strokes[:, 2]), 1e-10),
        # With the least extension arms are folded or stretched: strokes vary as the root of a rounding error.
        ("leastReach", rows(tip), crane.inverse(tip), 1e-7),
    ):
        results = np.array(called(tmp_path, module(), name, inputs), dtype=float)
        assert_allclose(results[:, :3], reach.strokes, rtol=0, atol=atol)
        assert_allclose(crane.tip_position(results[reach.reached, :3]), tip[reach.reached], rtol=0, atol=1e-9)
        assert_allclose(results[:, 3], reach.within_limits)


@needs_node
def test_the_driven_crane_is_where_statics_has_it(tmp_path, rng, strokes, payload):
    task = task_at(strokes, payload, CRANE)
    told = strokes + torch.from_numpy(rng.uniform(-0.1, 0.1, (200, 3)))
    one = torch.ones(200, dtype=torch.long)
    missed = positioning.errors(task, Placement(told, one.bool(), one))
    results = np.array(called(tmp_path, module(), "driven", rows(of_task(task), told)))
    assert_allclose(results[:, :2], task.targets - missed.each, rtol=1e-10, atol=1e-11)
    assert_allclose(results[:, 2], missed.stopped)


@needs_node
@pytest.mark.parametrize("name", ["direct", "modular", "inverseNetwork"])
def test_networks_answer_as_they_do_in_the_package(tmp_path, strokes, payload, name):
    task, own = task_at(strokes[:50], payload[:50], CRANE), networks()
    placement = {
        "direct": lambda: positioning.descend(task, own.direct, own.direct_options),
        "modular": lambda: positioning.descend(task, own.modular, own.modular_options),
        "inverseNetwork": lambda: positioning.by_inverse_network(task, own.inverse),
    }[name]()
    results = np.array(called(tmp_path, module(), name, rows(of_task(task))))
    assert_allclose(results, placement.strokes, rtol=1e-9, atol=1e-9)


@needs_node
def test_aiming_off_is_defined_where_the_package_has_it_and_the_same_there(tmp_path, strokes, payload):
    sag, answered = positioning.network_sag(networks().correction), 0
    inputs = rows(of_task(task_at(strokes, payload, CRANE)))
    for i, result in enumerate(called(tmp_path, module(), "compensation", inputs)):
        task = task_at(strokes[i : i + 1], payload[i : i + 1], CRANE)
        if isinstance(result, dict):
            assert result["error"] == "RangeError"
            with pytest.raises(ValueError, match="cannot be aimed off"):
                positioning.compensate(task, sag)
        else:
            # Where the arms are folded a stroke varies as the root of a rounding error, and the tip does not.
            expected = crane.tip_position(positioning.compensate(task, sag).strokes[0], CRANE)
            own = crane.tip_position(torch.tensor(result, dtype=torch.float64), CRANE)
            assert_allclose(own, expected, rtol=1e-9, atol=1e-9)
            answered += 1
    assert answered > 150


def test_a_descent_needs_a_rate():
    own = networks()
    with pytest.raises(ValueError, match="rate of a descent is None"):
        javascript_module(CRANE, replace(own, direct_options=DescentOptions()))


def test_a_descent_needs_an_end():
    own = networks()
    short = replace(own.modular_options, iterations=3)
    with pytest.raises(ValueError, match=r"^iterations is 3; the network needs more"):
        javascript_module(CRANE, replace(own, modular_options=short))
