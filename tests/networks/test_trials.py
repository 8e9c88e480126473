"""Stored trials: what is taken for one, and that a design which is killed goes on where it was."""

import dataclasses
import math
import multiprocessing
import os
import random
import signal
import sys
import types

import pytest
import torch
from design_problems import SMALL, small_problem

from dexterity.networks import design, files, levenberg_marquardt
from dexterity.networks import trials as trials_module
from dexterity.networks.design import design_feed_forward
from dexterity.networks.feed_forward import FeedForward
from dexterity.networks.network import View
from dexterity.networks.trials import TrialStore, source_key

PROBLEM = small_problem()
# Long enough to be killed at any of its sizes.
LONG = dataclasses.replace(SMALL, testing_error=0.0, neuron_limit=12, epoch_limit=60, restarts=1)


def network(seed=0):
    q = PROBLEM.data.train.q
    return FeedForward.untrained(View(2, [0, 1]), 3, q, q.sum(-1), torch.Generator().manual_seed(seed))


def designed(store, options=SMALL, problem=PROBLEM):
    return design_feed_forward(problem, options, trials=store, progress=False)


def contents(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def test_what_is_put_is_found(tmp_path):
    store = TrialStore(tmp_path / "new" / "folder")
    assert store.get("a") is None
    store.put("a", network(), {"answer": 42})
    found = store.get("a")
    assert found.card["answer"] == 42
    assert torch.equal(found(PROBLEM.data.test.q), network()(PROBLEM.data.test.q))


def test_only_a_whole_file_of_that_trial_is_taken(tmp_path):
    store = TrialStore(tmp_path)
    store.put("a", network(), {})
    content = (tmp_path / "a.npz").read_bytes()
    (tmp_path / "b.npz").write_bytes(content)
    assert store.get("b") is None
    for damaged in (b"", content[:-1], content[1:], content.replace(b"hidden", b"hodden"), b"not a network"):
        (tmp_path / "a.npz").write_bytes(damaged)
        assert store.get("a") is None
    files.save(network(), tmp_path / "a.npz", {"trial": "another"})
    assert store.get("a") is None
    store.put("a", network(), {})
    assert store.get("a") is not None


def test_a_design_is_the_same_from_stored_trials(tmp_path, monkeypatch):
    store = TrialStore(tmp_path)
    first = designed(store)
    assert len(contents(tmp_path)) == first.network.neurons
    assert first == designed(None)
    monkeypatch.setattr("dexterity.networks.design._Loop.trained", None)
    again = designed(store)
    assert again == first
    assert again.network.card == {}
    assert torch.equal(again.network(PROBLEM.data.test.q), first.network(PROBLEM.data.test.q))
    # When to stop is no part of a trial.
    assert designed(store, dataclasses.replace(SMALL, testing_error=0.5)).trials == first.trials[:2]


def test_damaged_trials_are_done_again(tmp_path):
    store = TrialStore(tmp_path)
    first = designed(store)
    whole = contents(tmp_path)
    name = min(whole)
    (tmp_path / name).write_bytes(whole[name][:100])
    assert designed(store) == first
    assert files.load(tmp_path / name).card.keys() == {"trial", "trials"}


def test_trials_of_other_runs_are_not_taken(tmp_path):
    store = TrialStore(tmp_path)
    designed(store)
    before = len(contents(tmp_path))
    changes = {"seed": 1, "readout": "logarithm", "epoch_limit": 31, "damping": "factor", "restarts": 1}
    for change in [*({name: value} for name, value in changes.items()), {"training_goal": 1e-9}]:
        designed(store, dataclasses.replace(SMALL, **change, neuron_limit=1))
        before += 1
        assert len(contents(tmp_path)) == before, change
    designed(store, dataclasses.replace(SMALL, neuron_limit=1), small_problem(seed=1))
    assert len(contents(tmp_path)) == before + 1


def test_errors_that_are_no_numbers_are_kept(tmp_path):
    """JSON has no infinity, and a diverged network has such errors."""
    trial = dataclasses.replace(designed(None).best, testing_error=math.inf)
    size = design._Size((trial,), network())
    TrialStore(tmp_path).put("a", size.network, design._to_record(size))
    assert design._from_record(TrialStore(tmp_path).get("a")).trials == (trial,)


def test_keys_follow_the_source(tmp_path):
    module = types.ModuleType("own")
    module.__file__ = str(tmp_path / "own.py")
    keys = []
    for text in ("a = 1", "a = 2", "a = 1"):
        (tmp_path / "own.py").write_text(text)
        keys.append(source_key([module]))
    assert keys[0] == keys[2] != keys[1]
    assert source_key([trials_module, module]) != keys[0]
    with pytest.raises(ValueError, match="no file"):
        source_key([sys])


def run_design_until_killed(folder, steps):
    """Killed by the number of steps, not by the clock: where it ends does not depend on the machine."""
    step, left = levenberg_marquardt._State.step, iter(range(steps))

    def counted(state):
        if next(left, None) is None:
            os.kill(os.getpid(), signal.SIGKILL)
        return step(state)

    levenberg_marquardt._State.step = counted
    designed(TrialStore(folder), LONG)


def test_a_design_killed_five_times_ends_as_an_undisturbed_one(tmp_path):
    undisturbed = designed(TrialStore(tmp_path / "undisturbed"), LONG)
    # Processes begin from one that has imported everything already.
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(["design_problems", "dexterity.networks.design"])
    draw = random.Random(5)
    folder = tmp_path / "killed"
    found = []
    for _ in range(5):
        process = context.Process(target=run_design_until_killed, args=(folder, draw.randint(1, 130)))
        process.start()
        process.join()
        assert process.exitcode == -signal.SIGKILL
        found.append(len(list(folder.glob("*.npz"))) if folder.exists() else 0)
    assert found == sorted(found)
    assert 0 < found[-1] < LONG.neuron_limit
    assert designed(TrialStore(folder), LONG) == undisturbed
    whole = {name: content for name, content in contents(folder).items() if name.endswith(".npz")}
    assert whole.keys() == contents(tmp_path / "undisturbed").keys()
