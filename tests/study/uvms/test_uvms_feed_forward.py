"""The chapter on feed-forward networks: settings of the paper, and what rows must satisfy."""

import re
from types import SimpleNamespace

import torch

from dexterity.networks.problem import End
from dexterity_study.claims.ledger import load_paper
from dexterity_study.uvms.feed_forward import experiment, show

PAPER = load_paper("sotiropoulos2016")
SMALL = {"rows": 200, "test": 100, "epochs": 5}


def printed(name):
    return PAPER.printed(f"feed-forward-{name}")


def test_settings_are_the_printed_ones():
    assert {experiment.LIMIT} == set(printed("testing-error-limit"))
    assert {experiment.EPOCHS} == set(printed("epoch-limit"))
    assert tuple(experiment.GOALS.values()) == printed("training-error-goals")
    assert experiment.LIMITS["w"] == printed("neuron-limit")[0]
    for index, sizes in experiment.LARGER.items():
        assert sizes[0] == printed(f"{index.lower()}-neurons")


def test_the_loop_ends_at_the_first_network_that_passes():
    rows = experiment.loop(seed=1, limits={"w": 100}, fresh=500, **SMALL).where()
    assert rows["neurons"].tolist() == list(range(1, len(rows) + 1))
    passes = rows["testing_error"] <= experiment.LIMIT
    assert passes.tolist() == [False] * (len(rows) - 1) + [True]
    # What the loop returns, and that alone, is judged on fresh points.
    assert rows["fresh"].notna().tolist() == passes.tolist()


def test_a_loop_that_is_given_up_judges_its_best_network():
    rows = experiment.loop(seed=0, limits={"KCI": 3}, fresh=500, **SMALL).where()
    assert len(rows) == 3
    assert rows["fresh"].notna().idxmax() == rows["testing_error"].idxmin()


def test_a_smaller_network_of_a_sweep_is_the_one_of_the_loop():
    rows = experiment.sizes(seed=1, of={"w": (1, 3)}, **SMALL).where(kind=experiment.AS_PRINTED)
    loop = experiment.loop(seed=1, limits={"w": 100}, fresh=500, **SMALL).where()
    both = min(len(rows), len(loop))
    assert rows["testing_error"][:both].tolist() == loop["testing_error"][:both].tolist()


def test_w_does_not_depend_on_the_task_point_and_kci_does():
    of = {"of": {"w": (2,), "KCI": (2,)}, "fresh": 200, **SMALL}
    chosen = experiment.printed_sizes(seed=0, **of).where()
    moved = experiment.printed_sizes(seed=0, reading="task-point=world-origin", **of).where(
        "task-point=world-origin"
    )
    same = chosen["fresh"].to_numpy() == moved["fresh"].to_numpy()
    assert same.tolist() == (chosen["index"] == "w").tolist()


def test_the_best_of_ten_is_no_worse_and_trained_on_stays():
    sizes = experiment.printed_sizes
    of = {"of": {"w": (2,)}, "fresh": 200, **SMALL}
    (once, on), histories = sizes.function(seed=0, reading=sizes.reading(), **of)
    (best, other_on), _ = sizes.function(seed=0, reading=sizes.reading("initial-weights=best-of-ten"), **of)
    assert best["testing_error"] <= once["testing_error"]
    assert other_on["testing_error"] == on["testing_error"]
    assert {len(history) for history in histories.values()} == {SMALL["epochs"] + 1}


def test_formulas_hold_and_the_step_tends_to_its_limits():
    (row,) = experiment.formulas(seed=0, rows=100).rows.to_dict("records")
    assert row["values"] < 1e-12
    assert row["step"] < 1e-10
    assert max(row["small_damping"], row["large_damping"]) < 1e-2


def design_of(success, trials):
    end = End.PASSED if success else End.EXHAUSTED
    return SimpleNamespace(success=success, end=end, trials=range(trials))


def test_a_loop_that_passes_ends_at_its_test():
    passed, last = show.passages(design_of(True, 3))
    assert last == "pass"
    assert passed == {"start": 1, "train": 3, "test": 3, "full": 2, "add": 2, "pass": 1}


def test_a_loop_that_passes_at_once_never_adds_a_neuron():
    passed, _ = show.passages(design_of(True, 1))
    assert passed == {"start": 1, "train": 1, "test": 1, "pass": 1}


def test_a_loop_that_is_given_up_ends_at_its_limit():
    passed, last = show.passages(design_of(False, 4))
    assert last == "stop"
    assert passed == {"start": 1, "train": 4, "test": 4, "full": 4, "add": 3, "stop": 1}


def test_table_3_is_set_whole():
    html = show.settings().html
    rows = re.findall(r"<tr>(.*?)</tr>", html.partition("<tbody>")[2], re.DOTALL)
    table = [re.findall(r"<td[^>]*>(.*?)</td>", row, re.DOTALL)[:4] for row in rows]
    assert table == [
        ["0.02", "0.02", "0.02", "0.02"],
        ["1\u00a0×\u00a010⁻⁶", "1\u00a0×\u00a010⁻⁶", "0.001", "5\u00a0×\u00a010⁻⁶"],
        ["0.01", "0.0001", "–", "–"],
        ["–", "–", "100", "100"],
        ["–", "–", "100", "100"],
        ["10", "10", "–", "–"],
        ["1,000", "1,000", "1,000", "1,000"],
    ]


def test_goals_are_said_as_shares_of_the_mean():
    values = torch.tensor([9.0, 11.0], dtype=torch.float64)
    fake = SimpleNamespace(data=SimpleNamespace(train=SimpleNamespace(values=values)))
    # The root of 1e-3 is 0.0316, which is 0.32 % of ten.
    assert "0.32 % of its mean value" in show.goals({"w": fake})
