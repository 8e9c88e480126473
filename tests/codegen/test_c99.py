"""C files of indices: standard C without warnings, without allocation, safe on any input, exact."""

import ctypes
import math
import re
import shutil
import subprocess
from dataclasses import replace
from functools import cache
from pathlib import Path

import mpmath
import numpy as np
import pytest
import torch
from numpy.testing import assert_allclose, assert_array_equal
from numpy.typing import NDArray

import dexterity as dx
from dexterity import symbolic
from dexterity.codegen import library
from dexterity.codegen.c99 import c_files, function_name
from dexterity.codegen.c_file import NOT_FINITE
from dexterity.indices import Index
from dexterity.symbolic import SymbolicChain

Array = NDArray[np.float64]
W, KCI = "manipulability", "kinematic_conditioning"
UVMS, PUMA = dx.robots.uvms(), dx.robots.puma560()
BEGIN = "arm"
NULL_POINTER, WRONG_JOINTS = 1, 2

WARNINGS = ("-Wall", "-Wextra", "-pedantic", "-Wconversion", "-Wshadow", "-Werror")
STRICT = ("-std=c99", *WARNINGS)
SANITIZERS = ("-O1", "-g", "-fsanitize=address,undefined", "-fno-sanitize-recover=all")
SANITIZED = ("-std=c99", "-Wall", "-Wextra", "-pedantic", "-Werror", *SANITIZERS)

both_indices = pytest.mark.parametrize("name", [W, KCI])


@pytest.fixture(params=["gcc", "clang"])
def compiler(request: pytest.FixtureRequest) -> str:
    if shutil.which(request.param) is None:
        pytest.skip(f"{request.param} is not installed")
    return request.param


@cache
def source_of(chain: dx.Chain, name: str) -> str:
    return symbolic.c_source(symbolic.derive(chain, Index(name)), BEGIN)


