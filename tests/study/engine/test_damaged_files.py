"""Stored rows, arrays, probes and cards that are damaged: named, and never taken for good."""

from dataclasses import dataclass

import pytest

from dexterity_study.engine import card, evidence, runs, strict
from dexterity_study.engine.experiment import Experiment

DECLARED = evidence.experiments("uvms.kinematics")


@dataclass
class Tolerance:
    rtol: float


@pytest.fixture
def experiment(tmp_path, monkeypatch) -> Experiment:
    """Return an experiment whose evidence lies in an empty folder."""
    monkeypatch.setattr(evidence, "folder", lambda _: tmp_path)
    return next(iter(DECLARED.values()))


def damaged(kind: str):
    return {
        "folder": lambda path: path.mkdir(),
        "bytes": lambda path: path.write_bytes(b"\xff\xfe"),
        "empty": lambda path: path.write_bytes(b""),
        "nested": lambda path: path.write_bytes(b"a = " + b"[" * 200_000),
    }[kind]


@pytest.mark.parametrize("kind", ["folder", "bytes", "empty", "nested"])
def test_damaged_rows_are_named(experiment, kind):
    place = evidence.files(experiment, "chosen", experiment.seeds[0])
    damaged(kind)(place.rows)
    with pytest.raises(ValueError, match=rf"{place.rows.name} (is damaged|cannot be read)"):
        evidence.load(experiment)


@pytest.mark.parametrize("kind", ["folder", "bytes", "empty"])
def test_damaged_arrays_are_named(experiment, kind):
    place = evidence.files(experiment, "chosen", experiment.seeds[0])
    place.rows.write_text("reading,seed,metric,value\nchosen,0,a,1\n")
    damaged(kind)(place.arrays)
    with pytest.raises(ValueError, match=rf"{place.arrays.name} is damaged"):
        evidence.load(experiment)


@pytest.mark.parametrize("kind", ["folder", "bytes", "empty", "nested"])
def test_damaged_cards_are_named(tmp_path, kind):
    damaged(kind)(tmp_path / "chosen.0.toml")
    with pytest.raises(ValueError, match=r"chosen\.0\.toml"):
        card.read(tmp_path / "chosen.0.toml")


@pytest.mark.parametrize("stored", ["inf", "-inf", "nan", "1e400"])
@pytest.mark.parametrize("now", ["0", "1e300", "nan"])
def test_no_stored_infinity_lets_every_number_pass(stored, now):
    declared = Experiment(list, rtol=0.1)
    assert not runs._agree(stored, now, declared, "error")
    assert runs._agree("inf", "inf", declared, "error")
    assert runs._agree("1.0", "1.05", declared, "error")


@pytest.mark.parametrize("number", ["nan", "inf", "-inf"])
def test_a_ledger_holds_finite_numbers(tmp_path, number):
    file = tmp_path / "near.toml"
    file.write_text(f"rtol = {number}\n")
    with pytest.raises(ValueError, match="finite number"):
        strict.read_table(file, Tolerance)
