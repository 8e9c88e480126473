"""The example of each module on the pages of the API: it stands on its own and comes out as printed."""

import doctest
import importlib
import re
from pathlib import Path

import pytest

PAGES = sorted(Path(__file__).parents[1].glob("book/reference/api*.md"))
MODULES = [
    name
    for page in PAGES
    for name in re.findall(r"^\.\. automodule:: (\S+)$", page.read_text(encoding="utf-8"), re.MULTILINE)
]
NEEDS = {"dexterity.command": "typer", "dexterity.networks.onnx_models": "onnx"}
"""Modules whose example needs a package that is optional."""

FLAGS = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE


def test_all_pages_are_read():
    assert {page.stem for page in PAGES} == {"api", "api_networks", "api_reach", "api_scenes", "api_systems"}
    assert len(MODULES) == len(set(MODULES)) > 80


@pytest.mark.parametrize("name", MODULES)
def test_the_example_is_what_it_prints(name):
    if name in NEEDS:
        pytest.importorskip(NEEDS[name])
    module = importlib.import_module(name)
    section = (module.__doc__ or "").partition("\nExamples\n--------\n")[2]
    assert doctest.DocTestParser().get_examples(section), f"{name} has no example in its docstring"
    # No names of the module itself, so that a reader can copy the example as it stands.
    outcome = doctest.testmod(module, globs={}, optionflags=FLAGS)
    assert outcome.attempted > 0
    assert outcome.failed == 0
