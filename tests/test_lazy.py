"""Names that are imported when they are first used."""

import re
import subprocess
import sys

import pytest

import dexterity as dx
from dexterity import lazy, store

FRESH = """
import functools, sys
import dexterity as dx

assert "torch" not in sys.modules, "the package itself is to cost nothing"
for name in NAMES:
    functools.reduce(getattr, name.split(".")[1:], dx)
"""


def documented_modules() -> list[str]:
    pages = sorted(store.repository().glob("book/reference/api*.md"))
    text = "\n".join(page.read_text(encoding="utf-8") for page in pages)
    return re.findall(r"^\.\. automodule:: (\S+)$", text, re.MULTILINE)


def test_each_documented_module_is_reached_by_dots_from_the_package():
    # A process of its own, because tests import submodules, which then are attributes anyway.
    subprocess.run([sys.executable, "-c", f"NAMES = {documented_modules()}{FRESH}"], check=True, timeout=300)


def test_flat_classes_are_those_of_their_modules():
    assert dx.Chain is dx.chain.Chain
    assert dx.Index is dx.indices.Index
    assert set(dx.__all__) <= set(dir(dx))


def test_an_unknown_name_is_an_attribute_error_that_names_package_and_attribute():
    with pytest.raises(AttributeError, match="module 'dexterity' has no attribute 'chian'"):
        _ = dx.chian
    get, _ = lazy.submodules("dexterity.workspace", [])
    with pytest.raises(AttributeError, match=r"'dexterity.workspace' has no attribute 'mapps'"):
        get("mapps")
