"""Elementary functions of generated C: near the exact value over all numbers, whatever the flags."""

import ctypes
import shutil
import subprocess
from functools import cache

import mpmath
import numpy as np
import pytest
from numpy.testing import assert_array_equal

from dexterity.codegen.c_file import CFile

FUNCTIONS = {
    "power_of_two": lambda x: mpmath.mpf(2) ** x,
    "exponential": mpmath.exp,
    "logarithm": mpmath.log,
}
TYPES = {"double": np.float64, "float": np.float32}
FLAGS = ["-O1", "-O3 -march=native -fno-math-errno -fno-trapping-math", "-Ofast"]


@pytest.fixture(scope="module", params=["gcc", "clang", "g++"])
def compiler(request) -> str:
    if shutil.which(request.param) is None:
        pytest.skip(f"{request.param} is not installed")
    return request.param


@pytest.fixture(scope="module", params=FLAGS)
def functions(request, compiler, tmp_path_factory):
    """Return a function that applies one of them to an array, in the array's type."""
    folder, loaded = tmp_path_factory.mktemp("elementary"), {}
    for precision in TYPES:
        file = CFile("f", precision)
        prototypes = [f"void {name}(const double *x, size_t count, double *y)" for name in FUNCTIONS]
        loops = "".join(
            f"{prototype}\n{{\n  for (size_t i = 0; i < count; ++i)\n    y[i] = f_{name}(x[i]);\n}}\n"
            for prototype, name in zip(prototypes, FUNCTIONS, strict=True)
        )
        declared = "".join(f"{prototype};\n" for prototype in prototypes)
        if compiler == "g++":
            declared = f'extern "C" {{\n{declared}}}\n'
        source = folder / f"{precision}.c"
        source.write_text(
            file.standalone(f"#include <stddef.h>\n{declared}", file.elementary(loops) + loops),
            encoding="utf-8",
        )
        language = ("-x", "c++") if compiler == "g++" else ("-std=c99",)
        warnings = ("-Wall", "-Wextra", "-pedantic", "-Wconversion", "-Wshadow", "-Werror")
        warnings = (*warnings, "-Wno-unused-function")
        made, result = source.with_suffix(".o"), source.with_suffix(".so")
        compiled = (*language, *request.param.split(), *warnings, "-fPIC", "-c", source, "-o", made)
        # Linked without fast math, which would round the denormal numbers of this process to zero.
        for arguments in (compiled, ("-shared", made, "-o", result, "-lm")):
            done = subprocess.run([compiler, *arguments], capture_output=True, text=True, check=False)
            assert (done.returncode, done.stderr) == (0, ""), done.stderr
        loaded[TYPES[precision]] = ctypes.CDLL(str(result))

    def apply(name: str, x: np.ndarray) -> np.ndarray:
        y, pointer = np.empty_like(x), ctypes.c_void_p
        arguments = pointer(x.ctypes.data), ctypes.c_size_t(x.size), pointer(y.ctypes.data)
        getattr(loaded[x.dtype.type], name)(*arguments)
        return y

    return apply


def of_all_sizes(rng, dtype, count: int) -> np.ndarray:
    """Positive numbers, drawn by their bits: denormal ones too."""
    bits = np.dtype(f"u{np.dtype(dtype).itemsize}")
    return rng.integers(1, np.array(np.inf, dtype).view(bits), count, dtype=bits).view(dtype)


def arguments(rng, name: str, dtype) -> np.ndarray:
    """Arguments over the whole range of a function, its ends and what is hard between them."""
    limits = np.finfo(dtype)
    if name == "logarithm":
        about_one = 1 + np.concatenate([rng.uniform(-0.5, 1, 500), rng.uniform(-1e-5, 1e-5, 500)])
        steps = 2.0 ** np.arange(-0.5, 1, 0.5)
        hard = np.array([limits.smallest_subnormal, limits.tiny, limits.max, *steps], dtype)
        x = np.concatenate([about_one.astype(dtype), of_all_sizes(rng, dtype, 2000), hard])
        x = np.concatenate([x, np.nextafter(x, dtype(0))])
        return x[x > 0]
    base = np.log(2) if name == "exponential" else 1.0
    most, least = base * limits.maxexp, base * limits.minexp
    ends = base * np.arange(limits.minexp, limits.maxexp, 0.5)
    x = [rng.uniform(-2, 2, 1000), rng.uniform(least, most, 1000), ends, rng.uniform(-1e-9, 1e-9, 100)]
    x = np.concatenate(x).astype(dtype)
    return x[(x > least) & (x < most)]


@cache
def exact(name: str, dtype) -> tuple[np.ndarray, list[mpmath.mpf]]:
    x = arguments(np.random.default_rng(0), name, dtype)
    with mpmath.workdps(40):
        return x, [FUNCTIONS[name](mpmath.mpf(float(each))) for each in x]


@pytest.mark.parametrize("dtype", TYPES.values(), ids=TYPES)
@pytest.mark.parametrize("name", FUNCTIONS)
def test_results_are_off_by_two_units_in_the_last_place_at_most(functions, name, dtype):
    x, expected = exact(name, dtype)
    y = functions(name, x)
    with mpmath.workdps(40):
        miss = [float(abs(mpmath.mpf(float(a)) - b)) for a, b in zip(y, expected, strict=True)]
    assert (np.array(miss) / np.spacing(np.abs(y)).astype(float)).max() <= 2


@pytest.mark.parametrize("dtype", TYPES.values(), ids=TYPES)
def test_ends_of_the_range_are_exact(functions, dtype):
    limits, inf, nan = np.finfo(dtype), np.inf, np.nan
    x = np.array([0, -0.0, 1, inf, -inf, nan, -1, -limits.smallest_subnormal, -limits.max], dtype)
    assert_array_equal(functions("logarithm", x), np.array([-inf, -inf, 0, inf, *[nan] * 5], dtype))
    x = np.array([0, -0.0, limits.smallest_subnormal, inf, -inf, nan, limits.max, -limits.max], dtype)
    for name in ("exponential", "power_of_two"):
        assert_array_equal(functions(name, x), np.array([1, 1, 1, inf, 0, nan, inf, 0], dtype))
    small = np.array([limits.minexp, limits.minexp - limits.nmant, limits.minexp - limits.nmant - 2], dtype)
    expected = [limits.tiny, limits.smallest_subnormal, 0]
    assert_array_equal(functions("power_of_two", small), np.array(expected, dtype))
    most = np.array([limits.maxexp - 1, limits.maxexp], dtype)
    assert_array_equal(functions("power_of_two", most), np.array([2.0 ** (limits.maxexp - 1), inf], dtype))
    # The exponential of a small denormal result keeps the digits that there are.
    deep = dtype(np.log(2) * (limits.minexp - limits.nmant // 2))
    result = functions("exponential", np.array([deep]))[0]
    assert abs(float(result) - float(mpmath.exp(float(deep)))) <= 2 * float(limits.smallest_subnormal)
