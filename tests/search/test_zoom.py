"""Global search by grids on problems whose best point is known."""

import math

import pytest
import torch
from scipy.optimize import differential_evolution
from torch.testing import assert_close

from dexterity.search.zoom import ZoomOptions, zoom_search

LOW, HIGH = [-4.0, -4.0, -4.0], [4.0, 4.0, 4.0]
TOP = [1.0, -2.0, 0.3]


def ridge(x: torch.Tensor) -> torch.Tensor:
    """Least of three slopes that meet in an edge each, as a smallest value over corners has."""
    return -(x - torch.tensor(TOP, dtype=torch.float64)).abs().amax(1)


def rastrigin(x: torch.Tensor) -> torch.Tensor:
    x = x - torch.tensor(TOP, dtype=torch.float64)
    return (10 * (2 * math.pi * x).cos() - 10 - x.square()).sum(1)


def crest(x: torch.Tensor) -> torch.Tensor:
    """Steep to both sides of a line that runs along no axis, and gently rising along it."""
    x = x - torch.tensor(TOP, dtype=torch.float64)
    return -100 * (x[:, 0] - 0.7 * x[:, 1] + 0.3 * x[:, 2]).abs() - x.square().sum(1)


@pytest.mark.parametrize("objective", [ridge, rastrigin])
def test_the_best_point_is_found(objective):
    found = zoom_search(objective, LOW, HIGH, [0.25, 0.25, 0.25])
    assert_close(found.point, torch.tensor(TOP, dtype=torch.float64), rtol=0, atol=1e-6)
    assert found.value == pytest.approx(0.0, abs=1e-6)
    assert_close(objective(found.ends), found.values)
    assert (found.values.diff() <= 0).all()


def test_a_crest_between_the_axes_is_climbed():
    found = zoom_search(crest, LOW, HIGH, [0.25, 0.25, 0.25])
    assert found.value == pytest.approx(0.0, abs=1e-3)


def test_it_agrees_with_differential_evolution():
    def waves(x: torch.Tensor) -> torch.Tensor:
        return (3 * x[:, 0]).sin() * (2 * x[:, 1]).cos() - 0.1 * (x - 0.7).square().sum(1)

    bounds = list(zip(LOW, HIGH, strict=True))
    other = differential_evolution(lambda x: -waves(torch.tensor(x)[None]).item(), bounds, seed=0, tol=1e-12)
    found = zoom_search(waves, LOW, HIGH, [0.2, 0.2, 0.8])
    assert found.value == pytest.approx(-other.fun, abs=1e-7)


def test_starts_are_no_neighbours():
    found = zoom_search(ridge, LOW, HIGH, [0.5, 0.5, 0.5], ZoomOptions(starts=20, stages=0))
    apart = (found.ends[:, None] - found.ends).abs().amax(-1)
    apart.fill_diagonal_(math.inf)
    assert apart.min() > 0.5 * 1.5
    assert found.evaluations == 17**3


def test_the_box_is_not_left():
    def outwards(x: torch.Tensor) -> torch.Tensor:
        return x.sum(1)

    found = zoom_search(outwards, LOW, HIGH, [3.0, 3.0, 3.0])
    assert_close(found.point, torch.tensor(HIGH, dtype=torch.float64))


def test_a_variable_may_be_held():
    found = zoom_search(ridge, [-4, -1.5, -4], [4, -1.5, 4], [0.5, 0.5, 0.5])
    assert found.point[1] == -1.5
    assert found.value == pytest.approx(-0.5)


def test_a_plateau_is_an_answer():
    found = zoom_search(lambda x: torch.zeros(len(x), dtype=torch.float64), LOW, HIGH, [2.0, 2.0, 2.0])
    assert found.value == 0.0


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"starts": 0}, "starts is 0"),
        ({"stages": -1}, "stages is -1"),
        ({"levels": 4}, "levels is 4"),
        ({"levels": 1}, "levels is 1"),
        ({"shrink": 1.0}, "shrink is 1.0"),
    ],
)
def test_options_out_of_range(change, message):
    with pytest.raises(ValueError, match=message):
        ZoomOptions(**change)


def test_steps_that_make_no_grid():
    with pytest.raises(ValueError, match="3 positive numbers are needed"):
        zoom_search(ridge, LOW, HIGH, [0.1, 0.1])
    with pytest.raises(ValueError, match="3 positive numbers are needed"):
        zoom_search(ridge, LOW, HIGH, [0.1, 0.1, 0.0])
    with pytest.raises(ValueError, match=r"upper -4\.0 at variable 0"):
        zoom_search(ridge, HIGH, LOW, [0.1, 0.1, 0.1])


@pytest.mark.parametrize(
    ("lower", "upper", "steps", "options", "argument"),
    [
        ([0] * 3, [1] * 3, [5e-4] * 3, {}, "steps"),
        ([0], [1], [1e-300], {}, "steps"),
        ([0] * 12, [1] * 12, [1] * 12, {"levels": 5}, "levels"),
        ([-1e308], [1e308], [1e307], {}, "upper"),
    ],
)
def test_a_search_that_fits_no_memory_is_refused_before_it_starts(lower, upper, steps, options, argument):
    # 2001³ points would take 64 GB.
    with pytest.raises(ValueError, match=f"^{argument} is "):
        zoom_search(ridge, lower, upper, steps, ZoomOptions(**options))


@pytest.mark.usefixtures("annotations_unchecked")
@pytest.mark.parametrize("answer", ["x", None, 1j * torch.ones(27), object()])
def test_an_objective_that_answers_with_no_numbers(answer):
    with pytest.raises(TypeError, match=r"^objective"):
        zoom_search(lambda _: answer, [0] * 3, [1] * 3, [0.5] * 3)


@pytest.mark.usefixtures("annotations_unchecked")
@pytest.mark.parametrize("field", ["starts", "levels", "shrink", "stages"])
@pytest.mark.parametrize("value", [math.nan, math.inf, 2.5, True, "3", None])
def test_options_that_are_no_numbers(field, value):
    with pytest.raises((TypeError, ValueError), match=f"^{field} is "):
        ZoomOptions(**{field: value})