def compile_strictly(compiler: str, flags: tuple[str, ...], *arguments: Path | str) -> None:
    run = subprocess.run([compiler, *flags, *arguments], capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stderr
    assert run.stderr == ""


class Functions:
    """The four functions of a compiled file, on arrays."""

    def __init__(self, chain: dx.Chain, name: str) -> None:
        self.joints = chain.joints
        loaded = library.compiled_library(source_of(chain, name))
        self.selftest = loaded.arm_selftest
        self._scalar, self._gradient, self._batch, self._gradient_batch = (
            getattr(loaded, BEGIN + end) for end in ("", "_gradient", "_batch", "_gradient_batch")
        )

    def scalar(self, q: Array | None, value: Array | None) -> int:
        return self._scalar(_pointer(q), _pointer(value))

    def gradient(self, q: Array | None, value: Array | None, gradient: Array | None) -> int:
        return self._gradient(_pointer(q), _pointer(value), _pointer(gradient))

    def batch(self, q: Array | None, count: int, joints: int, values: Array | None) -> int:
        return self._batch(_pointer(q), _size(count), _size(joints), _pointer(values))

    def gradient_batch(
        self, q: Array | None, count: int, joints: int, values: Array | None, gradients: Array | None
    ) -> int:
        return self._gradient_batch(
            _pointer(q), _size(count), _size(joints), _pointer(values), _pointer(gradients)
        )


_size = ctypes.c_size_t


def _pointer(array: Array | None) -> ctypes.c_void_p:
    assert array is None or array.flags.c_contiguous
    return ctypes.c_void_p(None if array is None else array.ctypes.data)


functions_of = cache(Functions)


# ---- the text --------------------------------------------------------------------------------------


@both_indices
@pytest.mark.parametrize("chain", [PUMA, UVMS], ids=["puma", "uvms"])
def test_a_file_compiles_without_warnings(tmp_path, compiler, chain, name):
    file = tmp_path / "index.c"
    file.write_text(source_of(chain, name), encoding="utf-8")
    compile_strictly(compiler, (*STRICT, "-O1"), "-c", file, "-o", tmp_path / "index.o")


@both_indices
def test_a_file_needs_nothing_and_keeps_nothing(name):
    source = source_of(UVMS, name)
    code = re.sub(r"/\*.*?\*/", "", source, flags=re.DOTALL)
    headers = ["<stddef.h>", "<math.h>", "<stdint.h>", "<string.h>"]
    assert re.findall(r"#\s*include\s*(\S+)", code) == headers
    assert not re.search(r"alloc|\bfree\b|\bgoto\b", code)
    # Whatever is static is a function or a constant.
    for line in re.findall(r"^\s*static (.*)$", code, flags=re.MULTILINE):
        assert re.match(r"(inline )?(void|int|double) \w+\(|const (int|double) \w+\[", line), line


@both_indices
def test_a_file_says_what_it_computes(name):
    index = Index(name, "body", joint_rates=(0.5,) * 3 + (0.25,) * 3 + (1.0,) * 6, tool_rates=(2.0,) * 6)
    comment, _ = symbolic.c_source(symbolic.derive(UVMS, index)).split("*/", 1)
    words = " ".join(comment.replace(" *", " ").split())
    for said in (
        f"of {UVMS.name}",
        "x [m], y [m]",
        "θx [rad]",
        "Frame: body Jacobian",
        "Largest joint rates [unit/s]: 0.5, 0.5, 0.5, 0.25",
        "Largest tool rates [m/s, rad/s]: 2, 2, 2, 2, 2, 2",
        "per [rad] or [m]",
        "Accuracy: a few rounding errors",
        "Geometry at home",
        "tool at (0, 1.75, 0)",
    ):
        assert said in words


@pytest.mark.parametrize(
    ("chain", "name"),
    [
        ("uvms", "uvms_manipulability_spatial_"),
        ("PUMA 560 (fitted)", "puma_560_fitted_manipulability_spatial_"),
        ("7-axis arm", "chain_7_axis_arm_manipulability_spatial_"),
        ("_hidden", "hidden_manipulability_spatial_"),
        ("Ärmchen", "rmchen_manipulability_spatial_"),
        ("θ", "manipulability_spatial_"),
        ("", "manipulability_spatial_"),
        ("*/ int main(void); /*", "int_main_void_manipulability_spatial_"),
        ("a" * 1000, "a" * 80 + "_manipulability_spatial_"),
    ],
)
def test_functions_are_named_for_chain_index_and_frame(chain, name):
    symbolic_chain = replace(SymbolicChain.from_chain(PUMA), name=chain)
    assert re.fullmatch(f"{name}[0-9a-f]{{8}}", function_name(symbolic_chain, Index(W)))


def test_variants_have_different_names_and_can_be_linked_together(tmp_path, compiler):
    """engineer.md, B4: frames and rates of one index exported one symbol."""
    rates = (1.0, 1.0, 1.0, 2.0, 2.0, 2.0)
    moved = PUMA.home
    moved[0, 3] += 1e-3
    variants = [
        (PUMA, Index(W)),
        (PUMA, Index(W, "geometric")),
        (PUMA, Index(W, tool_rates=rates)),
        (PUMA, Index(W, joint_rates=rates)),
        (dx.Chain(PUMA.screws, moved, name=PUMA.name), Index(W)),
    ]
    files = {}
    for chain, index in variants:
        for precision in ("double", "float"):
            files |= c_files(symbolic.derive(chain, index), precision=precision)
    assert len(files) == 2 * 2 * len(variants)
    for name, text in files.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    names = sorted(name.removesuffix(".c") for name in files if name.endswith(".c"))
    includes = "".join(f'#include "{name}.h"\n' for name in names)
    tests = " || ".join(f"{name}_selftest()" for name in names)
    (tmp_path / "main.c").write_text(f"{includes}int main(void) {{ return {tests}; }}\n", encoding="utf-8")
    everything = [tmp_path / f"{name}.c" for name in names]
    compile_strictly(
        compiler, (*STRICT, "-O1"), tmp_path / "main.c", *everything, "-o", tmp_path / "main", "-lm"
    )
    assert subprocess.run([tmp_path / "main"], check=False).returncode == 0
    # Also in one file, as some builds do it.
    (tmp_path / "unity.c").write_text(
        "".join(f'#include "{name}.c"\n' for name in names) + '#include "main.c"\n', encoding="utf-8"
    )
    compile_strictly(compiler, STRICT, tmp_path / "unity.c", "-o", tmp_path / "unity", "-lm")


HOSTILE = {
    "end of comment": "arm */ OUTSIDE /*",
    "end of comment, again": "arm **//",
    "end of comment, spread": "arm *\n/ OUTSIDE",
    "new lines": "arm\nOUTSIDE\r\nOUTSIDE\u2028OUTSIDE\x85OUTSIDE\x0bOUTSIDE",
    "backslash": "arm \\",
    "backslash and new line": "arm *\\\n/ OUTSIDE",
    "backslashes": "\\" * 300,
    "trigraph": "arm *??/\n/ OUTSIDE ??/",
    "start of comment": "arm /* OUTSIDE",
    "placeholder": "arm $joints ${name} $$",
    "quotes": "arm \" ' ` ${1}",
    "long": "arm */ OUTSIDE" * 100,
    "unprintable": "arm \x00 \x1b \ufeff \u202e */ OUTSIDE",
}


@pytest.mark.parametrize("chain_name", HOSTILE.values(), ids=HOSTILE)
def test_no_name_breaks_out_of_the_comment(tmp_path, compiler, chain_name):
    derivation = symbolic.derive(PUMA, Index(W))
    names = tuple(f"{chain_name} {i}" for i in range(6))
    chain = replace(derivation.chain, name=chain_name, joint_names=names)
    if not chain_name.isprintable():
        with pytest.raises(ValueError, match=r"^name is .* printable"):
            symbolic.c_source(replace(derivation, chain=chain), BEGIN)
        return
    source = symbolic.c_source(replace(derivation, chain=chain), BEGIN)
    _, code = source.split("*/", 1)
    assert re.match(r"\n#ifndef \w+_H\n", code)
    assert "OUTSIDE" not in code
    file = tmp_path / "index.c"
    file.write_text(source, encoding="utf-8")
    compile_strictly(compiler, STRICT, "-c", file, "-o", tmp_path / "index.o")


# ---- values ----------------------------------------------------------------------------------------


@both_indices
@pytest.mark.parametrize("chain", [PUMA, UVMS], ids=["puma", "uvms"])
def test_values_and_gradients_are_those_of_torch(rng, chain, name):
    q = rng.uniform(-3, 3, (200, chain.joints))
    f = symbolic.compile_index(chain, Index(name), "torch")
    expected, slopes = (x.numpy() for x in f.value_and_gradient(q))
    conditioning = Index(KCI).bind(chain)(q).numpy()
    values, gradients = np.empty(200), np.empty_like(q)
    assert functions_of(chain, name).gradient_batch(q, 200, chain.joints, values, gradients) == 0
    assert_allclose(values, expected, rtol=0, atol=1e-12)
    assert_allclose(values[conditioning > 1e-3], expected[conditioning > 1e-3], rtol=1e-12)
    assert (np.abs(gradients - slopes).max(-1) <= 1e-12 * np.abs(slopes).max(-1) / conditioning).all()


@both_indices
@pytest.mark.parametrize("count", [0, 1, 15, 16, 17, 33])
def test_all_four_functions_agree_and_write_their_rows_only(rng, name, count):
    functions = functions_of(PUMA, name)
    q = rng.uniform(-3, 3, (count, 6))
    values, values_too = (np.full(count + 8, -7.0) for _ in range(2))
    gradients = np.full((count + 8, 6), -7.0)
    assert functions.batch(q, count, 6, values) == 0
    assert functions.gradient_batch(q, count, 6, values_too, gradients) == 0
    for result in (values, values_too, gradients):
        assert_array_equal(result[count:], -7.0)
    assert_allclose(values_too[:count], values[:count], rtol=1e-13, atol=1e-16)
    for row in range(count):
        value, again, gradient = np.full(3, -7.0), np.full(3, -7.0), np.full(9, -7.0)
        assert functions.scalar(q[row].copy(), value) == 0
        assert functions.gradient(q[row].copy(), again, gradient) == 0
        for result, end in ((value, 1), (again, 1), (gradient, 6)):
            assert_array_equal(result[end:], -7.0)
        assert_allclose([value[0], again[0]], values[row], rtol=1e-13, atol=1e-16)
        assert_allclose(gradient[:6], gradients[row], rtol=1e-10, atol=1e-13)


TABLE = dx.Chain.from_dh([{"a": 0.3}, {"a": 0.25, "alpha": np.pi}, {"kind": "prismatic"}, {}], name="table")
MEASURES = [
    (PUMA, Index("smallest_singular_value", "geometric")),
    (PUMA, Index("isotropy", "geometric", rows="translational")),
    (PUMA, Index("log_manipulability")),
    (PUMA, Index("limited_manipulability")),
    (PUMA, Index("velocity_ratio", "geometric", direction=(0.0, 0.6, 0.8, 0.0, 0.0, 0.0))),
    (TABLE, Index(KCI, "geometric", rows=("vx", "vy", "vz", "wz"))),
    (PUMA, Index("guaranteed_speed", "geometric")),
    (PUMA, Index("guaranteed_speed", "geometric", rows="rotational")),
    (TABLE, Index("guaranteed_speed", "geometric", rows=("vx", "vy"))),
    (dx.robots.ur5e(), Index("dynamic_manipulability", "geometric")),
    (dx.robots.panda(), Index("dynamic_manipulability", "geometric", rows="translational")),
    (TABLE, Index("order_independent_manipulability", "geometric", rows=("vx",))),
]


@pytest.mark.parametrize(("chain", "index"), MEASURES, ids=lambda x: getattr(x, "name", None))
def test_every_recorded_measure_is_written(chain, index):
    """With any rows and joints; the self-test compares with the definition, as these lines do again."""
    q = torch.from_numpy(np.random.default_rng(3).uniform(-1.2, 1.2, (50, chain.joints))).requires_grad_()
    values = index.bind(chain)(q)
    (gradients,) = torch.autograd.grad(values.sum(), q)
    f = symbolic.compile_index(chain, index, "c")
    found, slopes = f.value_and_gradient(q.detach())
    assert_allclose(found, values.detach(), rtol=1e-10, atol=1e-14)
    assert_allclose(slopes, gradients, rtol=0, atol=1e-9 * float(gradients.abs().max()))


def test_a_limit_sees_the_value_and_a_sine_the_angle(rng):
    """A joint may turn several times: its angle is brought into one turn, its distance to a limit is not."""
    chain = dx.Chain(PUMA.screws, PUMA.home, lower=[-30.0] * 6, upper=[40.0] * 6, name="turns")
    index = Index("limited_manipulability")
    q = rng.uniform(-28, 38, (50, 6))
    assert_allclose(symbolic.compile_index(chain, index, "c")(q), index.bind(chain)(q), rtol=1e-10)


def test_what_is_not_recorded_is_refused_by_name():
    said = r'^guaranteed_speed is not recorded as a program: .* 792 facets.* backend="torch" computes it'
    with pytest.raises(ValueError, match=said):
        symbolic.compile_index(UVMS, Index("guaranteed_speed"), "c")


@pytest.mark.parametrize("angle", [1e-3, 1e-6, 1e-9, 1e-11])
def test_the_gradient_of_kci_keeps_its_digits_toward_a_singularity(angle):
    """faults.md, 19: the error was 2e-4 at a KCI of 3e-13; automatic differentiation keeps 1e-15."""
    q = torch.tensor([0.3, -0.5, 0.7, 0.2, angle, -0.4], dtype=torch.float64, requires_grad=True)
    value = Index(KCI).bind(PUMA)(q)
    (gradient,) = torch.autograd.grad(value, q)
    values, slopes = np.empty(1), np.empty(6)
    assert functions_of(PUMA, KCI).gradient(q.detach().numpy(), values, slopes) == 0
    assert_allclose(values, value.detach(), rtol=0, atol=1e-15)
    assert_allclose(slopes, gradient, rtol=0, atol=1e-13 * float(gradient.abs().max()))


def test_numbers_keep_all_their_digits():
    rates = (1 / 3, 1 / 7, math.pi, math.sqrt(2) / 10, 1e-3 / 9, 1.0)
    source = symbolic.c_source(symbolic.derive(PUMA, Index(KCI, "spatial", rates)), BEGIN)
    numbers = {float(number) for number in re.findall(r"[0-9]+\.[0-9]+(?:e[+-]?[0-9]+)?", source)}
    assert numbers >= set(rates)


# ---- errors ----------------------------------------------------------------------------------------


@both_indices
def test_null_pointers_are_refused(name):
    functions = functions_of(PUMA, name)
    q, values, gradients = np.ones((3, 6)), np.full(3, -7.0), np.full((3, 6), -7.0)
    assert functions.scalar(None, values) == NULL_POINTER
    assert functions.scalar(q, None) == NULL_POINTER
    assert functions.batch(None, 3, 6, values) == NULL_POINTER
    assert functions.batch(q, 3, 6, None) == NULL_POINTER
    for arrays in ((None, values, gradients), (q, None, gradients), (q, values, None)):
        assert functions.gradient(*arrays) == NULL_POINTER
        assert functions.gradient_batch(arrays[0], 3, 6, *arrays[1:]) == NULL_POINTER
    assert_array_equal(values, -7.0)
    assert_array_equal(gradients, -7.0)


@both_indices
def test_null_pointers_are_fine_where_there_is_nothing_to_do(name):
    functions = functions_of(PUMA, name)
    assert functions.batch(None, 0, 6, None) == 0
    assert functions.gradient_batch(None, 0, 6, None, None) == 0


@both_indices
@pytest.mark.parametrize("joints", [0, 5, 7, 12, 2**63])
def test_another_number_of_joints_is_refused(name, joints):
    functions = functions_of(PUMA, name)
    q, values, gradients = np.ones((3, 6)), np.full(3, -7.0), np.full((3, 6), -7.0)
    assert functions.batch(q, 3, joints, values) == WRONG_JOINTS
    assert functions.gradient_batch(q, 3, joints, values, gradients) == WRONG_JOINTS
    assert_array_equal(values, -7.0)
    assert_array_equal(gradients, -7.0)


@both_indices
@pytest.mark.parametrize("poison", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("row", [0, 15, 16, 32])
def test_what_is_not_finite_is_refused(name, poison, row):
    functions = functions_of(PUMA, name)
    for joint in range(6):
        q, values, gradients = np.ones((33, 6)), np.full(40, -7.0), np.full((40, 6), -7.0)
        q[row, joint] = poison
        assert functions.batch(q, 33, 6, values) == NOT_FINITE
        assert functions.gradient_batch(q, 33, 6, values, gradients) == NOT_FINITE
        assert functions.scalar(q[row], values[33:]) == NOT_FINITE
        assert functions.gradient(q[row], values[34:], gradients[33:]) == NOT_FINITE
        assert_array_equal(values[35:], -7.0)
        assert_array_equal(gradients[34:], -7.0)
        assert (values[:row] > 0).all()
        assert_array_equal(values[row:33], -7.0)
        assert_array_equal(gradients[row:33], -7.0)


@both_indices
def test_a_chain_that_cannot_be_computed_has_no_file(name):
    short = dx.Chain.from_dh([{"a": 1}] * 5, name="short arm")
    with pytest.raises(ValueError, match=r"short arm"):
        symbolic.c_source(symbolic.derive(short, Index(name)))
    open_lengths = SymbolicChain.from_description(dx.robots.describe("docking_arm"))
    with pytest.raises(ValueError, match=r"^docking_arm has lengths without a value"):
        symbolic.c_source(symbolic.derive(open_lengths, Index(name)))


MAIN = """
#include <stdio.h>
#include <stdlib.h>
#include "index.c"

/* Arrays of exactly the size that is needed, so that a step beside them is seen. */
static double *array(size_t size, double fill)
{
  double *x = malloc((size ? size : 1)*sizeof *x);
  if (x == NULL)
    exit(9);
  for (size_t i = 0; i < size; ++i)
    x[i] = fill;
  return x;
}

static void run(size_t count, double poison)
{
  double *q = array(count*JOINTS, 0.0), *values = array(count, -7.0), *gradients = array(count*JOINTS, -7.0);
  double *value = array(1, -7.0), *gradient = array(JOINTS, -7.0);
  for (size_t i = 0; i < count*JOINTS; ++i)
    q[i] = (double)(i*7919u%6000u)/1000.0 - 3.0;
  if (count > 0 && poison != 0.0)
    q[count*JOINTS - 1] = poison;
  printf("%d", NAME(_batch)(q, count, JOINTS, values));
  printf(" %d", NAME(_gradient_batch)(q, count, JOINTS, values, gradients));
  printf(" %d", NAME(_batch)(q, count, JOINTS + 1, values));
  printf(" %d", NAME(_batch)(NULL, count, JOINTS, values));
  printf(" %d", NAME(_gradient_batch)(q, count, JOINTS, values, NULL));
  if (count > 0) {
    printf(" %d", NAME()(q + (count - 1)*JOINTS, value));
    printf(" %d", NAME(_gradient)(q + (count - 1)*JOINTS, value, gradient));
  }
  if (poison == 0.0 || poison > 1e3)
    for (size_t i = 0; i < count; ++i) {
      printf(" %a", values[i]);
      for (int j = 0; j < JOINTS; ++j)
        printf(" %a", gradients[i*JOINTS + j]);
    }
  printf("\\n");
  free(q), free(values), free(gradients), free(value), free(gradient);
}

int main(void)
{
  const size_t counts[] = {0, 1, 15, 16, 17, 33};
  for (int i = 0; i < 6; ++i)
    run(counts[i], 0.0);
  run(17, NAN);
  run(17, -INFINITY);
  run(3, 1e300);
  return 0;
}
"""


@both_indices
def test_sanitizers_find_nothing(tmp_path, compiler, name):
    empty = tmp_path / "empty.c"
    empty.write_text("int main(void) { return 0; }\n", encoding="utf-8")
    if subprocess.run(
        [compiler, *SANITIZED, empty, "-o", tmp_path / "empty"], capture_output=True, check=False
    ).returncode:
        pytest.skip(f"{compiler} is installed without its sanitizers")
    (tmp_path / "index.c").write_text(source_of(PUMA, name), encoding="utf-8")
    main = tmp_path / "main.c"
    main.write_text(f"#define NAME(end) {BEGIN}##end\n#define JOINTS ARM_JOINTS\n{MAIN}", encoding="utf-8")
    # An empty argument of a macro is C99, but not for clang's -pedantic.
    compile_strictly(compiler, SANITIZED, main, "-o", tmp_path / "main", "-lm")
    run = subprocess.run([tmp_path / "main"], capture_output=True, text=True, check=False)
    assert (run.returncode, run.stderr) == (0, "")

    lines = [line.split() for line in run.stdout.splitlines()]
    f = symbolic.compile_index(PUMA, Index(name), "torch")
    for count, line in zip([0, 1, 15, 16, 17, 33], lines, strict=False):
        null = 0 if count == 0 else NULL_POINTER
        codes = [0, 0, WRONG_JOINTS, null, null] + [0, 0] * (count > 0)
        assert [int(word) for word in line[: len(codes)]] == codes
        rows = np.array([float.fromhex(word) for word in line[len(codes) :]]).reshape(count, 7)
        q = (np.arange(count * 6) * 7919 % 6000 / 1000 - 3).reshape(count, 6)
        value, gradient = f.value_and_gradient(q)
        assert_allclose(rows[:, 0], value, rtol=1e-9, atol=1e-13)
        assert_allclose(rows[:, 1:], gradient, rtol=1e-6, atol=1e-9)
    for line in lines[6:8]:
        assert [int(word) for word in line[:7]] == [3, 3, 2, 1, 1, 3, 3]
    assert [int(word) for word in lines[8][:7]] == [0, 0, 2, 1, 1, 0, 0]
    assert np.isfinite([float.fromhex(word) for word in lines[8][7:]]).all()


# ---- sine and cosine -------------------------------------------------------------------------------


def sines_and_cosines(x: Array) -> tuple[Array, Array]:
    wrapper = """
    void both(const double *x, size_t count, double *sine, double *cosine);
    void both(const double *x, size_t count, double *sine, double *cosine)
    {
      for (size_t i = 0; i < count; ++i)
        arm_sine_cosine(x[i], sine + i, cosine + i);
    }
    """
    sine, cosine = np.empty_like(x), np.empty_like(x)
    both = library.compiled_library(source_of(PUMA, W) + wrapper).both
    both(_pointer(x), _size(x.size), _pointer(sine), _pointer(cosine))
    return sine, cosine


ANGLES = {
    "one turn": lambda rng: rng.uniform(-7, 7, 2_000),
    "up to 1e5": lambda rng: rng.uniform(-1e5, 1e5, 2_000),
    "all magnitudes": lambda rng: rng.choice([-1, 1], 2_000) * 10 ** rng.uniform(-320, 5, 2_000),
    "beside multiples of π/2": lambda rng: (
        np.spacing(x := rng.integers(-63_661, 63_662, 2_000) * (np.pi / 2)) * rng.integers(-2, 3, 2_000) + x
    ),
    "beside odd multiples of π/4": lambda rng: (
        np.spacing(x := (rng.integers(-63_661, 63_660, 2_000) + 0.5) * (np.pi / 2))
        * rng.integers(-2, 3, 2_000)
        + x
    ),
    # 51 819 π/2 and others come nearest to a double: best approximations of π/2 by fractions.
    "nearest to multiples of π/2": lambda rng: np.array(
        [n * k * (np.pi / 2) for k in (1, 2, 7, 11, 22, 355, 710, 51_819) for n in (-1, 1)]
    ),
    "limits": lambda rng: np.array([0.0, -0.0, 5e-324, -1e-300, 1e5, -1e5, np.pi / 4, -np.pi / 4]),
}


@pytest.mark.parametrize("angles", ANGLES.values(), ids=ANGLES)
def test_sine_and_cosine_are_off_by_two_units_in_the_last_place_at_most(rng, angles):
    x = angles(rng)
    assert np.abs(x).max() <= 1e5
    with mpmath.workdps(60):
        for values, exact in zip(sines_and_cosines(x), (mpmath.sin, mpmath.cos), strict=True):
            exact_values = [exact(mpmath.mpf(angle)) for angle in x.tolist()]
            errors = [abs(mpmath.mpf(v) - e) for v, e in zip(values.tolist(), exact_values, strict=True)]
            ulps = [float(e / np.spacing(abs(float(v)))) for e, v in zip(errors, exact_values, strict=True)]
            assert max(ulps) <= 2


def test_sine_and_cosine_lie_on_the_unit_circle(rng):
    sine, cosine = sines_and_cosines(rng.uniform(-1e5, 1e5, 100_000))
    assert_allclose(sine**2 + cosine**2, 1, rtol=0, atol=1e-15)


@both_indices
@pytest.mark.parametrize("magnitude", [7.9, 8.1, 1e4, 0.9e5, 1.1e5, 1e9, 1e15])
def test_angles_of_any_size_keep_their_digits(rng, name, magnitude):
    """faults.md, 6: angles were summed before they were brought into one turn, 7e-12 off at 9e4."""
    q = rng.uniform(-1, 1, (100, 6)) * magnitude
    q[::2, 0] = 1.0  # beside a small one
    values = np.empty(100)
    assert functions_of(PUMA, name).batch(q, 100, 6, values) == 0
    plain = Index(name).bind(PUMA)(torch.from_numpy(q)).numpy()
    assert_allclose(values, plain, rtol=0, atol=10 * np.finfo(float).eps)


@both_indices
def test_the_result_does_not_jump_where_angles_begin_to_be_reduced(name):
    for edge in (8.0, 1e5):
        q = np.tile([0.3, -0.4, 0.7, 0.2, 0.8, 0.1], (3, 1))
        q[:, 2] = np.nextafter(edge, 0), edge, np.nextafter(edge, np.inf)
        values, gradients = np.empty(3), np.empty((3, 6))
        assert functions_of(PUMA, name).gradient_batch(q, 3, 6, values, gradients) == 0
        assert_allclose(values, values[1], rtol=0, atol=1e-15 + 2 * np.spacing(edge))


@both_indices
@pytest.mark.parametrize("size", [1e6, 1e25, 1e50])
def test_values_and_gradients_are_finite_up_to_the_length_that_the_book_states(name, size):
    q = np.array([size, -size, size, *np.linspace(0.1, 0.9, 9)])
    value, gradient = np.full(1, np.nan), np.full(12, np.nan)
    assert functions_of(UVMS, name).gradient(q, value, gradient) == 0
    assert np.isfinite([*value, *gradient]).all()
    if name == W:  # which does not depend on where the vehicle is
        assert_allclose(value, Index(W).bind(UVMS)([0.0] * 3 + list(q[3:])), rtol=1e-12)


@both_indices
@pytest.mark.parametrize("size", [1e6, 1e12])
def test_single_precision_is_finite_up_to_the_length_that_the_book_states(name, size):
    source = symbolic.c_source(symbolic.derive(UVMS, Index(name)), BEGIN, "float")
    q = np.array([size, -size, size, *np.linspace(0.1, 0.9, 9)], np.float32)
    value, gradient = np.full(1, np.nan, np.float32), np.full(12, np.nan, np.float32)
    compute = library.compiled_library(source).arm_gradient
    assert compute(_pointer(q), _pointer(value), _pointer(gradient)) == 0
    assert np.isfinite([*value, *gradient]).all()


def one_turns(x: Array) -> Array:
    wrapper = """
    void turns(const double *x, size_t count, double *y);
    void turns(const double *x, size_t count, double *y)
    {
      for (size_t i = 0; i < count; ++i)
        y[i] = arm_one_turn(x[i]);
    }
    """
    y = np.empty_like(x)
    library.compiled_library(source_of(PUMA, W) + wrapper).turns(_pointer(x), _size(x.size), _pointer(y))
    return y


def test_an_angle_less_its_turns_is_exact_to_its_last_digit(rng):
    x = rng.choice([-1, 1], 3_000) * 10 ** rng.uniform(-3, 15, 3_000)
    with mpmath.workdps(60):
        for angle, reduced in zip(x.tolist(), one_turns(x).tolist(), strict=True):
            exact = mpmath.mpf(angle)
            exact -= 2 * mpmath.pi * mpmath.nint(exact / (2 * mpmath.pi))
            apart = abs(mpmath.mpf(reduced) - exact)
            apart = min(apart, abs(2 * mpmath.pi - apart))
            assert apart <= 2 * np.spacing(max(abs(reduced), 1e-16))
