"""Distances of bodies against coal, by torch and in C; derivatives; which pairs count; bad input."""

import math
import shutil
import subprocess
from functools import cache

import numpy as np
import pytest
import torch
from torch.testing import assert_close

import dexterity as dx
from coal_distances import coal_distances
from dexterity import collision, spatial
from dexterity.collision import Bodies, Body, Box, Capsule, Sphere, c_source, capsules, in_c
from dexterity.collision.distances import box_box, segment_box, segment_segment

ARM = dx.robots.docking_arm()
BLOCK = Body(Box((2, 2, 2), centre=(0, 0, -1)), "world", "block")
VEHICLE = Body(Box((1.5, 1.2, 1.0), centre=(-0.8, 0, 0.3)), 0, "vehicle")
ROTATION = spatial.exp([0, 0, 0, 0.3, -0.5, 0.7])[:3, :3].tolist()
GRIPPER = Body(Box((0.1, 0.2, 0.15), centre=(0.8, 0, 0.1), rotation=ROTATION), 6, "gripper")
BUOY = Body(Sphere((0.4, 0.5, 0.3), 0.1), "world", "buoy")
LINKS = capsules(ARM, 0.04, hand=0.1, along=(1, 0, 0))


@cache
def docked() -> Bodies:
    return Bodies(ARM, [*LINKS, VEHICLE, BLOCK])


@cache
def of_all_kinds() -> Bodies:
    return Bodies(ARM, [*LINKS, VEHICLE, GRIPPER, BUOY, BLOCK])


def generator(seed: int = 0) -> torch.Generator:
    return torch.Generator().manual_seed(seed)


def drawn(*batch: int, seed: int = 0) -> tuple[torch.Tensor, torch.Tensor]:
    """Configurations, and poses of the base about the block."""
    unit = 2 * torch.rand(*batch, 12, generator=generator(seed), dtype=torch.float64) - 1
    poses = unit[..., 6:] * torch.tensor([1, 1, 0.6, 0.5, 0.5, 3], dtype=torch.float64)
    return 3 * unit[..., :6], dx.docking.base_pose(poses)


# ---- distances against coal ------------------------------------------------------------------------


def test_clearances_of_20_000_configurations_are_those_of_coal():
    q, T = drawn(20_000)
    bodies = in_c(docked())
    expected = coal_distances(docked(), q, T).min(1)
    clearance, collide = bodies.clearance(q, T), bodies.collides(q, T)
    np.testing.assert_allclose(clearance, expected, rtol=0, atol=1e-12)
    assert torch.equal(collide, clearance < -collision.TOUCH)
    assert 0.2 < collide.double().mean() < 0.95


def test_the_distance_of_each_pair_is_that_of_coal():
    q, T = drawn(800, seed=1)
    expected = coal_distances(of_all_kinds(), q, T)
    np.testing.assert_allclose(of_all_kinds().distances(q, T), expected, rtol=0, atol=1e-12)
    # Each pair is seen apart, and all kinds of pairs overlapping.
    assert (expected.max(0) > 0.005).all()
    assert (expected.min(0) < -0.03).sum() >= 18


@pytest.mark.parametrize("chain", [dx.robots.uvms(), dx.robots.panda()], ids=["UVMS", "Panda"])
def test_other_chains(chain):
    buoy = Body(Sphere((0.5, 0.5, 0.5), 0.2), "world", "buoy")
    bodies = Bodies(chain, [*capsules(chain, 0.03), buoy])
    q = 2 * torch.rand(300, chain.joints, generator=generator(), dtype=torch.float64) - 1
    T = torch.eye(4, dtype=torch.float64).expand(300, 4, 4)
    expected = coal_distances(bodies, q, T)
    np.testing.assert_allclose(bodies.distances(q), expected, rtol=0, atol=1e-12)
    assert_close(in_c(bodies).clearance(q), torch.tensor(expected.min(1)), rtol=0, atol=1e-12)


def test_torch_and_c_say_the_same_of_every_batch(batch_shape):
    q, T = drawn(*batch_shape)
    compiled = in_c(of_all_kinds())
    clearance = of_all_kinds().clearance(q, T)
    assert clearance.shape == compiled.clearance(q, T).shape == batch_shape
    assert_close(compiled.clearance(q, T), clearance, rtol=0, atol=1e-13)
    for margin in (0.0, 0.1):
        assert torch.equal(compiled.collides(q, T, margin), of_all_kinds().collides(q, T, margin))
    assert of_all_kinds().distances(q, T[..., :1, :, :] if batch_shape else T).shape[:-1] == batch_shape


# ---- distances by hand -----------------------------------------------------------------------------


def rows(*values):
    return torch.tensor(values, dtype=torch.float64)


