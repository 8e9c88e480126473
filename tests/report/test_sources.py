import os
import shutil
import sys

import pytest
from scratch import make_repository, write

from dexterity import store
from dexterity.report.sources import last_change, lock_hash, source_key, tree_key

STUDY = "dexterity.studies.scratch.sums"


@pytest.fixture
def root(tmp_path, monkeypatch):
    root = make_repository(tmp_path / "repository")
    monkeypatch.setattr(store, "PACKAGE", root / "src" / "dexterity")
    return root


def replace(file, old, new):
    text = file.read_text()
    assert old in text
    write(file, text.replace(old, new))


def module_that_does(root, statement):
    write(root / "src/dexterity/studies/scratch/user.py", statement)
    return "dexterity.studies.scratch.user"


@pytest.mark.parametrize(
    "statement",
    [
        "import dexterity.base",
        "import dexterity.base as base",
        "from dexterity import base",
        "from dexterity import unrelated, base as b",
        "from dexterity.base import double",
        "from dexterity.base import *",
        "from ... import base",
        "from ...base import double",
        "from dexterity import middle",
        "from dexterity.package import inner",
        "import numpy, dexterity.package.inner",
        "def f():\n    from dexterity import base",
        "class C:\n    def f(self):\n        if self:\n            import dexterity.base",
        "try:\n    from ...base import double\nexcept ImportError:\n    pass",
    ],
)
def test_every_way_to_import_a_module_is_followed(root, statement):
    module = module_that_does(root, statement)
    key = source_key(module)
    replace(root / "src/dexterity/base.py", "2 * x", "3 * x")
    assert source_key(module) != key


@pytest.mark.parametrize(
    ("statement", "counts"),
    [
        ("import dexterity", True),
        ("import dexterity as dx", True),
        ("import dexterity.base", True),
        ("from dexterity import thing", True),
        ("from dexterity import *", True),
        ("import dexterity.base as base", False),
        ("from dexterity import base", False),
        ("import numpy", False),
    ],
)
def test_what_a_package_imports_counts_where_it_can_be_reached(root, statement, counts):
    module = module_that_does(root, statement)
    key = source_key(module)
    write(root / "src/dexterity/top.py", "thing = 2\n")
    assert (source_key(module) != key) == counts


@pytest.mark.parametrize(
    ("name", "old", "new"),
    [
        ("src/dexterity/studies/scratch/sums.py", "/ 3.0", "/ 4.0"),
        ("src/dexterity/studies/scratch/sums.py", "terms: int = 3", "terms: int = 4"),
        ("src/dexterity/base.py", "2 * x", "x * 2"),
        ("src/dexterity/__init__.py", '"1"', '"2"'),
        ("data/robots/arm.toml", "1", "2"),
        ("environment.lock", "2.4.6", "2.4.7"),
    ],
)
def test_an_edit_that_can_change_a_result_changes_the_key(root, name, old, new):
    key = source_key(STUDY)
    replace(root / name, old, new)
    assert source_key(STUDY) != key
    replace(root / name, new, old)
    assert source_key(STUDY) == key


@pytest.mark.parametrize(
    ("name", "old", "new"),
    [
        ("src/dexterity/studies/scratch/sums.py", "A study", "The study"),
        ("src/dexterity/base.py", '"""Base."""\n', ""),
        ("src/dexterity/base.py", '    """Double."""\n', ""),
        ("src/dexterity/base.py", "# twice", "# two times"),
        ("src/dexterity/base.py", "2 * x", "(2  *  x)"),
        ("src/dexterity/__init__.py", "Package", "The package"),
        ("src/dexterity/__init__.py", "from dexterity.top import thing", "__all__ = []"),
        ("src/dexterity/unrelated.py", "1", "2"),
        ("src/dexterity/report/claims.py", "unrelated", "base"),
    ],
)
def test_an_edit_that_cannot_does_not(root, name, old, new):
    key = source_key(STUDY)
    replace(root / name, old, new)
    assert source_key(STUDY) == key


@pytest.mark.parametrize(
    ("name", "counts"),
    [
        ("data/robots/other.toml", True),
        ("data/tasks.toml", True),
        ("data/papers/paper.toml", False),
        ("data/results/new.json", False),
        ("data/robots/.hidden", False),
    ],
)
def test_data_counts_except_papers_and_results(root, name, counts):
    key = source_key(STUDY)
    write(root / name, "x = 1\n")
    assert (source_key(STUDY) != key) == counts


