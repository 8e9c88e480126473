"""Strokes to the tip against the thesis's own arithmetic, and back."""

import math

import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st
from torch.testing import assert_close

import dexterity as dx
from dexterity import crane, store

PATU = crane.patu655()


def strokes(*batch: int, seed: int = 0) -> torch.Tensor:
    unit = torch.rand(*batch, 3, generator=torch.Generator().manual_seed(seed), dtype=torch.float64)
    return unit * torch.tensor(PATU.upper, dtype=torch.float64)


def chained_transforms(s1: float, s2: float, s3: float) -> tuple[float, float]:
    """Tip by the 4 × 4 matrices of Appendix A and the angles of its listing, with its signs."""
    bc, bd = math.hypot(0.26, 1.04), math.hypot(0.105, 0.3025)
    fe, fg = math.hypot(0.203, 1.4165), math.hypot(0.015, 0.19)
    fh, hi, gi = 0.45, 0.48, 0.2581

    def corner(opposite: float, a: float, b: float) -> float:
        return math.acos((opposite**2 - a**2 - b**2) / (-2 * a * b))

    lift = corner(s1 + 0.8, bc, bd) + math.atan(0.26 / 1.04) + math.atan(0.105 / 0.3025) - math.pi / 2
    tilt = math.atan(0.015 / 0.19)
    beta = math.pi - math.atan(0.203 / 1.4165) - corner(s2 + 1.037, fe, fh) - tilt
    gh = math.sqrt(fh**2 + fg**2 - 2 * fh * fg * math.cos(beta))
    fold = -math.pi / 2 - tilt + corner(fh, gh, fg) + corner(hi, gh, gi) + math.atan(0.095 / 0.24)

    def joint(angle: float) -> np.ndarray:
        c, s = math.cos(angle), math.sin(angle)
        return np.array([[c, -s, 0, 0], [0, 0, 1, 0], [-s, -c, 0, 0], [0, 0, 0, 1]])

    def offset(x: float, y: float) -> np.ndarray:
        return np.array([[1, 0, 0, x], [0, 0, -1, y], [0, 1, 0, 0], [0, 0, 0, 1]])

    link = np.eye(4)
    link[:3, 3] = 2.141, 0, -0.008
    slide = np.array([[1, 0, 0, s3], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]])
    arms = offset(-0.09, 1.115) @ joint(lift) @ offset(2.88, -0.024) @ joint(-fold) @ offset(-0.095, 0.24)
    x, y = (arms @ link @ slide)[:2, 3]
    return x, y


# ---- forward ---------------------------------------------------------------------------------------


def test_the_tip_is_where_the_thesis_computes_it():
    """T56 is (2.141, −0.008) along x and z of a frame whose z axis points down in the plane: 0.008 up."""
    s = torch.cat([strokes(200), torch.cartesian_prod(*torch.tensor([[0.0] * 3, PATU.upper]).double().mT)])
    expected = torch.tensor([chained_transforms(*row) for row in s.tolist()], dtype=torch.float64)
    assert_close(crane.tip_position(s), expected, rtol=0, atol=1e-12)


def test_angles_span_what_the_linkages_allow():
    lift, jib, *_ = crane.posture([[0, 0, 0], PATU.upper])
    assert_close(torch.rad2deg(lift), torch.tensor([-29.8, 83.8]).double(), rtol=0, atol=0.05)
    assert_close(torch.rad2deg(jib - lift), torch.tensor([-1.1, -194.2]).double(), rtol=0, atol=0.05)


def test_the_jib_turns_one_way():
    s = torch.zeros(1000, 3, dtype=torch.float64)
    s[:, 1] = torch.linspace(0, PATU.upper[1], 1000)
    place = crane.posture(s)
    assert ((place.jib - place.lift).diff() < 0).all()