@pytest.mark.parametrize(
    ("q", "e", "distance"),
    [
        ((0.5, 1, 0), (0, 1, 0), 1.0),  # its end above the middle
        ((0.5, -1, 0.2), (0, 2, 0), 0.2),  # crossing
        ((2, 0, 0), (1, 0, 0), 1.0),  # one behind the other
        ((-1, 0.3, 0), (5, 0, 0), 0.3),  # parallel, beside
        ((0, 0.3, 0), (1, 1e-9, 0), 0.3),  # almost parallel
        ((0, 3, 4), (0, 0, 0), 5.0),  # a point
    ],
)
def test_lines(q, e, distance):
    p, d = rows(0, 0, 0), rows(1, 0, 0)
    q, e = rows(*q), rows(*e)
    assert float(segment_segment(p, d, q, e)) == pytest.approx(distance, abs=1e-9)
    assert float(segment_segment(q, e, p, d)) == pytest.approx(distance, abs=1e-9)


@pytest.mark.parametrize(
    ("start", "end", "distance"),
    [
        ((2, 0, 0), (3, 0, 0), 1.0),  # in front of a face
        ((2, 2, -5), (2, 2, 5), math.sqrt(2)),  # along an edge
        ((2, 2, 2), (2, 2, 2), math.sqrt(3)),  # a point off a corner
        ((-3, 2, 0), (3, 2, 0), 1.0),  # along a face
        ((3, 0, 0), (0, 3, 0), 1 / math.sqrt(2)),  # across an edge
        ((0.5, 0, 0), (0.9, 0, 0), -0.5),  # inside, nearest to +x
        ((-5, 0, 0), (5, 0, 0), -1.0),  # right through
        ((0.9, 3, 0), (3, 0.9, 0), -0.0),  # in front of an edge, see below
        ((1, -3, 0), (1, 3, 0), 0.0),  # touching a face
    ],
)
def test_a_line_and_a_box(start, end, distance):
    start, end, half = rows(*start), rows(*end), rows(1, 1, 1)
    if distance == 0 and float(start[0]) == 0.9:
        distance = (3.9 - 2) / math.sqrt(2)
    assert float(segment_box(start, end - start, half)) == pytest.approx(distance, abs=1e-12)
    assert float(segment_box(end, start - end, half)) == pytest.approx(distance, abs=1e-12)


def test_boxes():
    eye, half = torch.eye(3, dtype=torch.float64), rows(1, 1, 1)
    assert float(box_box(eye, rows(3, 0, 0), half, half)) == 1.0
    assert float(box_box(eye, rows(3, 3, 0), half, half)) == pytest.approx(math.sqrt(2))
    assert float(box_box(eye, rows(1.5, 0, 0), half, half)) == -0.5
    turned = spatial.exp([0, 0, 0, 0, 0, math.pi / 4])[:3, :3]
    assert float(box_box(turned, rows(3, 0, 0), half, half)) == pytest.approx(2 - math.sqrt(2))


# ---- derivatives -----------------------------------------------------------------------------------


def test_derivatives_are_those_of_finite_differences():
    """Each pair by itself, at configurations where it is smooth."""
    bodies, step = of_all_kinds(), 1e-6
    q, T = drawn(20, seed=2)
    q_there = q.clone().requires_grad_()
    distances = bodies.distances(q_there, T)
    found = torch.stack(
        [torch.autograd.grad(one.sum(), q_there, retain_graph=True)[0] for one in distances.unbind(1)], dim=1
    )
    moves = step * torch.eye(6, dtype=torch.float64)[:, None]
    by_differences = (bodies.distances(q + moves, T) - bodies.distances(q - moves, T)) / (2 * step)
    assert found.isfinite().all()
    assert ((found - by_differences.permute(1, 2, 0)).abs() < 1e-6).double().mean() > 0.99


def test_bodies_that_touch_have_finite_derivatives():
    q = torch.zeros(6, dtype=torch.float64, requires_grad=True)
    line = Body(Capsule((1.0, 0, 0), (1.0, 0, 1), 0.0), "world", "line")
    clearance = Bodies(ARM, [*capsules(ARM, 0.0, hand=0.2, along=(1, 0, 0)), line]).clearance(q)
    (slope,) = torch.autograd.grad(clearance, q)
    assert clearance == 0
    assert slope.isfinite().all()


# ---- which pairs, and what is refused --------------------------------------------------------------


def test_neighbours_are_not_looked_at():
    assert ("link 1", "link 2") not in docked().pairs
    assert ("link 4", "hand") not in docked().pairs  # link 5 in between carries no body
    assert ("link 1", "vehicle") not in docked().pairs
    assert {("link 2", "vehicle"), ("hand", "block"), ("vehicle", "block")} <= set(docked().pairs)
    fewer = Bodies(ARM, [*LINKS, VEHICLE, BLOCK], excluded=[("block", "hand")])
    assert set(docked().pairs) - set(fewer.pairs) == {("hand", "block")}


def test_links_and_hand():
    assert [body.name for body in LINKS] == ["link 1", "link 2", "link 4", "hand"]
    assert LINKS[-1].shape == Capsule((0.8, 0.0, 0.1), (0.9, 0.0, 0.1), 0.04)
    fitted = capsules(dx.robots.docking_arm("fitted"), 0.0)
    lengths = [np.linalg.norm(np.subtract(body.shape.end, body.shape.start)) for body in fitted]
    assert lengths == pytest.approx([0.1, 0.425, 0.05, 0.425])


