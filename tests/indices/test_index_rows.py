"""Rows, directions and numbers of an index, and the measures that need them; published values."""

import math

import numpy as np
import pytest
import torch
from numpy.testing import assert_allclose
from torch.testing import assert_close

import dexterity as dx
from dexterity import indices
from dexterity.indices import Index
from dexterity.indices.measures.guaranteed_speed import inradius

PUMA = dx.robots.puma560()
NAMES = indices.names()


def scara() -> dx.Chain:
    rows = [{"a": 0.3}, {"a": 0.25, "alpha": math.pi}, {"kind": "prismatic"}, {}]
    return dx.Chain.from_dh(rows, name="scara")


def panda() -> dx.Chain:
    """Modified DH with the hand .1034 m beyond the flange, turned by −π/4 (robotics-toolbox-python)."""
    half = math.pi / 2
    rows = [
        {"d": 0.333}, {"alpha": -half}, {"alpha": half, "d": 0.316}, {"a": 0.0825, "alpha": half},
        {"a": -0.0825, "alpha": -half, "d": 0.384}, {"alpha": half}, {"a": 0.088, "alpha": half},
    ]  # fmt: skip
    tool = dx.spatial.exp([0, 0, 0.107 + 0.1034, 0, 0, 0]) @ dx.spatial.exp([0, 0, 0, 0, 0, -math.pi / 4])
    return dx.Chain.from_dh(rows, modified=True, tool=tool, name="panda")


# ---- published values ------------------------------------------------------------------------------


def test_four_joints_have_a_manipulability_over_the_rows_they_serve():
    """moveit_core#164, #200, moveit2#3411: w = a₁ a₂ |sin q₂| over vx, vy, vz and ωz."""
    arm, index = scara(), Index("w", "geometric", rows=("vx", "vy", "vz", "wz"))
    assert_allclose(index(arm, [0.1, 1.0, 0.05, 0.2]), 0.3 * 0.25 * math.sin(1.0), rtol=1e-14)
    assert_allclose(index(arm, [0.1, 1.0, 0.05, 0.2]), 0.0631103, atol=5e-8)
    assert index(arm, [0.1, 0.0, 0.05, 0.2]) < 1e-16


@pytest.mark.parametrize(
    ("name", "rows", "value"),
    [
        ("w", "full", 0.0837), ("w", "translational", 0.1438), ("w", "rotational", 2.7455),
        ("invcondition", "full", 0.11222), ("minsingular", "full", 0.209013),
    ],
)  # fmt: skip
def test_a_panda_has_the_values_of_robotics_toolbox_python(name, rows, value):
    """exotica#552, reach#29, #31, pink#185; the numbers of tests/test_ETS.py of robotics-toolbox-python."""
    q = [0, -0.3, 0, -2.2, 0, 2, math.pi / 4]
    # The values of the toolbox are cut off, not rounded.
    assert_allclose(Index(name, "geometric", rows=rows)(panda(), q), value, atol=1e-4)


def test_a_panda_elsewhere_has_the_value_of_robotics_toolbox_python():
    """robotics-toolbox-python, tests/test_Robot.py, test_manipulability."""
    q = [1.4, 0.2, 1.8, 0.7, 0.1, 3.1, 2.9]
    assert_allclose(Index("w")(panda(), q), 0.006559178, atol=5e-10)


def test_the_planar_jacobian_of_pinocchio_1222():
    """pinocchio#1222: geometric, rows x and y, [[−√2, −1/√2], [√2, 1/√2]] for l₁ = l₂ = 1 at (45°, 0)."""
    arm = dx.Chain.from_dh([{"a": 1.0}, {"a": 1.0}])
    J = Index("w", "geometric", rows=("vx", "vy")).normalised_jacobian(arm, [math.pi / 4, 0])
    root = math.sqrt(2)
    assert_allclose(J, [[-root, -1 / root], [root, 1 / root]], atol=1e-15)


PLANAR = ("vx", "vy", "wz")


