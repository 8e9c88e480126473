"""Function files for Octave hold the index and the networks, and its answer is read or refused."""

import shutil

import numpy as np
import pytest
import sympy

from dexterity.program import Recorder
from dexterity_study.uvms.timing import experiment, octave
from dexterity_study.uvms.timing.experiment import EXACT, FEED_FORWARD, RADIAL_BASIS


def test_a_jacobian_becomes_a_matrix_of_plain_expressions_and_one_of_named_terms():
    a, b = sympy.symbols("q1 q2", real=True)
    entries = [sympy.sin(a + b) * b, sympy.S.Zero, sympy.sin(a + b), sympy.S.One]
    files = octave.jacobian_files("w", (a, b), entries)
    written = files["jacobian_written"]
    assert written.splitlines()[:3] == [
        "function J = jacobian_written(q)",
        "  q1 = q(1, 1);",
        "  q2 = q(1, 2);",
    ]
    assert written.count("sin(q1 + q2)") == 2
    assert files["jacobian_shared"].count("sin(") == 1
    at_once = files["jacobian_at_once"]
    assert "q1 = q(:, 1);" in at_once
    assert "J = zeros(2, 2, rows(q));" in at_once
    assert "J(1, 2, :)" not in at_once
    assert "J(2, 2, :) = 1;" in at_once
    assert "det(J * J')" in files["index_of"]
    assert "svd(J)" in octave.jacobian_files("KCI", (a, b), entries)["index_of"]


def test_a_closed_form_reads_the_joint_values_that_it_needs_as_columns():
    a, b = sympy.symbols("q1 q2", real=True)
    record = Recorder("x")
    program = record.program((a, b), [record(sympy.cos(b) ** 2)])
    text = octave.closed_form_files(program)["closed_form"]
    assert "q2 = q(:, 2);" in text
    assert "q1" not in text
    assert "value = sqrt(" in text


def test_an_answer_has_values_and_times_of_each_way():
    answer = octave.parsed("values one 1 2.5\nvalues two 3 4\ntimes one 0.1\ntimes two 0.2 0.3\n")
    assert list(answer) == ["one", "two"]
    assert answer["one"].values.tolist() == [1, 2.5]
    assert answer["two"].times.tolist() == [0.2, 0.3]


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("values one 1\n", "times of"),
        ("values one 1\nvalues one 2\ntimes one 1\n", "one line of values"),
        ("warning: something\n", "one line of values"),
        ("values one 1\ntimes one slow\n", "slow"),
    ],
)
def test_an_answer_that_lacks_something_is_refused(text, fault):
    with pytest.raises(ValueError, match=fault):
        octave.parsed(text)


def test_each_rung_has_the_exact_index_and_both_networks_and_only_w_a_closed_form():
    rows = experiment.in_octave(runs=0).rows
    sides = rows.groupby(["index", "rung"])["side"].agg(set)
    assert all(own == {EXACT, FEED_FORWARD, RADIAL_BASIS} for own in sides)
    closed = rows[rows["rung"].str.contains("closed")]
    assert set(closed["index"]) == {"w"}
    lengths = rows[rows["side"] == EXACT].set_index(["index", "rung"])["characters"]
    shared = lengths["w", "Octave, one by one, terms shared"]
    assert lengths["w", experiment.OCTAVE_IN_KIND] > 5 * shared


def test_a_program_in_octave_that_computes_something_else_is_refused():
    case = experiment.OctaveCase("w", 0, 3, 1)
    right = case._references["exact_written"](case.q).numpy()
    assert case.deviation("exact_written", right) == 0
    with pytest.raises(ValueError, match="is off by"):
        case.deviation("exact_written", right * (1 + 1e-8))


def test_means_have_their_standard_error():
    told = experiment._mean_of(np.array([1.0, 2.0, 3.0]))
    assert told["mean"] == told["median"] == 2
    assert told["error"] == pytest.approx(1 / np.sqrt(3))
    assert experiment._mean_of(np.array([]))["mean"] is None


@pytest.mark.skipif(shutil.which(octave.PROGRAM) is None, reason="GNU Octave is not installed")
def test_octave_computes_what_the_package_computes():
    rows = experiment.in_octave(runs=3, configurations=3, every=2).rows
    assert rows["deviation"].max() < experiment.TOLERANCE
    assert (rows["mean"] > 0).all()
    written = rows["way"] == "exact_written"
    assert set(rows["runs"][written]) == {2}
    assert set(rows["runs"][~written]) == {3}


def test_a_program_that_is_not_there_is_named(monkeypatch):
    monkeypatch.setattr(octave, "PROGRAM", "no-such-octave")
    with pytest.raises(RuntimeError, match="no-such-octave"):
        octave.versions()
