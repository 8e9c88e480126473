import dataclasses
import importlib
import itertools
import json
import sys
from xml.etree import ElementTree

import numpy as np
import pytest
from scratch import make_repository, write

import dexterity.studies
from dexterity import store
from dexterity.report import provenance, runs
from dexterity.report.provenance import check_stored, footer, load_stored, load_study, remember, write_stored
from dexterity.report.runs import run_study
from dexterity.report.stored import _differences
from dexterity.report.study import scale
from dexterity.store import content_key
from dexterity.timing import Machine

STUDY = "scratch.sums"
SOURCE = "src/dexterity/studies/scratch/sums.py"


@pytest.fixture
def root(tmp_path, monkeypatch):
    """Return a repository with one study, which is there to be imported as well."""
    root = make_repository(tmp_path / "repository")
    monkeypatch.setattr(store, "PACKAGE", root / "src" / "dexterity")
    folder = str(root / "src" / "dexterity" / "studies")
    monkeypatch.setattr(dexterity.studies, "__path__", [folder, *dexterity.studies.__path__])
    monkeypatch.delenv("DEXTERITY_SCALE", raising=False)
    importlib.invalidate_caches()
    yield root
    for name in [name for name in sys.modules if name.startswith("dexterity.studies.scratch")]:
        del sys.modules[name]


@pytest.fixture
def study(root):
    return load_study(STUDY)


def edit(file):
    write(file, file.read_text() + "EDITED = 1\n")


def remembered_file(root):
    (file,) = (root / ".results" / STUDY).iterdir()
    return file


def test_a_result_is_remembered(root, study):
    first, second = remember(STUDY), remember(STUDY)
    assert len(study.RUNS) == 1
    assert content_key(first) == content_key(second)
    assert second.config == study.CONFIGS["book"]
    assert remembered_file(root).stem == second.key
    np.testing.assert_array_equal(second.result.terms, np.arange(3) / 3.0)
    assert np.isnan(second.result.undefined)


def test_every_config_has_a_result_of_its_own(study):
    for terms in (4, 5, 4):
        assert len(remember(STUDY, study.Config(terms=terms)).result.terms) == terms
    assert len(study.RUNS) == 2


def test_the_scale_chooses_the_config(study, monkeypatch):
    assert scale() == "book"
    for name in ("smoke", "book", "full"):
        monkeypatch.setenv("DEXTERITY_SCALE", name)
        assert scale() == name
        assert remember(STUDY).config == study.CONFIGS[name]
    for name in ("", "Book", "huge"):
        monkeypatch.setenv("DEXTERITY_SCALE", name)
        with pytest.raises(ValueError, match=f"'{name}'.*smoke, book, full"):
            remember(STUDY)


@pytest.mark.parametrize("name", [SOURCE, "src/dexterity/base.py", "data/robots/arm.toml"])
def test_an_edit_that_can_change_the_result_makes_it_run_again(root, study, name):
    first = remember(STUDY)
    edit(root / name)
    assert remember(STUDY).source_key != first.source_key
    assert len(study.RUNS) == 2


@pytest.mark.parametrize(("pins", "runs"), [("numpy==2.4.7\n", 2), ("numpy==2.4.6\nscipy==1.17.1\n", 1)])
def test_a_new_pin_makes_it_run_again_where_the_study_uses_what_is_pinned(root, study, pins, runs):
    remember(STUDY)
    write(root / "environment.lock", pins)
    remember(STUDY)
    assert len(study.RUNS) == runs


@pytest.mark.parametrize(
    "name", ["src/dexterity/unrelated.py", "src/dexterity/report/claims.py", "data/papers/paper.toml"]
)
def test_an_edit_that_cannot_does_not(root, study, name):
    remember(STUDY)
    edit(root / name)
    remember(STUDY)
    assert len(study.RUNS) == 1


def test_another_machine_runs_again(study, monkeypatch):
    remember(STUDY)
    other = dataclasses.replace(Machine.present(), processor="another")
    monkeypatch.setattr(Machine, "present", lambda: other)
    assert remember(STUDY).machine == other
    assert len(study.RUNS) == 2


def test_a_source_newer_than_the_process_is_not_remembered(root, study, monkeypatch):
    # The code that runs may be the one from before the edit.
    monkeypatch.setattr(runs, "_LOADED", 9e8)
    remember(STUDY)
    assert not (root / ".results").exists()


def change(file, old, new):
    text = file.read_text()
    assert old in text
    file.write_text(text.replace(old, new, 1))


def reseal(file, old, new):
    """Change a record and give it the digest of what it now holds, as a hand that knows the format would."""
    content = json.loads(file.read_text().replace(old, new, 1))["content"]
    dumped = json.dumps(content, indent=1, ensure_ascii=False) + "\n"
    file.write_text(json.dumps({"digest": content_key(dumped), "content": content}))