@pytest.mark.parametrize(
    ("arm", "rows", "value"),
    [
        ([0.7, 0.4], ("vx", "vy"), lambda q: 0.7 * 0.4 * abs(math.sin(q[1]))),
        ([0.7, 0.4, 0.2], PLANAR, lambda q: 0.7 * 0.4 * abs(math.sin(q[1]))),
        ([0.3], ("vy",), lambda q: 0.3 * abs(math.cos(q[0]))),
    ],
    ids=["2R", "3R with its angle", "1R"],
)
def test_planar_arms_have_their_closed_forms(rng, arm, rows, value):
    """moveit_core#164, #200, moveit2#3411: fewer joints than six, and a w that is neither zero nor NaN."""
    chain = dx.Chain.from_dh([{"a": length} for length in arm])
    index = Index("w", "geometric", rows=rows)
    q = rng.uniform(-3, 3, (20, len(arm)))
    expected = [value(row) for row in q]
    assert_allclose(index.bind(chain)(q), expected, rtol=1e-12, atol=1e-15)
    assert_allclose(
        dx.symbolic.compile_index(chain, index, backend="torch")(q), expected, rtol=1e-12, atol=1e-15
    )


@pytest.mark.parametrize("joints", [4, 5, 9])
@pytest.mark.parametrize("rows", ["translational", "rotational", ("wz", "vx"), "full"], ids=str)
def test_any_number_of_joints_serves_any_rows(rng, joints, rows):
    """reach#29, #31, pink#185, roboplan#239: numpy's singular values, with fewer and with more than six."""
    dh = [dict(zip(("d", "a", "alpha"), rng.uniform(-1, 1, 3), strict=True)) for _ in range(joints)]
    chain, index = dx.Chain.from_dh(dh), Index("w", "geometric", rows=rows)
    q = rng.uniform(-2, 2, (10, joints))
    J = chain.geometric_jacobian(q).numpy()[:, index.row_numbers]
    if joints < len(index.row_numbers):
        assert (index.bind(chain)(q) == 0).all()
        with pytest.raises(ValueError, match="zero everywhere"):
            dx.symbolic.compile_index(chain, index, backend="torch")
        return
    expected = np.linalg.svd(J, compute_uv=False).prod(-1)
    assert_allclose(index.bind(chain)(q), expected, rtol=1e-11)
    assert_allclose(dx.symbolic.compile_index(chain, index, backend="torch")(q), expected, rtol=1e-9)


# ---- rows ------------------------------------------------------------------------------------------


def arguments(name: str, rows: tuple[int, ...]) -> dict[str, object]:
    along = (
        {"direction": tuple(np.arange(1.0, len(rows) + 1))}
        if "direction" in indices.describe(name).needs
        else {}
    )
    return {"rows": rows, **along}


STATIC = [name for name in NAMES if "inertias" not in indices.describe(name).needs]


