"""A crane that is not quite its model."""

import dataclasses

import pytest
import torch
from torch.testing import assert_close

from dexterity import crane
from dexterity.crane.existing import JOINTS, Differences, ExistingCrane, existing_crane, joint_forces

MODEL = crane.patu655()
STROKES = torch.tensor(
    [[0.36, 0.65, 0.0], [0.3, 0.45, 0.2], [0.26, 0.64, 0.0], [0.1, 0.2, 1.2]], dtype=torch.float64
)
ROUNDED_ROCKER = 3e-4  # the listing rounds its length, which the structure takes from its pins

PAYLOAD = torch.tensor([0.0, 86.0, 172.0, 400.0], dtype=torch.float64)


def drawn(seed: int = 0, **differences: float) -> ExistingCrane:
    return existing_crane(Differences(**differences), torch.Generator().manual_seed(seed))


def potential(strokes: torch.Tensor, payload: torch.Tensor, some: crane.Crane = MODEL) -> torch.Tensor:
    """Energy (N) of the rigid crane's own weight and payload [J]."""
    assembly = crane.structure.Assembly.of(some)
    pose = assembly.placed(strokes)
    still = torch.zeros(len(strokes), assembly.size, dtype=torch.float64)
    weight = some.structure.gravity * payload
    return assembly.gravity_potential(pose, still) + weight * crane.tip_position(strokes, some)[:, 1]


def longer(some: crane.Crane, name: str, step: float) -> crane.Crane:
    linkage = dataclasses.replace(some.linkage, **{name: getattr(some.linkage, name) + step})
    return dataclasses.replace(some, linkage=linkage)


def test_without_differences_it_is_the_model():
    same = drawn()
    assert same.built == MODEL
    assert same.play == (0.0,) * len(JOINTS)
    assert_close(same.reading(STROKES, PAYLOAD), crane.flexible_tip(STROKES, PAYLOAD), rtol=0, atol=1e-15)


@pytest.mark.parametrize(("rod", "stroke"), [(0, 0), (1, 1), (4, 2)])
def test_cylinders_hold_what_virtual_work_says(rod, stroke):
    step = torch.zeros(3, dtype=torch.float64)
    step[stroke] = 1e-6
    strokes = STROKES + torch.tensor([0.0, 0.0, 0.01])  # off the extension's end
    slope = (potential(strokes + step, PAYLOAD) - potential(strokes - step, PAYLOAD)) / 2e-6
    found = joint_forces(strokes, PAYLOAD).rods[:, rod]
    tilted = 0.01 if stroke == 2 else ROUNDED_ROCKER  # the line of the jib's nodes is not quite its slide
    assert_close(found, slope, rtol=tilted, atol=1e-3)


@pytest.mark.parametrize(("rod", "name"), [(2, "crank"), (3, "coupler")])
def test_rods_hold_what_virtual_work_says(rod, name):
    slope = (
        potential(STROKES, PAYLOAD, longer(MODEL, name, 1e-6))
        - potential(STROKES, PAYLOAD, longer(MODEL, name, -1e-6))
    ) / 2e-6
    assert_close(joint_forces(STROKES, PAYLOAD).rods[:, rod], slope, rtol=ROUNDED_ROCKER, atol=1e-3)


def test_the_lift_joint_holds_what_the_lift_cylinder_leaves():
    forces = joint_forces(STROKES, PAYLOAD)
    lighter = joint_forces(STROKES, torch.zeros(4, dtype=torch.float64))
    more = forces.rods[:, 0] - lighter.rods[:, 0]
    place = crane.posture(STROKES)
    links = MODEL.linkage
    base, foot = STROKES.new_tensor([links.lift_joint, links.lift_cylinder_foot])
    along = base + crane.kinematics.turned(place.lift, links.lift_cylinder_rod) - foot
    along = along / along.norm(dim=-1, keepdim=True)
    weight = torch.stack([torch.zeros(4), -MODEL.structure.gravity * PAYLOAD], dim=-1)
    held = forces.pins[:, 0] - lighter.pins[:, 0] + more[:, None] * along + weight
    assert_close(held, torch.zeros(4, 2, dtype=torch.float64), rtol=0, atol=1e-6)


