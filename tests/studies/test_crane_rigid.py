"""The rigid crane: that its study is sound, what its verdicts go by, and that its mechanism is the crane."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from dexterity import crane
from dexterity.report.claims import Outcome, load_paper
from dexterity.report.runs import run_study
from dexterity.studies.crane import kinematics as study


@pytest.fixture(scope="module")
def result() -> study.Result:
    return run_study("crane.kinematics", study.CONFIGS["smoke"]).result


def outcomes(result: study.Result) -> dict[str, Outcome]:
    return {verdict.claim: verdict.outcome for verdict in study.verdicts(result)}


# ---- what is found ---------------------------------------------------------------------------------


def test_formulas_are_exact_and_the_table_is_another_crane(result):
    found = outcomes(result)
    for claim in ("crane-lift-angle", "crane-jib-angle", "crane-transforms"):
        assert found[claim] is Outcome.REPRODUCED
    assert found["crane-cylinder-mounts"] is Outcome.CONTRADICTED
    assert result.downwards == pytest.approx(0.016, abs=1e-12)


def test_only_the_longer_stroke_leaves_the_stated_rows(result):
    printed = load_paper("rouvinen1999").claim("crane-training-vectors").value
    assert result.rows["training data"] == printed == len(crane.training_set())
    assert result.rows["listing"] > printed
    assert outcomes(result)["crane-stroke-ends"] is Outcome.CONTRADICTED
    agreeing = replace(result, rows=dict.fromkeys(result.rows, int(printed)))
    assert outcomes(agreeing)["crane-stroke-ends"] is Outcome.OUT_OF_SCOPE


def test_circles_are_where_arms_are_folded_stretched_and_low(result):
    around = study.circles()
    assert around["folded"].radius == pytest.approx(result.inner[2], abs=1e-6)
    _, distance, _ = study.fold_curves(7_801)
    assert around["stretched"].radius == pytest.approx(distance.max(), abs=1e-6)
    low = crane.tip_position([[0.0, s2, 0.0] for s2 in np.linspace(0, 0.78, 9)])
    centre = low.new_tensor(around["lift arm down"].centre)
    np.testing.assert_allclose((low - centre).norm(dim=-1), around["lift arm down"].radius, atol=1e-12)


def test_a_point_has_at_most_two_pairs_of_strokes(result):
    assert result.most == 2
    stretched = torch.tensor([[0.2, 0.02, 0.5]], dtype=torch.float64)
    bent = torch.tensor([[0.2, 0.4, 0.5]], dtype=torch.float64)
    assert study._pairs(stretched).tolist() == [2]
    assert study._pairs(bent).tolist() == [1]


# ---- what verdicts go by ---------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("largest", "outcome"),
    [(42.0, Outcome.REPRODUCED), (12.0, Outcome.IN_SHAPE), (8.0, Outcome.NOT_REPRODUCED)],
)
def test_several_centimetres_are_two_or_more(result, largest, outcome):
    gains = {name: replace(gain, largest=min(gain.largest, largest)) for name, gain in result.gains.items()}
    assert outcomes(replace(result, gains=gains))["crane-amplification"] is outcome


@pytest.mark.parametrize(
    ("shortest", "longest", "outcome"),
    [
        (0.0, 0.0005, Outcome.REPRODUCED),
        (0.0, 0.01, Outcome.IN_SHAPE),
        (0.0, 0.1, Outcome.NOT_REPRODUCED),
        (-0.01, 0.0, Outcome.NOT_REPRODUCED),
    ],
)
def test_the_inner_rule_must_reach(result, shortest, longest, outcome):
    folded = replace(result.rules["folded"], shortest=shortest, longest=longest)
    changed = replace(result, rules={**result.rules, "folded": folded})
    assert outcomes(changed)["crane-inner-rule"] is outcome


def test_a_closed_form_that_loses_a_posture_is_none(result):
    assert outcomes(result)["crane-no-closed-form"] is Outcome.NOT_REPRODUCED
    assert outcomes(replace(result, lost=0.01))["crane-no-closed-form"] is Outcome.REPRODUCED


def test_tables_have_a_row_for_each(result):
    assert list(study.gain_table(result))[:3] == list(study.CYLINDERS)
    assert len(study.misprint_table(result)) == 6
    assert list(study.stroke_end_table(result)) == ["listing", "training data"]


# ---- the mechanism ---------------------------------------------------------------------------------


def test_the_mechanism_is_the_crane():
    bodies, sliders = study.mechanism(steps=11)
    by_name = {body.name: body for body in bodies}
    for rows in ((0, 0, 0), (3, 7, 2), (10, 10, 10), (5, 9, 0)):
        chosen = dict(zip([slider.label for slider in sliders], rows, strict=True))

        def placed(name, chosen=chosen):
            body = by_name[name]
            carrier = placed(body.on) if body.on else np.eye(4)
            return carrier @ (body.poses[chosen[body.slider]] if body.slider else body.poses)

        strokes = [slider.values[row] for slider, row in zip(sliders, rows, strict=True)]
        np.testing.assert_allclose(placed("extension")[:2, 3], crane.tip_position(strokes), atol=1e-12)
        # The far end of the coupler is the jib's pin I, but for the rocker's last digit.
        end = placed("coupler") @ [*by_name["coupler"].rods[0, 1], 1.0]
        pin = placed("jib arm") @ [*crane.patu655().linkage.coupler_pin, 0.0, 1.0]
        np.testing.assert_allclose(end, pin, atol=2e-5)
        for name in ("lift", "jib"):
            barrel, rod = placed(f"{name} cylinder"), placed(f"{name} cylinder's rod")
            along = np.linalg.inv(barrel) @ rod @ np.append(by_name[f"{name} cylinder's rod"].rods[0, 0], 1.0)
            assert 0 <= along[0] < by_name[f"{name} cylinder"].rods[0, 1, 0]
            np.testing.assert_allclose(along[1:], [0, 0, 1], atol=1e-12)
