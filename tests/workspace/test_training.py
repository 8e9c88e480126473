"""Trainings: what they learn, what is frozen, and that a kill changes nothing."""

import math
import multiprocessing
import os
import signal
import time
from dataclasses import replace
from functools import cache

import pytest
import torch
from torch.testing import assert_close

from dexterity.workspace import dataset, training
from dexterity.workspace.archive import ArchiveError, read_archive, write_archive
from dexterity.workspace.jacobian_net import Architecture
from dexterity.workspace.training import OPTIMISERS, Options, cycles, epochs

SHARED = Architecture(encoder=(16, 16), confidence=(8,), estimation=(16,), normalised=(1, 1), dropout=0.2)
APART = Architecture(confidence=(16,), estimation=(32, 32))
OPTIONS = Options(cycles(2, 2), batch=128)


@cache
def confidence_rows():
    return dataset.confidence_data(1_500, 1)


@cache
def jacobian_rows():
    return dataset.jacobian_data(1_200, 2, dynamics=False)


def trained(options=OPTIONS, architecture=SHARED, seed=0, checkpoint=None, inputs="rotation", entries="tool"):
    net = training.network_for(architecture, inputs, entries, jacobian_rows(), seed=5)
    rows = {
        "confidence": training.confidence_rows(net, confidence_rows()),
        "estimation": training.estimation_rows(net, jacobian_rows()),
    }
    return training.train(net, rows, options, seed, checkpoint)


def weights(run):
    return run.network.state_dict()


def same(one, other):
    return all(torch.equal(a, b) for a, b in zip(weights(one).values(), weights(other).values(), strict=True))


def test_a_run_is_its_seed():
    assert same(trained(), trained())
    assert not same(trained(), trained(seed=1))


def test_global_draws_do_not_matter():
    torch.manual_seed(0)
    one = trained()
    torch.manual_seed(1)
    assert same(one, trained())


def test_both_heads_learn():
    run = trained(Options(epochs(8, 8), batch=64, rate=5e-3), APART, inputs="plane", entries="plane")
    by_head = {
        head: [loss.validation for loss in run.losses if loss.head == head]
        for head in ("confidence", "estimation")
    }
    constant = training.estimation_rows(run.network, jacobian_rows()).y.var(0).mean()
    assert by_head["confidence"][-1] < 0.5
    assert by_head["estimation"][-1] < by_head["estimation"][0]
    assert by_head["estimation"][-1] < constant


def test_the_papers_schedule():
    heads = [(epoch.head, epoch.frozen) for epoch in cycles(1, 2)]
    cycle = [("confidence", True), ("confidence", True), ("estimation", False)]
    assert heads == [("estimation", False), *cycle, *cycle]


def test_a_frozen_encoder_stays_as_it_was():
    before = weights(trained(Options(cycles(2, 1)[:2], batch=128)))
    after = weights(trained(Options(cycles(2, 1)[:4], batch=128)))
    for name, value in before.items():
        moved = not torch.equal(value, after[name])
        assert moved == name.startswith("confidence"), name
    last = weights(trained(Options(cycles(2, 1), batch=128)))
    assert not torch.equal(last["encoder.0.weight"], after["encoder.0.weight"])


@pytest.mark.parametrize("optimiser", OPTIMISERS)
def test_a_run_that_was_stopped_goes_on_to_the_same_weights(tmp_path, optimiser):
    options = replace(OPTIONS, optimiser=optimiser, decay=False)
    whole = trained(options)
    checkpoint = tmp_path / "run.npz"

    class StoppedError(Exception):
        pass

    for after in (1, 3, 6):
        with pytest.MonkeyPatch.context() as patch:
            keep = training._Run.keep

            def keep_and_stop(run, path, after=after, keep=keep):
                keep(run, path)
                if len(run.losses) == after:
                    raise StoppedError

            patch.setattr(training._Run, "keep", keep_and_stop)
            with pytest.raises(StoppedError):
                trained(options, checkpoint=checkpoint)
    again = trained(options, checkpoint=checkpoint)
    assert same(whole, again)
    assert again.losses == whole.losses


def _train_slowly(checkpoint):
    keep = training._Run.keep

    def keep_and_wait(run, path):
        keep(run, path)
        time.sleep(0.3)

    training._Run.keep = keep_and_wait
    trained(checkpoint=checkpoint)


def test_a_process_that_was_killed_goes_on_to_the_same_weights(tmp_path):
    checkpoint = tmp_path / "run.npz"
    process = multiprocessing.get_context("spawn").Process(target=_train_slowly, args=(checkpoint,))
    process.start()
    while not checkpoint.exists():
        assert process.is_alive()
        time.sleep(0.02)
    os.kill(process.pid, signal.SIGKILL)
    process.join()
    assert [path.name for path in tmp_path.iterdir() if not path.name.startswith(".")] == ["run.npz"]
    assert same(trained(), trained(checkpoint=checkpoint))


def test_a_finished_run_is_not_run_again(tmp_path):
    checkpoint = tmp_path / "run.npz"
    first = trained(checkpoint=checkpoint)
    content = checkpoint.read_bytes()
    assert same(first, trained(checkpoint=checkpoint))
    assert checkpoint.read_bytes() == content


