"""The networks that come with the package: what their cards say must be so."""

import pytest
import torch

import dexterity as dx
from dexterity import networks, sampling, store
from dexterity.networks import baselines, validation
from dexterity.networks.feed_forward import FeedForward
from dexterity.networks.judgement import layer_operations
from dexterity.networks.radial_basis import RadialBasis
from dexterity_study import shipment

UVMS = dx.robots.uvms()


def test_all_planned_networks_are_shipped_and_no_other():
    assert set(networks.shipped()) == set(shipment.PLANS)


PAPER = [name for name, plan in shipment.PLANS.items() if not isinstance(plan, shipment.LearnedPlan)]
LEARNED = [name for name, plan in shipment.PLANS.items() if isinstance(plan, shipment.LearnedPlan)]


@pytest.fixture
def network(name):
    return networks.load_shipped(name)


@pytest.fixture
def exact(network):
    return network.card.index().bind(network.card.chain())


@pytest.mark.parametrize("name", PAPER)
def test_a_network_of_the_paper_is_what_its_plan_says(name, network):
    plan = shipment.PLANS[name]
    assert network.card.index() == dx.Index(plan.index)
    torch.testing.assert_close(network.card.chain().screws, UVMS.screws, rtol=0, atol=0)
    assert network.card.space() == sampling.uvms_space(plan.index)
    assert len(network.view.carriers) == plan.carriers
    assert network.card["errors"]["count"] == shipment.JUDGED
    if isinstance(plan, shipment.FeedForwardPlan):
        assert isinstance(network, FeedForward)
        assert (network.neurons, network.readout) == (plan.recipe.neurons, plan.recipe.readout)
    else:
        assert isinstance(network, RadialBasis)
        assert network.neurons == plan.neurons


@pytest.mark.parametrize("name", LEARNED)
def test_a_network_of_a_robot_is_what_its_plan_says(name, network):
    plan, card = shipment.PLANS[name], network.card
    chain = dx.robots.load(plan.robot)
    assert card.index() == plan.index
    assert card.chain().name == chain.name
    torch.testing.assert_close(card.chain().screws, chain.screws, rtol=0, atol=1e-15)
    torch.testing.assert_close(card.chain().home, chain.home, rtol=0, atol=1e-15)
    assert card["training"]["seed"] == plan.seed
    space = card.space()
    assert [space.lower[i] <= middle <= space.upper[i] for i, middle in enumerate(plan.middle)]


@pytest.mark.parametrize("name", shipment.PLANS)
def test_a_network_errs_less_than_what_it_is_compared_with_or_its_card_advises_the_fit(name, network):
    card = network.card
    assert set(card["baselines"]) == {"constant", "linear", "cubic"}
    largest = {fit: entry["maximum"] for fit, entry in card["baselines"].items()}
    better = [fit for fit, error in largest.items() if error <= card["errors"]["maximum"]]
    assert not better or (name in PAPER and f"or the {better[0]} fit" in card["advice"])


@pytest.mark.parametrize("name", shipment.PLANS)
def test_no_network_is_worse_than_a_cubic_polynomial(network, exact):
    space = network.card.space()
    cubic = baselines.polynomial(network.view, validation.fresh(exact, space, 4096, seed=3), 3)
    points = validation.fresh(exact, space, 4096, seed=4)
    assert validation.judge(network, points).maximum < validation.judge(cubic, points).maximum


def test_there_are_twenty():
    assert len(shipment.PLANS) >= 20


@pytest.mark.parametrize("name", shipment.PLANS)
class TestShipped:
    def test_its_worst_case_is_where_the_card_says(self, network, exact):
        worst = network.card["worst_case"]
        q = torch.tensor(worst["q"], dtype=torch.float64)
        assert network.card.space().contains(q)
        assert float(network(q).detach()) == pytest.approx(worst["value"], rel=1e-9)
        assert float(exact(q)) == pytest.approx(worst["exact"], rel=1e-9)
        assert abs(worst["value"] / worst["exact"] - 1) == pytest.approx(worst["error"], rel=1e-6)

    def test_fresh_points_are_no_worse_than_the_card_says(self, network, exact):
        errors = network.card["errors"]
        ours = validation.error_distribution(network, exact, network.card.space(), 4096, seed=5)
        assert ours.maximum <= 1.05 * network.card["worst_case"]["error"]
        assert errors["maximum"] <= network.card["worst_case"]["error"]
        assert ours.median == pytest.approx(errors["median"], rel=0.1)
        assert ours.percentile_99 == pytest.approx(errors["percentile_99"], rel=0.2)

    def test_its_card_is_complete(self, name, network):
        assert network.card["name"] == name
        assert network.card.keys() >= {
            "name", "chain", "index", "kind", "inputs", "neurons", "space", "training", "chosen", "errors",
            "worst_case", "operations", "time", "retrain", "licence", "baselines", "histogram", "slices",
            "rounding", "advice",
        }  # fmt: skip
        assert network.card["operations"]["layers"] == layer_operations(network).total
        assert set(network.card["time"]["ns_per_configuration"]) == {"exact", "network"}

    def test_it_is_small(self, name, network):
        weights = sum(8 * tensor.numel() for tensor in network.state_dict().values())
        assert store.data_path("networks", f"{name}.npz").stat().st_size < weights + 14_000


def test_an_unplanned_network_is_refused(tmp_path):
    with pytest.raises(ValueError, match=r"^name is 'nothing'"):
        shipment.ship("nothing", tmp_path)
