"""JavaScript modules of indices, run by node."""

import json
import math
import re
import shutil
import subprocess
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

import dexterity as dx
from dexterity import robots, symbolic
from dexterity.codegen.javascript import literal
from dexterity.indices import Index
from dexterity.symbolic import SymbolicChain

W, KCI = "manipulability", "kinematic_conditioning"
UVMS, PUMA, ARM = dx.robots.uvms(), dx.robots.puma560(), dx.robots.docking_arm()
GANTRY = dx.Chain(np.eye(6), np.eye(4), name="gantry")  # three slides, three axes through the tool point

needs_node = pytest.mark.skipif(shutil.which("node") is None, reason="node is not installed")
both_indices = pytest.mark.parametrize("name", [W, KCI])

CALLER = """
import { readFileSync } from "node:fs";
import { about, value } from "./index.mjs";

const results = JSON.parse(readFileSync(0, "utf8")).map((q) => {
  try {
    return value(q === null ? q : q.map((x) => (typeof x === "string" ? Number(x) : x)));
  } catch (error) {
    return { error: error.name, message: error.message };
  }
});
console.log(JSON.stringify({ about, results }));
"""


@cache
def module_of(chain: dx.Chain, index: Index) -> str:
    return symbolic.javascript_module(symbolic.derive(chain, index))


def called(folder: Path, module: str, configurations: list[Any]) -> dict[str, Any]:
    """What the module says about itself, and its value, or error, at each configuration.

    JSON knows neither NaN nor infinities, so they are passed as strings.
    """
    (folder / "index.mjs").write_text(module, encoding="utf-8")
    (folder / "call.mjs").write_text(CALLER, encoding="utf-8")
    run = subprocess.run(
        ["node", folder / "call.mjs"],
        input=json.dumps(configurations, allow_nan=False),
        capture_output=True,
        text=True,
        check=False,
    )
    assert (run.returncode, run.stderr) == (0, "")
    return json.loads(run.stdout)


@needs_node
@pytest.mark.parametrize(
    ("chain", "index"),
    [
        (PUMA, Index(W)),
        (PUMA, Index(KCI, "body", (0.3, 1.0, 0.7, 2.0, 1.0, 3.0), (0.5, 1.0, 0.7, 2.0, 1.0, 3.0))),
        (ARM, Index(KCI, "geometric")),
        (UVMS, Index(W)),
        (UVMS, Index(KCI)),
        (GANTRY, Index(KCI, "body")),
    ],
    ids=["puma w", "puma", "docking arm", "uvms w", "uvms", "gantry"],
)
def test_values_are_those_of_the_plain_computation(tmp_path, rng, chain, index):
    q = rng.uniform(-3, 3, (200, chain.joints))
    q[:20] *= rng.integers(0, 2, (20, chain.joints))
    q[0] = 0
    values = called(tmp_path, module_of(chain, index), q.tolist())["results"]
    assert_allclose(values, index.bind(chain)(q), rtol=1e-11, atol=1e-14)


@needs_node
@pytest.mark.parametrize(
    "index",
    [
        Index("smallest_singular_value", "geometric"),
        Index("isotropy", "geometric", rows="translational"),
        Index("log_manipulability"),
        Index(KCI, "geometric", rows=("vx", "wz")),
        Index("guaranteed_speed", "geometric", rows="translational"),
        Index("dynamic_manipulability", "geometric"),
    ],
    ids=lambda index: index.name,
)
def test_every_recorded_measure_is_written(tmp_path, rng, index):
    q, chain = rng.uniform(-1.5, 1.5, (50, 6)), robots.ur5e() if "inertias" in index.measure.needs else PUMA
    values = called(tmp_path, module_of(chain, index), q.tolist())["results"]
    assert_allclose(values, index.bind(chain)(q), rtol=1e-10, atol=1e-14)


@needs_node
@both_indices
@pytest.mark.parametrize("size", [9e4, 1e9, 1e15])
def test_angles_of_any_size_keep_their_digits(tmp_path, rng, name, size):
    """faults.md, 6: sums of large angles lost their digits before the sine."""
    q = rng.uniform(-1, 1, (50, 6)) * size
    values = called(tmp_path, module_of(PUMA, Index(name)), q.tolist())["results"]
    assert_allclose(values, Index(name).bind(PUMA)(q), rtol=0, atol=5e-15)


def test_what_is_not_recorded_is_refused_by_name():
    with pytest.raises(ValueError, match=r"^guaranteed_speed is not recorded as a program: .* 792 facets"):
        symbolic.javascript_module(symbolic.derive(UVMS, Index("guaranteed_speed")))


