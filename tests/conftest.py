"""Shared by all tests: run-time checks of all annotations, repeatable hypothesis runs, batch shapes, seeds.

The import hook must be there before the package is first imported, so this file imports nothing of it.
"""

import importlib.util
import os
import pkgutil
import random
from collections.abc import Iterator
from functools import cache

import hypothesis
import jaxtyping
import numpy as np
import pytest
from beartype import BeartypeConf
from beartype.claw import beartype_packages

# Read when sympy is imported; with its default of a thousand entries derivations take half as long again.
os.environ.setdefault("SYMPY_CACHE_SIZE", "100000")

# Workers that share the cores must not each start a thread for every core. Read when torch is imported.
if "PYTEST_XDIST_WORKER" in os.environ:
    os.environ.setdefault("OMP_NUM_THREADS", "1")

# Modules of expressions have no array shapes: beartype alone checks their annotations. jaxtyping would bind
# the arguments of each call, which doubles the time of a derivation. An int passes for a float, as elsewhere.
EXPRESSIONS = ["dexterity.derivation", "dexterity.elimination", "dexterity.program"]
_package = importlib.util.find_spec("dexterity")
jaxtyping.install_import_hook(
    [
        name
        for _, name, _ in pkgutil.iter_modules(_package.submodule_search_locations, "dexterity.")
        if name not in EXPRESSIONS
    ],
    "beartype.beartype(conf=beartype.BeartypeConf(is_pep484_tower=True))",
)
beartype_packages(EXPRESSIONS, conf=BeartypeConf(is_pep484_tower=True, claw_is_pep526=False))

# The same examples at every run; no deadline, because the first call of a torch function is slow.
hypothesis.settings.register_profile(
    "repeatable", derandomize=True, deadline=None, database=None, max_examples=50
)
hypothesis.settings.load_profile("repeatable")


LONG = (
    "test_symbolic.py", "test_evidence_runs.py", "test_wheel.py", "test_build.py", "test_design.py",
    "test_c99.py", "test_portable_c.py", "test_symbolic_derivatives.py", "test_examples.py",
)  # fmt: skip
"""Files that take minutes. They start first, so that no core waits for the last one of them."""


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    items.sort(key=lambda item: item.path.name not in LONG)


@pytest.fixture(scope="session", autouse=True)
def quick_compilation(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Compile indices without optimisation, in a twentieth of the time, and derive them once for all workers.

    No value changes by it beyond rounding, which tests/test_symbolic.py makes sure of.
    """
    from dexterity.codegen import library
    from dexterity.derivation import programs

    folder = tmp_path_factory.getbasetemp()
    folder = (folder.parent if "PYTEST_XDIST_WORKER" in os.environ else folder) / "compiled"
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("DEXTERITY_CACHE", os.environ.get("DEXTERITY_CACHE", str(folder)))
        patch.setattr(library, "FLAGS", tuple("-O0" if f == "-O3" else f for f in library.FLAGS))
        # Files of one worker derive the same few indices of the same robots.
        patch.setattr(programs, "_derived", cache(programs._derived.__wrapped__))
        yield


@pytest.fixture(autouse=True)
def _repeatable_type_checks() -> None:
    """Seed the generator by which beartype picks the one item of a sequence that it looks at."""
    random.seed(0)


@pytest.fixture
def annotations_unchecked() -> Iterator[None]:
    """Leave bad arguments to the package's own errors, as for a user, whose annotations nobody checks."""
    jaxtyping.config.update("jaxtyping_disable", True)
    yield
    jaxtyping.config.update("jaxtyping_disable", False)


@pytest.fixture(params=[(), (1,), (3, 1, 2), (0,)], ids=str)
def batch_shape(request: pytest.FixtureRequest) -> tuple[int, ...]:
    """Leading axes that every function on batches is tried with."""
    return request.param


@pytest.fixture
def rng() -> np.random.Generator:
    """Return the same random numbers for every test."""
    return np.random.default_rng(20_160_801)
