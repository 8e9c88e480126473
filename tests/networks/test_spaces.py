"""Spaces come back from a card as they were."""

import json

import pytest

from dexterity import sampling
from dexterity.networks import spaces
from dexterity.networks.domain import Guarded, OutsideTrainedSpace
from dexterity.networks.files import load_shipped, save, shipped

SPACES = [
    sampling.Box([-1.0, 0.0, 0.1], [1.0, 0.0, 0.2]),
    sampling.Box([-1.0, 0.0], [1.0, 2.0], levels=[None, 5]),
    sampling.uvms_space("manipulability"),
    sampling.uvms_space("kinematic_conditioning"),
    sampling.uvms_space("kinematic_conditioning", turned=True),
]


@pytest.mark.parametrize("space", SPACES)
def test_a_space_comes_back_from_json(space):
    assert spaces.from_card(json.loads(json.dumps(spaces.to_card(space)))) == space


@pytest.mark.parametrize(
    ("entry", "message"),
    [
        ([], "a mapping"),
        ({}, "of the kind None"),
        ({"kind": "Ball"}, "of the kind 'Ball'"),
        ({"kind": "Box"}, "does not describe a Box"),
        ({"kind": "Box", "lower": [0.0], "upper": [-1.0]}, "lower exceeds upper"),
        ({"kind": "Box", "lower": [0.0], "upper": [1.0], "radius": 1}, "does not describe a Box"),
        ({"kind": "TaskSector", "rest": 3}, "does not describe a TaskSector"),
    ],
)
@pytest.mark.usefixtures("annotations_unchecked")
def test_an_entry_that_is_no_space_is_refused(entry, message):
    with pytest.raises(ValueError, match=message):
        spaces.from_card(entry)


@pytest.mark.usefixtures("annotations_unchecked")
def test_another_space_cannot_stand_on_a_card():
    with pytest.raises(TypeError, match=r"^space is a str"):
        spaces.to_card("everywhere")


@pytest.mark.parametrize("name", shipped())
def test_a_shipped_file_alone_guards_its_network(tmp_path, name):
    """Point 6.2 of the engineer's trial: the space on a card could not be turned back into one."""
    save(load_shipped(name), tmp_path / "network.npz")
    guarded = Guarded.load(tmp_path / "network.npz")
    inside = sampling.sobol(guarded.space, 16, 0)
    assert guarded(inside).shape == (16,)
    outside = inside.clone()
    seen = guarded.network.inputs[-1]
    outside[3, seen] += 7.0
    with pytest.raises(OutsideTrainedSpace, match=rf"joint {seen + 1} "):
        guarded(outside)


def test_a_network_without_a_space_on_its_card_is_not_guarded():
    network = load_shipped(shipped()[0])
    network.card = {}
    with pytest.raises(ValueError, match=r"^card has no entry 'space'"):
        Guarded.of(network)
