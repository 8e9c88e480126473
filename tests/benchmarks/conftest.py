"""Benchmarks measure what users have: optimised code."""

import pytest


@pytest.fixture(scope="session", autouse=True)
def quick_compilation() -> None:
    """Compile as the library does, in place of the fixture of all other tests."""
