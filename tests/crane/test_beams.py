"""Beams against the textbook, and the co-rotational energy against the linear stiffness and the elastica."""

import math

import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq
from scipy.special import ellipe, ellipeinc, ellipk, ellipkinc
from torch.testing import assert_close

from dexterity.crane.beams import Beams, flexibility, gravity_potential, hermite, stiffness, strain_energy
from dexterity.crane.equilibrium import Equilibrium, NewtonOptions, equilibrium

LENGTH, EA, EI, WEIGHT = 2.4, 3e8, 5e5, 700.0


def row(elements: int, slope: float = 0.0, axial: float = EA) -> tuple[Beams, torch.Tensor]:
    """Straight beam of some elements from the origin, rising with a slope [rad]."""
    along = torch.linspace(0, LENGTH, elements + 1, dtype=torch.float64)
    nodes = along[:, None] * torch.tensor([math.cos(slope), math.sin(slope)], dtype=torch.float64)
    first, ones = torch.arange(elements), torch.ones(elements, dtype=torch.float64)
    return Beams(torch.stack([first, first + 1], dim=-1), axial * ones, EI * ones, WEIGHT * ones), nodes


def weight_loads(beams: Beams, nodes: torch.Tensor) -> torch.Tensor:
    q = torch.zeros(len(nodes), 3, dtype=torch.float64, requires_grad=True)
    return -torch.autograd.grad(gravity_potential(beams, nodes, q), q)[0]


def displaced(beams: Beams, nodes: torch.Tensor, loads: torch.Tensor, held: list[int]) -> torch.Tensor:
    return (flexibility(stiffness(beams, nodes), held) @ loads.flatten()).view(-1, 3)


CLAMPED = [0, 1, 2]


@pytest.mark.parametrize("elements", [1, 2, 5])
def test_a_cantilever_with_a_load_at_its_end(elements):
    beams, nodes = row(elements)
    loads = torch.zeros_like(nodes[:, [0, 1, 1]])
    loads[-1] = torch.tensor([2e5, -1e4, 3e3], dtype=torch.float64)
    q = displaced(beams, nodes, loads, CLAMPED)
    sag = -1e4 * LENGTH**3 / (3 * EI) + 3e3 * LENGTH**2 / (2 * EI)
    turn = -1e4 * LENGTH**2 / (2 * EI) + 3e3 * LENGTH / EI
    assert_close(q[-1], torch.tensor([2e5 * LENGTH / EA, sag, turn], dtype=torch.float64), rtol=1e-8, atol=0)


@pytest.mark.parametrize("slope", [0.0, 0.7, -2.0])
@pytest.mark.parametrize("elements", [1, 4])
def test_a_cantilever_under_its_own_weight(elements, slope):
    beams, nodes = row(elements, slope)
    q = displaced(beams, nodes, weight_loads(beams, nodes), CLAMPED)[-1]
    across = WEIGHT * math.cos(slope)
    normal = q[1] * math.cos(slope) - q[0] * math.sin(slope)
    assert normal.item() == pytest.approx(-across * LENGTH**4 / (8 * EI), rel=1e-8)
    assert q[2].item() == pytest.approx(-across * LENGTH**3 / (6 * EI), rel=1e-8)
    along = q[0] * math.cos(slope) + q[1] * math.sin(slope)
    assert along.item() == pytest.approx(
        -WEIGHT * math.sin(slope) * LENGTH**2 / (2 * EA), rel=1e-8, abs=1e-15
    )


def test_a_beam_on_two_supports():
    beams, nodes = row(2)
    held = [0, 1, 7]
    own = displaced(beams, nodes, weight_loads(beams, nodes), held)
    assert own[1, 1].item() == pytest.approx(-5 * WEIGHT * LENGTH**4 / (384 * EI), rel=1e-8)
    loads = torch.zeros_like(own)
    loads[1, 1] = -1e4
    pressed = displaced(beams, nodes, loads, held)
    assert pressed[1, 1].item() == pytest.approx(-1e4 * LENGTH**3 / (48 * EI), rel=1e-8)
    assert pressed[2, 2].item() == pytest.approx(1e4 * LENGTH**2 / (16 * EI), rel=1e-8)


def test_a_propped_cantilever():
    beams, nodes = row(1)
    own = displaced(beams, nodes, weight_loads(beams, nodes), [*CLAMPED, 4])
    assert own[1, 2].item() == pytest.approx(-(-WEIGHT * LENGTH**3 / (48 * EI)), rel=1e-8)


def test_what_is_held_does_not_matter_to_loads_in_equilibrium():
    beams, nodes = row(4, 0.3)
    matrix = stiffness(beams, nodes)
    displacement = torch.randn(len(matrix), generator=torch.Generator().manual_seed(0), dtype=torch.float64)
    loads = matrix @ displacement
    works = [loads @ flexibility(matrix, held) @ loads for held in ([0, 1, 2], [6, 7, 8], [0, 1, 13])]
    assert_close(torch.stack(works), (loads @ displacement).expand(3), rtol=1e-8, atol=0)


def test_a_mechanism_is_refused():
    beams, nodes = row(2)
    with pytest.raises(ValueError, match=r"held.*mechanism"):
        flexibility(stiffness(beams, nodes), [0, 1])


def test_the_stiffness_is_the_curvature_of_the_energy_at_rest():
    beams, nodes = row(3, 0.4)

    def energy(q: torch.Tensor) -> torch.Tensor:
        return strain_energy(beams, nodes, q.view(-1, 3))

    curvature = torch.autograd.functional.hessian(energy, torch.zeros(12, dtype=torch.float64))
    assert_close(curvature, stiffness(beams, nodes), rtol=1e-10, atol=1e-3)


