"""Evidence from the command line: what is stale and why, what is accepted, and what survives a kill."""

import os
import signal
import time

import pytest
from scratch_house import House

from warm_process import wait_for

TINY = "src/dexterity_study/uvms/tiny"


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    house = House(tmp_path_factory.mktemp("house"))
    code, printed = house.run("evidence")
    assert code == 0, printed
    return house


ERRORS = {f"uvms.tiny.errors[{which}]" for which in ("probe", "chosen.0", "chosen.1", "chosen.2")}
SPEED = {"uvms.tiny.speed[probe]", "uvms.tiny.speed[chosen.0]"}


def test_a_run_stores_rows_and_a_card_and_nothing_is_stale(built):
    assert sorted(file.name for file in (built.results / "errors").iterdir()) == [
        *(f"chosen.{seed}.{kind}" for seed in range(3) for kind in ("csv", "toml")),
        "probe.csv",
    ]
    assert "torch" in (built.results / "errors/chosen.0.toml").read_text()
    assert built.run("stale") == (0, "0 of 6 tasks are out of date\n")


def test_prose_and_what_is_not_used_make_nothing_stale(built):
    edits = [
        (f"{TINY}/verdicts.py", "It holds.", "It does not hold."),
        (f"{TINY}/experiment.py", '"""Errors."""', '"""Errors of the draw."""'),
        (f"{TINY}/experiment.py", "    time.sleep", "    # Wait.\n    time.sleep"),
        ("src/dexterity/robots/__init__.py", '"""', '"""More prose. '),
        ("src/dexterity_study/engine/progress.py", "passed", "gone"),
        ("data/robots/puma560.toml", "name", "# a comment\nname"),
    ]
    assert built.stale_after(edits) == [{}] * len(edits)


def test_what_is_used_makes_stale_what_uses_it_and_the_file_is_the_reason(built):
    edits = {
        (f"{TINY}/sampler.py", "Random(seed)", "Random(seed + 1)"): ERRORS | SPEED,
        ("src/dexterity/timing/measurement.py", "0.25", "0.1"): ERRORS | SPEED,
        ("data/robots/uvms.toml", "0.75", "0.76"): ERRORS,
        ("data/results/uvms/tiny/errors/chosen.1.csv", "error,0.", "error,1."): {
            "uvms.tiny.errors[chosen.1]"
        },
    }
    for (file, *_), expected, answer in zip(
        edits, edits.values(), built.stale_after(list(edits)), strict=True
    ):
        assert answer.keys() == expected
        assert set(map(tuple, answer.values())) == {(f"{file}: changed",)}


def test_a_probe_tells_of_data_files_that_are_read_and_not_named(built):
    assert built.run("probe", "uvms.tiny.errors")[0] == 0
    file = f"{TINY}/experiment.py"
    built.edit(file, '"robots/uvms.toml"', '"tasks.toml"')
    code, printed = built.run("probe", "uvms.tiny.errors")
    built.edit(file, '"tasks.toml"', '"robots/uvms.toml"')
    assert code == 1
    assert "uvms.tiny.errors reads robots/uvms.toml, which it does not name" in printed


def test_acceptance_repeats_the_probe_and_leaves_its_reason_on_the_card(tmp_path, built):
    file = f"{TINY}/sampler.py"
    built.edit(file, "random.Random(seed).random()", "(random.Random(seed).random() + 0.0)")
    code, printed = built.run(
        "accept", "uvms.tiny.errors", "--reason", "The sum with zero is the same number."
    )
    assert code == 0, printed
    card = (built.results / "errors/chosen.2.toml").read_text()
    assert 'reason = "The sum with zero is the same number."' in card
    assert f'changed = ["{file}: changed"]' in card
    built.edit(file, "+ 0.0", "+ 1.0")
    code, printed = built.run("accept", "uvms.tiny.errors", "--reason", "It is surely the same.")
    assert code == 1
    assert "stored 0.844421851525, now 1.84442185153" in printed
    assert "It is surely" not in (built.results / "errors/chosen.2.toml").read_text()
    built.edit(file, "+ 1.0", "+ 0.0")


def test_a_killed_run_goes_on_where_it_was(tmp_path):
    house = House(tmp_path)
    house.edit(f"{TINY}/experiment.py", "pause=0.0, sizes", "pause=1.0, sizes")
    process = house.start("evidence", "uvms.tiny.errors", "--workers", "1")
    wait_for(lambda: list(house.results.glob("errors/chosen.*.toml")))
    # Runs start in any order.
    (first,) = house.results.glob("errors/chosen.*.toml")
    time.sleep(0.3)
    process.kill()
    process.end()
    made = first.read_bytes()
    code, printed = house.run("evidence", "uvms.tiny.errors", "--workers", "1")
    assert code == 0, printed
    assert first.read_bytes() == made
    assert not list(house.results.rglob("*.tmp"))
    assert not (house.results / "speed").exists()
    assert house.run("stale", "uvms.tiny.errors")[0] == 0


def test_source_that_changes_while_it_runs_stores_nothing(tmp_path):
    house = House(tmp_path)
    house.edit(f"{TINY}/experiment.py", "pause=0.0, sizes", "pause=2.0, sizes")
    process = house.start("evidence", "uvms.tiny.errors", "--workers", "1")
    wait_for(lambda: list(house.results.glob("errors/chosen.*.toml")))
    time.sleep(0.3)
    house.edit(f"{TINY}/sampler.py", "Random(seed)", "Random(seed + 1)")
    code, printed = process.end()
    assert code == 1
    assert "sampler.py has changed while uvms.tiny ran" in printed
    assert len(list(house.results.glob("errors/chosen.*.csv"))) == 1


def test_a_cluster_finishes_although_one_of_its_workers_is_killed(tmp_path):
    house = House(tmp_path)
    house.edit(f"{TINY}/experiment.py", "pause=0.0, sizes", "pause=2.0, sizes")
    with house.cluster(workers=2) as (scheduler, workers):
        process = house.start("evidence", "uvms.tiny.errors", "--backend", "dask", "--scheduler", scheduler)
        wait_for(lambda: list(house.results.glob("errors/*.csv")))
        os.kill(workers()[0], signal.SIGKILL)
        code, printed = process.end()
    assert code == 0, printed
    assert house.run("stale", "uvms.tiny.errors")[0] == 0
