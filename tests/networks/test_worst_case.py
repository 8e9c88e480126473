"""The search against functions whose largest error is known, and against sampling."""

import math

import pytest
import torch
from torch.testing import assert_close

import dexterity as dx
from dexterity import sampling
from dexterity.indices import Index
from dexterity.networks import baselines, validation
from dexterity.networks.feed_forward import FeedForward
from dexterity.networks.network import View
from dexterity.networks.worst_case import Search, climb, worst_case, worst_points
from dexterity.sampling import Box

SMALL = Search(samples=512, corners=64, starts=32, steps=80)
SPACE = Box([-1.0] * 5, [1.0] * 5)
CENTRE = torch.tensor([0.3, -0.2, 0.7, 0.0, -0.9], dtype=torch.float64)


def index(q):
    return 2.0 + q[..., 0]


def with_error(error):
    return lambda q: index(q) * (1 + error(q))


def vector(numbers):
    return torch.tensor(numbers, dtype=torch.float64)


# Errors with the point and the size of their largest absolute value.
KNOWN = {
    "peak inside": (lambda q: 0.1 - (q - CENTRE).square().sum(-1) / 100, CENTRE, 0.1),
    "dip inside": (lambda q: (q - CENTRE).square().sum(-1) / 100 - 0.1, CENTRE, 0.1),
    "ridge with a kink": (lambda q: 0.1 - 0.01 * (q - CENTRE).abs().sum(-1), CENTRE, 0.1),
    "corner": (lambda q: 0.01 * (q @ vector([1, -2, 3, -4, 5])), None, 0.15),
    "far from every start": (lambda q: 0.1 * torch.exp(-40 * (q - CENTRE).square().sum(-1)), CENTRE, 0.1),
}


@pytest.mark.parametrize("name", KNOWN)
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_known_maxima_are_found_by_every_seed(name, seed):
    error, where, size = KNOWN[name]
    found = worst_case(with_error(error), index, SPACE, SMALL, seed)
    assert found.error == pytest.approx(size, rel=1e-6)
    if where is not None:
        assert_close(vector(found.q), where, rtol=0, atol=1e-2)
    assert found.value == pytest.approx(found.exact * (1 + float(error(vector(found.q)))), rel=1e-12)


def test_a_maximum_on_a_face_is_found():
    def error(q):
        return 0.05 * q[..., 0] - 0.1 * (q[..., 1:] - 0.25).square().sum(-1) + 0.5

    found = worst_case(with_error(error), index, SPACE, SMALL)
    assert found.error == pytest.approx(0.55, rel=1e-9)
    assert_close(vector(found.q), vector([1.0, 0.25, 0.25, 0.25, 0.25]), rtol=0, atol=1e-4)


def test_corners_are_all_looked_at_where_they_are_few():
    """An error at one corner alone, too steep for any climb from a sample."""

    def error(q):
        return 0.1 * torch.exp(-1e4 * (q + 1).square().sum(-1)) + 0 * q[..., 0]

    found = worst_case(with_error(error), index, SPACE, SMALL)
    assert found.q == (-1.0,) * 5
    assert found.sampled == found.error == pytest.approx(0.1, rel=1e-12)


@pytest.fixture(scope="module", params=["manipulability", "kinematic_conditioning"])
def untrained(request):
    """Return a network of a UVMS's index, the index and the space; its errors are large and anywhere."""
    exact = Index(request.param).bind(dx.robots.uvms())
    space = sampling.uvms_space(request.param)
    q = sampling.sobol(space, 512, 0)
    network = FeedForward.untrained(View(12, range(4, 11)), 5, q, exact(q), torch.Generator().manual_seed(0))
    return network, exact, space


def test_it_beats_sampling_with_as_many_evaluations(untrained):
    network, exact, space = untrained
    found = worst_case(network, exact, space, Search(samples=2048, corners=256, starts=32, steps=60))
    sampled = validation.error_distribution(network, exact, space, found.evaluations, seed=7)
    assert found.error > sampled.maximum
    assert found.error >= found.sampled
    assert found.error == max(found.reached[0], found.sampled)


def test_what_is_found_is_in_the_space_and_so_large(untrained):
    network, exact, space = untrained
    found = worst_case(network, exact, space, SMALL)
    q = vector(found.q)
    assert space.contains(q)
    assert found.exact == pytest.approx(float(exact(q)), rel=1e-10)
    assert found.value == pytest.approx(float(network(q).detach()), rel=1e-10)
    assert found.error == abs(found.value / found.exact - 1)


def test_the_same_seed_gives_the_same(untrained):
    network, exact, space = untrained
    search = Search(samples=256, corners=16, starts=8, steps=5)
    assert worst_case(network, exact, space, search, 4) == worst_case(network, exact, space, search, 4)


def test_climbing_never_ends_below_where_it_began(untrained):
    network, exact, space = untrained
    u = torch.rand(50, space.dimensions, generator=torch.Generator().manual_seed(1), dtype=torch.float64)
    before = u.clone()
    heights = []
    for steps in (0, 3, 30):
        end = climb(network, exact, space, u, steps)
        assert ((end >= 0) & (end <= 1)).all()
        q = space.from_unit(end)
        heights.append((network(q) / exact(q) - 1).abs().detach())
    assert (heights[1] >= heights[0]).all()
    assert (heights[2] >= heights[1]).all()
    assert (heights[2] > heights[0]).all()
    assert torch.equal(u, before)


def test_worst_points_are_where_the_climbs_end(untrained):
    network, exact, space = untrained
    points = worst_points(network, exact, space, SMALL, 3)
    assert points.q.shape == (32, 12)
    assert_close(points.values, exact(points.q))
    errors = validation.relative_errors(network, points).abs().sort(descending=True).values
    assert_close(errors, vector(worst_case(network, exact, space, SMALL, 3).reached), rtol=1e-12, atol=0)


def test_no_slope_at_a_kink_is_no_trouble():
    def cone(q):
        return 0.1 - 0.01 * torch.hypot(q[..., 0], q[..., 1])

    u = torch.full((1, 5), 0.5, dtype=torch.float64)
    assert_close(climb(with_error(cone), index, SPACE, u, 10), u)
    assert worst_case(with_error(cone), index, SPACE, SMALL).error == pytest.approx(0.1, rel=1e-5)


def test_what_cannot_be_climbed_on_is_refused():
    data = validation.fresh(index, SPACE, 100)
    stairs = baselines.trees(View(5, range(5)), data)
    for f in (stairs, lambda q: torch.ones(len(q), dtype=torch.float64)):
        with pytest.raises(ValueError, match=r"^f cannot be differentiated"):
            worst_case(f, index, SPACE, SMALL)
    with pytest.raises(ValueError, match="value of zero"):
        worst_case(index, lambda q: q[..., 0] * 0, SPACE, SMALL)
    with pytest.raises(ValueError, match="is not finite"):
        worst_case(lambda q: q[..., 0] * math.nan, index, SPACE, SMALL)
    with pytest.raises(ValueError, match="single configuration"):
        worst_case(index, index, Box([1.0], [1.0]), SMALL)


@pytest.mark.parametrize("name", ["samples", "corners", "starts", "steps"])
def test_a_search_for_nothing_is_refused(name):
    with pytest.raises(ValueError, match=f"^{name} is 0"):
        Search(**{name: 0})
