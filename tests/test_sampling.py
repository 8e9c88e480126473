"""Spaces against other descriptions of them, draws against what each kind of draw promises."""

import dataclasses
import itertools
import math
import tomllib
from functools import partial

import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import qmc
from torch.testing import assert_close

import dexterity as dx
from dexterity import sampling, store
from dexterity.chain import Chain
from dexterity.indices import Index
from dexterity.sampling import Box, TaskSector

UVMS = dx.robots.uvms()
INDICES = ["manipulability", "kinematic_conditioning"]
W_SPACE, KCI_SPACE = (sampling.uvms_space(name) for name in INDICES)
TURNED_SPACE = dataclasses.replace(KCI_SPACE, turned=True)
SMALL = Box([-1.0, 0.5, 2.0, 0.0], [1.0, 0.5, 3.0, 6.0], levels=[3, 2, 7])

spaces = pytest.mark.parametrize(
    "space", [W_SPACE, KCI_SPACE, TURNED_SPACE, SMALL], ids=["w", "kci", "turned", "box"]
)


def generator(seed: int = 0) -> torch.Generator:
    return torch.Generator().manual_seed(seed)


def cube(space, *batch: int) -> torch.Tensor:
    return torch.rand(*batch, space.dimensions, generator=generator(), dtype=torch.float64)


def vector(numbers) -> torch.Tensor:
    return torch.tensor(numbers, dtype=torch.float64)


def tight(actual, expected):
    assert_close(actual, expected, rtol=0, atol=1e-13)


# Strategies give what makes a space: type checks pick items at random, which hypothesis does not want.
@st.composite
def boxes(draw):
    lower = draw(st.lists(st.floats(-10, 10), min_size=1, max_size=6))
    widths = draw(st.lists(st.just(0.0) | st.floats(0.01, 10), min_size=len(lower), max_size=len(lower)))
    return partial(Box, lower, [a + width for a, width in zip(lower, widths, strict=True)])


@st.composite
def sectors(draw):
    point = st.tuples(*[st.floats(-3, 3)] * 3)
    r_min = draw(st.floats(0.05, 2))
    rest = draw(st.lists(st.just(0.0) | st.floats(0.1, 3), min_size=3, max_size=6))
    numbers = (
        draw(point), draw(point), r_min, r_min + draw(st.floats(0.05, 2)),
        draw(st.just(0.0) | st.floats(0.01, 3.1)), draw(st.just(0.0) | st.floats(0.01, 1.5)),
    )  # fmt: skip
    turned = draw(st.booleans())
    return lambda: TaskSector(*numbers, Box([-x for x in rest], rest), turned)


# ---- both ways between space and cube --------------------------------------------------------------


@given(make=boxes() | sectors(), seed=st.integers(0, 2**32))
def test_points_of_the_cube_come_back(make, seed):
    space = make()
    u = torch.rand(20, space.dimensions, generator=generator(seed), dtype=torch.float64)
    u = torch.cat([u, u.round()])
    q = space.from_unit(u)
    assert q.shape == (40, space.joints)
    assert_close(space.to_unit(q), u, rtol=0, atol=1e-11)
    assert_close(space.from_unit(space.to_unit(q)), q, rtol=0, atol=1e-11)
    assert space.contains(q).all()


@given(make=boxes() | sectors(), data=st.data())
def test_a_configuration_beyond_a_limit_is_outside(make, data):
    space = make()
    if space.dimensions == 0:
        return
    u = torch.rand(space.dimensions, generator=generator(), dtype=torch.float64)
    i = data.draw(st.integers(0, space.dimensions - 1))
    u[i] = data.draw(st.sampled_from([0.0, 1.0]))
    q = space.from_unit(u)
    outward = torch.autograd.functional.jacobian(space.from_unit, u)[:, i] * (1 if u[i] else -1)
    assert space.contains(q)
    # Along the tangent of an angle, so that only a short step stays clear of its other limit.
    assert not space.contains(q + 1e-4 * outward)


@given(make=boxes(), step=st.sampled_from([-0.1, 1e-6, 5.0]))
def test_a_held_joint_that_has_moved_is_outside(make, step):
    space = make()
    held = [i for i in range(space.joints) if i not in space.free_joints]
    q = space.from_unit(torch.full((space.dimensions,), 0.5, dtype=torch.float64))
    for i in held:
        moved = q.clone()
        moved[i] += step
        assert not space.contains(moved)
        tight(space.to_unit(moved), space.to_unit(q))


