"""A small repository with a package of the same name, to edit and to run."""

import os
from pathlib import Path

STUDY = '''"""A study."""
from dataclasses import dataclass

import numpy as np

from dexterity.report.claims import Acceptance, Outcome, Verdict

RUNS = []


@dataclass(frozen=True)
class Config:
    terms: int = 3
    seeds: tuple[int, ...] = (1, 2)


@dataclass(frozen=True)
class Result:
    total: float
    terms: np.ndarray
    undefined: float


CONFIGS = {"smoke": Config(terms=2), "book": Config(), "full": Config(terms=9)}


def run(config):
    RUNS.append(config)
    terms = np.arange(config.terms) / 3.0
    return Result(float(terms.sum()), terms, float("nan"))


def never_called(x):
    # The package that runs is the real one, which has no such module.
    from dexterity.base import double

    return double(x)


def verdicts(result):
    return ()


def acceptance(result):
    return ()
'''

FILES = {
    "pyproject.toml": "",
    "environment.lock": "numpy==2.4.6\n",
    "data/robots/arm.toml": "length = 1\n",
    "data/papers/paper.toml": "",
    "data/results/old.json": "",
    "src/dexterity/__init__.py": '"""Package."""\nfrom dexterity.top import thing\n__version__ = "1"\n',
    "src/dexterity/top.py": "thing = 1\n",
    "src/dexterity/base.py": '"""Base."""\n\ndef double(x):\n    """Double."""\n    return 2 * x  # twice\n',
    "src/dexterity/middle.py": "def g():\n    from .base import double\n    return double(1)\n",
    "src/dexterity/package/__init__.py": "FACTOR = 2\n",
    "src/dexterity/package/inner.py": "from .. import base\nfrom . import FACTOR\n",
    "src/dexterity/unrelated.py": "x = 1\n",
    "src/dexterity/report/__init__.py": "",
    "src/dexterity/report/claims.py": "from dexterity import unrelated\n",
    "src/dexterity/studies/__init__.py": "",
    "src/dexterity/studies/scratch/__init__.py": "",
    "src/dexterity/studies/scratch/sums.py": STUDY,
}


def make_repository(root: Path) -> Path:
    """Write the repository into a folder and return the folder."""
    for name, text in FILES.items():
        write(root / name, text)
    return root


def write(file: Path, text: str) -> None:
    """Write a file as if long ago."""
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(text)
    os.utime(file, (1e9, 1e9))
