"""ECMAScript modules run by node: their exported functions called with arguments, one after the other."""

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
import * as module from "./module.mjs";

const { name, calls } = JSON.parse(readFileSync(0, "utf8"));
const number = (value) => (typeof value === "string" ? Number(value) : value);
const numbers = (value) => (Array.isArray(value) ? value.map(numbers) : number(value));
const texts = (value) => (Array.isArray(value) ? value.map(texts) : Number.isNaN(value) ? "NaN" : value);
const answers = calls.map((call) => {
  try {
    return texts(module[name](...call.map(numbers)));
  } catch (error) {
    return { error: error.name, message: error.message };
  }
});
console.log(JSON.stringify({ about: module.about, answers }));
"""


def called(folder: Path, source: str, name: str, calls: Sequence[Sequence[Any]]) -> list[Any]:
    """Answer of a module's function to each call; texts stand for NaN and infinities, as JSON has none."""
    (folder / "module.mjs").write_text(source, encoding="utf-8")
    (folder / "call.mjs").write_text(_CALLER, encoding="utf-8")
    run = subprocess.run(
        ["node", folder / "call.mjs"],
        input=json.dumps({"name": name, "calls": calls}, allow_nan=False),
        capture_output=True,
        text=True,
        check=False,
    )
    assert (run.returncode, run.stderr) == (0, "")
    return json.loads(run.stdout)["answers"]