@spaces
def test_batches_are_mapped_row_by_row(space, batch_shape):
    u = cube(space, *batch_shape)
    q = space.from_unit(u)
    assert q.shape == (*batch_shape, space.joints)
    assert q.dtype == torch.float64
    assert space.to_unit(q).shape == u.shape
    assert space.contains(q).shape == batch_shape
    rows = [space.from_unit(row) for row in u.reshape(-1, space.dimensions)]
    tight(q.reshape(-1, space.joints), torch.stack(rows) if rows else q.reshape(0, space.joints))


@spaces
def test_gradients_agree_with_finite_differences(space):
    u = cube(space, 3).requires_grad_()
    assert torch.autograd.gradcheck(space.from_unit, u)
    assert torch.autograd.gradcheck(space.to_unit, space.from_unit(u).detach().requires_grad_())


@spaces
def test_all_spaces_have_one_interface(space):
    assert isinstance(space, sampling.Space)
    assert len(space.levels) == space.dimensions


@spaces
@pytest.mark.parametrize("beyond", [-1e-6, 1 + 1e-6, 7.0])
def test_points_outside_the_cube_are_refused(space, beyond):
    u = cube(space, 4)
    u[2, 1] = beyond
    with pytest.raises(ValueError, match=r"^u goes from .*0 to 1 is needed"):
        space.from_unit(u)


@spaces
@pytest.mark.parametrize("poison", [np.nan, np.inf])
def test_what_is_not_finite_is_refused(space, poison):
    with pytest.raises(ValueError, match=r"^u is not finite"):
        space.from_unit([poison] * space.dimensions)
    for function in (space.to_unit, space.contains):
        with pytest.raises(ValueError, match=r"^q is not finite"):
            function([poison] * space.joints)


@spaces
def test_the_wrong_number_of_joints_is_refused(space):
    for wrong in (0.5, np.zeros((2, space.dimensions + 1))):
        with pytest.raises(ValueError, match=rf"^u has shape .* {space.dimensions} coordinates"):
            space.from_unit(wrong)
    for wrong in (0.5, np.zeros((2, space.joints - 1))):
        for function in (space.to_unit, space.contains):
            with pytest.raises(ValueError, match=rf"^q has shape .* {space.joints} joints"):
                function(wrong)


# ---- boxes -----------------------------------------------------------------------------------------


def test_limits_of_a_box_are_met_exactly():
    ends = torch.stack([torch.zeros(7), torch.ones(7)])
    q = W_SPACE.from_unit(ends)
    assert tuple(q[0].tolist()) == W_SPACE.lower
    assert tuple(q[1].tolist()) == W_SPACE.upper
    assert torch.equal(W_SPACE.to_unit(q), ends.to(torch.float64))


def test_held_joints_have_no_coordinate():
    assert SMALL.joints == 4
    assert SMALL.dimensions == 3
    assert SMALL.free_joints == (0, 2, 3)
    assert (SMALL.from_unit(cube(SMALL, 9))[:, 1] == 0.5).all()


def test_a_box_of_a_chain_has_its_limits():
    puma = dx.robots.puma560()
    box = Box.from_chain(puma, levels=4)
    assert torch.equal(vector(box.lower), puma.lower)
    tight(box.from_unit(np.ones(6)), puma.upper)
    assert box.levels == (4,) * 6


def test_a_chain_without_limits_has_no_box():
    with pytest.raises(ValueError, match=r"^chain has unlimited joints: x, y, z, θx"):
        Box.from_chain(UVMS)


@pytest.mark.parametrize(
    ("lower", "upper", "levels", "message"),
    [
        ([0, 2], [1, 1], None, "lower exceeds upper at joint 2"),
        ([0, np.nan], [1, 1], None, "lower is not finite"),
        ([0, 0], [1, np.inf], None, "upper is not finite"),
        ([0, 0], [1, 1, 1], None, "lower has 2 joints and upper 3"),
        ([[0, 0]], [1, 1], None, r"lower has shape \(1, 2\)"),
        ([], [], None, r"lower has shape \(0,\)"),
        ([0, 0], [1, 1], 0, "levels is 0"),
        ([0, 0], [1, 1], 1, "levels is 1"),
        ([0, 0], [1, 1], [2, -3], "levels is -3"),
        ([0, 0], [1, 0], [2, 2], "levels has 2 entries.* 1 joints that vary"),
    ],
)
def test_an_impossible_box_is_refused(lower, upper, levels, message):
    with pytest.raises(ValueError, match=f"^{message}"):
        Box(lower, upper, levels)


def test_broken_levels_are_refused(annotations_unchecked):
    with pytest.raises(TypeError, match=r"^levels is 2\.5"):
        Box([0], [1], [2.5])