@pytest.mark.parametrize(
    "damage",
    [
        lambda file: file.write_text(""),
        lambda file: file.write_bytes(b"\xff\xfe"),
        lambda file: file.write_text("[1, 2]"),
        lambda file: file.write_text(file.read_text()[:-20]),
        lambda file: change(file, '"total": 1.0', '"total": 1.5'),
        lambda file: change(file, '"terms": 3', '"terms": 4'),
        lambda file: reseal(file, '"terms": 3', '"terms": 4'),
        lambda file: reseal(file, '"terms": 3', '"terms": "3"'),
        lambda file: reseal(file, '"total": 1.0', '"total": "1"'),
        lambda file: reseal(file, '"source_key": "', '"source_key": "0'),
        lambda file: reseal(file, '"processor": "', '"processor": "another '),
        lambda file: reseal(file, '"study": "scratch.sums"', '"study": "uvms.kinematics"'),
        lambda file: reseal(file, '"total"', '"whole"'),
    ],
    ids=itertools.count(),
)
def test_a_damaged_or_foreign_record_is_replaced(root, study, damage):
    first = remember(STUDY)
    file = remembered_file(root)
    damage(file)
    second = remember(STUDY)
    assert len(study.RUNS) == 2
    assert content_key(second.result) == content_key(first.result)
    assert remembered_file(root) == file
    remember(STUDY)
    assert len(study.RUNS) == 2


def test_a_record_sealed_anew_without_a_change_is_believed(root, study):
    """Without this, the refusals above might have another cause."""
    remember(STUDY)
    reseal(remembered_file(root), "", "")
    remember(STUDY)
    assert len(study.RUNS) == 1


def test_an_installed_package_remembers_nothing(root, study):
    (root / "data").rename(root / "src/dexterity/_data")
    assert remember(STUDY).lock_hash is None
    remember(STUDY)
    assert len(study.RUNS) == 2
    assert not (root / ".results").exists()
    with pytest.raises(RuntimeError, match="source tree"):
        write_stored(STUDY)


def test_a_study_that_is_not_there_is_named(root):
    for name in ("scratch.nothing", "nothing", "nothing.at.all"):
        with pytest.raises(ValueError, match=name):
            remember(name)


def test_a_study_that_is_incomplete_is_told_what_it_lacks(root):
    write(root / "src/dexterity/studies/scratch/empty.py", "CONFIGS = {}\n")
    with pytest.raises(TypeError, match="Config, Result, run, verdicts, acceptance"):
        load_study("scratch.empty")


def test_an_import_that_fails_inside_a_study_is_not_hidden(root):
    write(root / "src/dexterity/studies/scratch/broken.py", "import no_such_package\n")
    with pytest.raises(ModuleNotFoundError, match="no_such_package"):
        load_study("scratch.broken")


@pytest.mark.parametrize("config", ["book", 3, dataclasses.make_dataclass("Config", ["terms"])(3)], ids=str)
def test_a_config_of_another_kind_is_refused(study, config):
    with pytest.raises(TypeError):
        remember(STUDY, config)


def test_a_machine_says_what_computes_and_not_whose_it_is():
    machine = Machine.present()
    assert machine == Machine.present()
    assert machine.processor
    assert machine.cores >= 1
    names = {field.name for field in dataclasses.fields(machine)}
    assert names == {"processor", "cores", "threads", "python", "torch", "numpy"}


def test_a_stored_result_is_the_full_run_with_a_probe(root, study):
    assert load_stored(STUDY) is None
    file = write_stored(STUDY)
    assert file == root / "data" / "results" / "scratch-sums.json"
    stored = load_stored(STUDY)
    assert stored.is_current
    assert stored.run.config == study.CONFIGS["full"]
    assert stored.probe.config == study.CONFIGS["smoke"]
    assert content_key(stored.run.result) == content_key(run_study(STUDY, study.CONFIGS["full"]).result)
    check_stored(STUDY)


def test_a_stored_result_from_other_sources_says_so(root, study):
    write_stored(STUDY)
    edit(root / "src/dexterity/unrelated.py")
    assert load_stored(STUDY).is_current
    edit(root / "src/dexterity/base.py")
    assert not load_stored(STUDY).is_current


def shifted(study, amount):
    """Let the study return totals and terms that are off by a relative amount."""
    original = study.run

    def run(config):
        result = original(config)
        return dataclasses.replace(
            result, total=result.total * (1 + amount), terms=result.terms * (1 + amount)
        )

    study.run = run


def test_a_probe_comes_out_again_within_its_tolerance(study):
    write_stored(STUDY)
    shifted(study, 1e-10)
    check_stored(STUDY)


@pytest.mark.parametrize("kind", [list, tuple])
def test_the_tolerance_is_that_of_numbers_in_sequences(kind):
    close, far = kind([1.0 + 1e-12, 2.0]), kind([1.0 + 1e-6, 2.0])
    assert list(_differences("x", kind([1.0, 2.0]), close, provenance.Tolerance())) == []
    (difference,) = _differences("x", kind([1.0, 2.0]), far, provenance.Tolerance())
    assert difference.startswith("x[0]: stored 1.0")


