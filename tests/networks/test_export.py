"""Networks as C, JavaScript and ONNX: the values of torch, safe on any input, refused where impossible."""

import ctypes
import json
import math
import re
import shutil
import subprocess
import sys
from functools import cache
from pathlib import Path

import numpy as np
import onnx
import onnxruntime
import pytest
import torch
from numpy.testing import assert_allclose, assert_array_equal

from dexterity.codegen import library
from dexterity.codegen.c_file import NOT_FINITE, CFile
from dexterity.networks import c_code, export
from dexterity.networks.feed_forward import FeedForward
from dexterity.networks.folding import origin_program
from dexterity.networks.network import Network, View
from example_networks import (
    CARRIED,
    JOINTS,
    PLAIN,
    UVMS,
    examples,
    feed_forward,
    radial_basis,
    random_configurations,
)
from program_values import values_of

NETWORKS = examples()
NULL_POINTER, WRONG_JOINTS = 1, 2
EVERY = pytest.mark.parametrize("name", NETWORKS)
STRICT = ("-std=c99", "-Wall", "-Wextra", "-Wconversion", "-pedantic", "-Werror")
SANITIZED = (*STRICT, "-O1", "-g", "-fsanitize=address,undefined", "-fno-sanitize-recover=all")
needs_node = pytest.mark.skipif(shutil.which("node") is None, reason="node is not installed")


@pytest.fixture(params=["gcc", "clang"])
def compiler(request: pytest.FixtureRequest) -> str:
    if shutil.which(request.param) is None:
        pytest.skip(f"{request.param} is not installed")
    return request.param


compiled = cache(lambda name: export.compile_network(NETWORKS[name]))


def several_values() -> Network:
    q = random_configurations(np.random.default_rng(0), 20)
    return FeedForward.untrained(PLAIN, 3, q, q[:, :2], torch.Generator().manual_seed(0))


class Constant(Network):
    neurons = 0

    def answer(self, x: torch.Tensor) -> torch.Tensor:
        return x[..., 0] * 0


LANGUAGES = pytest.mark.parametrize(
    "write",
    [lambda network: export.c_source(network, "network"), export.javascript_module, export.onnx_model],
    ids=["C", "JavaScript", "ONNX"],
)


@LANGUAGES
def test_what_has_no_single_value_is_refused(write):
    with pytest.raises(ValueError, match=r"^network answers with 2 values; networks of one can be exported"):
        write(several_values())
    with pytest.raises(
        TypeError, match=r"^network is a Constant; FeedForward and RadialBasis can be exported"
    ):
        write(Constant(PLAIN))


@LANGUAGES
@pytest.mark.parametrize(
    ("large", "message"),
    [({"target_half_range": 1e308, "output_weights": 1e10}, "output"), ({"hidden_weights": 1e301}, "hidden")],
)
def test_weights_that_overflow_are_refused(rng, write, large, message):
    """Case of the review, faults #32: 'inf' is no constant of C, nor of JavaScript."""
    network = feed_forward(rng, "identity")
    arrays = {name: array.clone() for name, array in network.state_dict().items() if name != "view.carriers"}
    for name, size in large.items():
        arrays[name] = torch.full_like(arrays[name], size)
    with pytest.raises(ValueError, match=rf"^network is not finite .*{message} overflow"):
        write(FeedForward(PLAIN, "identity", arrays))


# ---- what is seen ----------------------------------------------------------------------------------


@pytest.mark.parametrize("carriers", [1, 4, 6, 9, 12])
def test_the_origin_is_that_of_the_view_and_of_the_chain(rng, carriers):
    view = View(JOINTS, [0], UVMS.screws[:carriers])
    q = rng.uniform(-2, 2, (30, JOINTS))
    program = origin_program(view)
    origin = values_of(program, dict(zip(program.inputs, q.T[:carriers], strict=True)))
    assert_allclose(origin, view(q)[:, :3], rtol=0, atol=1e-14)