def test_equal_spaces_have_equal_keys_and_hashes():
    pairs = [
        (Box([-0.0, 0], [1, 2], 3), Box(torch.zeros(2), np.array([1.0, 2.0]), [3, 3])),
        (KCI_SPACE, sampling.uvms_space("kinematic_conditioning")),
        (KCI_SPACE, dataclasses.replace(KCI_SPACE)),
    ]
    for a, b in pairs:
        assert a == b
        assert hash(a) == hash(b)
        assert store.content_key(a) == store.content_key(b)
    different = [W_SPACE, KCI_SPACE, TURNED_SPACE, SMALL, dataclasses.replace(SMALL, levels=None)]
    assert len({store.content_key(space) for space in different}) == len(set(different)) == 5


def test_a_space_cannot_be_changed():
    with pytest.raises(dataclasses.FrozenInstanceError):
        SMALL.levels = None


# ---- the sector of paper A -------------------------------------------------------------------------


def transcribed(u, task_point, l_v_half, turned):
    """Write Fig. 7 down again in NumPy, one configuration at a time, from u to θ1 … θ12."""
    quarter = math.pi / 12
    r = 0.2 + 0.8 * u[0]
    azimuth, elevation = (2 * u[1:3] - 1) * quarter
    theta = np.zeros(12)
    theta[3:11] = (2 * u[3:] - 1) * quarter

    def about(axis, angle):
        along, across = np.outer(axis, axis), np.cross(axis, np.eye(3)).T
        return along + np.cos(angle) * (np.eye(3) - along) + np.sin(angle) * across

    x, y, z = np.eye(3)
    # A positive elevation of the line of sight turns it from y towards z, a positive azimuth towards x.
    sight = about(z, -azimuth) @ about(x, elevation) @ y
    R = about(x, theta[3]) @ about(y, theta[4]) @ about(z, theta[5]) if turned else np.eye(3)
    theta[:3] = task_point - r * sight - R @ np.array([0, l_v_half, 0])
    return theta


@pytest.mark.parametrize("task_point", [(0.0, 1.35, 0.0), (0.0, 0.0, 0.0), (3.0, -1.0, 0.5)])
@pytest.mark.parametrize("turned", [False, True])
def test_the_sector_agrees_with_an_independent_transcription(rng, task_point, turned):
    space = sampling.uvms_space("kinematic_conditioning", task_point=task_point, turned=turned)
    u = rng.uniform(size=(50, 11))
    expected = np.stack([transcribed(row, np.array(task_point), 0.75, turned) for row in u])
    np.testing.assert_allclose(space.from_unit(u), expected, rtol=0, atol=1e-14)


def base_of_the_turned_vehicle(q):
    """Place the arm's base by the product of exponentials of the vehicle's six joints."""
    home = torch.eye(4, dtype=torch.float64)
    home[1, 3] = 0.75
    return Chain(UVMS.screws[:6], home).forward(q[..., :6])[..., :3, 3]


def distance_to_task(space, base):
    return (base - vector(space.task_point)).norm(dim=-1)


def test_the_unturned_base_is_where_the_direction_says():
    q = sampling.uniform(KCI_SPACE, 1000, generator())
    base = q[:, :3] + vector(KCI_SPACE.base_offset)
    r = distance_to_task(KCI_SPACE, base)
    tight(r, 0.2 + 0.8 * KCI_SPACE.to_unit(q)[:, 0])
    ahead = vector(KCI_SPACE.task_point) - base
    assert (ahead[:, 0].abs() <= math.tan(math.radians(15)) * ahead[:, 1]).all()
    assert (ahead[:, 2].abs() <= math.sin(math.radians(15)) * r).all()


def test_turning_the_vehicle_takes_the_base_of_some_configurations_out_of_the_sector():
    """Fig. 7 promises a task point within reach; that fails for some if the vehicle turns later."""
    q = sampling.uniform(KCI_SPACE, 20_000, generator())
    r = distance_to_task(KCI_SPACE, base_of_the_turned_vehicle(q))
    is_out = (r < KCI_SPACE.r_min) | (r > KCI_SPACE.r_max)
    # 3.8 % of 300 000; five standard deviations of a share among 20 000.
    assert is_out.double().mean() == pytest.approx(0.038, abs=0.007)
    assert not TURNED_SPACE.contains(q).all()


def test_the_base_of_the_turned_vehicle_stays_in_the_turned_sector():
    q = sampling.uniform(TURNED_SPACE, 20_000, generator())
    r = distance_to_task(TURNED_SPACE, base_of_the_turned_vehicle(q))
    tight(r, 0.2 + 0.8 * TURNED_SPACE.to_unit(q)[:, 0])


