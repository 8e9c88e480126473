"""Files for other processors: they run there, and stay within the memory that their headers promise."""

import re
import shutil
import subprocess
from functools import cache
from pathlib import Path

import pytest

import dexterity as dx
from dexterity import symbolic
from dexterity.indices import Index
from dexterity.networks import export

PUMA, UVMS = dx.robots.puma560(), dx.robots.uvms()
NETWORK = "uvms-kinematic-conditioning-feed-forward"
TARGETS = {"aarch64-linux-gnu": "qemu-aarch64", "arm-linux-gnueabihf": "qemu-arm"}
MAIN = """
#include "w.h"
#include "kci.h"
#include "arm.h"
#include "network.h"

int main(void)
{
  return w_selftest() + 8*kci_selftest() + 16*arm_selftest() + 32*network_selftest();
}
"""


@cache
def texts(precision: str) -> dict[str, str]:
    files = dict(export.c_files(dx.networks.load_shipped(NETWORK), "network", precision))
    for name, index in (("w", "manipulability"), ("kci", "kinematic_conditioning")):
        files |= dx.codegen.c_files(symbolic.derive(PUMA, Index(index, "geometric")), name, precision)
    return files | dx.codegen.c_files(PUMA, "arm", precision)


@pytest.fixture(params=["double", "float"])
def folder(request, tmp_path) -> Path:
    dx.codegen.write_c(tmp_path, texts(request.param))
    (tmp_path / "main.c").write_text(MAIN, encoding="utf-8")
    return tmp_path


def need(program: str) -> None:
    if shutil.which(program) is None:
        pytest.skip(f"{program} is not installed")


def run(*command: str | Path) -> str:
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, ""), done.stderr
    return done.stdout


@pytest.mark.parametrize("target", TARGETS)
def test_selftests_pass_on_arm(folder, target):
    compiler, emulator = f"{target}-gcc", TARGETS[target]
    need(compiler), need(emulator)
    sources = [folder / f"{name}.c" for name in ("main", "w", "kci", "arm", "network")]
    run(compiler, "-static", "-Os", "-Wall", "-Wextra", "-Werror", *sources, "-o", folder / "main", "-lm")
    run(emulator, folder / "main")


@pytest.mark.parametrize("prefix", ["", *(f"{target}-" for target in TARGETS)])
def test_memory_is_what_the_header_promises(folder, prefix):
    need(f"{prefix}gcc"), need(f"{prefix}size")
    for name in ("w", "kci", "arm"):
        header = " ".join((folder / f"{name}.h").read_text(encoding="utf-8").replace(" *", " ").split())
        code, stack, least = map(
            int,
            re.search(
                r"at most (\d+) bytes of code and constants.*?stack at most (\d+) bytes, (\d+) where", header
            ).groups(),
        )
        for lanes, promised in ((16, stack), (1, least)):
            flags = ("-Os", "-DW_NO_SELFTEST", f"-D{name.upper()}_LANES={lanes}", "-fstack-usage")
            flags = (*flags, f"-D{name.upper()}_NO_SELFTEST")
            run(f"{prefix}gcc", *flags, "-c", folder / f"{name}.c", "-o", folder / "o.o")
            (usage,) = folder.glob("*.su")
            frames = [line.split("\t")[:2] for line in usage.read_text().splitlines()]
            usage.unlink()
            # A batch function calls functions of the file, these others in turn; -Os inlines most of them.
            batch = max(int(size) for place, size in frames if place.endswith("_batch"))
            inner = sorted(
                (int(size) for place, size in frames if not place.endswith("_batch")), reverse=True
            )
            assert batch + sum(inner[: 2 if name == "kci" else 1]) <= promised
            text, data, bss, *_ = run(f"{prefix}size", folder / "o.o").splitlines()[1].split()
            assert (data, bss) == ("0", "0")
            assert code / 4 < int(text) <= code


def test_more_than_the_promised_operations_are_never_needed():
    """Iterations are bounded: the header counts all of them."""
    header = texts("double")["kci.h"]
    source = texts("double")["kci.c"]
    assert re.search(r"Worst case for a value: \d+ additions", " ".join(header.replace(" *", " ").split()))
    loops = re.findall(r"for \(int (?:k|sweep) = 0; (?:k|sweep) < (\d+); \+\+(?:k|sweep)\)", source)
    assert {"60", "30"} <= set(loops)
    assert "while" not in source
