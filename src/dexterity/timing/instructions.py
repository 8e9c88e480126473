"""Instructions that generated C executes for a configuration, where the machine can count them.

Callgrind runs a program instruction by instruction, so a count is the same at every run, whatever else the
machine does. It knows vectors of 256 bits, not of 512; times are therefore not those of the same code.

Examples
--------
>>> import dexterity as dx
>>> from dexterity.timing.instructions import instructions_per_configuration
>>> network = dx.networks.load_shipped("uvms-manipulability-feed-forward")
>>> source = dx.networks.export.c_source(network, "w")
>>> count = instructions_per_configuration(source, "w")
>>> count is None or count > 100
True
"""

from __future__ import annotations

import platform
import re
import shutil
import subprocess
import tempfile
from pathlib import Path
from string import Template

__all__ = ["instructions_per_configuration"]

FLAGS = ("-std=c99", "-O3", "-ffp-contract=fast", "-fno-math-errno", "-fno-trapping-math", "-march=haswell")
"""As for compiled indices, for processors with vectors of 256 bits."""

PATIENCE = 600.0
"""Seconds after which a compiler or a count that has not ended is stopped."""

CONFIGURATIONS = 1008
"""Configurations of a batch, a multiple of those that are worked on side by side."""


def instructions_per_configuration(source: str, name: str) -> float | None:
    """Count the instructions of a batch function of a generated C file.

    Parameters
    ----------
    source
        A file that needs nothing but ``math.h``.
    name
        What its functions begin with.

    Returns
    -------
    Instructions for each of many configurations within ±15° or ±0.26 m; None where there is no valgrind,
    no C compiler, or another processor than one of the x86-64 family.

    Raises
    ------
    RuntimeError
        If the file does not compile or run, or has not ended after ten minutes.
    """
    if platform.machine() != "x86_64" or not (shutil.which("valgrind") and shutil.which("cc")):
        return None
    with tempfile.TemporaryDirectory() as folder:
        main = Path(folder, "main.c")
        main.write_text(
            source + _MAIN.substitute(name=name, prefix=name.upper(), configurations=CONFIGURATIONS),
            encoding="utf-8",
        )
        _output(["cc", *FLAGS, str(main), "-o", f"{folder}/main", "-lm"])
        once, twice = (_collected(f"{folder}/main", str(times)) for times in (1, 2))
    return (twice - once) / CONFIGURATIONS


def _collected(*command: str) -> int:
    report = _output(["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null", *command])
    found = re.search(r"Collected\s*:\s*(\d+)", report)
    if found is None:
        raise RuntimeError(f"callgrind told no number of instructions: {report[-500:]}")
    return int(found[1])


def _output(command: list[str]) -> str:
    try:
        run = subprocess.run(  # noqa: S603
            command, capture_output=True, text=True, errors="replace", timeout=PATIENCE, check=False
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        raise RuntimeError(f"{command[0]} did not run to its end: {error}") from error
    if run.returncode != 0:
        raise RuntimeError(f"{command[0]} failed with status {run.returncode}: {run.stderr[-500:]}")
    return run.stderr


_MAIN = Template("""
#include <stdlib.h>

int main(int count, char **arguments)
{
  static double q[$configurations*${prefix}_JOINTS], values[$configurations];
  unsigned int state = 1;
  int error = count != 2;
  for (int i = 0; i < $configurations*${prefix}_JOINTS; ++i) {
    state = state*1664525u + 1013904223u;
    q[i] = 0.52*(state/4294967296.0 - 0.5);
  }
  for (int times = error ? 0 : atoi(arguments[1]); times > 0; --times)
    error |= ${name}_batch(q, $configurations, ${prefix}_JOINTS, values);
  return error;
}
""")