def test_slides_need_no_sines_and_zeros_vanish():
    program = origin_program(View(JOINTS, [0], UVMS.screws[:3]))
    assert not program.steps
    assert [str(output) for output in program.outputs] == ["-q0", "-q1", "-q2"]


def test_a_carrier_may_be_a_screw_with_a_pitch(rng):
    axis = np.array([0.36, 0.48, 0.8])
    screw = np.concatenate([np.cross([0.3, -0.1, 0.2], axis) + 0.7 * axis, axis])
    view = View(JOINTS, [0, 5], np.stack([screw, *UVMS.screws[3:5].numpy()]))
    network, q = feed_forward(rng, "identity", view), random_configurations(rng, 20)
    assert_allclose(export.compile_network(network)(q), network(q).detach(), rtol=1e-13)
    assert_allclose(run_in_onnx(network, q), network(q).detach(), rtol=1e-13)


# ---- C ---------------------------------------------------------------------------------------------


@EVERY
def test_c_has_the_values_of_torch(rng, name):
    q = 3 * random_configurations(rng, 100)
    expected = NETWORKS[name](q).detach()
    assert_allclose(compiled(name)(q), expected, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("kind", ["feed forward", "radial basis"])
def test_networks_of_the_largest_sizes_have_their_values(rng, kind):
    if kind == "feed forward":
        network: Network = feed_forward(rng, "cone", CARRIED, neurons=60)
    else:
        network = radial_basis(rng, View(JOINTS, range(11)), neurons=149)
    q = random_configurations(rng, 50)
    assert_allclose(export.compile_network(network)(q), network(q).detach(), rtol=1e-12, atol=1e-12)
    assert_allclose(run_in_onnx(network, q), network(q).detach(), rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("dtype", [torch.float64, torch.float32, torch.int64])
def test_a_compiled_network_takes_what_a_network_takes(batch_shape, dtype):
    f, network = compiled("cone, origin and joints"), NETWORKS["cone, origin and joints"]
    q = torch.arange(math.prod(batch_shape) * JOINTS).reshape(*batch_shape, JOINTS).remainder(3).to(dtype)
    assert_allclose(f(q), network(q).detach(), rtol=1e-12)
    strided = torch.stack([q, q], dim=-1)[..., 0]
    assert_allclose(f(strided), network(q).detach(), rtol=1e-12)
    # Its memory holds the negatives, which were answered for in silence.
    assert_allclose(f(torch._neg_view(-q)), network(q).detach(), rtol=1e-12)
    assert_allclose(f(q.tolist() if batch_shape == (1,) else q.numpy()), network(q).detach(), rtol=1e-12)


def test_a_compiled_network_refuses_what_a_network_refuses():
    f = compiled("identity, joints")
    for q, message in (
        (torch.zeros(3, 11), r"^q has shape \(3, 11\); the chain has 12 joints"),
        (torch.zeros(()), r"^q has shape \(\)"),
        (torch.full((2, 12), math.nan, dtype=torch.float64), r"^q is not finite"),
        (torch.full((2, 12), math.inf), r"^q is not finite"),
    ):
        with pytest.raises(ValueError, match=message):
            f(q)
        with pytest.raises(ValueError, match=message):
            NETWORKS["identity, joints"](q)


@pytest.mark.parametrize("size", [1e3, 1e5, 1.1e5, 1e7])
def test_angles_of_any_size_are_taken_as_they_are(rng, size):
    """Those that turn the vehicle are brought into one turn first."""
    network = NETWORKS["logarithm, origin and joints"]
    q = random_configurations(rng, 40)
    q[::2, 3:6] *= size
    assert_allclose(compiled("logarithm, origin and joints")(q), network(q).detach(), rtol=1e-11 * size / 1e3)


@EVERY
def test_where_a_network_saturates_it_does_so_in_c(rng, name):
    q = random_configurations(rng, 20) * 10 ** torch.arange(20, dtype=torch.float64)[:, None]
    q[:, :6] = q[:, :6].remainder(3)
    assert_allclose(compiled(name)(q), NETWORKS[name](q).detach(), rtol=1e-12, atol=1e-12)


def test_a_value_that_overflows_is_infinite_and_one_that_underflows_is_zero(rng):
    network = feed_forward(rng, "logarithm")
    q = random_configurations(rng, 1)
    for centre, value in ((1e4, math.inf), (-1e4, 0.0)):
        with torch.no_grad():
            network.target_centre.fill_(centre)
        assert export.compile_network(network)(q).item() == network(q).item() == value


class Functions:
    """The two functions of a compiled file, on arrays."""

    def __init__(self, name: str) -> None:
        loaded = library.compiled_library(export.c_source(NETWORKS[name], "network"))
        self._scalar, self._batch = loaded.network, loaded.network_batch

    def scalar(self, q: np.ndarray | None, value: np.ndarray | None) -> int:
        return self._scalar(_pointer(q), _pointer(value))

    def batch(self, q: np.ndarray | None, count: int, joints: int, values: np.ndarray | None) -> int:
        return self._batch(_pointer(q), ctypes.c_size_t(count), ctypes.c_size_t(joints), _pointer(values))


functions_of = cache(Functions)


def _pointer(array: np.ndarray | None) -> ctypes.c_void_p:
    return ctypes.c_void_p(None if array is None else array.ctypes.data)


@EVERY
@pytest.mark.parametrize("count", [0, 1, 15, 16, 17, 33])
def test_both_functions_agree_and_write_their_rows_only(rng, name, count):
    functions = functions_of(name)
    q, values = rng.uniform(-2, 2, (count, JOINTS)), np.full(count + 8, -7.0)
    assert functions.batch(q, count, JOINTS, values) == 0
    assert_array_equal(values[count:], -7.0)
    for row in range(count):
        value = np.full(3, -7.0)
        assert functions.scalar(q[row].copy(), value) == 0
        assert_array_equal(value[1:], -7.0)
        assert_allclose(value[0], values[row], rtol=1e-13, atol=1e-14)


@pytest.mark.parametrize("name", ["identity, joints", "radial basis, origin and joints"])
def test_errors_are_told_apart(name):
    functions = functions_of(name)
    q, values = np.ones((33, JOINTS)), np.full(40, -7.0)
    assert functions.scalar(None, values) == functions.scalar(q, None) == NULL_POINTER
    assert functions.batch(None, 3, JOINTS, values) == functions.batch(q, 3, JOINTS, None) == NULL_POINTER
    assert functions.batch(None, 0, JOINTS, None) == 0
    for joints in (0, 11, 13, 2**63):
        assert functions.batch(q, 3, joints, values) == WRONG_JOINTS
    assert_array_equal(values, -7.0)
    for poison in (math.nan, math.inf, -math.inf):
        for row in (0, 15, 16, 32):
            for joint in range(JOINTS):
                poisoned = q.copy()
                poisoned[row, joint] = poison
                assert functions.batch(poisoned, 33, JOINTS, values) == NOT_FINITE
                assert functions.scalar(poisoned[row].copy(), values[33:]) == NOT_FINITE
    assert_array_equal(values[34:], -7.0)


@EVERY
def test_a_file_compiles_without_warnings(tmp_path, compiler, name):
    (tmp_path / "network.c").write_text(export.c_source(NETWORKS[name], "network"), encoding="utf-8")
    compile_strictly(compiler, (*STRICT, "-O1"), "-c", tmp_path / "network.c", "-o", tmp_path / "network.o")


def compile_strictly(compiler: str, flags: tuple[str, ...], *arguments: Path | str) -> None:
    run = subprocess.run([compiler, *flags, *arguments], capture_output=True, text=True, check=False)
    assert (run.returncode, run.stderr) == (0, "")


@EVERY
def test_a_file_needs_nothing_and_keeps_nothing(name):
    code = re.sub(r"/\*.*?\*/", "", export.c_source(NETWORKS[name], "network"), flags=re.DOTALL)
    headers = ["<stddef.h>", "<math.h>", "<stdint.h>", "<string.h>"]
    assert re.findall(r"#\s*include\s*(\S+)", code) == headers
    assert not re.search(r"alloc|\bfree\b|\bgoto\b", code)
    for line in re.findall(r"^\s*static (.*)$", code, flags=re.MULTILINE):
        assert re.match(r"(inline )?(void|int|double) \w+\(|const (int|double) \w+\[", line), line


MAIN = """
#include <stdio.h>
#include <stdlib.h>
#include "network.c"

#define JOINTS NETWORK_JOINTS

int main(void)
{
  const size_t counts[] = {0, 1, 15, 16, 17, 33};
  const double scales[] = {1.0, 1e6, 1e300, 0.0};
  for (int n = 0; n < 6; ++n)
    for (int scale = 0; scale < 4; ++scale) {
      const size_t count = counts[n];
      /* Arrays of exactly the size that is needed, so that a step beside them is seen. */
      double *q = malloc((count ? count*JOINTS : 1)*sizeof *q);
      double *values = malloc((count ? count : 1)*sizeof *q);
      if (q == NULL || values == NULL)
        return 9;
      for (size_t i = 0; i < count*JOINTS; ++i)
        q[i] = ((double)(i*7919u%6000u)/3000.0 - 1.0)*scales[scale];
      if (scale == 3 && count > 0)
        q[count*JOINTS - 1] = NAN;
      const int error = network_batch(q, count, JOINTS, values);
      printf("%d", error);
      for (size_t i = 0; scale == 0 && i < count; ++i)
        printf(" %a", values[i]);
      printf("\\n");
      free(q);
      free(values);
    }
  return 0;
}
"""


@pytest.mark.parametrize("name", ["triple, origin and joints", "reciprocal, joints", "radial basis, joints"])
def test_sanitizers_find_nothing(tmp_path, compiler, name):
    (tmp_path / "empty.c").write_text("int main(void) { return 0; }\n", encoding="utf-8")
    arguments = [tmp_path / "empty.c", "-o", tmp_path / "empty"]
    if subprocess.run([compiler, *SANITIZED, *arguments], capture_output=True, check=False).returncode:
        pytest.skip(f"{compiler} is installed without its sanitizers")
    (tmp_path / "network.c").write_text(export.c_source(NETWORKS[name], "network"), encoding="utf-8")
    (tmp_path / "main.c").write_text(MAIN, encoding="utf-8")
    compile_strictly(compiler, SANITIZED, tmp_path / "main.c", "-o", tmp_path / "main", "-lm")
    run = subprocess.run([tmp_path / "main"], capture_output=True, text=True, check=False)
    assert (run.returncode, run.stderr) == (0, "")
    lines = iter(run.stdout.splitlines())
    for count in (0, 1, 15, 16, 17, 33):
        error, *words = next(lines).split()
        q = (np.arange(count * JOINTS) * 7919 % 6000 / 3000 - 1).reshape(count, JOINTS)
        assert error == "0"
        expected = NETWORKS[name](q).detach()
        assert_allclose([float.fromhex(word) for word in words], expected, rtol=1e-12, atol=1e-12)
        codes = [next(lines) for _ in range(3)]
        assert codes == ["0", "0", str(NOT_FINITE if count else 0)]


def smallest_eigenvalues(matrices: np.ndarray) -> np.ndarray:
    wrapper = """
    void smallest(double *rows, size_t count, double *y);
    void smallest(double *rows, size_t count, double *y)
    {
      for (size_t i = 0; i < count; ++i) {
        double u[6][F_LANES];
        for (int k = 0; k < 6; ++k)
          u[k][0] = rows[6*i + (size_t)k];
        f_smallest_eigenvalue(1, u);
        y[i] = u[0][0];
      }
    }
    """
    file = CFile("f")
    source = file.standalone("#include <stddef.h>\n", c_code.smallest_eigenvalue(file) + wrapper)
    rows, y = matrices[:, [0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]].copy(), np.empty(len(matrices))
    library.compiled_library(source).smallest(_pointer(rows), ctypes.c_size_t(len(y)), _pointer(y))
    return y


@pytest.mark.parametrize("apart", [1.0, 1e-4, 1e-8, 1e-12, 0.0])
def test_the_smallest_eigenvalue_is_exact_also_where_two_meet(rng, apart):
    axes = np.linalg.qr(rng.normal(size=(3000, 3, 3)))[0]
    eigenvalues = rng.normal(size=(3000, 3))
    eigenvalues[:, 1] = eigenvalues[:, 0] + apart * eigenvalues[:, 1]
    eigenvalues[::7, 2] = eigenvalues[::7, 0]
    matrices = (
        10 ** rng.uniform(-8, 8, (3000, 1, 1)) * (axes * eigenvalues[:, None]) @ np.swapaxes(axes, 1, 2)
    )
    matrices[:3] = [np.zeros((3, 3)), np.ones((3, 3)), np.diag([1.0, 1.0, -1.0])]
    exact = np.linalg.eigvalsh(matrices)[:, 0]
    error = np.abs(smallest_eigenvalues(matrices) - exact)
    assert (error <= 2e-15 * np.linalg.norm(matrices, axis=(1, 2))).all()


HOSTILE = [
    "arm */ OUTSIDE /*",
    "arm *\n/ OUTSIDE",
    "a\u2028OUTSIDE\x85OUTSIDE",
    "arm *\\\n/ OUTSIDE ??/",
    "$name",
]


@pytest.mark.parametrize("text", HOSTILE, ids=ascii)
def test_no_card_breaks_out_of_the_comment(tmp_path, compiler, rng, text):
    network = feed_forward(rng, "identity")
    network.card = {"chain": text, text: 1}
    source = export.c_source(network, "network")
    _, code = source.split("*/", 1)
    assert code.startswith("\n#ifndef NETWORK_H\n")
    assert "OUTSIDE" not in code
    (tmp_path / "network.c").write_text(source, encoding="utf-8")
    compile_strictly(compiler, STRICT, "-c", tmp_path / "network.c", "-o", tmp_path / "network.o")


def test_a_file_says_what_it_is(rng):
    network = radial_basis(rng, CARRIED)
    network.card = {"chain": "uvms", "worst case": {"error": 0.01}}
    comment, _ = export.c_source(network, "kci").split("*/", 1)
    for said in (
        "Radial-basis network of 6 neurons, generated by dexterity.",
        "Sees the world's origin in the link after joint 6, and joints 7, 9, 10.",
        'chain: "uvms"',
        'worst case: {"error": 0.01}',
    ):
        assert said in comment


@pytest.mark.parametrize(
    "name", ["", "8neurons", "a-b", "a b", "é", "a;b", "_x", "int", "double", "class", "sin"]
)
def test_functions_need_a_name_in_c(rng, name):
    with pytest.raises(ValueError, match=r"^name is "):
        export.c_source(feed_forward(rng, "identity"), name)


# ---- JavaScript ------------------------------------------------------------------------------------

CALLER = """
import { readFileSync } from "node:fs";
const questions = JSON.parse(readFileSync(0, "utf8"));
const answers = {};
for (const [file, configurations] of Object.entries(questions)) {
  const { about, value } = await import(file);
  const results = configurations.map((q) => {
    try {
      return value(q.map((x) => (typeof x === "string" ? Number(x) : x)));
    } catch (error) {
      return `${error.name}: ${error.message}`;
    }
  });
  answers[file] = { about, results };
}
console.log(JSON.stringify(answers));
"""


def asked(folder: Path, questions: dict[str, tuple[str, list]]) -> dict[str, dict]:
    """Answers of modules, and what they say about themselves, by name."""
    (folder / "call.mjs").write_text(CALLER, encoding="utf-8")
    for i, (module, _) in enumerate(questions.values()):
        (folder / f"{i}.mjs").write_text(module, encoding="utf-8")
    asking = {f"./{i}.mjs": configurations for i, (_, configurations) in enumerate(questions.values())}
    run = subprocess.run(
        ["node", folder / "call.mjs"], input=json.dumps(asking), capture_output=True, text=True, check=False
    )
    assert (run.returncode, run.stderr) == (0, "")
    return dict(zip(questions, json.loads(run.stdout).values(), strict=True))


@needs_node
def test_javascript_has_the_values_of_torch(tmp_path, rng):
    q = 3 * random_configurations(rng, 40)
    questions = {name: (export.javascript_module(network), q.tolist()) for name, network in NETWORKS.items()}
    for name, answer in asked(tmp_path, questions).items():
        assert_allclose(answer["results"], NETWORKS[name](q).detach(), rtol=1e-12, atol=1e-12, err_msg=name)


@needs_node
def test_a_module_refuses_bad_input_and_says_what_it_is(tmp_path, rng):
    network = feed_forward(rng, "identity")
    network.card = {"chain": "</script> ` ${throwing} */ \u2028", "θ": [1, None]}
    bad = [[0] * 11, [0] * 11 + ["NaN"], ["Infinity"] * 12]
    answer = asked(tmp_path, {"network": (export.javascript_module(network), bad)})["network"]
    assert answer["about"] == {"joints": 12, "inputs": [4, 5, 7, 8, 10], "card": network.card}
    assert answer["results"] == [
        "RangeError: q has 11 joints, the chain has 12",
        *["RangeError: q is not finite: it holds NaN or an infinity"] * 2,
    ]


# ---- ONNX ------------------------------------------------------------------------------------------


def run_in_onnx(network: Network, q: torch.Tensor) -> np.ndarray:
    model = export.onnx_model(network).SerializeToString()
    session = onnxruntime.InferenceSession(model, providers=["CPUExecutionProvider"])
    (value,) = session.run(["value"], {"q": q.numpy()})
    return value


@EVERY
@pytest.mark.parametrize("rows", [1, 7, 1000])
def test_onnx_has_the_values_of_torch(rng, name, rows):
    q = 3 * random_configurations(rng, rows)
    value = run_in_onnx(NETWORKS[name], q)
    assert (value.shape, value.dtype) == ((rows,), np.float64)
    assert_allclose(value, NETWORKS[name](q).detach(), rtol=1e-12, atol=1e-12)


def test_a_model_is_a_file_with_the_card(tmp_path, rng):
    network = feed_forward(rng, "cone", CARRIED)
    network.card = {"chain": "uvms", "θ": [1, None]}
    export.save_onnx(network, tmp_path / "network.onnx")
    model = onnx.load(tmp_path / "network.onnx")
    assert [(entry.key, json.loads(entry.value)) for entry in model.metadata_props] == [
        ("card", network.card)
    ]
    assert [value.name for value in (*model.graph.input, *model.graph.output)] == ["q", "value"]
    content = (tmp_path / "network.onnx").read_bytes()
    export.save_onnx(network, tmp_path / "network.onnx")
    assert (tmp_path / "network.onnx").read_bytes() == content


def test_without_onnx_it_is_said_what_is_missing(rng, monkeypatch):
    monkeypatch.setitem(sys.modules, "onnx", None)
    with pytest.raises(
        ImportError, match=r"^ONNX models need the package onnx: pip install dexterity-study\[onnx\]"
    ):
        export.onnx_model(feed_forward(rng, "identity"))
