"""From chain, index, space and goal to a judged network: the card tells the truth, and advice is sound."""

import dataclasses
import json
import math
import re

import pytest
import torch

import dexterity as dx
from dexterity.networks import Effort, Search, learning, validation
from dexterity.networks.worst_case import worst_case
from dexterity.sampling import Box

PUMA = dx.robots.puma560()
SPACE = Box.around(PUMA, [0.0, 0.6, -0.9, 0.0, 0.8, 0.0], 0.2, joints=(1, 2, 4))
FEW = Search(256, 16, 8, 10)
EFFORT = Effort(
    sizes=(2, 5), readouts=("identity",), rows=512, epochs=40, restarts=1, validation=1024, search=FEW
)


@pytest.fixture(scope="module")
def learned():
    return dx.networks.for_index(PUMA, "manipulability", SPACE, 0.01, effort=EFFORT, points=2000)


@pytest.fixture(scope="module")
def exact():
    return dx.Index("manipulability").bind(PUMA)


def test_the_card_holds_on_other_points_and_by_another_search(learned, exact):
    card = learned.card
    assert learned.success
    assert learned.error == max(card["errors"]["maximum"], card["worst_case"]["error"])
    again = validation.error_distribution(learned.network, exact, SPACE, 2000, seed=99)
    assert again.median == pytest.approx(card["errors"]["median"], rel=0.2)
    assert again.maximum <= 1.3 * learned.error
    assert worst_case(learned.network, exact, SPACE, FEW, 99).error == pytest.approx(
        card["worst_case"]["error"], rel=0.3
    )


def test_the_network_sees_what_varies_and_matters(learned):
    assert learned.network.inputs == (1, 2, 4)
    assert learned.network.joints == 6


def test_it_answers_inside_its_space_alone(learned, exact):
    q = dx.sampling.sobol(SPACE, 10, 5)
    torch.testing.assert_close(learned(q), exact(q), rtol=0.01, atol=0)
    with pytest.raises(dx.networks.OutsideTrainedSpace):
        learned(q + 1.0)


def test_file_and_card_alone_judge_it_again(learned, tmp_path):
    learned.save(tmp_path / "network.npz")
    network = dx.networks.load(tmp_path / "network.npz")
    card = network.card
    assert card == learned.card
    assert card.space() == SPACE
    assert card.index() == dx.Index("manipulability")
    torch.testing.assert_close(card.chain().screws, PUMA.screws, rtol=0, atol=0)
    torch.testing.assert_close(card.chain().home, PUMA.home, rtol=0, atol=0)
    assert card.chain().joint_names == PUMA.joint_names
    torch.testing.assert_close(card.chain().upper, PUMA.upper)
    seed = card["errors"]["seed"]
    again = dx.networks.judge_again(network, points=2000, seed=seed)
    assert again["errors"]["maximum"] == pytest.approx(card["errors"]["maximum"], rel=1e-9)
    assert again.keys() == card.keys()
    assert again["baselines"].keys() == card["baselines"].keys()
    assert again["operations"] == card["operations"]
    other = dx.networks.judge_again(network, points=500, seed=seed + 1, search=FEW)
    assert other["errors"]["maximum"] < 1.5 * card["worst_case"]["error"]


def test_the_advice_follows_from_the_numbers(learned):
    card = learned.card
    times = card["time"]["ns_per_configuration"]
    assert set(times) == {"exact", "network"}
    assert f"{times['exact'][1]:.3g} ns" in card["advice"]
    if learned.recommendation == "network":
        assert times["exact"][1] > times["network"][1]
        assert min(entry["maximum"] for entry in card["baselines"].values()) > card["errors"]["maximum"]


@pytest.mark.parametrize(
    ("largest", "ratio", "cubic", "better", "words"),
    [
        (0.005, 2.0, 0.1, "network", "2 times as fast"),
        (0.005, 1.0, 0.1, "exact", "no slower"),
        (0.005, 0.5, 0.1, "exact", "no slower"),
        (0.02, 2.0, 0.1, "exact", "no network kept the goal"),
        (0.005, 2.0, 0.004, "exact", "the cubic fit"),
    ],
)
def test_advice(largest, ratio, cubic, better, words):
    from dexterity.networks.comparison import Times
    from dexterity.timing import Timing

    exact_time = Timing("exact", 1, 9.9e-9 * ratio, 1e-8 * ratio, 1.01e-8 * ratio)
    network_time = Timing("network", 1, 9.9e-9, 1e-8, 1.01e-8)
    card = dx.networks.Card(
        {
            "errors": {"maximum": largest},
            "worst_case": {"error": largest},
            "baselines": {"cubic": {"maximum": cubic}},
        }
    )
    found, reasons = learning._advice(card, Times(exact_time, network_time, ("C", "C")), goal=0.01)
    assert found == better
    assert words in reasons


