"""Generated C is right whatever the flags, the language, the compiler and the processor are."""

import ctypes
import os
import shutil
import subprocess
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import torch
from numpy.testing import assert_allclose

import dexterity as dx
from dexterity import symbolic
from dexterity.codegen.c99 import c_files
from dexterity.codegen.c_file import NOT_FINITE
from dexterity.indices import Index
from dexterity.networks import export

PUMA, NETWORK = dx.robots.puma560(), dx.networks.load_shipped("uvms-kinematic-conditioning-feed-forward")
EXACT = {"w": "manipulability", "kci": "kinematic_conditioning"}
WARNINGS = ("-Wall", "-Wextra", "-pedantic", "-Wconversion", "-Wshadow", "-Werror")
SELFTESTS = """
#include "w.h"
#include "kci.h"
#include "network.h"

int main(void)
{
  return w_selftest() + 8*kci_selftest() + 64*network_selftest();
}
"""


@cache
def texts(precision: str) -> dict[str, str]:
    files = export.c_files(NETWORK, "network", precision)
    for name, index in EXACT.items():
        files |= c_files(symbolic.derive(PUMA, Index(index, "geometric")), name, precision)
    return files | {"selftests.c": SELFTESTS}


@pytest.fixture(scope="module", params=["double", "float"])
def sources(request, tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp(request.param)
    for name, text in texts(request.param).items():
        (folder / name).write_text(text, encoding="utf-8")
    return folder


@pytest.fixture(params=["gcc", "clang", "g++", "clang++"])
def compiler(request) -> str:
    if shutil.which(request.param) is None:
        pytest.skip(f"{request.param} is not installed")
    return request.param


def run(*command: str | Path) -> None:
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, ""), done.stderr


@pytest.mark.parametrize(
    "standard",
    [
        "default", "-std=gnu17", "-std=gnu11", "-std=c99", "-std=c11", "-std=c2x", "-D_GNU_SOURCE",
        "-D_POSIX_C_SOURCE=200809L", "-std=c++11", "-std=c++20",
    ],
)  # fmt: skip
def test_files_compile_without_warnings_in_every_mode(sources, compiler, standard):
    """engineer.md, B3: ``finite`` collided with the GNU library's in the default mode of compilers."""
    plus = compiler.endswith("++")
    if standard.startswith("-std") and ("++" in standard) != plus:
        pytest.skip("a standard of the other language")
    flags = () if standard == "default" else (standard,)
    for name in ("w", "kci", "network"):
        language = ("-x", "c++") if plus else ()
        run(compiler, *flags, *WARNINGS, *language, "-fsyntax-only", sources / f"{name}.c")


FLAGS = [
    "-O1",
    "-O1 -ffast-math",
    "-Ofast -march=native",
    "-O1 -funsafe-math-optimizations",
    "-O1 -fassociative-math -fno-signed-zeros -fno-trapping-math",
    "-O1 -ffinite-math-only",
    "-O1 -freciprocal-math -ffp-contract=off",
    "-O1 -mfpmath=387 -std=c99",
    "-Os",
]


@pytest.mark.parametrize("flags", FLAGS)
def test_results_do_not_depend_on_flags(tmp_path, sources, compiler, flags):
    """engineer.md, B2: fast math made all rows wrong, and a NaN went through."""
    if "387" in flags and (os.uname().machine != "x86_64" or compiler != "gcc"):
        pytest.skip("gcc computes with x87 on x86 alone")
    double = "float" not in str(sources)
    if (compiler.endswith("++") or not double) and flags not in FLAGS[:2]:
        pytest.skip("tried for C and doubles")
    language = ("-x", "c++") if compiler.endswith("++") else ()
    names = [sources / f"{name}.c" for name in ("w", "kci", "network")]
    library = tmp_path / "all.so"
    objects = [tmp_path / f"{name.stem}.o" for name in names]
    for name, made in zip(names, objects, strict=True):
        run(compiler, *flags.split(), *language, "-fPIC", "-c", name, "-o", made)
    # Linked with fast math, the library would round denormal numbers of the whole process to zero.
    run(compiler, "-shared", *objects, "-o", library, "-lm")
    loaded = ctypes.CDLL(str(library))
    for name, (function, q) in references().items():
        assert getattr(loaded, f"{name}_selftest")() == 0
        q = q if double else q.float().double()
        expected = function(q).numpy()
        assert_allclose(
            called(loaded, name, q.numpy(), double), expected, rtol=1e-11 if double else 2e-4, atol=0
        )


@cache
def references():
    q = torch.from_numpy(np.random.default_rng(0).uniform(-3, 3, (2000, 6)))
    regular = Index("kinematic_conditioning", "geometric").bind(PUMA)(q) > 0.02
    indices = {name: (Index(index, "geometric").bind(PUMA), q[regular]) for name, index in EXACT.items()}
    near = torch.from_numpy(np.random.default_rng(0).uniform(-0.2, 0.2, (500, 12)))
    return indices | {"network": (torch.no_grad()(NETWORK), near)}


def called(loaded: ctypes.CDLL, name: str, q: np.ndarray, double: bool) -> np.ndarray:
    """Call a batch function on rows, then on the same with a NaN among them."""
    q = q.astype(np.float64 if double else np.float32)
    values, count, joints = np.empty(len(q), q.dtype), ctypes.c_size_t(len(q)), ctypes.c_size_t(q.shape[1])
    batch, pointer = getattr(loaded, f"{name}_batch"), ctypes.c_void_p
    poisoned, rest = q.copy(), np.full(len(q), -7.0, q.dtype)
    for poison in (np.nan, np.inf):
        poisoned[37, 1] = poison
        error = batch(pointer(poisoned.ctypes.data), count, joints, pointer(rest.ctypes.data))
        assert error == NOT_FINITE
        first = getattr(loaded, f"{name}_first_not_finite")
        first.restype = ctypes.c_size_t
        assert first(pointer(poisoned.ctypes.data), count) == 37
        assert (rest[37:] == -7).all()
    assert batch(pointer(q.ctypes.data), count, joints, pointer(values.ctypes.data)) == 0
    np.testing.assert_array_equal(rest[:32], values[:32])
    return values
