"""Which files decide that a page has to be executed again."""

import subprocess
import sys
import tomllib
from importlib import metadata

import pytest
from packaging.requirements import Requirement

from dexterity import store
from dexterity_study.page.dependencies import dependencies, imported_modules

CHAPTER = """
from dexterity_study.engine.evidence import Evidence
from dexterity_study.uvms.radial_basis import show

stored = Evidence("uvms.radial_basis")
"""

# Of another part, which the chapter neither imports nor names.
ELSEWHERE = "dexterity.crane.positioning.tables"


def test_chapter_depends_on_its_imports_data_results_and_locks() -> None:
    files = dependencies("uvms/radial_basis", CHAPTER)
    for name in (
        "dexterity.spatial",
        "dexterity_study.engine.table",
        "dexterity_study.uvms.radial_basis.show",
        "dexterity_study.uvms.radial_basis.verdicts",
        "dexterity/scenes/scene.html",
        "robots/uvms.toml",
        "environment.lock",
    ):
        assert name in files
    assert any(name.startswith("results/uvms/radial_basis/") for name in files)
    assert any(name.startswith("uvms.radial_basis.") for name in files), "nothing of pytask.lock"
    assert ELSEWHERE not in files
    assert "dexterity_study.page.build" not in files


def test_page_that_is_no_chapter_depends_on_everything() -> None:
    files = dependencies("index", "")
    assert ELSEWHERE in files
    assert dependencies("uvms/radial_basis", CHAPTER).items() <= files.items()


def test_chapter_depends_on_the_results_that_its_verdicts_read_elsewhere() -> None:
    files = dependencies("uvms/kinematics", "from dexterity_study.uvms.kinematics import show")
    assert "results/uvms/cost/counts/chosen.0.csv" in files
    assert not any(file.startswith("results/docking/") for file in files)


def test_chapter_that_names_no_module_does_not_depend_on_the_sources_of_others() -> None:
    files = dependencies("uvms/radial_basis", "print(1)")
    assert "dexterity_study.uvms.radial_basis.experiment" in files
    assert "dexterity.docking" not in files


@pytest.mark.parametrize(
    ("code", "modules"),
    [
        ("import numpy", set()),
        ("from dexterity import robots, spatial", {"dexterity.robots", "dexterity.spatial"}),
        ("import dexterity.crane.beams as beams", {"dexterity.crane.beams"}),
        ("from dexterity.spatial import exp", {"dexterity.spatial"}),
        ("import dexterity as dx", {"dexterity"}),
        ("%timeit 1", {"dexterity", "dexterity_study"}),
    ],
)
def test_imports_of_cells(code: str, modules: set[str]) -> None:
    assert imported_modules(code) == modules


CHAPTERS_ALONE = """
import sys

sys.modules.update(dict.fromkeys(sys.argv[1:]))  # an import of these fails

import importlib
import pkgutil
import dexterity_study
from dexterity_study.engine.evidence import chapters

for chapter in chapters():
    package = importlib.import_module(f"dexterity_study.{chapter}")
    for module in pkgutil.iter_modules(package.__path__):
        importlib.import_module(f"{package.__name__}.{module.name}")
"""


def test_pages_need_none_of_what_only_evidence_needs() -> None:
    project = tomllib.loads((store.repository() / "pyproject.toml").read_text())["project"]
    extras = project["optional-dependencies"]
    only = {
        Requirement(line).name.replace("-", "_")
        for extra in ("evidence", "distributed", "onnx")
        for line in extras[extra]
    } - {Requirement(line).name.replace("-", "_") for line in extras["book"]}
    owners = metadata.packages_distributions()
    blocked = [name for name, own in owners.items() if only & {one.replace("-", "_") for one in own}]
    assert {"xgboost", "lightgbm", "distributed", "onnx"} <= set(blocked)
    done = subprocess.run(
        [sys.executable, "-c", CHAPTERS_ALONE, *blocked], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
