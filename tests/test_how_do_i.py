"""The page *How do I …*: each section runs by itself and prints what stands below it."""

import json
import subprocess
import sys

import pytest

from dexterity import store
from markdown_blocks import RUNNER, difference, sections

RECIPES = sections(store.repository() / "book" / "reference" / "how_do_i.md")


@pytest.fixture(scope="module")
def printed() -> dict[str, list[str]]:
    codes = [[block.code for block in recipe] for recipe in RECIPES.values()]
    done = subprocess.run(
        [sys.executable, "-W", "error", "-"],
        input=f"SECTIONS = {codes!r}\n{RUNNER}",
        capture_output=True,
        text=True,
        timeout=600,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return dict(zip(RECIPES, json.loads(done.stdout), strict=True))


@pytest.mark.parametrize("heading", RECIPES)
def test_a_recipe_prints_what_the_page_shows(heading, printed):
    assert len(printed[heading]) == len(RECIPES[heading]), printed[heading][-1]
    for block, text in zip(RECIPES[heading], printed[heading], strict=True):
        assert not (found := difference(block, text)), found


@pytest.mark.parametrize("heading", RECIPES)
def test_a_recipe_stands_on_its_own_and_shows_something(heading):
    assert "import dexterity as dx" in RECIPES[heading][0].code
    assert any(block.printed for block in RECIPES[heading])
