"""Cards: what they say of a network must be so."""

import dataclasses
import json

import pytest
import torch

import dexterity as dx
from dexterity import networks, sampling
from dexterity.networks import card, judgement, validation
from dexterity.networks.feed_forward import FeedForward
from dexterity.networks.network import View
from dexterity.networks.recipes import Recipe
from dexterity.networks.worst_case import Search
from dexterity.operations import feed_forward, radial_basis

SPACE = sampling.Box([-1.0, -1.0, 0.0], [1.0, 1.0, 0.0])
SEARCH = Search(samples=64, corners=4, starts=4, steps=5)


def exact(q):
    return 3 + torch.sin(q[..., 0]) * q[..., 1]


@pytest.fixture(scope="module")
def network():
    q = sampling.sobol(SPACE, 200, 1)
    (training,) = networks.train.for_seeds(View(3, [0, 1]), 3, q, exact(q), (0,))
    return training.network


@pytest.fixture(scope="module")
def described(network):
    about = {"name": "toy", "training": card.plain(Recipe(3))}
    return judgement.describe(network, exact, SPACE, about, seed=7, count=500, search=SEARCH)


def test_errors_are_those_on_the_fresh_points_of_the_seed(network, described):
    points = validation.fresh(exact, SPACE, 500, 7)
    errors = validation.relative_errors(network, points).abs()
    assert described["errors"]["count"] == 500
    assert described["errors"]["maximum"] == errors.max().item()
    assert described["errors"]["seed"] == 7


def test_the_worst_case_is_where_it_says(network, described):
    worst = described["worst_case"]
    q = torch.tensor(worst["q"], dtype=torch.float64)
    assert SPACE.contains(q)
    assert network(q).item() == pytest.approx(worst["value"], rel=1e-12)
    assert worst["error"] == pytest.approx(abs(worst["value"] / exact(q).item() - 1), rel=1e-9)


def test_what_was_said_and_what_the_network_is_stand_in_it(described):
    assert described["name"] == "toy"
    assert described["training"]["neurons"] == 3
    assert (described["kind"], described["neurons"], described["inputs"]) == ("FeedForward", 3, "θ1, θ2")
    assert described["space"]["kind"] == "Box"
    assert described["space"]["upper"] == [1.0, 1.0, 0.0]


def test_it_survives_the_file_of_its_network(network, described, tmp_path):
    networks.save(network, tmp_path / "toy.npz", described)
    assert (
        networks.load(tmp_path / "toy.npz").card == json.loads(json.dumps(described.to_dict())) == described
    )


def test_operations_of_layers_are_those_of_the_formulas():
    q = sampling.sobol(sampling.uvms_space("manipulability"), 50, 0)
    view = View(12, range(4, 11))
    random = torch.Generator().manual_seed(0)
    for readout, outputs in {"identity": 1, "triple": 6}.items():
        network = FeedForward.untrained(view, 5, q, torch.linspace(1, 2, 50), random, readout)
        count = judgement.layer_operations(network)
        assert count.total == feed_forward(7, 5).total + (outputs - 1) * 10
    bells = networks.load_shipped("uvms-manipulability-radial-basis")
    assert judgement.layer_operations(bells) == radial_basis(7, bells.neurons)


def test_the_worst_case_is_never_below_a_fresh_point(network, monkeypatch):
    """Where kinks hold up every climb, the worst fresh point is the worst case."""
    found = judgement.worst_case(network, exact, SPACE, SEARCH)
    low = dataclasses.replace(found, error=0.0)
    monkeypatch.setattr(judgement, "worst_case", lambda *arguments: low)
    told = judgement.describe(network, exact, SPACE, seed=3, count=200, search=SEARCH)
    assert told["worst_case"]["error"] == told["errors"]["maximum"]
    assert told["worst_case"]["q"] == told["errors"]["worst"]
    q = torch.tensor(told["worst_case"]["q"], dtype=torch.float64)
    assert told["worst_case"]["exact"] == pytest.approx(float(exact(q)))


# ---- chains and indices come back ------------------------------------------------------------------

CHAINS = {name: dx.robots.load(name) for name in dx.robots.names()}
CHAINS["arm on a vehicle"] = CHAINS["reach_alpha5"].on_vehicle(torch.eye(4, dtype=torch.float64))
CHAINS["arm on a planar base"] = CHAINS["ur5e"].on_planar_base(torch.eye(4, dtype=torch.float64))


@pytest.mark.parametrize("chain", CHAINS.values(), ids=CHAINS)
def test_a_chain_comes_back_from_json(chain):
    entry = json.loads(json.dumps(card.chain_entry(chain)))
    again = card.Card({"chain": entry}).chain()
    assert (again.name, again.joint_names, again.kinds) == (chain.name, chain.joint_names, chain.kinds)
    for part in ("screws", "home", "lower", "upper", "rates"):
        assert torch.equal(getattr(again, part), getattr(chain, part))
    assert (again.inertias is None) == (chain.inertias is None)
    if chain.inertias is not None:
        assert all(map(torch.equal, again.inertias, chain.inertias))


@pytest.mark.parametrize(
    "index",
    [
        dx.Index("manipulability"),
        dx.Index("kci", "geometric", joint_rates=(1.0, 0.0), tool_rates=(2.0,) * 6),
        dx.Index("velocity_ratio", "body", rows=("vx", "wz"), direction="vx"),
        dx.Index("isotropy", "geometric", rows="rotational", characteristic_length=0.3),
        dx.Index("tool_deviation", "geometric", joint_noise=(1e-3, 2e-3)),
    ],
    ids=repr,
)
def test_an_index_comes_back_from_json(index):
    entry = json.loads(json.dumps(card.index_entry(index)))
    assert card.Card({"index": entry}).index() == index


@pytest.mark.parametrize(
    ("entries", "call"),
    [
        ({}, "chain"),
        ({"chain": "uvms"}, "chain"),
        ({"chain": {"screws": 3, "home": 4}}, "chain"),
        ({"chain": {"screws": [[0, 0, 1, 0, 0, 0]], "home": None}}, "chain"),
        ({"index": "manipulability"}, "index"),
        ({"index": {"name": "beauty"}}, "index"),
        ({"index": {"name": "manipulability", "rows": 3.5}}, "index"),
        ({"space": {"kind": "Ball"}}, "space"),
    ],
)
def test_a_card_that_says_too_little_says_so(entries, call):
    with pytest.raises(ValueError, match=r"card|chain|index|space|name|rows|screws|home"):
        getattr(card.Card(entries), call)()


def test_a_card_cannot_be_changed():
    entries = {"a": [1, {"b": 2}]}
    told = card.Card(entries)
    entries["a"][1]["b"] = 3
    told.to_dict()["a"].append(4)
    assert told["a"] == [1, {"b": 2}]
    assert told.with_entries(a=0)["a"] == 0
    assert told == {"a": [1, {"b": 2}]}