@needs_node
def test_a_description_can_hold_any_key_and_no_end_of_a_script(tmp_path):
    """faults.md, 32: a key set the prototype of ``about``."""
    about = {"__proto__": {"a": 1}, 'x"__proto__': 2, "y": '"__proto__": </script>'}
    text = literal(about)
    assert "</script" not in text
    (tmp_path / "says.mjs").write_text(f"console.log(JSON.stringify(Object.entries({text})));\n")
    run = subprocess.run(["node", tmp_path / "says.mjs"], capture_output=True, text=True, check=True)
    assert dict(json.loads(run.stdout)) == about
    with pytest.raises(ValueError, match="not JSON compliant"):
        literal({"a": math.inf})


@needs_node
@both_indices
def test_bad_input_is_a_range_error(tmp_path, name):
    bad = {
        "too few": ([0.0] * 5, "q has 5 joints, the chain has 6"),
        "too many": ([0.0] * 7, "q has 7 joints, the chain has 6"),
        "none": ([], "q has 0 joints, the chain has 6"),
        "NaN": ([0, 0, "NaN", 0, 0, 0], "q is not finite: it holds NaN or an infinity"),
        "infinity": ([0, 0, 0, 0, 0, "Infinity"], "q is not finite: it holds NaN or an infinity"),
        "minus infinity": (["-Infinity", 0, 0, 0, 0, 0], "q is not finite: it holds NaN or an infinity"),
        "no number": ([None] * 6, "q is not finite: it holds NaN or an infinity"),
    }
    results = called(tmp_path, module_of(PUMA, Index(name)), [q for q, _ in bad.values()])["results"]
    for result, (_, message) in zip(results, bad.values(), strict=True):
        assert result == {"error": "RangeError", "message": message}


@needs_node
def test_a_module_says_what_it_computes(tmp_path):
    about = called(tmp_path, module_of(UVMS, Index(KCI, "body")), [])["about"]
    assert about == {
        "chain": UVMS.name,
        "index": KCI,
        "frame": "body",
        "joints": list(UVMS.joint_names),
        "matters": [5, 6, 7, 8, 9, 10, 11],
    }


def test_a_module_exports_two_names_and_imports_nothing():
    module = module_of(PUMA, Index(KCI))
    exports = [line.split("(")[0] for line in module.splitlines() if line.startswith("export")]
    assert exports == ["export const about = {", "export function value"]
    assert "import" not in module
    assert module.startswith("// Kinematic conditioning index, KCI of puma560")


@needs_node
@pytest.mark.parametrize(
    "chain_name",
    [
        "arm */ throw 1; /*",
        "arm \\",
        'arm "; throw 1; "',
        "arm ${throwing} $joints `",
        "</script><script>throw 1",
        "\\" * 300,
        "θ 腕",
    ],
    ids=ascii,
)
def test_no_name_breaks_out_of_a_comment_or_a_string(tmp_path, chain_name):
    derivation = symbolic.derive(PUMA, Index(W))
    names = tuple(f"{chain_name} {i}" for i in range(6))
    module = symbolic.javascript_module(
        replace(derivation, chain=replace(derivation.chain, name=chain_name, joint_names=names))
    )
    answer = called(tmp_path, module, [[0.0] * 6])
    assert answer["results"] == pytest.approx([float(Index(W).bind(PUMA)([0.0] * 6))])
    assert answer["about"]["chain"] == chain_name
    assert answer["about"]["joints"] == list(names)
    heading = module.split("export", 1)[0]
    assert all(line.startswith("//") for line in heading.splitlines() if line)


@both_indices
def test_a_chain_that_cannot_be_computed_has_no_module(name):
    short = dx.Chain.from_dh([{"a": 1}] * 5, name="short arm")
    with pytest.raises(ValueError, match=r"^short arm has 5 joints"):
        symbolic.javascript_module(symbolic.derive(short, Index(name)))
    open_lengths = SymbolicChain.from_description(robots.describe("docking_arm"))
    with pytest.raises(ValueError, match=r"^docking_arm has lengths without a value"):
        symbolic.javascript_module(symbolic.derive(open_lengths, Index(name)))


def test_numbers_keep_all_their_digits():
    rates = (1 / 3, 1 / 7, math.pi, math.sqrt(2) / 10, 1e-3 / 9, 1.0)
    module = module_of(PUMA, Index(KCI, "spatial", rates))
    numbers = {float(number) for number in re.findall(r"[0-9]+\.[0-9]+(?:e[+-]?[0-9]+)?", module)}
    assert numbers >= set(rates)


@needs_node
@both_indices
def test_values_are_finite_up_to_the_length_that_the_book_states(tmp_path, name):
    q = [[size, -size, size, *np.linspace(0.1, 0.9, 9)] for size in (1e6, 1e25, 1e50)]
    assert np.isfinite(called(tmp_path, module_of(UVMS, Index(name)), q)["results"]).all()