def test_touching_is_no_collision():
    ball = Bodies(ARM, [*capsules(ARM, 0.1), Body(Sphere((1.1, 0, 0.1), 0.2), "world", "ball")])
    assert float(ball.clearance([0.0] * 6)) == pytest.approx(0, abs=1e-15)
    for bodies in (ball, in_c(ball)):
        assert not bodies.collides([0.0] * 6)
        assert bodies.collides([0.0] * 6, margin=1e-6)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Sphere((0, 0, 0), -0.1), r"radius is -0\.1"),
        (lambda: Sphere((0, 0, 0), math.nan), "radius is nan"),
        (lambda: Capsule((0, 0, 0), (0, 0, math.inf), 0.1), "end is inf"),
        (lambda: Capsule((0, 0), (0, 0, 1), 0.1), "start is"),
        (lambda: Box((1, 0, 1)), "size is 0"),
        (lambda: Box((1, 1, 1), rotation=2 * np.eye(3)), "rotation"),
        (lambda: Body(Sphere((0, 0, 0), 0.1), -1, "ball"), "link is -1"),
        (lambda: Body(Sphere((0, 0, 0), 0.1), "wrold", "ball"), "did you mean 'world'"),
        (lambda: Body(Sphere((0, 0, 0), 0.1), 1, " "), "name is"),
        (lambda: capsules(ARM, -0.1), r"radius is -0\.1"),
        (lambda: capsules(ARM, math.nan), "radius is nan"),
        (lambda: capsules(ARM, 0.1, hand=1.0), "hand is 1 m; all links together have 0.9 m"),
        (lambda: capsules(ARM, 0.1, hand=0.1, along=(0, 0, 0)), "along is"),
        (lambda: Bodies(ARM, []), "bodies is empty"),
        (lambda: Bodies(ARM, [VEHICLE]), "bodies leaves no pair"),
        (lambda: Bodies(ARM, [VEHICLE, VEHICLE]), "more than once"),
        (lambda: Bodies(ARM, [Body(Sphere((0, 0, 0), 0.1), 7, "ball")]), "has links 0 to 6"),
        (lambda: Bodies(ARM, [*LINKS, BLOCK], excluded=[("hand", "blok")]), "did you mean 'block'"),
        (lambda: Bodies(ARM, [*LINKS, BLOCK], excluded=[("hand",)]), r"excluded\[0\]"),
    ],
)
@pytest.mark.usefixtures("annotations_unchecked")
def test_bad_input(make, message):
    with pytest.raises(ValueError, match=message):
        make()


def test_bodies_that_overlap_at_home_are_named():
    wide = Body(Box((1.5, 1.2, 1.0), centre=(-0.7, 0, 0.3)), 0, "vehicle")
    with pytest.raises(ValueError, match=r"'link 2' and 'vehicle', which overlap by 0\.09 m at home"):
        Bodies(ARM, [*LINKS, wide])
    # What stands in the world may be where the robot is at home: nobody says that it is there.
    Bodies(ARM, [*LINKS, Body(Sphere((0.6, 0, 0.1), 0.1), "world", "ball")])


@pytest.mark.parametrize("compiled", [False, True], ids=["torch", "C"])
def test_bad_configurations(compiled):
    bodies = in_c(docked()) if compiled else docked()
    with pytest.raises(ValueError, match="q is not finite"):
        bodies.clearance([math.nan, 0, 0, 0, 0, 0])
    with pytest.raises(ValueError, match="q has shape"):
        bodies.clearance([0.0] * 5)
    with pytest.raises(ValueError, match="T_world_base"):
        bodies.clearance([0.0] * 6, 2 * torch.eye(4, dtype=torch.float64))
    with pytest.raises(ValueError, match="do not broadcast"):
        bodies.clearance(torch.zeros(3, 6), torch.eye(4).expand(2, 4, 4))
    with pytest.raises(ValueError, match="margin is -1"):
        bodies.collides([0.0] * 6, margin=-1.0)


def test_the_source_stands_alone():
    source = c_source(docked(), "arm")
    assert "int arm_clearance_batch(" in source
    assert c_source(docked()) == c_source(docked())
    with pytest.raises(ValueError, match="name is 'sqrt'"):
        c_source(docked(), "sqrt")


@pytest.mark.parametrize("compiler", [c for c in ("gcc", "clang") if shutil.which(c)])
def test_the_source_compiles_without_a_warning(compiler, tmp_path):
    warnings = ("-Wall", "-Wextra", "-pedantic", "-Wconversion", "-Wshadow", "-Werror", "-fsyntax-only")
    (tmp_path / "arm.c").write_text(c_source(of_all_kinds(), "arm"), encoding="utf-8")
    subprocess.run([compiler, "-std=c99", *warnings, tmp_path / "arm.c"], check=True)
