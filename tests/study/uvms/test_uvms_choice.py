"""The chapter on which network to use: what its rows must satisfy, and how times are read."""

import numpy as np
import pandas as pd
import pytest

from dexterity import networks, robots
from dexterity_study.engine.evidence import Evidence
from dexterity_study.engine.table import Table
from dexterity_study.uvms.choice import experiment, show, verdicts

SMALL = experiment.SMALL


def test_every_shipped_network_has_a_card():
    rows = experiment.cards().where()
    names = [experiment.shipped_name(*key) for key in zip(rows["index"], rows["kind"], strict=True)]
    assert sorted(names) == [name for name in networks.shipped() if name.startswith("uvms-")]
    assert (rows["worst"] >= rows["error"]).all()
    assert (rows["exact_0"] <= rows["exact_2"]).all()


def test_an_ascent_finds_no_less_than_the_points_do():
    pytest.importorskip("sklearn")
    rows = experiment.judged(effort=experiment.Effort(500, 2000, experiment.SMALL_SEARCH)).where()
    climbed = rows.dropna(subset="worst")
    assert set(rows["what"]) - set(climbed["what"]) == {"boosted trees"}
    assert (climbed["worst"] >= climbed["sampled"]).all()
    assert (rows["sampled"] >= rows["most"]).all()


def test_what_passes_a_test_was_the_smallest_that_could():
    rows = experiment.selection(largest=2, restarts=3, limits=(0.001, 0.05, 0.5), effort=SMALL).where()
    # No network passes the first limit; one neuron is enough for the others.
    assert rows["limit"].tolist() == [0.05, 0.5]
    assert (rows["testing"] <= rows["limit"]).all()
    assert (rows["broken"] <= rows["accepted"]).all()
    assert (rows["accepted"] <= rows["trained"]).all()


def test_pruning_takes_neurons_and_operations_off():
    rows = experiment.pruned(sizes={"w": (20, 2)}, spreads=(3.0,), rows=200).where()
    assert (rows["after"] < rows["before"]).all()
    assert (rows["allowed"] >= experiment.LIMIT).all()
    # A neuron with seven inputs takes 26 operations by the paper's rules.
    assert (rows["operations"] == 26 * rows["after"]).all()


def test_other_systems_keep_joints_that_they_lack_at_zero():
    rows = experiment.elsewhere(neurons=(2, 2), epochs=3, effort=SMALL).where().set_index(["system", "index"])
    inputs = rows["inputs"]
    for index in ("w", "KCI"):
        assert (
            inputs["UVMS with pitch and roll passive", index] == inputs["UVMS in other postures", index] - 2
        )
    assert inputs["PUMA 560, fixed", "w"] < robots.puma560().joints
    assert (rows["span"] > 1).all()


def test_a_network_is_faster_only_where_quartiles_are_apart():
    times = {"exact": (10.0, 11.0, 12.0)}
    found = {}
    for kind, network in {
        "apart": (5.0, 6.0, 7.0),
        "overlap": (9.0, 10.0, 11.0),
        "slower": (13.0, 14.0, 15.0),
    }.items():
        both = {**times, "network": network}
        row = {f"{of}_{i}": both[of][i] for of in both for i in range(3)}
        found[kind] = {"reading": "chosen", "seed": 0, "index": "w", "kind": kind, **row}
    table = Table(pd.DataFrame(found.values()), ("index", "kind"))
    speeds = verdicts.speeds(Evidence("uvms.choice", {"cards": table})).xs("w")
    assert speeds["faster"].to_dict() == {"apart": True, "overlap": False, "slower": False}
    assert speeds["ratio"].to_dict() == {"apart": "1.83", "overlap": "indistinguishable", "slower": "0.79"}


@pytest.mark.parametrize("seed", range(3))
def test_the_smallest_eigenvalue_comes_closer_to_a_tip_than_a_smooth_output(seed):
    example = show.train_on_a_tip(neurons=6, seed=seed)
    assert example.errors["smallest eigenvalue"] < 0.5 * example.errors["smooth output"]
    # The line passes through the tip, where the value is 1.
    assert example.exact.max() == pytest.approx(1.0)
    assert example.line[example.exact.argmax()] == pytest.approx(0.0, abs=1e-12)
    for name, values in example.answers.items():
        on_line = np.abs(values / example.exact - 1).max()
        assert on_line <= example.errors[name] * (1 + 1e-2), name
