"""The examples of the modules of chains and URDFs that have no page of their own."""

import doctest
import importlib
import pkgutil

import pytest

from dexterity import chain, urdf

PARTS = [
    name
    for package in (chain, urdf)
    for _, name, _ in pkgutil.iter_modules(package.__path__, f"{package.__name__}.")
]


@pytest.mark.parametrize("name", PARTS)
def test_the_example_is_what_it_prints(name):
    outcome = doctest.testmod(importlib.import_module(name), globs={})
    assert outcome.attempted > 0
    assert outcome.failed == 0