def test_the_reference_configuration_is_in_the_middle():
    for space in (W_SPACE, KCI_SPACE, TURNED_SPACE):
        tight(space.from_unit(np.full(space.dimensions, 0.5)), vector([0] * 12))


def test_an_angle_that_does_not_vary_has_no_coordinate():
    flat = dataclasses.replace(KCI_SPACE, elevation=0.0)
    assert flat.levels == (None, None) + (7,) * 8
    q = sampling.uniform(flat, 100, generator())
    tight(q[:, 2], vector([0] * 100))
    q[:, 2] += 1e-3
    assert not flat.contains(q).any()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"r_min": 0.0}, r"r_min is 0\.0"),
        ({"r_min": 1.0}, r"r_min is 1\.0"),
        ({"r_max": math.nan}, "r_max is nan"),
        ({"r_max": math.inf}, "r_max is inf"),
        ({"azimuth": -0.1}, "azimuth is -0.1"),
        ({"azimuth": 3.2}, "azimuth is 3.2"),
        ({"elevation": math.pi / 2}, r"elevation is 1\.57"),
        ({"elevation": math.nan}, "elevation is nan"),
        ({"task_point": (0.0, math.nan, 0.0)}, "task_point is not finite"),
        ({"rest": Box([0, 0], [1, 1]), "turned": True}, "rest has 2 joints"),
    ],
)
def test_an_impossible_sector_is_refused(change, message):
    with pytest.raises(ValueError, match=f"^{message}"):
        dataclasses.replace(KCI_SPACE, **change)


def test_a_point_of_two_numbers_is_refused(annotations_unchecked):
    with pytest.raises(ValueError, match=r"^base_offset has 2 numbers"):
        dataclasses.replace(KCI_SPACE, base_offset=(0.0, 1.0))


# ---- the spaces of paper A -------------------------------------------------------------------------


def test_inputs_are_those_of_equations_11_and_12():
    assert sampling.relevant_joints(UVMS, Index("kinematic_conditioning")) == tuple(range(11))
    assert sampling.relevant_joints(UVMS, Index("manipulability")) == tuple(range(4, 11))


def test_unequal_translation_rates_make_a_further_joint_relevant():
    unequal = Index("manipulability", joint_rates=(1.0, 2.0, 3.0) + (1.0,) * 9)
    assert sampling.relevant_joints(UVMS, unequal) == tuple(range(3, 11))


@pytest.mark.parametrize("name", INDICES)
def test_what_a_space_varies_is_what_the_index_depends_on(name):
    space = sampling.uvms_space(name)
    q = sampling.uniform(space, 50, generator())
    varying = [i for i in range(12) if len(q[:, i].unique()) > 1]
    assert tuple(varying) == sampling.relevant_joints(UVMS, Index(name))


def test_settings_are_those_of_the_paper():
    settings = tomllib.loads(store.data_path("papers", "sotiropoulos2016", "settings.toml").read_text())
    printed = {setting["id"]: setting.get("value") for setting in settings["settings"]}
    low, high = (math.radians(x) for x in printed["joint-range"])
    for space in (W_SPACE, KCI_SPACE):
        box = getattr(space, "rest", space)
        assert [box.lower[i] for i in box.free_joints] == pytest.approx([low] * len(box.free_joints))
        assert [box.upper[i] for i in box.free_joints] == pytest.approx([high] * len(box.free_joints))
        step = (high - low) / (box.levels[0] - 1)
        assert math.degrees(step) == pytest.approx(printed["joint-step"])
    assert KCI_SPACE.r_min == pytest.approx(printed["inner-radius"])
    assert KCI_SPACE.r_max == pytest.approx(printed["outer-radius"])
    assert math.degrees(2 * KCI_SPACE.azimuth) == pytest.approx(printed["sampling-angle"])


def test_wider_ranges_keep_the_step_and_the_sector():
    wide = sampling.uvms_space("kinematic_conditioning", half_range_deg=90)
    assert wide.levels == (None,) * 3 + (37,) * 8
    assert wide.azimuth == KCI_SPACE.azimuth
    assert sampling.uvms_space("manipulability", 10, 2.5).levels == (9,) * 7


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("dexterity",), "name is 'dexterity'"),
        (("manipulability", 15, 4), "step_deg is 4"),
        (("manipulability", 15, 31), "step_deg is 31"),
        (("manipulability", 15, 0), "step_deg is 0"),
        (("manipulability", -15, 5), "half_range_deg is -15"),
        (("manipulability", math.nan, 5), "half_range_deg is nan"),
        (("manipulability", 15, math.nan), "step_deg is nan"),
    ],
)
def test_an_impossible_space_of_the_paper_is_refused(arguments, message):
    with pytest.raises(ValueError, match=f"^{message}"):
        sampling.uvms_space(*arguments)