@pytest.mark.parametrize(
    ("joint", "name"), [("EH", "jib_cylinder_length"), ("FH", "crank"), ("IH", "coupler")]
)
def test_play_of_a_rod_is_that_rod_longer_or_shorter(joint, name):
    slack = 1e-5
    play = tuple(2 * slack * (other == joint) for other in JOINTS)
    sign = -joint_forces(STROKES, PAYLOAD).rods[:, JOINTS.index(joint) - 2].sign()
    ends = [crane.tip_position(STROKES, longer(MODEL, name, end * slack)) for end in (1, -1)]
    expected = torch.where(sign[:, None] > 0, *ends) - crane.tip_position(STROKES)
    assert_close(ExistingCrane(MODEL, play).seating(STROKES, PAYLOAD), expected, rtol=1e-3, atol=1e-9)


@pytest.mark.parametrize("joint", JOINTS)
def test_play_lets_a_heavy_load_down_and_is_doubled_with_its_size(joint):
    heavy = torch.full((4,), 500.0, dtype=torch.float64)
    weightless = dataclasses.replace(
        MODEL,
        structure=dataclasses.replace(
            MODEL.structure, density=1e-9, lift_cylinder_mass=0.0, jib_cylinder_mass=0.0, linkage_mass=0.0
        ),
    )
    play = tuple(1e-3 * (other == joint) for other in JOINTS)
    once = ExistingCrane(weightless, play).seating(STROKES, heavy)
    assert (once[:, 1] <= 1e-9).all()
    twice = ExistingCrane(weightless, tuple(2 * size for size in play)).seating(STROKES, heavy)
    assert_close(twice, 2 * once)


def test_pins_of_a_misaligned_crane_are_within_the_offset():
    built = drawn(3, misalignment=0.001).built
    for name in ("lift_joint", "coupler_pin", "jib_cylinder_foot"):
        for a, b in zip(getattr(MODEL.linkage, name), getattr(built.linkage, name), strict=True):
            assert 0 < abs(a - b) <= 0.001
    assert built.structure.bending_factor == MODEL.structure.bending_factor
    assert (crane.tip_position(STROKES, built) - crane.tip_position(STROKES)).norm(dim=-1).max() > 1e-3


def test_arms_of_a_misaligned_crane_meet_at_its_pins():
    built = drawn(5, misalignment=0.002).built
    assembly = crane.structure.Assembly.of(built)
    pose = assembly.placed(STROKES)
    pillar, lift, _, extension = assembly.members
    assert_close(pose.nodes[:, pillar.stop - 1], pose.nodes[:, lift.start])
    assert_close(pose.nodes[:, lift.stop - 1], pose.pins["G"])
    assert_close(pose.nodes[:, extension.stop - 1], crane.tip_position(STROKES, built))


def test_draws_are_the_same_whatever_is_switched_on():
    one, both = drawn(7, misalignment=0.001), drawn(7, misalignment=0.001, play=0.001, stiffness=0.1)
    assert one.built.linkage == both.built.linkage
    assert max(both.play) <= 0.002
    ratio = both.built.structure.ground_stiffness / MODEL.structure.ground_stiffness
    assert 0 < abs(ratio - 1) <= 0.1
    assert drawn(8, misalignment=0.001).built != one.built


def test_strokes_and_readings_are_rounded():
    coarse = drawn(stroke_step=0.01, reading_step=0.0005)
    read = coarse.reading(STROKES + 0.004, PAYLOAD)
    assert_close(read / 0.0005, (read / 0.0005).round(), rtol=0, atol=1e-9)
    assert_close(read, crane.flexible_tip(STROKES, PAYLOAD), rtol=0, atol=0.00026)


@pytest.mark.parametrize(
    ("wrong", "message"), [({"play": -1.0}, "play is -1.0"), ({"stiffness": 1.0}, "stiffness is 1.0")]
)
def test_differences_without_sense_are_refused(wrong, message):
    with pytest.raises(ValueError, match=message):
        Differences(**wrong)


def test_each_joint_needs_its_play():
    with pytest.raises(ValueError, match="play has 1 lengths"):
        ExistingCrane(MODEL, (0.0,))


def test_play_does_not_matter_where_the_model_was_set_right():
    loose = drawn(2, play=0.001)
    zeroed = loose.zeroed(STROKES[1], 86.0)
    at_rest = zeroed.seating(STROKES, PAYLOAD)
    assert_close(at_rest[1], torch.zeros(2, dtype=torch.float64), rtol=0, atol=1e-12)
    # At the third pose the jib cylinder pushes, and pulls at the second.
    assert joint_forces(STROKES, PAYLOAD).rods[1:3, 1].sign().tolist() == [-1, 1]
    assert at_rest[2].norm() > 1e-3
