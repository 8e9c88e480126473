"""Declaration of experiments, and the generic promises that every experiment of the study makes."""

from pathlib import Path

import pytest

from dexterity import store
from dexterity_study.engine import evidence
from dexterity_study.engine.experiment import Experiment, experiment

ALL = [(chapter, name) for chapter in evidence.chapters() for name in evidence.experiments(chapter)]


def rows(seed, size=3):
    yield {"size": size, "error": seed / size}


def test_a_call_runs_one_seed_with_its_changes():
    declared = experiment(keys=("size",), seeds=2, smoke={"size": 1})(rows)
    assert declared.seeds == (0, 1)
    assert declared(1).values("error").tolist() == [1 / 3]
    assert declared(1, size=2).values("error").tolist() == [0.5]
    assert declared.probe().rows["size"].tolist() == [1]


@pytest.mark.parametrize(
    ("fields", "complaint"),
    [
        ({"smoke": {"length": 1}}, "no parameters \\['length'\\]"),
        ({"seeds": ()}, "at least one"),
        ({"seeds": (1, 1)}, "different seeds"),
        ({"assumes": ("l1",)}, "go together"),
        ({"paper": "sotiropoulos2016"}, "go together"),
    ],
)
def test_declarations_that_cannot_be_run_are_refused(fields, complaint):
    with pytest.raises(TypeError, match=complaint):
        Experiment(rows, **fields)


def test_arrays_must_be_declared():
    declared = experiment(arrays=("a",))(lambda seed: ([], {"b": [seed]}))
    with pytest.raises(ValueError, match=r"returns the arrays \['b'\] and declares \['a'\]"):
        declared()


@pytest.mark.parametrize(("chapter", "name"), ALL, ids=".".join)
def test_the_declared_readings_and_data_files_exist(chapter, name):
    declared = evidence.experiments(chapter)[name]
    for reading, _ in evidence.runs(declared):
        assert declared.reading(reading).only(*declared.assumes).keys() == set(declared.assumes)
    for file in declared.data:
        assert store.data_path(*file.split("/")).exists()


@pytest.mark.parametrize("chapter", evidence.chapters())
def test_experiments_read_no_data_file_that_they_do_not_name(chapter, monkeypatch):
    opened: list[Path] = []
    original = Path.open

    def spy(self, *args, **kwargs):
        opened.append(self)
        return original(self, *args, **kwargs)

    for declared in evidence.experiments(chapter).values():
        if declared.timed:
            continue
        opened.clear()
        monkeypatch.setattr(Path, "open", spy)
        declared.probe()
        monkeypatch.undo()
        data = store.data_path()
        read = {path.relative_to(data).as_posix() for path in opened if path.is_relative_to(data)}
        # Values of assumptions are parameters of the task.
        read -= {name for name in read if name.startswith("papers/")}
        named = {
            name for name in read if any(name == own or name.startswith(f"{own}/") for own in declared.data)
        }
        assert read == named, f"{declared.name} reads {sorted(read - named)}"