# ---- grids -----------------------------------------------------------------------------------------


def keys(q):
    """Rows as bytes, the same for the same row only."""
    return [row.tobytes() for row in q.numpy()]


def test_a_grid_is_the_product_of_its_values():
    values = [np.linspace(a, b, k) for a, b, k in [(-1, 1, 3), (0.5, 0.5, 1), (2, 3, 2), (0, 6, 7)]]
    expected = np.array(list(itertools.product(*values)))
    assert sampling.grid_size(SMALL) == len(expected) == 42
    np.testing.assert_allclose(sampling.grid(SMALL), expected, rtol=0, atol=1e-15)


def test_a_grid_comes_whole_or_in_pieces():
    pieces = [sampling.grid(SMALL, start, min(start + 10, 42)) for start in range(0, 42, 10)]
    assert torch.equal(torch.cat(pieces), sampling.grid(SMALL))
    assert sampling.grid(SMALL, 5, 5).shape == (0, 4)


def test_the_grid_of_w_has_7_to_the_7_rows_in_steps_of_5_degrees():
    assert sampling.grid_size(W_SPACE) == 7**7 == 823_543
    last = sampling.grid(W_SPACE, 7**7 - 1000)
    steps = last.rad2deg() / 5
    tight(steps, steps.round())
    assert torch.equal(last[-1], vector(W_SPACE.upper))


@pytest.mark.parametrize(("start", "stop"), [(-1, 3), (4, 3), (0, 43)])
def test_rows_that_a_grid_does_not_have_are_refused(start, stop):
    with pytest.raises(ValueError, match=r"^start is .*≤ 42 is needed"):
        sampling.grid(SMALL, start, stop)


def test_a_space_with_continuous_coordinates_has_no_whole_grid():
    for function in (sampling.grid, sampling.grid_size):
        with pytest.raises(ValueError, match=r"^space has 3 coordinates without a grid"):
            function(KCI_SPACE)


def test_the_grid_of_a_single_configuration_has_one_row():
    assert torch.equal(sampling.grid(Box([1, 2], [1, 2])), vector([[1, 2]]))


# ---- draws -----------------------------------------------------------------------------------------


def test_draws_on_the_grid_are_different_rows_of_it():
    q = sampling.on_grid(W_SPACE, 5000, generator())
    assert len(set(keys(q))) == 5000
    numbers = W_SPACE.to_unit(q) * 6
    tight(numbers, numbers.round())


def test_as_many_draws_as_rows_are_the_grid_in_another_order():
    q = sampling.on_grid(SMALL, 42, generator())
    grid = sampling.grid(SMALL)
    assert keys(q) != keys(grid)
    assert sorted(keys(q)) == sorted(keys(grid))


def test_each_row_of_a_grid_is_as_likely():
    drawn = [key for seed in range(600) for key in keys(sampling.on_grid(SMALL, 7, generator(seed)))]
    counts = np.unique(drawn, return_counts=True)[1]
    # 42 rows, 600 draws of 7: binomial with mean 100 and deviation 9.1.
    assert len(counts) == 42
    assert abs(counts - 100).max() < 5 * 9.2


def test_a_grid_too_large_to_be_written_out_is_drawn_from():
    wide = sampling.uvms_space("manipulability", half_range_deg=90)
    assert sampling.grid_size(wide) == 37**7
    q = sampling.on_grid(wide, 10_000, generator())
    assert len(set(keys(q))) == 10_000
    assert wide.contains(q).all()


def test_only_coordinates_without_a_grid_are_drawn_between_its_points():
    u = KCI_SPACE.to_unit(sampling.on_grid(KCI_SPACE, 5000, generator()))
    off_grid = (u * 6 - (u * 6).round()).abs() > 1e-6
    assert off_grid[:, :3].double().mean() > 0.99
    assert not off_grid[:, 3:].any()
    assert [len((column * 6).round().unique()) for column in u[:, 3:].T] == [7] * 8


@spaces
def test_uniform_draws_are_inside_and_uniform_in_the_cube(space):
    q = sampling.uniform(space, 20_000, generator())
    assert space.contains(q).all()
    u = space.to_unit(q)
    # Five standard deviations of a mean and of a correlation.
    assert abs(u.mean(0) - 0.5).max() < 5 / math.sqrt(12 * 20_000)
    correlation = np.corrcoef(u.T) - np.eye(space.dimensions)
    assert abs(correlation).max() < 5 / math.sqrt(20_000)


