"""Which files decide that a page has to be executed again."""

import pytest

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
