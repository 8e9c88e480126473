"""Declaration of experiments, and what every one of the study has to declare rightly."""

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


@pytest.mark.parametrize("name", ["rtol", "atol"])
@pytest.mark.parametrize(
    ("value", "error"), [(float("nan"), ValueError), (float("inf"), ValueError), ("1", TypeError)]
)
def test_a_tolerance_is_a_finite_number(name, value, error):
    with pytest.raises(error, match=f"^{name} of rows is"):
        Experiment(rows, **{name: value})


def test_what_draws_nothing_takes_no_seed():
    def fixed(size=3):
        yield {"error": size}

    assert experiment()(fixed)(0).values("error").tolist() == [3]
    with pytest.raises(TypeError, match="takes no seed"):
        experiment(seeds=2)(fixed)


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