@spaces
def test_a_sobol_sequence_is_stratified_in_each_coordinate(space):
    q = sampling.sobol(space, 1024, seed=3)
    assert space.contains(q).all()
    strata = (space.to_unit(q) * 1024).clamp(0, 1023).floor()
    # Rounding may push a point over the edge of its stratum, not further.
    assert all(len(column.unique()) >= 1022 for column in strata.T)


def test_a_sobol_sequence_fills_the_cube_more_evenly_than_random_draws():
    def discrepancy(q):
        return qmc.discrepancy(W_SPACE.to_unit(q).clamp(0, 1).numpy())

    even = [discrepancy(sampling.sobol(W_SPACE, 512, seed)) for seed in range(5)]
    random = [discrepancy(sampling.uniform(W_SPACE, 512, generator(seed))) for seed in range(5)]
    assert max(even) < 0.5 * min(random)


def test_an_overhang_moves_its_share_of_each_coordinate_onto_the_bounds():
    u = KCI_SPACE.to_unit(sampling.sobol(KCI_SPACE, 4096, 1, overhang=0.5))
    on_a_face = ((u - 0.5).abs() > 0.5 - 1e-9).double().mean(0)
    torch.testing.assert_close(on_a_face, torch.full_like(on_a_face, 1 / 3), rtol=0, atol=0.01)
    assert bool(KCI_SPACE.contains(KCI_SPACE.from_unit(u.clamp(0, 1))).all())


@pytest.mark.parametrize("overhang", [-0.1, float("inf"), float("nan")])
def test_an_overhang_that_is_no_share_is_refused(overhang):
    with pytest.raises(ValueError, match="overhang"):
        sampling.sobol(SMALL, 8, 0, overhang)


def test_longer_sobol_sequences_begin_with_shorter_ones():
    assert torch.equal(sampling.sobol(SMALL, 100, 7)[:40], sampling.sobol(SMALL, 40, 7))
    assert not torch.equal(sampling.sobol(SMALL, 40, 7), sampling.sobol(SMALL, 40, 8))


@pytest.mark.parametrize("draw", [sampling.uniform, sampling.on_grid])
def test_draws_repeat_with_the_seed_and_leave_the_global_one_alone(draw):
    state = torch.get_rng_state()
    first, again, other = (draw(KCI_SPACE, 100, generator(seed)) for seed in (1, 1, 2))
    assert keys(first) == keys(again)
    assert not set(keys(first)) & set(keys(other))
    random = generator(1)
    assert keys(draw(KCI_SPACE, 100, random)) != keys(draw(KCI_SPACE, 100, random))
    sampling.sobol(KCI_SPACE, 10, 0)
    assert torch.equal(torch.get_rng_state(), state)


DRAWS = [
    lambda space, count: sampling.uniform(space, count, generator()),
    lambda space, count: sampling.on_grid(space, count, generator()),
    lambda space, count: sampling.sobol(space, count, 0),
]


@pytest.mark.parametrize("draw", DRAWS)
def test_no_draws_and_nothing_to_draw_are_refused(draw):
    for count in (0, -3):
        with pytest.raises(ValueError, match=f"^count is {count}; a whole number of at least 1"):
            draw(SMALL, count)
    with pytest.raises(ValueError, match=r"^space is a single configuration"):
        draw(Box([1, 2], [1, 2]), 5)


def test_more_rows_than_the_grid_has_are_refused():
    with pytest.raises(ValueError, match=r"^count is 43; the grid has 42 rows"):
        sampling.on_grid(SMALL, 43, generator())
    with pytest.raises(ValueError, match="fewer than 2⁶³"):
        sampling.on_grid(Box([0] * 10, [1] * 10, 100), 5, generator())


def test_a_space_without_a_grid_is_not_drawn_from_on_the_grid():
    with pytest.raises(ValueError, match=r"^space has no grid"):
        sampling.on_grid(Box([0, 0], [1, 1]), 5, generator())


# ---- data sets -------------------------------------------------------------------------------------


def product(q):
    return q.prod(-1)


METHODS = ["grid", "sobol", "uniform"]
SIZES = {"train": 300, "test": 100, "validation": 200}


def parts(sets):
    return {name: getattr(sets, name) for name in SIZES}


@spaces
@pytest.mark.parametrize("method", METHODS)
def test_no_configuration_occurs_twice(space, method):
    sizes = {"train": 20, "test": 15, "validation": 30} if space is SMALL else SIZES
    sets = parts(sampling.data_sets(product, space, **sizes, seed=1, method=method))
    assert {name: len(part.q) for name, part in sets.items()} == sizes
    assert len(set(keys(torch.cat([part.q for part in sets.values()])))) == sum(sizes.values())
    assert all(space.contains(part.q).all() for part in sets.values())