def test_a_probe_that_is_missed_names_what_differs(study):
    write_stored(STUDY)
    shifted(study, 1e-8)
    with pytest.raises(
        provenance.ProbeMissed, match=r"(?s)result\.total: stored .*result\.terms\.values\[1\]"
    ) as missed:
        check_stored(STUDY)
    assert len(str(missed.value).splitlines()) == 3


def test_a_probe_whose_shape_changed_is_missed(study):
    write_stored(STUDY)
    original = study.run
    study.run = lambda config: dataclasses.replace(original(config), terms=np.zeros(5))
    with pytest.raises(provenance.ProbeMissed, match=r"result\.terms\.shape\[0\]: stored 2, now 5"):
        check_stored(STUDY)


def test_a_study_declares_how_far_its_probe_may_differ(study):
    study.TOLERANCE = provenance.Tolerance(rtol=1e-6)
    write_stored(STUDY)
    shifted(study, 1e-7)
    check_stored(STUDY)
    shifted(study, 1e-5)
    with pytest.raises(provenance.ProbeMissed):
        check_stored(STUDY)


def test_a_stored_result_that_cannot_be_read_is_not_passed_over(root, study):
    with pytest.raises(ValueError, match="no stored result"):
        check_stored(STUDY)
    file = write_stored(STUDY)
    change(file, '"total"', '"whole"')
    with pytest.raises(ValueError, match=r"scratch-sums\.json .*make full STUDY=scratch\.sums"):
        load_stored(STUDY)


def facts(markup):
    page = ElementTree.fromstring(f"<div>{markup._repr_html_()}</div>")
    assert not any(element.get("style") for element in page.iter())
    lists = page.findall("section[@class='provenance']/dl")
    return [
        {dt.text: dd.text for dt, dd in zip(found.findall("dt"), found.findall("dd"), strict=True)}
        for found in lists
    ]


def test_a_footer_says_what_the_numbers_were_made_from(root, study):
    own = remember(STUDY, study.Config(terms=7, seeds=()))
    first, second = facts(footer(remember(STUDY), own))
    assert first["Study"] == STUDY
    assert first["Scale"] == "book"
    assert first["Seeds"] == "1, 2"
    assert first["Source key"] == own.source_key
    assert first["Lock"] == own.lock_hash
    assert "torch" in first["Machine"]
    assert first["Run time"].endswith(f"s on {own.date}")
    assert first["Stored result"] == "none"
    assert second["Scale"] == "a config of its own"
    assert second["Seeds"] == "no random draw"


def test_a_footer_tells_whether_the_stored_result_is_current(root, study):
    write_stored(STUDY)
    (shown,) = facts(footer(remember(STUDY)))
    assert shown["Stored result"].startswith("current (")
    edit(root / "src/dexterity/base.py")
    (shown,) = facts(footer(remember(STUDY)))
    assert shown["Stored result"].startswith("from other sources (")


@pytest.fixture
def cache(root, tmp_path):
    cache = tmp_path / "cache"
    assert provenance.main(["fresh-cache", str(cache)]) == 0
    (cache / "executed" / "0").mkdir(parents=True)
    (cache / "executed" / "0" / "base.ipynb").touch()
    (cache / "global.db").touch()
    return cache


@pytest.mark.parametrize(
    ("name", "kept"),
    [
        ("src/dexterity/base.py", False),
        ("src/dexterity/report/claims.py", False),
        ("data/papers/paper.toml", False),
        ("data/results/old.json", False),
        ("environment.lock", False),
        ("pyproject.toml", True),
    ],
)
def test_the_execution_cache_outlives_no_edit_of_the_source(root, cache, name, kept):
    provenance.main(["fresh-cache", str(cache)])
    assert (cache / "global.db").exists()
    edit(root / name)
    provenance.main(["fresh-cache", str(cache)])
    assert (cache / "global.db").exists() == (cache / "executed").exists() == kept
    assert (cache / ".source-key").exists()


def test_the_execution_cache_outlives_no_change_of_scale(cache, monkeypatch):
    monkeypatch.setenv("DEXTERITY_SCALE", "smoke")
    provenance.main(["fresh-cache", str(cache)])
    assert [path.name for path in cache.iterdir()] == [".source-key"]


def test_a_cache_without_a_note_is_emptied(cache):
    (cache / ".source-key").unlink()
    provenance.main(["fresh-cache", str(cache)])
    assert [path.name for path in cache.iterdir()] == [".source-key"]


def test_a_folder_that_is_no_cache_is_left_alone(root, capsys):
    for folder in (root, root / "src", root / "environment.lock"):
        with pytest.raises(SystemExit, match="1"):
            provenance.main(["fresh-cache", str(folder)])
        assert str(folder) in capsys.readouterr().err
    assert (root / SOURCE).exists()
    with pytest.raises(SystemExit, match="2"):
        provenance.main([])