@pytest.mark.parametrize(
    "rows", [(0, 1, 2, 3, 4, 5), (0, 1, 2), (3, 4, 5), (2, 5), (1,), (5, 0, 3, 1)], ids=str
)
@pytest.mark.parametrize("name", STATIC)
def test_rows_are_those_of_the_jacobian(rng, name, rows):
    index = Index(name, "body", **arguments(name, rows))
    q = torch.from_numpy(rng.uniform(-1, 1, (20, 6)))
    J = PUMA.body_jacobian(q)[:, rows]
    assert_close(index.normalised_jacobian(PUMA, q), J, rtol=0, atol=0)
    sigma = torch.linalg.svdvals(J)
    u = torch.tensor(index.direction if index.direction else [0.0] * len(rows), dtype=torch.float64)
    middle, half = (PUMA.upper + PUMA.lower) / 2, (PUMA.upper - PUMA.lower) / 2
    room = (1 - ((q - middle) / half) ** 2).clamp(min=0).prod(-1)
    inverse = torch.linalg.inv(J @ J.mT)
    w = sigma.prod(-1)
    expected = {
        "manipulability": w,
        "log_manipulability": w.log(),
        "order_independent_manipulability": w ** (1 / len(rows)),
        "smallest_singular_value": sigma[:, -1],
        "kinematic_conditioning": sigma[:, -1] / sigma[:, 0],
        "isotropy": w ** (2 / len(rows)) / sigma.square().mean(-1),
        "velocity_ratio": (u @ inverse @ u) ** -0.5,
        "force_ratio": (u @ (J @ J.mT) @ u) ** -0.5,
        "limited_manipulability": w * (1 - torch.exp(-10 * room)) / (1 - math.exp(-10)),
        "tool_deviation": sigma.square().sum(-1).sqrt(),
    }
    if name in expected:
        assert_close(index(PUMA, q), expected[name], rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("rows", [(0, 1, 2, 3, 4, 5), (0, 1, 2), (0, 5), (1,)], ids=str)
def test_guaranteed_speed_is_reached_in_every_direction_and_no_more(rng, rows):
    """The support function Σ|uᵀJ_i| is at least the radius for all u, and touches it."""
    chain = panda()
    q = torch.from_numpy(rng.uniform(-1, 1, (3, 7)))
    index = Index("guaranteed_speed", "geometric", joint_rates=(2.0,) * 3 + (1.0,) * 4, rows=rows)
    J, radius = index.normalised_jacobian(chain, q), index(chain, q)
    u = torch.from_numpy(rng.normal(size=(200_000, len(rows))))
    u = u / u.norm(dim=1, keepdim=True)
    support = (u @ J).abs().sum(-1)
    assert (support >= radius[:, None] * (1 - 1e-12)).all()
    # Random directions come close to the least one in few dimensions only.
    miss = {1: 1e-12, 2: 1e-3, 3: 0.02, 6: 3.0}[len(rows)]
    assert (support.amin(1) <= radius * (1 + miss)).all()


def test_a_flat_zonotope_guarantees_nothing_and_degenerate_columns_are_skipped():
    assert inradius(torch.ones(1, 3, 4, dtype=torch.float64)) == 0
    square = torch.tensor([[[1.0, 2.0, 0.0], [0.0, 0.0, 1.0]]], dtype=torch.float64)
    assert inradius(square) == 1.0


def test_the_characteristic_length_divides_velocities(rng):
    q = torch.from_numpy(rng.uniform(-1, 1, (5, 6)))
    scaled = Index("kci", "geometric", characteristic_length=0.4)(PUMA, q)
    assert_close(
        scaled, Index("kci", "geometric", tool_rates=(0.4,) * 3 + (1.0,) * 3)(PUMA, q), rtol=1e-15, atol=0
    )
    both = Index("kci", "geometric", tool_rates=(0.5,) * 6, characteristic_length=0.4)(PUMA, q)
    assert_close(both, scaled, rtol=1e-13, atol=0)


@pytest.mark.parametrize("name", STATIC)
def test_values_lie_within_the_bounds_and_gradients_are_finite_at_singularities(rng, name):
    index = Index(name, "geometric", **arguments(name, (0, 1, 2)))
    low, high = index.measure.bounds
    q = torch.from_numpy(rng.uniform(-3, 3, (20, 6)))
    q[:3] = 0
    q[3, 2] = math.pi / 2
    for arm in (PUMA, dx.Chain.from_dh([{"a": 1.0}] * 6)):
        x = q.clone().requires_grad_()
        value = index(arm, x)
        assert not value.isnan().any()
        assert ((value >= low) & (value <= high)).all()
        (gradient,) = torch.autograd.grad(value.sum(), x)
        assert gradient.isfinite().all()


def test_an_index_says_what_it_is():
    assert repr(Index("w")) == "Index('manipulability', 'spatial')"
    index = Index("sigma_min", "body", rows=(5, 0), characteristic_length=0.5)
    assert (
        repr(index)
        == "Index('smallest_singular_value', 'body', rows=('wz', 'vx'), characteristic_length=0.5)"
    )
    assert eval(repr(index)) == index
    assert index.title == "Smallest singular value, σ_m, wz vx"
    assert (
        Index("w", rows=(0, 1, 2)) == Index("w", rows="translational") == Index("w", rows=("vx", "vy", "vz"))
    )


def test_at_least_twelve_measures_say_all_there_is_to_say():
    assert len(NAMES) >= 12
    for name in NAMES:
        measure = indices.describe(name)
        assert measure.name == name
        assert all((measure.title, measure.formula, measure.unit, measure.meaning, measure.references))
        assert all(indices.describe(alias.upper()) is measure for alias in measure.aliases)


# ---- zero everywhere -------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("chain", "advice"),
    [
        (scara(), r"rows='translational'"),
        (dx.Chain.from_dh([{"a": 1.0}] * 3, name="planar"), r"rows=\('vx', 'vy', 'wz'\)"),
        (dx.Chain.from_dh([{"a": 1.0}] * 7, name="planar"), r"rows=\('vx', 'vy', 'wz'\)"),
        (dx.Chain.from_dh([{"a": 0.1, "alpha": 1.0}] * 5), r"rows='translational'"),
    ],
)
def test_an_index_that_is_zero_everywhere_is_refused_with_rows_that_are_not(chain, advice):
    with pytest.raises(ValueError, match=f"is zero everywhere.*{advice}"):
        indices.require_not_zero_everywhere(Index("w", "geometric"), chain)