@pytest.mark.parametrize("test", [1, 20, 41])
def test_training_and_test_set_share_out_the_grid(test):
    sets = sampling.data_sets(product, SMALL, train=42 - test, test=test, validation=5)
    rows = keys(torch.cat([sets.train.q, sets.test.q]))
    assert sorted(rows) == sorted(keys(sampling.grid(SMALL)))
    with pytest.raises(ValueError, match=f"the grid has {42 - test} rows"):
        sampling.data_sets(product, SMALL, train=43 - test, test=test, validation=5)


def test_as_the_paper_training_and_test_are_on_the_grid_and_validation_is_not():
    sets = sampling.data_sets(product, W_SPACE)
    assert [len(part.q) for part in parts(sets).values()] == [5000, 1000, 1000]
    for part in (sets.train, sets.test):
        numbers = W_SPACE.to_unit(part.q) * 6
        tight(numbers, numbers.round())
    numbers = W_SPACE.to_unit(sets.validation.q) * 6
    assert ((numbers - numbers.round()).abs() > 1e-3).any(-1).all()


@pytest.mark.parametrize("name", INDICES)
def test_values_are_those_of_the_index(name):
    f = Index(name).bind(UVMS)
    sets = sampling.data_sets(f, sampling.uvms_space(name), **SIZES)
    for part in parts(sets).values():
        assert_close(part.values, f(part.q), rtol=0, atol=0)


@pytest.mark.parametrize("method", METHODS)
def test_the_same_seed_gives_the_same_sets_and_another_seed_others(method):
    def sets(seed):
        return parts(sampling.data_sets(product, KCI_SPACE, **SIZES, seed=seed, method=method))

    first, again, other = sets(4), sets(4), sets(5)
    for name in SIZES:
        assert store.content_key(first[name]) == store.content_key(again[name])
        assert not set(keys(first[name].q)) & set(keys(other[name].q))


@pytest.mark.parametrize("method", METHODS)
def test_test_and_validation_stay_while_the_training_set_grows(method):
    few, many = (
        sampling.data_sets(product, W_SPACE, train=train, test=50, validation=60, method=method)
        for train in (10, 1000)
    )
    assert keys(few.test.q) == keys(many.test.q)
    assert keys(few.validation.q) == keys(many.validation.q)


@pytest.mark.parametrize("name", SIZES)
@pytest.mark.parametrize("number", [0, -1])
def test_an_empty_set_is_refused(name, number):
    with pytest.raises(ValueError, match=f"^{name} is {number}"):
        sampling.data_sets(product, SMALL, **{name: number})


@pytest.mark.parametrize(
    ("f", "message"),
    [
        (lambda q: q, r"f\(q\) has shape \(20, 4\)"),
        (lambda q: q.sum(), r"f\(q\) has shape \(\)"),
        (lambda q: q[:-1].sum(-1), r"f\(q\) has shape \(19,\)"),
        (lambda q: q[:, 0] / 0, r"f\(q\) is not finite"),
    ],
)
def test_an_index_that_returns_something_else_is_refused(f, message):
    with pytest.raises(ValueError, match=f"^{message}"):
        sampling.data_sets(f, SMALL, train=20, test=20, validation=20)


def test_a_space_with_too_few_configurations_is_refused():
    line = Box([1.0], [math.nextafter(1.0, 2.0)])
    with pytest.raises(ValueError, match=r"^space gave only 2 different configurations in 15"):
        sampling.data_sets(product, line, train=5, test=5, validation=5, method="uniform")


def test_an_unknown_method_is_refused(annotations_unchecked):
    with pytest.raises(ValueError, match=r"^method is 'random'"):
        sampling.data_sets(product, SMALL, method="random")


# ---- numbers of numpy, and what is no number: cases of the review, faults #21 and #22 -------------------


@pytest.mark.usefixtures("annotations_unchecked")
def test_whole_numbers_of_numpy_are_taken():
    box = Box([0.0, 0.0], [1.0, 1.0], levels=np.int64(5))
    assert box == Box([0.0, 0.0], [1.0, 1.0], levels=5)
    assert torch.equal(sampling.sobol(box, np.int32(4), np.int64(3)), sampling.sobol(box, 4, 3))
    assert sampling.grid(box, np.int64(2), np.uint8(7)).shape == (5, 2)