@pytest.mark.parametrize(
    ("change", "what"),
    [
        ({"architecture": replace(SHARED, estimation=(17,))}, "network"),
        ({"options": replace(OPTIONS, rate=2e-3)}, "options"),
        ({"seed": 9}, "seed"),
        ({"inputs": "plane"}, "network, data, initial weights"),
    ],
)
def test_a_checkpoint_of_another_run_is_refused(tmp_path, change, what):
    checkpoint = tmp_path / "run.npz"
    trained(checkpoint=checkpoint)
    content = checkpoint.read_bytes()
    with pytest.raises(ArchiveError, match=f"another run: its {what}"):
        trained(checkpoint=checkpoint, **change)
    assert checkpoint.read_bytes() == content


def test_a_network_file_is_no_checkpoint(tmp_path):
    trained().network.save(tmp_path / "run.npz")
    with pytest.raises(ArchiveError, match="no training file"):
        trained(checkpoint=tmp_path / "run.npz")


def test_patience_keeps_the_best_weights(tmp_path):
    # A rate that is far too high for anything to get better for long.
    options = Options(epochs(0, 30), batch=64, rate=0.3, decay=False, patience=1)
    run = trained(options, APART, checkpoint=tmp_path / "run.npz")
    losses = [loss.validation for loss in run.losses]
    best = losses.index(min(losses))
    assert run.stopped_early
    assert len(losses) == best + 1 + 1 < 30
    until_then = trained(replace(options, schedule=epochs(0, best + 1), patience=None), APART)
    assert same(run, until_then)
    assert same(run, trained(options, APART, checkpoint=tmp_path / "run.npz"))


def test_scalings_are_those_of_the_training_part():
    net = training.network_for(APART, "rotation", "tool", jacobian_rows(), seed=0, validation=0.5)
    x = net.scaled_inputs(jacobian_rows().samples)
    assert_close(x[:600].mean(0), torch.zeros(16), atol=1e-5, rtol=0)
    assert x[600:].mean(0).abs().max() > 1e-3


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"schedule": ()}, "schedule is empty"),
        ({"optimiser": "Newton"}, "optimiser is 'Newton'"),
        ({"rate": 0.0}, "rate is 0.0"),
        ({"rate": math.inf}, "rate is inf"),
        ({"batch": 1}, "batch is 1"),
        ({"validation": 1.0}, "validation is 1.0"),
        ({"patience": 0}, "patience is 0"),
        ({"schedule": (training.Epoch("both"),)}, r"schedule\[0\]\.head is 'both'"),
    ],
)
def test_bad_options_are_named(change, message):
    with pytest.raises(ValueError, match=message):
        replace(OPTIONS, **change)


def test_rows_must_be_there():
    net = training.network_for(APART, "plane", "plane", jacobian_rows(), 0)
    rows = training.confidence_rows(net, confidence_rows())
    with pytest.raises(ValueError, match="rows lack estimation"):
        training.train(net, {"confidence": rows}, OPTIONS, 0)
    few = training.Rows(rows.x[:2], rows.y[:2])
    with pytest.raises(ValueError, match="there are 2 rows"):
        training.train(net, {"confidence": few}, Options(epochs(1)), 0)


@pytest.mark.usefixtures("annotations_unchecked")
@pytest.mark.parametrize(
    "field", ["schedule", "optimiser", "rate", "decay", "batch", "validation", "patience"]
)
@pytest.mark.parametrize("value", [math.nan, "x", 2.5j, [1.0], object()])
def test_options_that_are_no_options_are_named(field, value):
    with pytest.raises((TypeError, ValueError), match=rf"^{field}(\[0\])? is "):
        replace(OPTIONS, **{field: value})


@pytest.mark.parametrize("with_checkpoint", [False, True])
def test_a_training_that_diverges_ends_and_says_so(tmp_path, with_checkpoint):
    options = replace(OPTIONS, optimiser="SGD", rate=1e30, decay=False)
    run = trained(options, checkpoint=tmp_path / "run.npz" if with_checkpoint else None)
    assert run.diverged
    assert len(run.losses) < len(options.schedule)
    assert all(math.isfinite(loss.train) and math.isfinite(loss.validation) for loss in run.losses)
    assert all(part.isfinite().all() for part in weights(run).values())
    assert not trained().diverged


@pytest.mark.parametrize("name", ["weights/encoder.0.weight", "best/encoder.0.weight", "estimation/0/step"])
def test_a_checkpoint_that_lacks_something_is_refused(tmp_path, name):
    path, options = tmp_path / "run.npz", replace(OPTIONS, patience=3)
    trained(options, checkpoint=path)
    header, tensors = read_archive(path, "training")
    write_archive(path, "training", header, {key: part for key, part in tensors.items() if key != name})
    with pytest.raises(ArchiveError, match=r"run\.npz"):
        trained(options, checkpoint=path)
    write_archive(path, "training", {"run": header["run"]}, tensors)
    with pytest.raises(ArchiveError, match=r"run\.npz"):
        trained(options, checkpoint=path)
