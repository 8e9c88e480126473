"""The networks that come with the package: what their cards say must be so."""

import pytest
import torch

import dexterity as dx
from dexterity import networks, sampling
from dexterity.indices import Index
from dexterity.networks import validation
from dexterity.networks.feed_forward import FeedForward
from dexterity.networks.judgement import layer_operations
from dexterity.networks.radial_basis import RadialBasis
from dexterity_study import shipment

UVMS = dx.robots.uvms()


def test_all_planned_networks_are_shipped_and_no_other():
    assert set(networks.shipped()) == set(shipment.PLANS)


@pytest.mark.parametrize("name", shipment.PLANS)
class TestShipped:
    @pytest.fixture
    def network(self, name):
        return networks.load_shipped(name)

    @pytest.fixture
    def exact(self, network):
        card = network.card["index"]
        return Index(card["name"], card["frame"]).bind(UVMS)

    @pytest.fixture
    def space(self, network):
        return sampling.uvms_space(network.card["index"]["name"])

    def test_it_is_what_its_plan_says(self, name, network):
        plan = shipment.PLANS[name]
        assert network.card["name"] == name
        assert network.card["index"]["name"] == plan.index
        assert len(network.view.carriers) == plan.carriers
        if isinstance(plan, shipment.FeedForwardPlan):
            assert isinstance(network, FeedForward)
            assert (network.neurons, network.readout) == (plan.recipe.neurons, plan.recipe.readout)
        else:
            assert isinstance(network, RadialBasis)
            assert network.neurons == plan.neurons

    def test_its_worst_case_is_where_the_card_says(self, network, exact, space):
        worst = network.card["worst_case"]
        q = torch.tensor(worst["q"], dtype=torch.float64)
        assert space.contains(q)
        assert float(network(q).detach()) == pytest.approx(worst["value"], rel=1e-9)
        assert float(exact(q)) == pytest.approx(worst["exact"], rel=1e-9)
        assert abs(worst["value"] / worst["exact"] - 1) == pytest.approx(worst["error"], rel=1e-6)

    def test_fresh_points_are_no_worse_than_the_card_says(self, network, exact, space):
        told = network.card["errors"]
        ours = validation.error_distribution(network, exact, space, 4096, seed=5)
        assert ours.maximum <= network.card["worst_case"]["error"]
        assert told["maximum"] <= network.card["worst_case"]["error"]
        assert ours.median == pytest.approx(told["median"], rel=0.1)
        assert ours.percentile_99 == pytest.approx(told["percentile_99"], rel=0.2)

    def test_its_card_is_complete(self, network):
        assert network.card.keys() >= {
            "name", "chain", "index", "kind", "inputs", "neurons", "space", "training", "chosen", "errors",
            "worst_case", "operations", "time", "retrain", "licence",
        }  # fmt: skip
        assert network.card["operations"]["layers"] == layer_operations(network).total
        assert network.card["errors"]["count"] == shipment.JUDGED


def test_an_unplanned_network_is_refused(tmp_path):
    with pytest.raises(ValueError, match=r"^name is 'nothing'"):
        shipment.ship("nothing", tmp_path)
