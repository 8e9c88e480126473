"""Functions of an ECMAScript module called by node."""

import json
import shutil
import subprocess
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest

needs_node = pytest.mark.skipif(shutil.which("node") is None, reason="node is not installed")

_CALLER = """
import { readFileSync } from "node:fs";
import * as own from "./own.mjs";

const results = JSON.parse(readFileSync(0, "utf8")).map(([name, input]) => {
  try {
    return own[name](input);
  } catch (error) {
    return { error: error.name, message: error.message };
  }
});
// JSON has no NaN.
console.log(JSON.stringify(results, (_, value) => (Number.isNaN(value) ? "NaN" : value)));
"""


def call(folder: Path, module: str, calls: Sequence[tuple[str, Any]]) -> list[Any]:
    """What functions of a module return for inputs, or the errors that they throw."""
    (folder / "own.mjs").write_text(module, encoding="utf-8")
    (folder / "call.mjs").write_text(_CALLER, encoding="utf-8")
    run = subprocess.run(
        ["node", folder / "call.mjs"],
        input=json.dumps(calls, allow_nan=False),
        capture_output=True,
        text=True,
        check=False,
    )
    assert (run.returncode, run.stderr) == (0, "")
    return json.loads(run.stdout)


def call_all(folder: Path, module: str, name: str, inputs: Sequence[Any]) -> list[Any]:
    """What one function of a module returns for each of several inputs."""
    return call(folder, module, [(name, one) for one in inputs])
