"""Torch's defaults belong to the caller: no default type or device changes an answer or breaks a call."""

import contextlib

import numpy as np
import pytest
import torch

import dexterity as dx
from dexterity import sobol
from warm_process import WarmProcess

Q = [0.5, -0.7, 0.6, -2.3, 0.3, 1.7, 0.5]


@contextlib.contextmanager
def default_type(dtype):
    given = torch.get_default_dtype()
    torch.set_default_dtype(dtype)
    try:
        yield
    finally:
        torch.set_default_dtype(given)


@contextlib.contextmanager
def default_device(device):
    torch.set_default_device(device)
    try:
        yield
    finally:
        torch.set_default_device(None)


def answers():
    """What draws points, searches or descends."""
    # Built here: what load returns may have been built before.
    panda, puma = (dx.robots.build(dx.robots.describe(name)) for name in ("panda", "puma560"))
    index = dx.Index("w", "geometric")
    return {
        "points": sobol.points(3, 4, seed=1),
        "draws": dx.sampling.sobol(dx.sampling.Box.from_chain(puma), 4, 1),
        "configurations": dx.inverse_kinematics.solve(panda, panda.forward(Q), seeds=4).q,
        "extreme": torch.tensor(
            dx.search.extremes(index, puma, samples=64, starts=2, steps=5).highest.q, dtype=torch.float64
        ),
        "ranked": dx.tasks.rank(panda, [Q, [0.1] * 7], "welding").values,
    }


@pytest.mark.parametrize("dtype", [torch.float16, torch.bfloat16, torch.float64])
def test_default_types_change_no_answer(dtype):
    expected = answers()
    with default_type(dtype):
        found = answers()
        assert torch.get_default_dtype() is dtype
    for name, value in expected.items():
        assert found[name].dtype == torch.float64
        assert torch.equal(found[name], value), name


def test_default_device_mixes_with_nothing():
    """Of the kind of pytorch_kinematics#39; the device meta, which holds no values, shows any mixture."""
    puma, panda = dx.robots.puma560(), dx.robots.panda()
    q = torch.tensor(Q, dtype=torch.float64)
    best = dx.search.extremes(dx.Index("w"), puma, samples=64, starts=2, steps=2)
    gradient, target = np.linspace(-1, 1, 7), puma.forward(q[None, :6] + 0.1)
    moved = dx.inverse_kinematics.null_space_step(panda, q, gradient)
    with default_device("meta"):
        again = dx.search.extremes(dx.Index("w"), puma, samples=64, starts=2, steps=2)
        assert again.highest.q == best.highest.q
        assert torch.equal(dx.inverse_kinematics.null_space_step(panda, q, gradient), moved)
        end, miss = dx.descent.descend(puma, target, q[None, :6])
        assert end.is_cpu
        assert miss.is_cpu


MANY = """
import torch
import dexterity as dx
panda, q = dx.robots.panda(), torch.tensor([[0.5, -0.7, 0.6, -2.3, 0.3, 1.7, 0.5]], dtype=torch.float64)
names = [name for name in dx.indices.names() if not dx.indices.describe(name).needs & {"inertias"}]
for name in names:
    needs = dx.indices.describe(name).needs
    index = dx.Index(name, "geometric", direction="vz" if "direction" in needs else None)
    compiled = torch.compile(index.bind(panda), fullgraph=True, backend="eager")
    assert torch.allclose(compiled(q), index(panda, q), rtol=1e-12, atol=0), name
"""


def test_torch_compiles_as_many_indices_as_there_are():
    """torch.compile gives up after eight variants of one function."""
    # Apart from the tests' checks of types, which torch does not trace.
    ended, printed = WarmProcess(MANY).end()
    assert ended == 0, printed[-2000:]


def test_drawing_points_changes_no_default_of_the_process(monkeypatch):
    """Another thread would see it."""
    monkeypatch.setattr(torch, "set_default_dtype", None)
    assert sobol.points(3, 4, seed=1).dtype == torch.float64