@pytest.mark.parametrize(
    ("pin", "counts"),
    [
        ("scikit-learn==1.9.1", True),
        ("numpy==2.4.6", True),
        ("threadpoolctl==3.8.0", True),
        ("sympy==1.14.0", False),
        ("# Made by make lock", False),
    ],
)
@pytest.mark.parametrize("statement", ["import sklearn.svm", "def f():\n    from sklearn.svm import SVC"])
def test_of_the_pins_those_count_that_the_imports_need(root, statement, pin, counts):
    lock = root / "environment.lock"
    pins = ["numpy==2.4.6", "scikit-learn==1.9.1", "sympy==1.14.0", "threadpoolctl==3.8.0"]
    write(lock, "\n".join(["# Made by make lock", *pins]))
    module = module_that_does(root, statement)
    key = source_key(module)
    replace(lock, pin, f"{pin}.1")
    assert (source_key(module) != key) == counts


def test_what_only_report_imports_needs_no_pin(root):
    replace(root / "src/dexterity/report/claims.py", "from dexterity", "import sympy\nfrom dexterity")
    write(root / "environment.lock", "numpy==2.4.6\nsympy==1.14.0\n")
    key = source_key(STUDY)
    replace(root / "environment.lock", "1.14.0", "1.15.0")
    assert source_key(STUDY) == key


def test_every_pin_counts_where_an_import_is_not_known(root):
    module = module_that_does(root, "import nowhere_to_be_found")
    key = source_key(module)
    replace(root / "environment.lock", "2.4.6", "2.4.7")
    assert source_key(module) != key


def test_renaming_a_data_file_changes_the_key(root):
    key = source_key(STUDY)
    (root / "data/robots/arm.toml").rename(root / "data/robots/leg.toml")
    assert source_key(STUDY) != key


def test_a_key_does_not_depend_on_where_the_repository_lies(root, tmp_path, monkeypatch):
    keys = source_key(STUDY), tree_key()
    shutil.copytree(root, tmp_path / "elsewhere")
    monkeypatch.setattr(store, "PACKAGE", tmp_path / "elsewhere" / "src" / "dexterity")
    assert (source_key(STUDY), tree_key()) == keys


def test_nothing_is_imported(root):
    module = module_that_does(root, "raise RuntimeError\nfrom dexterity.middle import g\n")
    ours = {name for name in sys.modules if name.startswith("dexterity")}
    source_key(module)
    assert {name for name in sys.modules if name.startswith("dexterity")} == ours


@pytest.mark.parametrize("statement", ["import dexterity.nowhere", "from dexterity.nowhere import x"])
def test_a_module_without_a_file_is_named(root, statement):
    with pytest.raises(ModuleNotFoundError, match=r"dexterity\.nowhere"):
        source_key(module_that_does(root, statement))


def test_an_installed_package_has_no_lock(root, monkeypatch):
    assert lock_hash() is not None
    key = source_key(STUDY)
    (root / "data").rename(root / "src/dexterity/_data")
    assert lock_hash() is None
    assert source_key(STUDY) != key


@pytest.mark.parametrize(
    ("name", "counts"),
    [
        ("src/dexterity/studies/scratch/sums.py", True),
        ("src/dexterity/base.py", True),
        ("data/robots/arm.toml", True),
        ("environment.lock", True),
        ("src/dexterity/unrelated.py", False),
        ("data/papers/paper.toml", False),
    ],
)
def test_the_last_change_is_that_of_the_newest_file_that_counts(root, name, counts):
    os.utime(root / name, (2e9, 2e9))
    assert last_change(STUDY) == (2e9 if counts else 1e9)


@pytest.mark.parametrize(
    ("name", "counts"),
    [
        ("src/dexterity/base.py", True),
        ("src/dexterity/report/claims.py", True),
        ("data/papers/paper.toml", True),
        ("data/results/old.json", True),
        ("environment.lock", True),
        ("src/dexterity/__pycache__/base.cpython-311.pyc", False),
        ("pyproject.toml", False),
    ],
)
def test_the_tree_key_sees_every_byte(root, name, counts):
    key = tree_key()
    old = (root / name).read_text() if (root / name).exists() else ""
    write(root / name, old + "# prose\n")
    assert (tree_key() != key) == counts


def test_the_keys_of_the_present_studies_can_be_made():
    assert len(source_key("dexterity.studies.uvms.kinematics")) == 16
