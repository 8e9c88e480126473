"""What is sent to workers: pickled or copied, it answers as before."""

import copy
import pickle
from functools import cache

import numpy as np
import pytest
import torch

import dexterity as dx
from dexterity import docking, indices, networks, reach, robots, sampling, search, symbolic, tasks, workspace
from dexterity.codegen import CompilationFailed
from dexterity.crane import positioning

Q = torch.tensor([[0.3, -0.5, 0.7, -0.2, 0.9, 0.4, 0.1]], dtype=torch.float64)
WAYS = {"pickle": lambda value: pickle.loads(pickle.dumps(value)), "deepcopy": copy.deepcopy}


@pytest.fixture(params=WAYS.values(), ids=WAYS)
def sent(request):
    return request.param


def index(name):
    needs = indices.describe(name).needs
    return dx.Index(name, "geometric", **({"direction": "vx"} if "direction" in needs else {}))


@pytest.mark.parametrize("name", indices.names())
def test_a_measure_an_index_and_a_bound_index(sent, name):
    panda = robots.panda()
    expected = index(name)(panda, Q)
    assert sent(indices.describe(name)).name == name
    assert torch.equal(sent(index(name)).bind(panda)(Q), expected)
    bound = index(name).bind(panda)
    assert torch.equal(sent(bound)(Q), expected)
    assert torch.equal(sent(sent(bound))(Q), expected)


def test_a_bound_index_tells_what_it_is():
    assert "Index('manipulability', 'spatial') of 'panda'" in repr(dx.Index("w").bind(robots.panda()))


@cache
def network():
    return networks.load_shipped("uvms-manipulability-feed-forward")


@cache
def data():
    box = sampling.Box([-0.5] * 2, [0.5] * 2)
    return sampling.data_sets(
        dx.Index("w", rows=("vx",)).bind(planar()), box, train=8, test=4, validation=4, method="uniform"
    )


def planar():
    return dx.Chain([[0, 0, 0, 0, 0, 1], [0, -1, 0, 0, 0, 1]], np.eye(4), lower=[-3, -3], upper=[3, 3])


def puma_map():
    return reach.survey(robots.puma560(), reach.box([0.3, 0, 0.2], [0.4, 0, 0.2], 0.1), reach.rotations(4))


EVERYTHING = {
    "chain": (robots.panda, lambda chain: chain.forward(Q)),
    "description": (lambda: robots.describe("panda"), lambda found: found.name),
    "task": (lambda: tasks.find("welding"), lambda task: task.name),
    "ranking": (lambda: tasks.rank(robots.panda(), Q, "welding"), lambda found: found.values),
    "box": (lambda: sampling.Box([0.0] * 2, [1.0] * 2), lambda box: box.from_unit([0.3, 0.4])),
    "sector": (lambda: sampling.uvms_space("w"), lambda space: space.from_unit([0.5] * space.dimensions)),
    "data sets": (data, lambda sets: sets.train.values),
    "problem": (
        lambda: networks.problem.DesignProblem(networks.View(2, (0, 1)), data()),
        lambda problem: problem.data.test.q,
    ),
    "network": (network, lambda found: found(torch.full((12,), 0.1)).detach()),
    "guarded network": (lambda: networks.Guarded.of(network()), lambda found: found.space),
    "compiled network": (
        lambda: networks.export.compile_network(network()),
        lambda found: found(torch.full((12,), 0.1)),
    ),
    "compiled index": (
        lambda: symbolic.compile_index(planar(), dx.Index("w", rows=("vx",))),
        lambda found: found([0.1, 0.2]),
    ),
    "docking problem": (lambda: docking.DockingProblem(robots.docking_arm()), lambda found: found.lower),
    "solutions": (
        lambda: dx.inverse_kinematics.solve(robots.puma560(), robots.puma560().home),
        lambda found: found.q,
    ),
    "extremes": (
        lambda: search.extremes(dx.Index("w"), robots.puma560(), samples=16, starts=2, steps=2),
        lambda found: torch.tensor(found.highest.q),
    ),
    "map": (puma_map, lambda found: found.best),
    "inverse map": (lambda: puma_map().inverted(), lambda found: found.bases(np.eye(4))[0]),
    "answer by closed form": (
        lambda: workspace.maps.ByClosedForm([0.15, 0.43, 0.43, 0.02], lower=[-2.0] * 6, upper=[2.0] * 6),
        lambda found: found(dx.spatial.translation(0.4, 0.2, 0.1)).manipulability,
    ),
    "answer by branches": (
        lambda: workspace.maps.ByBranches(robots.puma560()),
        lambda found: found(dx.spatial.translation(0.4, 0.2, 0.1)).manipulability,
    ),
    "sag": (positioning.linear_sag, lambda sag: sag(positioning.thesis_task().starts[0], 100.0)),
    "positioning task": (positioning.thesis_task, lambda task: task.targets),
}


@pytest.mark.parametrize("name", EVERYTHING)
def test_it_answers_as_before(sent, name):
    make, answer = EVERYTHING[name]
    value = make()
    expected, found = answer(value), answer(sent(value))
    assert torch.equal(expected, found) if isinstance(expected, torch.Tensor) else expected == found


def test_an_error_comes_back_from_a_worker(sent):
    """One that cannot be pickled hangs the pool that it was raised in."""
    guarded = networks.Guarded.of(network())
    with pytest.raises(networks.OutsideTrainedSpace) as raised:
        guarded(torch.full((12,), 9.0))
    back = sent(raised.value)
    assert str(back) == str(raised.value)
    assert back.joints == raised.value.joints
    assert str(sent(CompilationFailed("no compiler"))) == "no compiler"
