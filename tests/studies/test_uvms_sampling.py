"""The geometry that the sampling study shows, and the thresholds that its docstring sets."""

import dataclasses

import numpy as np
import pytest
import torch
from torch.testing import assert_close

from dexterity import robots, sampling
from dexterity.report.claims import Outcome
from dexterity.studies.uvms import sampling as study
from dexterity.studies.uvms.sampling import Choice, Extension, Result, Trained

UVMS = robots.uvms()
SECTORS = study.choices()


def generator() -> torch.Generator:
    return torch.Generator().manual_seed(0)


# ---- geometry --------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", SECTORS)
def test_the_arm_reaches_the_task_point_exactly_from_between_the_radii(name):
    sector = SECTORS[name]
    q = sampling.uniform(sector, 500, generator())
    reached = study.reaching(UVMS, q, sector.task_point)
    task = torch.tensor(sector.task_point, dtype=torch.float64)
    base = torch.from_numpy(study.base_positions(sector, 500, seed=0))
    distance = (base - task).norm(dim=-1)
    can = reached.isfinite().all(-1)
    assert torch.equal(can, (distance >= sector.r_min) & (distance <= sector.r_max))
    tool = UVMS.forward(reached[can])[:, :3, 3]
    assert_close(tool, task.expand_as(tool), rtol=0, atol=1e-12)


def test_bases_of_the_turned_vehicle_lie_inside_the_outline():
    sector = dataclasses.replace(SECTORS[study.TURNED], elevation=0.0)
    base = study.base_positions(sector, 500, seed=0) - np.array(sector.task_point)
    outline = study.sector_outline(sector) - np.array(sector.task_point)
    assert_close(base[:, 2], np.zeros(500), rtol=0, atol=1e-12)
    turn, border = (np.arctan2(xyz[:, 0], -xyz[:, 1]) for xyz in (base, outline))
    assert border.min() <= turn.min() < turn.max() <= border.max()
    radius, radii = (np.linalg.norm(xyz, axis=1) for xyz in (base, outline))
    assert radii.min() <= radius.min() < radius.max() <= radii.max()
    assert_close(outline[0], outline[-1])


@pytest.mark.parametrize("name", SECTORS)
def test_every_choice_has_the_joints_of_equation_11_or_fewer(name):
    q = sampling.uniform(SECTORS[name], 50, generator())
    varying = (q.amax(0) > q.amin(0)).nonzero().flatten().tolist()
    assert set(varying) <= set(range(11))


# ---- thresholds ------------------------------------------------------------------------------------


def trained(error: float, rows: int = 100, neurons: int = 8) -> Trained:
    return Trained(neurons, rows, *[(error, error)] * 4)


def extensions(errors: dict[float, float]) -> tuple[Extension, ...]:
    return tuple(Extension(width, 1.0, 2.0, 49, (trained(error),)) for width, error in errors.items())


def judged(claim: str, **changes) -> Outcome:
    """Judge a result in which nothing is special but what is changed."""
    choice = Choice(0.2, 0.4, 0.0, 0.2, 1.0, 1.0, 0.0, trained(0.03))
    plain = Result(
        inputs={"w": tuple(range(5, 12)), "KCI": tuple(range(1, 12))},
        shares=np.linspace(0, 1, 3),
        values={},
        by_method={"grid": (trained(0.01),)},
        kci_by_rows=(trained(0.03),),
        choices=dict.fromkeys(SECTORS, choice),
        ranges=extensions({15.0: 0.01}),
        places={study.AS_PRINTED: extensions({1.0: 0.9}), study.FROM_VEHICLE: extensions({1.0: 0.9})},
    )
    (verdict,) = (v for v in study.verdicts(dataclasses.replace(plain, **changes)) if v.claim == claim)
    return verdict.outcome


@pytest.mark.parametrize(
    ("widest", "outcome"),
    [(15, Outcome.NOT_REPRODUCED), (90, Outcome.IN_SHAPE), (180, Outcome.REPRODUCED)],
)
def test_the_whole_space_is_possible_as_far_as_errors_stay_within_the_limit(widest, outcome):
    errors = {width: 0.019 if width <= widest else 0.021 for width in (15.0, 45.0, 90.0, 180.0)}
    assert judged("whole-space-possible", ranges=extensions(errors)) is outcome


@pytest.mark.parametrize(
    ("w", "kci", "outcome"),
    [
        (0.01, 0.01, Outcome.REPRODUCED),
        (0.01, 0.03, Outcome.IN_SHAPE),
        (0.03, 0.01, Outcome.IN_SHAPE),
        (0.03, 0.03, Outcome.NOT_REPRODUCED),
    ],
)
def test_any_task_point_is_judged_where_the_vehicle_is_farthest(w, kci, outcome):
    places = {study.AS_PRINTED: extensions({1.0: 0.01, 2.0: 0.9}), study.FROM_VEHICLE: extensions({2.0: kci})}
    assert judged("any-task-point", by_method={"grid": (trained(w),)}, places=places) is outcome


@pytest.mark.parametrize(
    ("rows", "outcome"),
    [(100, Outcome.NOT_REPRODUCED), (150, Outcome.IN_SHAPE), (200, Outcome.REPRODUCED)],
)
def test_rows_needed_are_the_fewest_that_come_near_the_best(rows, outcome):
    errors = {size: 0.0124 if size >= rows else 0.0126 for size in (100, 150, 200)} | {400: 0.01}
    by_rows = tuple(trained(error, size) for size, error in errors.items())
    w = {"grid": (trained(0.01, 100), trained(0.01, 400))}
    assert judged("kci-needs-more-data", kci_by_rows=by_rows, by_method=w) is outcome


def test_a_joint_too_many_is_not_reproduced():
    assert judged("data-set-w") is Outcome.REPRODUCED
    inputs = {"w": tuple(range(4, 12)), "KCI": tuple(range(1, 12))}
    assert judged("data-set-w", inputs=inputs) is Outcome.NOT_REPRODUCED