def test_a_direction_that_is_never_reached_is_refused():
    arm = dx.Chain.from_dh([{"a": 1.0}] * 3, name="planar")
    for name, word in (("velocity_ratio", "zero"), ("force_ratio", "inf")):
        with pytest.raises(ValueError, match=f"is {word} everywhere"):
            indices.require_not_zero_everywhere(Index(name, "geometric", direction="vz"), arm)
        indices.require_not_zero_everywhere(Index(name, "geometric", direction="vx"), arm) if name[
            0
        ] == "f" else None


# ---- bad input -------------------------------------------------------------------------------------


NO_NUMBERS = (
    *("123456", b"123456", {1, 2, 3}, {1: 2}, [True] * 6, [1j] * 6, ["1"] * 6, [[1.0] * 6], 1.0, object()),
    *([math.nan] * 6, [math.inf] * 6, [-1.0] * 6),
)


@pytest.mark.usefixtures("annotations_unchecked")
@pytest.mark.parametrize("field", ["joint_rates", "tool_rates", "joint_noise"])
@pytest.mark.parametrize("values", NO_NUMBERS, ids=range(len(NO_NUMBERS)))
def test_rates_and_noise_that_are_no_numbers_are_refused_by_name(field, values):
    name = "tool_deviation" if field == "joint_noise" else "w"
    with pytest.raises((TypeError, ValueError), match=f"^{field} "):
        Index(name, **{field: values})


BAD = [
    *({"name": name} for name in (3, None, "")),
    *({"rows": rows} for rows in ("linear", (), (0, 0), (6,), (-1,), (1.5,), (True,), 3, {0, 1}, ("x",))),
    *({"direction": direction} for direction in ("vx", (1.0,) * 6)),
    *({"characteristic_length": length} for length in (0.0, "1", math.nan, True, -1, math.inf)),
    *({"name": "velocity_ratio", "direction": direction} for direction in (None, "z", (1, 0, 0), (0,) * 6)),
    {"name": "velocity_ratio", "direction": (math.nan,) * 6},
    {"joint_noise": (1.0,) * 6},
    {"frame": 3},
    {"tool_rates": (1.0,) * 5},
]


@pytest.mark.usefixtures("annotations_unchecked")
@pytest.mark.parametrize("given", BAD, ids=str)
def test_bad_arguments_are_refused_by_name(given):
    with pytest.raises((TypeError, ValueError), match=f"^{list(given)[-1]} (is|has|holds)"):
        Index(**({"name": "w"} | given))


@pytest.mark.usefixtures("annotations_unchecked")
def test_what_is_no_chain_is_refused():
    with pytest.raises(TypeError, match=r"^chain is 'puma'"):
        Index("w").bind("puma")


@pytest.mark.parametrize("name", ["joint_rates", "joint_noise"])
def test_the_wrong_number_of_rates_is_refused_when_bound(name):
    index = Index("tool_deviation", **{name: (1.0,) * 5})
    with pytest.raises(ValueError, match=rf"^{name} has shape \(5,\); \(6,\) is needed"):
        index.bind(PUMA)


@pytest.mark.parametrize("name", ["manipulability", "kinematic_conditioning", "velocity_ellipsoid"])
def test_numbers_whose_powers_overflow_are_refused(name):
    with pytest.raises(ValueError, match=r"^J holds numbers beyond 1e\+50"):
        getattr(indices, name)(np.full((6, 6), 1e154))
    uvms = dx.robots.uvms()
    for f in (Index("w").bind(uvms), Index("kci").bind(uvms)):
        with pytest.raises(ValueError, match=r"^q holds numbers beyond 1e\+50"):
            f([1e154] * 12)


@pytest.mark.parametrize("backend", ["torch", "c"])
@pytest.mark.parametrize("size", [1e77, 1e154, 1e300])
@pytest.mark.parametrize("name", ["kci", "isotropy"])
def test_a_compiled_index_is_finite_or_refuses(backend, size, name):
    compiled = dx.symbolic.compile_index(dx.robots.uvms(), Index(name), backend=backend)
    q = np.array([size] * 3 + [0.1] * 9)
    for call in (compiled, compiled.value_and_gradient):
        for given in (q, np.stack([q] * 3)):
            try:
                answer = call(given)
            except ValueError as error:
                if not str(error).startswith("q holds numbers beyond 1e+50"):
                    raise
                continue
            for part in answer if isinstance(answer, tuple) else [answer]:
                assert torch.as_tensor(part).isfinite().all()
