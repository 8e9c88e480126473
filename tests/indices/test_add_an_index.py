"""The section "Add an index" of CONTRIBUTING.md, followed literally."""

import re
import shutil
import sys
from pathlib import Path

import pytest
import torch
from torch.testing import assert_close

import dexterity as dx
from dexterity import indices, symbolic, tasks
from dexterity.indices import Index, measures

CONTRIBUTING = Path(__file__).parents[2] / "CONTRIBUTING.md"
PUMA = dx.robots.puma560()


@pytest.fixture(scope="module")
def name(tmp_path_factory):
    """Name of the measure that the section adds, from its code in a folder of its own."""
    section = CONTRIBUTING.read_text(encoding="utf-8").partition("## Add an index\n")[2].partition("\n## ")[0]
    (code,) = re.findall(r"```python\n(.*?)```", section, re.DOTALL)
    folder = tmp_path_factory.mktemp("measures")
    (folder / "mean_speed.py").write_text(code, encoding="utf-8")
    measures.__path__.append(str(folder))
    yield "mean_speed"
    measures.__path__.remove(str(folder))
    sys.modules.pop("dexterity.indices.measures.mean_speed", None)


@pytest.fixture
def q() -> torch.Tensor:
    return 2 * torch.rand(20, 6, generator=torch.Generator().manual_seed(1), dtype=torch.float64) - 1


def test_it_is_found_and_described(name):
    assert name in indices.names()
    assert indices.describe("rms_singular_value").name == name
    assert Index(name, "geometric").title.startswith("Mean speed")


def test_it_is_bound(name, q):
    sigma = torch.linalg.svdvals(PUMA.geometric_jacobian(q)[:, :3])
    value = Index(name, "geometric", rows="translational")(PUMA, q)
    assert_close(value, sigma.square().mean(-1).sqrt(), rtol=1e-12, atol=0)


@pytest.mark.parametrize("rows", ["full", "translational"])
@pytest.mark.parametrize("backend", ["torch", "c"])
def test_it_is_compiled_and_differentiated(name, q, rows, backend, monkeypatch, tmp_path):
    if backend == "c" and not shutil.which("cc"):
        pytest.skip("there is no C compiler")
    monkeypatch.setenv("DEXTERITY_CACHE", str(tmp_path))
    index = Index(name, "geometric", rows=rows, tool_rates=(0.5,) * 3 + (2.0,) * 3)
    value, gradient = symbolic.compile_index(PUMA, index, backend).value_and_gradient(q)
    q.requires_grad_()
    plain = index(PUMA, q)
    (expected,) = torch.autograd.grad(plain.sum(), q)
    assert_close(value, plain.detach(), rtol=1e-12, atol=0)
    assert_close(gradient, expected, rtol=1e-9, atol=1e-12)


def test_it_ranks(name, q):
    ranking = tasks.rank(PUMA, q, name)
    assert (ranking.values[ranking.order].diff() <= 0).all()
    assert "twice the tool speed on average" in ranking.explain()


def test_two_measures_of_one_name_are_refused(name, tmp_path):
    (tmp_path / "mean_speed_again.py").write_text(
        "from dexterity.indices.measures.manipulability import MEASURE as W\n"
        "import dataclasses\n"
        f"MEASURE = dataclasses.replace(W, name={name!r})\n"
    )
    measures.__path__.append(str(tmp_path))
    try:
        with pytest.raises(ValueError, match=f"two measures are called '{name}'"):
            indices.names()
    finally:
        measures.__path__.remove(str(tmp_path))
        sys.modules.pop("dexterity.indices.measures.mean_speed_again", None)