@settings(max_examples=15)
@given(st.floats(-3.0, 3.0), st.floats(-5.0, 5.0), st.floats(-5.0, 5.0))
def test_rigid_motions_cost_no_energy(turn, x, y):
    beams, nodes = row(3, 0.2)
    c, s = math.cos(turn), math.sin(turn)
    moved = nodes @ torch.tensor([[c, s], [-s, c]], dtype=torch.float64) + torch.tensor(
        [x, y], dtype=torch.float64
    )
    q = torch.cat([moved - nodes, torch.full((4, 1), turn, dtype=torch.float64)], dim=-1)
    assert strain_energy(beams, nodes, q).item() == pytest.approx(0, abs=1e-6)
    bent = q.clone()
    bent[-1, 2] += 0.01
    straight = torch.zeros_like(q)
    straight[-1, 2] = 0.01
    expected = strain_energy(beams, nodes, straight).item()
    assert strain_energy(beams, nodes, bent).item() == pytest.approx(expected, rel=1e-9)


def test_energy_keeps_batch_axes(batch_shape):
    beams, nodes = row(2)
    q = torch.zeros(*batch_shape, 3, 3, dtype=torch.float64)
    for function in (strain_energy, gravity_potential):
        assert function(beams, nodes, q).shape == batch_shape


def test_an_element_bows_as_its_tilted_ends_make_it():
    place = torch.linspace(0, 1, 11, dtype=torch.float64)
    bow = hermite(place)
    assert_close(bow[[0, -1]], torch.zeros(2, 2, dtype=torch.float64))
    assert_close(bow[5], torch.tensor([1 / 8, -1 / 8], dtype=torch.float64))
    step = torch.tensor([1e-6, -1e-6], dtype=torch.float64)
    slopes = hermite(torch.tensor([0.0, 1.0], dtype=torch.float64) + step) / step[:, None]
    assert_close(slopes, torch.eye(2, dtype=torch.float64), rtol=0, atol=1e-5)


# ---- large rotations -------------------------------------------------------------------------------


def tip_loaded(force: float, elements: int, axial: float = 1e12) -> Equilibrium:
    beams, nodes = row(elements, axial=axial)
    free = torch.ones(3 * len(nodes), dtype=torch.bool)
    free[:3] = False

    def potential(q: torch.Tensor, share: float) -> torch.Tensor:
        nodal = q.unflatten(-1, (-1, 3))
        return strain_energy(beams, nodes, nodal) + share * force * nodal[:, -1, 1]

    options = NewtonOptions(load_steps=4)
    return equilibrium(potential, lambda q: q[:, :0], free, 1, options)


def elastica(load: float) -> tuple[float, float]:
    """Sag and shortening, per length, of a cantilever under P L² / EI at its end (Bisshopp & Drucker)."""

    def reach(k: float) -> float:
        return ellipk(k**2) - ellipkinc(math.asin(1 / (k * math.sqrt(2))), k**2) - math.sqrt(load)

    k = brentq(reach, math.sqrt(0.5) + 1e-12, 1 - 1e-12)
    phi = math.asin(1 / (k * math.sqrt(2)))
    sag = 1 - 2 * (ellipe(k**2) - ellipeinc(phi, k**2)) / math.sqrt(load)
    ahead = math.sqrt(2 * (2 * k**2 - 1) / load)
    return sag, 1 - ahead


@pytest.mark.parametrize("load", [0.5, 1.0, 4.0, 10.0])
def test_a_cantilever_that_bends_far_is_an_elastica(load):
    sag, shortening = elastica(load)
    errors = []
    for elements in (10, 20):
        rest = tip_loaded(load * EI / LENGTH**2, elements)
        assert rest.converged.all()
        tip = rest.q[0, -3:-1] / LENGTH
        errors.append(torch.hypot(tip[1] + sag, tip[0] + shortening).item())
    assert errors[1] < 1e-3 * sag
    # Second order: half the elements' length, a quarter of the error.
    assert errors[1] == pytest.approx(errors[0] / 4, rel=0.1)


def test_the_elastica_is_the_published_one():
    """Bisshopp & Drucker's curves for P L² / EI = 1 and 10, as tabulated by Mattiasson (1981)."""
    assert elastica(1.0) == pytest.approx((0.30172, 0.05643), abs=1e-5)
    assert elastica(10.0) == pytest.approx((0.81061, 0.55500), abs=1e-5)


def test_small_loads_bend_it_as_the_textbook_says():
    rest = tip_loaded(1.0, 4, axial=EA)
    assert rest.q[0, -2].item() == pytest.approx(-(LENGTH**3) / (3 * EI), rel=1e-8)


def test_what_has_not_converged_is_flagged():
    beams, nodes = row(2)
    free = torch.ones(9, dtype=torch.bool)
    free[:3] = False

    def potential(q: torch.Tensor, share: float) -> torch.Tensor:
        nodal = q.unflatten(-1, (-1, 3))
        return strain_energy(beams, nodes, nodal) + share * q.new_tensor([1.0, 1e7]) * nodal[:, -1, 1]

    rest = equilibrium(potential, lambda q: q[:, :0], free, 2, NewtonOptions(iterations=3))
    assert rest.converged.tolist() == [True, False]
    # Nothing holds it: there is no step to take.
    loose = equilibrium(potential, lambda q: q[:, :0], torch.ones(9, dtype=torch.bool), 2)
    assert not loose.converged.any()


@pytest.mark.parametrize(
    "bad", [{"load_steps": 0}, {"iterations": 0}, {"tolerance": 0.0}, {"tolerance": math.nan}]
)
def test_bad_options_are_named(bad):
    with pytest.raises(ValueError, match=next(iter(bad))):
        NewtonOptions(**bad)