@pytest.mark.parametrize(
    ("call", "name"),
    [
        (lambda box: sampling.sobol(box, "3", 0), "count"),
        (lambda box: sampling.sobol(box, 3, "0"), "seed"),
        (lambda box: sampling.sobol(box, math.nan, 0), "count"),
        (lambda box: sampling.sobol(box, 3, 0, overhang="1"), "overhang"),
        (lambda box: sampling.grid(box, start=2.5), "start"),
        (lambda box: sampling.uniform(box, 2.5, torch.Generator()), "count"),
        (lambda box: sampling.uniform(box, 2, 0), "random"),
        (lambda box: sampling.sobol("box", 2, 0), "space"),
        (lambda box: Box([0.0], [1.0], levels=True), "levels"),
        (lambda box: Box([0.0], [1.0], levels=b"a"), "levels"),
        (lambda box: sampling.data_sets(lambda q: q[:, 0], box, train=2.5), "train"),
        (lambda box: sampling.data_sets(lambda q: q[:, 0], box, seed=None), "seed"),
    ],
)
@pytest.mark.usefixtures("annotations_unchecked")
def test_what_is_no_number_is_refused_by_name(call, name):
    with pytest.raises((TypeError, ValueError), match=f"^{name} "):
        call(Box([0.0, 0.0], [1.0, 1.0], levels=5))


# ---- a box about a configuration -------------------------------------------------------------------


def limited(lower, upper):
    screws = [[0.0, 0, 0, 0, 0, 1], [0, 0, 0, 0, 1, 0], [1, 0, 0, 0, 0, 0]]
    return dx.Chain(screws, np.eye(4), lower=lower, upper=upper)


def test_a_box_about_a_configuration_ends_at_the_limits():
    chain = limited([-1.0, -2.0, 0.1], [1.0, math.inf, 0.3])
    assert Box.around(chain, [0.9, 0.0, 0.2], 0.5) == Box([0.4, -0.5, 0.1], [1.0, 0.5, 0.3])
    held = Box.around(chain, half_range=[0.2, 0.3, 0.05], joints=(1, 2))
    np.testing.assert_allclose(held.lower, [0.0, -0.3, 0.15])
    np.testing.assert_allclose(held.upper, [0.0, 0.3, 0.25])
    assert Box.around(limited([2.0, -9.0, -9.0], [math.inf, -4.0, 9.0])).upper[0] == 2.0 + math.radians(20)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"q": [0.0, 0.0]}, r"^q has shape \(2,\)"),
        ({"q": [2.0, 0.0, 0.2]}, r"^q is outside the limits of the chain at joint 1"),
        ({"half_range": 0.0}, r"^half_range is 0\.0"),
        ({"half_range": [1.0, 1.0]}, r"^half_range is"),
        ({"joints": [3]}, r"^joints\[0\] is 3"),
    ],
)
def test_a_box_that_does_not_fit_the_chain_is_refused(arguments, message):
    with pytest.raises(ValueError, match=message):
        Box.around(limited([-1.0, -2.0, 0.1], [1.0, 2.0, 0.3]), **arguments)


# ---- what an open index depends on -----------------------------------------------------------------


def test_an_index_that_is_zero_everywhere_depends_on_nothing_and_is_refused():
    """Point 3.2 of the engineer's trial: (1, 2, 3) for an arm whose index is 0 everywhere."""
    puma = dx.robots.puma560()
    short = dx.Chain(puma.screws[:5], puma.home, name="short")
    for name in ("manipulability", "guaranteed_speed"):  # the second one has no slope there at all
        with pytest.raises(ValueError, match=r"^short has 5 joints; .* is zero everywhere: .*Take rows="):
            sampling.relevant_joints(short, Index(name))
    assert sampling.relevant_joints(short, Index("manipulability", "geometric", rows="translational"))


@pytest.mark.parametrize("name", ["guaranteed_speed", "limited_manipulability"])
def test_joints_of_a_measure_are_those_along_which_it_changes(name):
    chain = dx.robots.ur5e()
    chain = dx.Chain(
        chain.screws,
        chain.home,
        lower=[-1.0, -2.0, 0.5, -2.0, -2.0, -1.0],
        upper=[1.0, -1.0, 2.0, 0.0, -1.0, 1.0],
    )
    index = Index(name, "geometric", rows="translational")
    q = sampling.sobol(Box.from_chain(chain), 8, 1).requires_grad_()
    (slopes,) = torch.autograd.grad(index.bind(chain)(q).sum(), q)
    changing = tuple((slopes.abs().amax(0) > 1e-9).nonzero().flatten().tolist())
    assert sampling.relevant_joints(chain, index) == changing
