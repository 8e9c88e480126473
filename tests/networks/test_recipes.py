"""Recipes: where their rows lie, and what rounds of worst points do."""

import dataclasses
from functools import cache

import pytest
import torch
from torch.testing import assert_close

import dexterity as dx
from dexterity import sampling
from dexterity.indices import Index
from dexterity.networks import recipes, worst_case
from dexterity.networks.network import View
from dexterity.networks.recipes import Recipe
from dexterity.sampling import Box

VIEW = View(12, range(4, 11))
SMALL = Recipe(neurons=3, rows=300, epochs=20)


@cache
def uvms_space():
    return sampling.uvms_space("manipulability")


@pytest.fixture(scope="module")
def w():
    return Index("manipulability").bind(dx.robots.uvms())


def test_each_seed_has_a_network_of_its_own(w):
    networks = recipes.prepare(SMALL, VIEW, w, uvms_space(), seeds=(4, 5))
    alone = recipes.prepare(SMALL, VIEW, w, uvms_space(), seeds=(5,))
    q = sampling.sobol(uvms_space(), 16, 9)
    assert_close(networks[1](q), alone[0](q), rtol=1e-6, atol=0)
    assert not torch.equal(networks[0](q), networks[1](q))
    again = recipes.prepare(SMALL, VIEW, w, uvms_space(), seeds=(4, 5))
    assert torch.equal(networks[0](q), again[0](q))


def test_rounds_of_worst_points_lower_the_worst_case():
    """Not of every network; of these, which have hardly more rows than weights, clearly."""
    space = Box([-1.0] * 4, [1.0] * 4)

    def index(q):
        return 3 + torch.sin(q @ torch.tensor([2.0, -1.0, 1.5, 0.5], dtype=torch.float64)) + q[..., 1] ** 3

    def worst(recipe):
        networks = recipes.prepare(recipe, View(4, range(4)), index, space, seeds=(0, 1, 2))
        return sorted(worst_case.worst_case(one, index, space).error for one in networks)[1]

    plain = Recipe(neurons=8, rows=60, epochs=60)
    assert worst(dataclasses.replace(plain, rounds=2, worst_points=150)) < 0.5 * worst(plain)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"neurons": 0}, "neurons is 0"),
        ({"rows": 0}, "rows is 0"),
        ({"epochs": 0}, "epochs is 0"),
        ({"rounds": -1}, "rounds is -1"),
        ({"worst_points": 0}, "worst_points is 0"),
        ({"round_epochs": 0}, "round_epochs is 0"),
        ({"overhang": -0.1}, "overhang is -0.1"),
    ],
)
def test_an_impossible_recipe_is_refused(change, message, annotations_unchecked):
    with pytest.raises(ValueError, match=f"^{message}"):
        Recipe(**change)


def test_no_seeds_are_refused(w):
    with pytest.raises(ValueError, match=r"^seeds is empty"):
        recipes.prepare(SMALL, VIEW, w, uvms_space(), seeds=())
