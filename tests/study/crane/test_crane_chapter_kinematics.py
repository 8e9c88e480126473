"""The rigid crane: its circles and pairs, what its rows must satisfy, and that its mechanism is the crane."""

import inspect

import numpy as np
import pytest
import torch

from dexterity import crane
from dexterity_study.claims.ledger import load_paper
from dexterity_study.crane.kinematics import experiment, show

MACHINE = crane.patu655()


def test_formulas_are_exact_and_the_table_is_another_crane():
    row = experiment.formulas(drawn=200).rows.iloc[0]
    assert max(row["lift"], row["jib"], row["transforms"]) < 1e-12
    assert row["table"] > 1
    assert row["downwards"] == pytest.approx(2 * load_paper("rouvinen1999").printed("crane-joints")[-1])


def test_the_mounts_that_are_tried_are_those_of_the_table():
    mounts = inspect.signature(experiment.formulas.function).parameters["mounts"].default
    assert mounts == load_paper("rouvinen1999").printed("crane-cylinder-mounts")


def test_only_the_longer_stroke_leaves_the_stated_vectors():
    printed = load_paper("rouvinen1999").printed("crane-training-vectors")
    small = {"spacing": 1.0, "extensions": 3}
    longer, shorter = (
        experiment.working_area(reading=name, **small).rows.iloc[0]
        for name in ("chosen", "crane-jib-stroke=0.75")
    )
    assert longer["vectors"] == printed < shorter["vectors"]
    assert longer["inner_least"] < longer["inner_at_end"] < shorter["inner_at_end"]


def test_circles_are_where_arms_are_folded_stretched_and_low():
    around = experiment.circles(MACHINE)
    arms = np.hypot(*MACHINE.linkage.jib_joint), np.hypot(*MACHINE.linkage.extension_joint)
    assert around["folded"][1] == pytest.approx(arms[0] - arms[1], abs=1e-6)
    _, distance = experiment.folding(MACHINE)
    assert around["stretched"][1] == pytest.approx(distance.max().item(), abs=1e-6)
    low = crane.tip_position([[0.0, s2, 0.0] for s2 in np.linspace(0, 0.78, 9)])
    centre, radius = around["lift arm down"]
    np.testing.assert_allclose((low - centre).norm(dim=-1), radius, atol=1e-12)


def test_a_point_has_at_most_two_pairs_of_strokes():
    both = torch.tensor([[0.2, 0.02, 0.5], [0.2, 0.4, 0.5]], dtype=torch.float64)
    assert experiment.count_pairs(both, MACHINE).tolist() == [2, 1]
    # Strokes are a pair of their own, at the ends of the cylinders too.
    assert (experiment.count_pairs(experiment.random_strokes(MACHINE, 20, 0), MACHINE) >= 1).all()


def test_the_printed_rules_are_a_little_off_where_their_circles_decide():
    rows = experiment.rules(spacing=0.3).rows.set_index("circle")
    assert (rows["largest"] - rows["smallest"] < 0.01).all()
    # Beside the line from the joint the reach grows by less than the stroke.
    assert (rows["smallest"].drop("folded") < rows["radius"].drop("folded")).all()
    assert rows.loc["folded", "smallest"] > rows.loc["folded", "radius"]


def test_the_map_holds_the_least_extension_and_its_gain():
    table = experiment.working_area(spacing=0.6, extensions=3)
    points, shape = experiment.grid(0.6)
    reach = crane.inverse(points)
    extension = table.arrays["chosen", 0]["extension"]
    assert extension.shape == shape
    expected = torch.where(reach.within_limits, reach.strokes[:, 2], torch.nan).reshape(shape)
    np.testing.assert_allclose(extension, expected, atol=1e-3)
    gain = crane.tip_jacobian(reach.strokes[reach.within_limits]).norm(dim=-2)[:, :2].amax(-1)
    amplification = table.arrays["chosen", 0]["amplification"]
    np.testing.assert_allclose(amplification[np.isfinite(amplification)], gain, atol=1e-3)


def test_the_mechanism_is_the_crane():
    bodies, sliders = show.mechanism(steps=11)
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
        pin = placed("jib arm") @ [*MACHINE.linkage.coupler_pin, 0.0, 1.0]
        np.testing.assert_allclose(end, pin, atol=2e-5)
        lettered = [(body.name, *letter) for body in bodies for letter in body.letters.items()]
        at = {letter: placed(name) @ [*point, 1.0] for name, letter, point in lettered}
        assert at.keys() == {*"BCDEFGHIJ", "tip"}
        links = MACHINE.linkage
        cylinders = np.array([links.lift_cylinder_length, links.jib_cylinder_length]) + strokes[:2]
        lengths = dict(zip(("CD", "EH", "FH", "HI"), [*cylinders, links.crank, links.coupler], strict=True))
        for (first, second), length in lengths.items():
            assert np.linalg.norm(at[first] - at[second]) == pytest.approx(length, abs=2e-5)
        np.testing.assert_allclose(at["tip"], placed("extension") @ [0, 0, 0, 1.0])
        for name in ("lift", "jib"):
            barrel, rod = placed(f"{name} cylinder"), placed(f"{name} rod")
            far = np.append(by_name[f"{name} rod"].rods[0, 1], 1.0)
            along = np.linalg.inv(barrel) @ rod @ far
            assert 0 <= along[0] < by_name[f"{name} cylinder"].rods[0, 1, 0]
            np.testing.assert_allclose(along[1:], [0, 0, 1], atol=1e-12)
