"""The machine that a result was made on, as far as it can change a number or a time.

Examples
--------
>>> from dexterity.timing.machine import Machine
>>> Machine.present().cores > 0
True
"""

import importlib.metadata
import os
import platform
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch

from dexterity import checks

__all__ = ["Machine", "conditions", "processor", "versions"]


@dataclass(frozen=True)
class Machine:
    """The processor, its cores, the threads in use, and the versions of what computes on them."""

    processor: str
    cores: int
    threads: int
    python: str
    torch: str
    numpy: str

    @classmethod
    def present(cls) -> "Machine":
        """Describe the machine that this runs on."""
        return cls(
            processor=processor(),
            cores=os.cpu_count() or 1,
            threads=torch.get_num_threads(),
            python=platform.python_version(),
            torch=str(torch.__version__),
            numpy=np.__version__,
        )

    def __str__(self) -> str:
        return (
            f"{self.processor}, {self.cores} cores, {self.threads} threads; "
            f"Python {self.python}, torch {self.torch}, numpy {self.numpy}"
        )


def processor() -> str:
    """Name the processor, as far as the system tells it."""
    # Linux alone keeps the model out of `platform`.
    description = Path("/proc/cpuinfo")
    text = description.read_text(encoding="utf-8") if description.exists() else ""
    model = re.search(r"^model name\s*:\s*(.+)$", text, flags=re.MULTILINE)
    return model[1] if model else platform.processor() or platform.machine()


@checks.arguments(distributions=checks.Each(checks.name))
def versions(*distributions: str) -> dict[str, str]:
    """Versions of Python and of installed distributions, each under its name.

    Raises
    ------
    importlib.metadata.PackageNotFoundError
        If one is not installed.
    """
    return {"Python": platform.python_version()} | {
        name: importlib.metadata.version(name) for name in distributions
    }


@checks.arguments(distributions=checks.Each(checks.name))
def conditions(*distributions: str) -> dict[str, str]:
    """Tell what times depend on: the processor, the threads that `measure` uses, and versions.

    Parameters
    ----------
    distributions
        Installed distributions beside Python, torch and numpy, such as ``"pin"``.

    Raises
    ------
    importlib.metadata.PackageNotFoundError
        If one is not installed.
    """
    return {"processor": processor(), "threads": "1"} | versions("torch", "numpy", *distributions)