def test_an_index_that_vanishes_in_the_space_is_judged_by_its_range():
    through_zero = Box.around(PUMA, [0.0, 0.6, -0.9, 0.0, 0.0, 0.0], 0.2, joints=(1, 4))
    few = dataclasses.replace(EFFORT, sizes=(4,))
    learned = dx.networks.for_index(PUMA, "manipulability", through_zero, 0.1, effort=few, points=500)
    assert learned.card["errors"]["relative_to"] > 0


def test_without_a_space_the_middle_of_the_limits_is_taken():
    upper = [1.0, 1.0, -0.4, 0.5, 1.4, 1.0]
    arm = dx.Chain(
        PUMA.screws, PUMA.home, name="limited", lower=[-1.0, 0.2, -1.4, -0.5, 0.2, -1.0], upper=upper
    )
    few = dataclasses.replace(EFFORT, sizes=(2,))
    learned = dx.networks.for_index(arm, "manipulability", goal=10.0, effort=few, points=200)
    relevant = dx.sampling.relevant_joints(arm, dx.Index("manipulability"))
    assert learned.space == Box.around(arm, joints=relevant)
    assert learned.space.upper[1] == pytest.approx(0.6 + math.radians(20))


def test_an_interrupt_returns_the_judged_network_so_far():
    def interrupt(text, done, most):
        raise KeyboardInterrupt

    learned = dx.networks.for_index(
        PUMA, "manipulability", SPACE, 1e-9, effort=EFFORT, points=200, progress=interrupt
    )
    assert learned.interrupted
    assert not learned.success
    assert learned.card["errors"]["count"] == 200


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"chain": 3}, "chain is 3"),
        ({"index": "dexterity"}, r"(index )?name is 'dexterity'"),
        ({"index": 3}, "index is 3"),
        ({"goal": 0}, "goal is 0"),
        ({"goal": math.nan}, "goal is nan"),
        ({"points": 2.5}, r"points is 2\.5"),
        ({"space": "all"}, "space is 'all'"),
        ({"space": Box([-1.0], [1.0])}, "space has 1 joints and chain 6"),
        ({"space": Box.around(PUMA, joints=(0, 5))}, "space holds all joints that the index depends on"),
        ({"progress": "yes"}, "progress is 'yes'"),
        ({"name": "a\x00b"}, "name is"),
    ],
)
@pytest.mark.usefixtures("annotations_unchecked")
def test_bad_arguments_are_refused_by_name(arguments, message):
    tiny = dataclasses.replace(EFFORT, sizes=(1,), epochs=1, rows=64, validation=64)
    given = {"chain": PUMA, "index": "manipulability", "space": SPACE, "effort": tiny} | arguments
    with pytest.raises((TypeError, ValueError), match=f"^{message}"):
        dx.networks.for_index(given.pop("chain"), given.pop("index"), given.pop("space"), **given)


# ---- what people see -------------------------------------------------------------------------------


def test_its_text_tells_size_error_and_advice(learned):
    assert re.search(r"of \d neurons.*keeps the goal 0\.01; better answer: (exact|network)", repr(learned))


def test_the_card_as_text_has_all_that_counts(learned):
    text = learned.card.markdown()
    for part in ("puma560", "manipulability", "worst case", "cubic instead", "elbow", "ns"):
        assert part in text


def test_the_card_as_a_page_stands_alone(learned):
    page = learned.card.html()
    assert page.count("<svg") == 2
    assert not re.search(r"(src|href)=[\"']?(https?:)?//", page)
    assert "<script" not in page
    assert page == learned.card.html()


def test_names_on_a_page_are_text(learned):
    """Case of the review, faults #2: names become script nowhere."""
    hostile = '<img src=x onerror="alert(1)"> --> $\\alpha$ \u4e2d `|`'
    entries = json.loads(json.dumps(learned.card.to_dict()).replace("elbow", "ELBOW"))
    entries["name"] = entries["chain"]["name"] = hostile
    entries["chain"]["joint_names"] = [hostile + str(i) for i in range(6)]
    entries["slices"][0]["joint"] = hostile
    entries[hostile] = {hostile: hostile}
    card = dx.networks.Card(entries)
    for text in (card.html(), card.markdown()):
        assert "<img" not in text
