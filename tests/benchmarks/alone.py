"""Measurements in a process of their own: one thread, and no run-time checks of annotations."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pandas as pd

from dexterity import store

ONE_THREAD = dict.fromkeys(["OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS"], "1")
PEERS = ("pin", "roboticstoolbox-python", "pytorch-kinematics")


def results(name: str) -> Path:
    """Files of a benchmark, without the ending."""
    return (store.repository() or Path()) / "_build" / "benchmarks" / name


def run_alone(script: str, name: str) -> pd.DataFrame:
    """Run a script that writes the results of that name; print and return them."""
    tests = str(Path(__file__).resolve().parents[1])
    subprocess.run([sys.executable, script], env=os.environ | ONE_THREAD | {"PYTHONPATH": tests}, check=True)
    print("\n" + results(name).with_suffix(".md").read_text(encoding="utf-8"))
    return pd.read_csv(results(name).with_suffix(".csv"), comment="#")
