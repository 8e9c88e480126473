"""Extremes of indices against closed forms and scipy, and of kinds that no grid can search."""

import math

import numpy as np
import pytest
import torch
from scipy.optimize import minimize
from torch.testing import assert_close

import dexterity as dx
from dexterity.ascent import climb, corners
from dexterity.search import extremes

PANDA = dx.robots.load("panda")
W = dx.indices.Index("manipulability")
KCI = dx.indices.Index("kinematic_conditioning", "geometric")
SCARA = dx.Chain.from_dh(
    [{"a": 0.3}, {"a": 0.25, "alpha": math.pi}, {"kind": "prismatic"}, {}],
    lower=[-2.5, -2.5, 0, -3], upper=[2.5, 2.5, 0.2, 3],
)  # fmt: skip


@pytest.mark.parametrize("engine", ["bound", "compiled"])
def test_the_extremes_of_w_of_a_panda(engine):
    """22.83 is what an engineer's review found by L-BFGS-B from eight starts."""
    f = W.bind(PANDA) if engine == "bound" else dx.symbolic.compile_index(PANDA, W)
    found = extremes(f, PANDA, samples=4096, starts=16)
    assert found.highest.value == pytest.approx(22.8288, abs=1e-4)
    assert 0 <= found.lowest.value < 1e-9
    for extreme in (found.lowest, found.highest):
        assert f(extreme.q).item() == pytest.approx(extreme.value, rel=1e-9, abs=1e-15)
        assert dx.inverse_kinematics.within_limits(PANDA, extreme.q)
        assert len(extreme.reached) == 16
        assert extreme.reached[0] == extreme.value
    assert found.lowest.sampled > found.lowest.value
    assert found.highest.sampled < found.highest.value
    assert found.evaluations == 4096 + 2**7 + 2 * 16 * 101


def test_the_singularity_of_kci_is_found_with_few_evaluations():
    found = extremes(KCI, PANDA)
    # Grids needed 188 680 980.
    assert found.evaluations < 16_000
    assert found.lowest.value < 1e-10
    assert found.highest.value > 0.124


def test_closed_form_of_four_joints():
    index = dx.indices.Index("manipulability", "geometric", rows=("vx", "vy", "vz", "wz"))
    found = extremes(index, SCARA, samples=256, starts=8)
    assert found.highest.value == pytest.approx(0.3 * 0.25, rel=1e-9)
    assert abs(found.highest.q[1]) == pytest.approx(math.pi / 2, abs=1e-3)
    assert found.lowest.value < 1e-9


def test_twelve_joints():
    f = dx.symbolic.compile_index(dx.robots.uvms(), W)
    box = dx.sampling.Box([-0.5] * 12, [0.5] * 12)
    found = extremes(f, box, samples=4096, starts=8, steps=60)

    def negative(q):
        value, gradient = f.value_and_gradient(q)
        return -float(value), -gradient.numpy()

    best = min(
        (
            minimize(negative, start, jac=True, bounds=[(-0.5, 0.5)] * 12).fun
            for start in np.eye(12)[:4] * 0.3
        ),
    )
    assert found.highest.value >= -best * (1 - 1e-6)


def test_an_infinite_value_is_infinite():
    def log_radius(q):
        return q.norm(dim=-1).log()

    found = extremes(log_radius, dx.sampling.Box([-1.0, 0.0], [1.0, 2.0]), samples=64, starts=4)
    assert found.highest.value == pytest.approx(math.log(math.sqrt(5)))
    held = extremes(lambda q: (q[..., 0]).log(), dx.sampling.Box([0.0], [1.0]), samples=4, starts=2)
    assert held.lowest.value == -math.inf


def test_the_same_seed_finds_the_same():
    first, again = (extremes(W, PANDA, samples=128, starts=4, steps=10, seed=3) for _ in range(2))
    assert first == again
    assert extremes(W, PANDA, samples=128, starts=4, steps=10, seed=4) != first


def test_inference_mode_changes_nothing():
    w = W.bind(PANDA)
    expected = extremes(w, PANDA, samples=64, starts=2, steps=5)
    with torch.inference_mode():
        assert extremes(w, PANDA, samples=64, starts=2, steps=5) == expected


def test_sectors_are_searched_too():
    space = dx.sampling.uvms_space("manipulability")
    found = extremes(W.bind(dx.robots.uvms()), space, samples=128, starts=4, steps=10)
    assert space.contains(torch.tensor([found.highest.q, found.lowest.q], dtype=torch.float64)).all()


@pytest.mark.parametrize(
    ("options", "error", "message"),
    [
        ({"samples": 0}, ValueError, "^samples is 0"),
        ({"starts": 2.5}, TypeError, "^starts is 2.5"),
        ({"steps": math.nan}, TypeError, "^steps is nan"),
        ({"seed": -1}, ValueError, "^seed is -1"),
        ({"f": 3}, TypeError, "^f is 3"),
        ({"f": lambda q: q}, ValueError, r"^f\(q\) has shape"),
        ({"f": lambda q: q.sum(-1) * math.nan}, ValueError, r"^f\(q\) holds NaN"),
        ({"f": lambda q: q.sum(-1).detach()}, ValueError, "^f cannot be differentiated"),
        ({"space": dx.sampling.Box([0.0] * 7, [1.0] * 7)}, TypeError, "^f is Index"),
        ({"space": dx.robots.uvms()}, ValueError, "^chain has unlimited joints"),
        ({"space": [0, 1]}, TypeError, "^(f|space) is"),
    ],
)
def test_bad_arguments_are_refused_by_name(options, error, message, annotations_unchecked):
    f, space = options.pop("f", W), options.pop("space", PANDA)
    with pytest.raises(error, match=message):
        extremes(f, space, **{"samples": 8, "starts": 2, "steps": 2} | options)


# ---- ascent ------------------------------------------------------------------------------------------------


def test_a_name_is_no_index_and_the_error_says_what_is(annotations_unchecked):
    with pytest.raises(TypeError, match=r"^f is 'w'; an index is needed, such as dexterity.Index\('w', "):
        extremes("w", PANDA)


def test_points_stay_in_the_cube_and_keep_the_best():
    def ridge(u):
        return u[:, 0] - (u[:, 1] - 0.4).abs(), torch.stack([torch.ones(len(u)), -(u[:, 1] - 0.4).sign()], 1)

    u = torch.rand(20, 2, generator=torch.Generator().manual_seed(0), dtype=torch.float64)
    tops, heights = climb(lambda u: tuple(x.double() for x in ridge(u)), u, 80)
    assert_close(heights, torch.ones(20, dtype=torch.float64), rtol=0, atol=1e-3)
    assert ((tops >= 0) & (tops <= 1)).all()


def test_corners_are_all_or_random():
    assert len(corners(3, 8, 0).unique(dim=0)) == 8
    some = corners(30, 16, 0)
    assert some.shape == (16, 30)
    assert set(some.unique().tolist()) == {0.0, 1.0}