@given(st.floats(0, 0.535), st.floats(0, 0.78), st.floats(0, 1.6))
def test_the_crank_pin_keeps_its_distances(s1, s2, s3):
    links = PATU.linkage
    place = crane.posture([s1, s2, s3])
    pin = place.crank_pin
    for other, length in (
        (links.jib_cylinder_foot, s2 + links.jib_cylinder_length), (links.crank_joint, links.crank)
    ):  # fmt: skip
        assert math.dist(pin.tolist(), other) == pytest.approx(length, abs=1e-12)
    angle = (place.jib - place.lift).item() + math.atan2(*reversed(links.coupler_pin))
    rocker = [
        links.jib_joint[0] + links.rocker * math.cos(angle),
        links.jib_joint[1] + links.rocker * math.sin(angle),
    ]
    assert math.dist(pin.tolist(), rocker) == pytest.approx(links.coupler, abs=1e-12)


def test_batches_of_strokes(batch_shape):
    s = strokes(*batch_shape)
    tip = crane.tip_position(s)
    assert tip.shape == (*batch_shape, 2)
    assert crane.tip_jacobian(s).shape == (*batch_shape, 2, 3)
    assert crane.within_limits(s).shape == (*batch_shape, 3)
    assert crane.inverse(tip).strokes.shape == (*batch_shape, 3)
    for row, point in zip(s.reshape(-1, 3), tip.reshape(-1, 2), strict=True):
        assert_close(crane.tip_position(row), point, rtol=0, atol=1e-14)


def test_the_jacobian_is_what_small_strokes_do():
    s, h = strokes(50), 1e-6
    steps = h * torch.eye(3, dtype=torch.float64)
    differences = (crane.tip_position(s[:, None] + steps) - crane.tip_position(s[:, None] - steps)) / (2 * h)
    assert_close(crane.tip_jacobian(s), differences.mT, rtol=1e-7, atol=1e-7)


def test_strokes_beyond_their_ends_are_flagged():
    assert crane.within_limits([0, 0, 0]).all()
    assert crane.within_limits(PATU.upper).all()
    assert crane.within_limits([-1e-6, 0.79, 1.7]).tolist() == [False, False, False]
    assert crane.tip_position([0.1, 0.1, 1.7]).isfinite().all()


@pytest.mark.parametrize(("s", "named"), [([0.7, 0, 0], "s1 = 0.7.*lift"), ([0, 0.9, 0], "s2 = 0.9.*jib")])
def test_a_linkage_that_cannot_close_is_named(s, named):
    with pytest.raises(ValueError, match=named):
        crane.tip_position([[0.1, 0.1, 0.1], s])
    place = crane.posture(s)
    assert not (place.lift_closes & place.jib_closes)


@pytest.mark.parametrize("bad", [[0.1, 0.1], [math.nan, 0, 0], 0.1, [[math.inf, 0, 0]]])
def test_what_are_no_strokes_is_refused(bad):
    for function in (crane.tip_position, crane.posture, crane.within_limits, crane.tip_jacobian):
        with pytest.raises(ValueError, match="strokes"):
            function(bad)


# ---- inverse ---------------------------------------------------------------------------------------


def test_a_round_trip_over_the_workspace():
    s = strokes(20_000)
    position = crane.tip_position(s)
    for extension in (s[:, 2], None):
        back = crane.inverse(position, extension)
        tip = crane.tip_position(back.strokes[back.reached])
        assert (tip - position[back.reached]).norm(dim=-1).max() < 1e-9
        assert back.strokes[~back.reached].isnan().all()
    assert crane.inverse(position, s[:, 2]).reached.double().mean() > 0.97


def test_strokes_come_back_where_the_elbow_is_up():
    s = strokes(20_000)
    lift, jib, *_ = crane.posture(s)
    length, offset = PATU.linkage.extension_joint
    to_tip = jib + torch.atan2(torch.full_like(jib, offset), length + s[:, 2])
    bend = to_tip - lift - math.atan2(*reversed(PATU.linkage.jib_joint))
    up = (bend < -1e-3) & (bend > 1e-3 - math.pi)
    back = crane.inverse(crane.tip_position(s[up]), s[up, 2])
    assert back.within_limits.all()
    assert_close(back.strokes, s[up], rtol=0, atol=1e-9)
    # With the elbow down there is another pair of strokes, if any.
    down = s[(bend > 1e-3) | (bend < -1e-3 - math.pi)]
    other = crane.inverse(crane.tip_position(down), down[:, 2])
    assert ((other.strokes - down)[other.reached].norm(dim=-1) > 1e-4).all()


