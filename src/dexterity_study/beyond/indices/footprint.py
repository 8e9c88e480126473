"""Memory of generated C files, measured on what a C compiler makes of them with ``-Os``."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from tempfile import TemporaryDirectory

from dexterity import codegen, networks, robots, symbolic
from dexterity.codegen import compiler
from dexterity.codegen.c_file import Precision
from dexterity.indices import Index
from dexterity.networks import export

__all__ = ["CASES", "bytes_of", "files"]

CASES: Mapping[str, tuple[str, Index | None]] = {
    "w, UR5e": ("ur5e", Index("manipulability", "geometric")),
    "KCI, UR5e": ("ur5e", Index("kinematic_conditioning", "geometric")),
    "KCI, Panda": ("panda", Index("kinematic_conditioning", "geometric")),
    "KCI, paper A": ("uvms", Index("kinematic_conditioning", "geometric")),
    "pose, Jacobians and rates, Panda": ("panda", None),
}
"""Robot and index of each row; without an index, the robot's kinematics."""

NETWORK = "panda-kinematic-conditioning"
"""The network in the last row."""


def files(precision: Precision) -> Iterator[tuple[str, dict[str, str]]]:
    """Yield the name of each row with its header and its C file."""
    for name, (robot, index) in CASES.items():
        chain = robots.load(robot)
        subject = chain if index is None else symbolic.derive(chain, index)
        yield name, codegen.c_files(subject, "f", precision)
    yield "network for KCI, Panda", export.c_files(networks.load_shipped(NETWORK), "f", precision)


def bytes_of(texts: Mapping[str, str], lanes: int) -> tuple[int, int, int]:
    """Return the bytes of code with constants, of data that is written, and of the stack.

    Parameters
    ----------
    texts
        A header and a C file whose names begin with ``f``.
    lanes
        Configurations that are worked on side by side.

    The stack is that of a function for a batch with the two largest functions below it.
    """
    with TemporaryDirectory() as folder:
        codegen.write_c(folder, texts)
        source, result = Path(folder, "f.c"), Path(folder, "f.o")
        flags = ("-Os", "-DF_NO_SELFTEST", f"-DF_LANES={lanes}", "-fstack-usage", "-c")
        compiler.run([*compiler.command(), *flags, str(source), "-o", str(result)])
        text, data, bss, *_ = compiler.run(["size", str(result)]).splitlines()[1].split()
        usage = [line.split("\t") for line in Path(folder, "f.su").read_text("utf-8").splitlines()]
    frames = [(place.rpartition(":")[2], int(size)) for place, size, *_ in usage]
    batch = max(size for function, size in frames if function.endswith("_batch"))
    inner = sorted((size for function, size in frames if not function.endswith("_batch")), reverse=True)
    return int(text), int(data) + int(bss), batch + sum(inner[:2])
