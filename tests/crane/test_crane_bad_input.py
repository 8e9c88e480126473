"""What is no crane, task or option is refused by name, and what is good works in every mode of torch."""

import dataclasses
import math

import numpy as np
import pytest
import torch
from torch.testing import assert_close

from dexterity import crane, store
from dexterity.crane import positioning
from dexterity.crane.description import Linkage, Structure

pytestmark = pytest.mark.usefixtures("annotations_unchecked")

FILE = store.data_path("robots", "patu655.toml").read_text(encoding="utf-8")
STROKES, PAYLOAD = [[0.25, 0.5, 1.0], [0.2, 0.3, 0.4]], [100.0, 200.0]
PATU = crane.patu655()
OPTIONS = (
    crane.NewtonOptions,
    crane.Differences,
    positioning.GeneticInverseOptions,
    positioning.DescentOptions,
    positioning.GaussNewtonOptions,
)


@pytest.mark.parametrize(
    ("options", "field"),
    [(options, field.name) for options in OPTIONS for field in dataclasses.fields(options)],
)
@pytest.mark.parametrize(
    "value", [math.nan, "3", -1, True, [1.0], np.ones(2), 10**400], ids=lambda v: type(v)
)
def test_an_option_that_is_none_is_named(options, field, value):
    with pytest.raises((TypeError, ValueError), match=rf"^{field} is "):
        options(**{field: value})


@pytest.mark.parametrize(
    ("kind", "whole"), [(Linkage, PATU.linkage), (Structure, PATU.structure), (crane.Crane, PATU)]
)
def test_a_description_that_is_none_is_named(kind, whole):
    for field in dataclasses.fields(kind):
        for value in (math.nan, None, object(), -math.inf):
            with pytest.raises((TypeError, ValueError), match=rf"^{field.name} is "):
                dataclasses.replace(whole, **{field.name: value})


@pytest.mark.parametrize(
    "text",
    [
        f"rating = {'9' * 5000}",
        f"rating = {'9' * 400}",
        "rating = " + "[" * 100_000,
        "a." * 50_000 + "b = 1",
        "rating = \x00",
        FILE.replace("crank = 0.45", "crank = -0.45"),
        FILE.replace("rating = 500.0", "rating = true"),
        FILE.replace('name = "patu655"', 'name = "a\\u0000b"'),
        FILE.replace("upper = [0.535", "upper = [-0.535"),
        FILE.replace("[linkage]", "[[linkage]]"),
    ],
    ids=range(10),
)
def test_a_file_that_is_no_cranes_is_named(tmp_path, text):
    (tmp_path / "yard.toml").write_text(text, encoding="utf-8")
    with pytest.raises(ValueError, match=r"^yard\.toml is not a crane's file"):
        crane.read_crane(tmp_path / "yard.toml")


def test_a_byte_order_mark_is_no_fault(tmp_path):
    (tmp_path / "yard.toml").write_text(FILE, encoding="utf-8-sig")
    assert crane.read_crane(tmp_path / "yard.toml") == PATU


@pytest.mark.parametrize(
    "compute",
    [
        lambda: crane.deflection(STROKES, PAYLOAD),
        lambda: crane.tip_jacobian(STROKES),
        lambda: crane.corotational_deflection(STROKES, PAYLOAD).deflection,
        lambda: crane.joint_forces(STROKES, PAYLOAD).rods,
        lambda: crane.load_response(torch.tensor(STROKES)).own_weight,
        lambda: torch.cat(list(crane.shape.bars(STROKES).loaded(PAYLOAD))),
    ],
)
def test_inference_mode_changes_nothing_inside_and_poisons_nothing_outside(compute):
    crane.structure.Assembly.of.cache_clear()
    with torch.inference_mode():
        inside = compute().clone()
    assert_close(inside.clone(), compute(), rtol=1e-14, atol=1e-11)
    assert crane.tip_jacobian(STROKES).shape == (2, 2, 3)


@pytest.mark.parametrize(
    "call",
    [
        lambda: crane.deflection(STROKES, [1.0, 2.0, 3.0]),
        lambda: crane.corotational_deflection(STROKES, [1.0, 2.0, 3.0]),
        lambda: crane.joint_forces(STROKES[:1], PAYLOAD),
        lambda: crane.shape.bars(STROKES).loaded([1.0, 2.0, 3.0]),
        lambda: crane.ExistingCrane(PATU, (0.0,) * 9).tip(STROKES[:1], PAYLOAD),
        lambda: crane.inverse([[3.0, 0.0], [4.0, 0.0]], [0.1, 0.2, 0.3]),
        lambda: positioning.Task(STROKES, PAYLOAD, STROKES, PATU),
        lambda: positioning.thesis_task(payloads=[]),
        lambda: positioning.thesis_task(points=[]),
        lambda: crane.least_extension([1e154, 0.0]),
        lambda: crane.shape.bars(STROKES[0]).loaded(1.0, magnified=math.nan),
        lambda: positioning.TableSag.of([2000, 2000, 2000]),
        lambda: positioning.compensate(None, positioning.linear_sag()),
        lambda: crane.deflection(STROKES, PAYLOAD, crane="patu655"),
        lambda: crane.existing_crane(crane.Differences(), None),
    ],
)
def test_what_does_not_fit_is_named(call):
    with pytest.raises(
        (TypeError, ValueError),
        match=r"^(payload|payloads|points|position|strokes|extension|targets|magnified|nodes|task|crane|generator)\b",
    ):
        call()


def test_corrections_end_where_the_tip_stays():
    task = positioning.thesis_task(points=[[4.0, 0.0]], payloads=[100.0])
    placement = positioning.compensate(
        task, lambda strokes, _: torch.zeros_like(strokes[:, :2]), corrections=10_000, tolerance=1e-300
    )
    assert placement.iterations.item() < 10
    with pytest.raises(ValueError, match=r"^tolerance is nan"):
        positioning.compensate(task, positioning.linear_sag(), tolerance=math.nan)


def test_a_task_stays_as_it_is_when_the_callers_array_changes():
    targets, payload, starts = np.array([[4.0, 0.0]]), np.array([100.0]), np.array([[0.2, 0.3, 0.4]])
    task = positioning.Task(targets, payload, starts, PATU)
    for array in (targets, payload, starts):
        array[:] = 7.0
    assert (task.targets.tolist(), task.payload.tolist()) == ([[4.0, 0.0]], [100.0])
    assert task.starts.tolist() == [[0.2, 0.3, 0.4]]