def test_the_least_extension_is_the_least():
    position = crane.tip_position(strokes(5000))
    position = position[crane.inverse(position, strokes(5000)[:, 2]).within_limits]
    least = crane.least_extension(position)
    grid = torch.linspace(0, 1.6, 161, dtype=torch.float64)
    possible = crane.inverse(position[:, None], grid).within_limits
    first = torch.where(possible.any(-1), grid[possible.int().argmax(-1)], torch.nan)
    own = crane.inverse(position).within_limits
    assert own.double().mean() > 0.9
    assert (least[own] <= first[own].nan_to_num(9.0) + 1e-9).all()
    # Where a shorter one would do, the linkages' ends allow none of either kind.
    assert not (possible.any(-1) & ~own).any()
    assert (first[own] - least[own]).nan_to_num(0.0).max() < 0.0101


@pytest.mark.parametrize(
    ("position", "least"),
    [((6.0, 1.0), 1.15), ((4.0, 2.0), 0.0), ((0.2, 1.3), 0.478), ((2.0, -4.0), 1.63)],
    ids=["ahead", "near", "folded", "below"],
)
def test_where_the_extension_must_be_out(position, least):
    assert crane.least_extension(position) == pytest.approx(least, abs=0.01)


def test_what_cannot_be_reached_is_flagged():
    # Far away with an extension that the crane does not have; at the lift joint in any direction, so in none.
    far = crane.inverse([[9.0, 1.0], [-0.09, 1.115], [4.0, 2.0]])
    assert far.reached.tolist() == [True, False, True]
    assert far.within_limits.tolist() == [False, False, True]
    assert not crane.inverse([9.0, 1.0], 1.6).reached


def test_an_extension_for_each_position_or_one_for_all():
    assert crane.inverse([[4.0, 2.0]] * 3, 0.1).strokes.shape == (3, 3)
    with pytest.raises((ValueError, RuntimeError)):
        crane.inverse([[4.0, 2.0]] * 3, [0.1, 0.2])


@pytest.mark.parametrize("bad", [[1.0, 2.0, 3.0], [math.nan, 0.0], 1.0])
def test_what_is_no_position_is_refused(bad):
    for function in (crane.inverse, crane.least_extension):
        with pytest.raises(ValueError, match="position"):
            function(bad)


# ---- the description -------------------------------------------------------------------------------


def test_the_crane_says_where_its_numbers_are_from():
    assert "Rouvinen" in PATU.source
    assert "MIT" in PATU.licence
    assert PATU.rating == 500.0
    assert dx.crane is crane


@pytest.mark.parametrize(
    ("old", "new", "named"),
    [
        ("rating = 500.0", "", "rating"),
        ("rating = 500.0", "rating = true", "rating"),
        ("rating = 500.0", "rating = inf", "rating"),
        ("rating = 500.0", 'rating = 500.0\ncolour = "red"', "colour"),
        ("crank = 0.45", 'crank = "long"', "crank of linkage"),
        ("jib_joint = [2.88, -0.024]", "jib_joint = [2.88]", "jib_joint of linkage"),
        ("ground_stiffness = 3.33e6", "ground_stiffness = 0", "structure: ground_stiffness"),
        ("[0.2, 0.2, 0.01]", "[0.2, 0.2, 0.11]", "pillar: a tube"),
        ("[0.2, 0.2, 0.01]", "[0.2, 0.2]", "tubes of pillar"),
        (", [0.2, 0.2, 0.01]", "", "pillar: there are 4 nodes and 2 tubes"),
        ("[linkage]", "[linkages]", "linkages"),
        ("[linkage]", "[linkage", "not a crane"),
    ],
)
def test_a_malformed_description_is_named(tmp_path, old, new, named):
    text = store.data_path("robots", "patu655.toml").read_text(encoding="utf-8")
    assert old in text
    file = tmp_path / "crane.toml"
    file.write_text(text.replace(old, new), encoding="utf-8")
    with pytest.raises(ValueError, match=rf"(?s)crane\.toml.*{named}"):
        crane.read_crane(file)
