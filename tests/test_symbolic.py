"""Compiled indices against the plain computation in float64, on the robots of the package and random ones.

The plain computation is exact up to a few rounding errors of the Jacobian. Relative to the smallest singular
value these grow as ε/KCI, in both computations alike; so does what the manipulability may differ by.
"""

import math
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from itertools import count

import mpmath
import numpy as np
import pytest
import torch
from numpy.testing import assert_allclose, assert_array_equal
from torch.testing import assert_close

import dexterity as dx
from dexterity import robots, symbolic
from dexterity.codegen import library
from dexterity.derivation import programs
from dexterity.indices import Frame, Index
from dexterity.symbolic import CompilationFailed, SymbolicChain
from serial_chains import random_robot

W, KCI = "manipulability", "kinematic_conditioning"
NAMES = (W, KCI)
FRAMES: tuple[Frame, ...] = ("spatial", "body", "geometric")
UVMS, PUMA, ARM = dx.robots.uvms(), dx.robots.puma560(), dx.robots.docking_arm()

both_backends = pytest.mark.parametrize("backend", ["torch", "c"])
both_indices = pytest.mark.parametrize("name", NAMES)

FLAGS_OF_THE_LIBRARY = library.FLAGS  # as they are before tests compile without optimisation


@pytest.fixture
def in_the_middle_link(monkeypatch, tmp_path) -> None:
    """Derive in the middle link: the search for the shortest formulas changes no value and takes longest."""
    monkeypatch.setenv("DEXTERITY_CACHE", str(tmp_path))
    monkeypatch.setattr(programs, "_shortest", lambda chain, index, weights, places: places[len(places) // 2])


compiled = cache(symbolic.compile_index)


def configurations(rng: np.random.Generator, chain: dx.Chain, count: int = 100) -> torch.Tensor:
    return torch.from_numpy(rng.uniform(-3, 3, (count, chain.joints)))


def assert_agrees(values: torch.Tensor, chain: dx.Chain, index: Index, q: torch.Tensor) -> None:
    """Compare with the plain computation: KCI in absolute terms, w in relative ones divided by KCI."""
    plain = index.bind(chain)(q)
    kci = replace(index, name=KCI).bind(chain)(q)
    if index.name == KCI:
        assert_close(values, plain, rtol=0, atol=1e-13)
        assert_close(values[kci > 1e-3], plain[kci > 1e-3], rtol=1e-10, atol=0)
    else:
        # Products, since rounding may leave zero in w or in KCI at a singularity.
        error = (values - plain).abs() * (kci / 1e-3).clamp(max=1)
        assert (error <= 1e-12 * plain).all()
        assert_close(values, plain, rtol=1e-9, atol=1e-10)


# ---- values ----------------------------------------------------------------------------------------

ROV = (0.5,) * 3 + (0.3,) * 3 + (1.0,) * 6
UNEVEN_ROV = (0.5, 0.4, 0.3, 0.3, 0.2, 0.3, 1.0, 0.9, 0.8, 0.7, 0.6, 0.5)
BLOCKWISE, UNEVEN = (0.5,) * 3 + (2.0,) * 3, (0.5, 1.0, 0.7, 2.0, 1.0, 3.0)
CASES = {
    "uvms w": (UVMS, Index(W)),
    "uvms w, all limits": (UVMS, Index(W, "body", UNEVEN_ROV, UNEVEN)),
    "uvms spatial": (UVMS, Index(KCI)),
    "uvms body, rov": (UVMS, Index(KCI, "body", ROV, BLOCKWISE)),
    "uvms, all limits": (UVMS, Index(KCI, "spatial", UNEVEN_ROV, UNEVEN)),
    "uvms with seven joints": (UVMS, Index(KCI, "body", (0.0,) * 5 + (1.0,) * 7)),
    "puma w": (PUMA, Index(W, tool_rates=UNEVEN)),
    "puma spatial": (PUMA, Index(KCI, "spatial", tool_rates=UNEVEN)),
    "puma body": (PUMA, Index(KCI, "body", (0.3, 1.0, 0.7, 2.0, 1.0, 3.0), UNEVEN)),
    "puma geometric": (PUMA, Index(KCI, "geometric", tool_rates=UNEVEN)),
    "stated arm w": (ARM, Index(W)),
    "stated arm": (ARM, Index(KCI)),
    "fitted arm w": (dx.robots.docking_arm("fitted"), Index(W, tool_rates=BLOCKWISE)),
    "fitted arm": (dx.robots.docking_arm("fitted"), Index(KCI, "body", tool_rates=BLOCKWISE)),
}


@both_backends
@pytest.mark.parametrize(("chain", "index"), CASES.values(), ids=CASES)
def test_a_compiled_index_is_the_plain_one(rng, chain, index, backend):
    q = configurations(rng, chain)
    assert_agrees(compiled(chain, index, backend)(q), chain, index, q)


@both_backends
@pytest.mark.parametrize(("chain", "index"), CASES.values(), ids=CASES)
def test_right_angles_and_zeros_are_no_exception(rng, chain, index, backend):
    """Entries that are zero there, or all but zero, are not so everywhere and cannot be left out."""
    right = rng.choice([0.0, 0.5, 1.0, -0.5], (200, chain.joints)) * math.pi
    free = rng.uniform(-3, 3, right.shape)
    q = torch.from_numpy(np.where(rng.random(right.shape) < 0.7, right, free))
    q[0] = 0
    values, plain = compiled(chain, index, backend)(q), index.bind(chain)(q)
    assert_close(values, plain, rtol=1e-12, atol=1e-14 * float(plain.max()))


@both_indices
def test_the_librarys_flags_change_nothing_beyond_rounding(rng, monkeypatch, name):
    monkeypatch.setattr(library, "FLAGS", FLAGS_OF_THE_LIBRARY)
    q = configurations(rng, PUMA, 10_000)
    assert_agrees(symbolic.compile_index(PUMA, Index(name), "c")(q), PUMA, Index(name), q)


@both_backends
@pytest.mark.parametrize("bend", [1e-3, 1e-6, 1e-9, 1e-12])
def test_the_manipulability_keeps_its_digits_near_a_singularity(rng, bend, backend):
    """Against the arm's closed form in fifty digits; squaring J would lose all of them below 1e-8."""
    q = configurations(rng, ARM)
    q[:, 4] = bend
    l1 = l2 = mpmath.mpf(0.4)
    with mpmath.workdps(50):
        exact = [
            l1 * l2 * abs(mpmath.sin(q3) * mpmath.sin(q5) * (l1 * mpmath.cos(q2) + l2 * mpmath.cos(q2 + q3)))
            for _, q2, q3, _, q5, _ in (map(mpmath.mpf, row) for row in q.tolist())
        ]
        w = compiled(ARM, Index(W), backend)(q).tolist()
        error = np.array([float(value / reference - 1) for value, reference in zip(w, exact, strict=True)])
    kci = Index(KCI).bind(ARM)(q).numpy()
    assert_array_equal(np.abs(error) <= 1e-15 / kci, True)


# ---- singularities ---------------------------------------------------------------------------------


def planar_chain() -> dx.Chain:
    """Seven parallel axes: nothing leaves the plane."""
    return dx.Chain.from_dh([{"a": 0.3 + 0.1 * i} for i in range(7)], name="planar")


def spherical_chain() -> dx.Chain:
    """Six axes through one point, where the tool is."""
    axes = np.random.default_rng(5).normal(size=(6, 3))
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    return dx.Chain(np.hstack([np.zeros((6, 3)), axes]), np.eye(4), name="spherical")


DEFICIENT = {
    "planar": (planar_chain(), None),
    "spherical": (spherical_chain(), None),
    "seven locked": (UVMS, (0.0,) * 7 + (1.0,) * 5),
    "all locked": (UVMS, (0.0,) * 12),
    "one locked of six": (PUMA, (1.0,) * 5 + (0.0,)),
}


@both_backends
@both_indices
@pytest.mark.parametrize(("chain", "rates"), DEFICIENT.values(), ids=DEFICIENT)
def test_without_six_ways_to_move_an_index_is_refused(chain, rates, name, backend):
    with pytest.raises(ValueError, match=rf"^{chain.name} has {chain.joints} joints.* is zero everywhere: "):
        symbolic.compile_index(chain, Index(name, joint_rates=rates), backend)


SINGULAR = {
    "straight": (ARM, [0.0] * 6),
    "overhead": (ARM, [0.3, math.pi / 2, 0, 0.2, 0.5, 0.1]),
    "elbow": (ARM, [0.3, 0.5, 0, 0.2, 0.5, 0.1]),
    "wrist": (ARM, [0.3, 0.5, 1.0, 0.2, 0, 0.1]),
    "folded": (ARM, [0.3, 0.5, math.pi, 0.2, 0.5, 0.1]),
    "puma at home": (PUMA, [0.0] * 6),
    "puma's wrist": (PUMA, [0.3, 0.5, 1.0, 0.2, math.pi, 0.1]),
}


at_singularities = pytest.mark.parametrize(("chain", "q"), SINGULAR.values(), ids=SINGULAR)


@both_backends
@both_indices
@at_singularities
def test_a_singularity_has_a_zero_index_and_a_finite_gradient(chain, q, name, backend):
    value, gradient = compiled(chain, Index(name), backend).value_and_gradient(q)
    assert 0 <= value.item() <= 1e-14
    assert gradient.isfinite().all()
    if name == KCI or value == 0:
        assert_close(gradient, torch.zeros(6, dtype=torch.float64), rtol=0, atol=0)


@both_backends
@at_singularities
def test_a_gradient_is_no_steeper_than_the_rise_of_w(rng, chain, q, backend):
    """There w has a minimum, with a kink: it rises in all directions, or stays at zero."""
    _, gradient = compiled(chain, Index(W), backend).value_and_gradient(q)
    step, plain = 1e-6, Index(W).bind(chain)
    for direction in torch.from_numpy(rng.normal(size=(20, 6))):
        rise = plain(torch.tensor(q, dtype=torch.float64) + step * direction).item() / step
        assert abs((gradient @ direction).item()) <= rise + 1e-5


@both_backends
@both_indices
@pytest.mark.parametrize("count", [1, 20])
def test_a_singular_configuration_does_not_disturb_others(rng, count, name, backend):
    f = compiled(ARM, Index(name), backend)
    q = configurations(rng, ARM, count)
    beside = torch.cat([q, torch.zeros(1, 6, dtype=torch.float64), q])
    for alone, together in zip(f.value_and_gradient(q), f.value_and_gradient(beside), strict=True):
        assert_close(together[:count], alone, rtol=1e-12, atol=1e-15)
        assert_close(together[count + 1 :], alone, rtol=1e-12, atol=1e-15)


# ---- repeated singular values ----------------------------------------------------------------------


def gantry() -> dx.Chain:
    """Three orthogonal slides, then three axes through the tool point, orthogonal while q₅ is zero.

    Their columns have the singular values √(1 ± sin q₅) and 1, those of the slides are the slides' limits.
    """
    return dx.Chain(np.eye(6), np.eye(4), name="gantry")


def least(slide: float, s: np.ndarray) -> np.ndarray:
    return np.minimum(slide, np.sqrt(1 - s))


GANTRY = gantry()
REPEATED = {
    "largest and smallest equal": ((1.0,) * 6, (1.0,) * 6, lambda s: np.sqrt((1 - s) / (1 + s))),
    "smallest twice": ((1.0, 0.2, 0.2, 1, 1, 1), (1.0,) * 6, lambda s: least(0.2, s) / np.sqrt(1 + s)),
    "smallest three times": ((0.2,) * 3 + (1.0,) * 3, (1.0,) * 6, lambda s: least(0.2, s) / np.sqrt(1 + s)),
    "largest twice": ((1.0, 1.0, 0.7, 1, 1, 1), (1.0,) * 3 + (3.0,) * 3, lambda s: np.sqrt(1 - s) / 3),
    "largest three times": ((1.0,) * 6, (1.0,) * 3 + (3.0,) * 3, lambda s: np.sqrt(1 - s) / 3),
}


@both_backends
@pytest.mark.parametrize(("joint_rates", "tool_rates", "closed_form"), REPEATED.values(), ids=REPEATED)
def test_singular_values_that_repeat_are_found(rng, joint_rates, tool_rates, closed_form, backend):
    q = configurations(rng, GANTRY)
    q[:10, 4] = 0
    q[:10, 3:] *= torch.from_numpy(rng.integers(0, 2, (10, 3)))
    index = Index(KCI, "body", joint_rates, tool_rates)
    kci = compiled(GANTRY, index, backend)(q)
    assert_allclose(kci, closed_form(np.abs(np.sin(q[:, 4].numpy()))), rtol=0, atol=1e-13)
    assert_agrees(kci, GANTRY, index, q)


@both_backends
def test_an_isotropic_chain_has_a_conditioning_of_one(backend):
    for frame in FRAMES:
        kci = compiled(GANTRY, Index(KCI, frame), backend)([[0.0] * 6, [0, 0, 0, 0.5, 0, 1]])
        assert_close(kci, torch.ones(2, dtype=torch.float64), rtol=0, atol=1e-14)


@both_backends
@pytest.mark.parametrize(
    ("joint_rates", "tool_rates"), [case[:2] for case in REPEATED.values()], ids=REPEATED
)
@pytest.mark.parametrize("at_home", [True, False], ids=["at home", "turned"])
def test_gradients_of_repeated_values_lie_between_slopes(rng, joint_rates, tool_rates, at_home, backend):
    """KCI is σ₆/σ₁, the least over the largest of branches: along a direction d each falls at least as fast
    as KCI rises along −d, and no faster than KCI itself along d."""
    index = Index(KCI, "spatial", joint_rates, tool_rates)
    q = torch.zeros(6, dtype=torch.float64)
    if not at_home:
        q[3:] = torch.tensor([0.4, 0, 0.7])
    kci, gradient = compiled(GANTRY, index, backend).value_and_gradient(q)
    assert gradient.isfinite().all()
    step, plain = 1e-6, index.bind(GANTRY)
    for direction in torch.from_numpy(rng.normal(size=(20, 6))):
        ahead, behind = ((plain(q + h * direction) - kci).item() / h for h in (step, -step))
        assert ahead - 1e-4 <= (gradient @ direction).item() <= behind + 1e-4


# ---- gradients -------------------------------------------------------------------------------------

GRADIENT_CASES = ["uvms w", "uvms spatial", "uvms, all limits", "puma w", "puma body", "stated arm"]
of_gradient_cases = pytest.mark.parametrize(
    ("chain", "index"), [CASES[case] for case in GRADIENT_CASES], ids=GRADIENT_CASES
)


@both_backends
@of_gradient_cases
def test_a_gradient_is_that_of_the_plain_index(rng, chain, index, backend):
    q = configurations(rng, chain)
    value, gradient = compiled(chain, index, backend).value_and_gradient(q)
    assert_agrees(value, chain, index, q)
    q.requires_grad_()
    (plain,) = torch.autograd.grad(index.bind(chain)(q).sum(), q)
    kci = replace(index, name=KCI).bind(chain)(q).detach()
    scale = plain.norm(dim=-1) / kci
    assert ((gradient - plain).norm(dim=-1) <= 1e-13 * scale).all()
    # The rounding of sums and differences in both computations, wherever a gradient is small.
    assert_close(gradient[kci > 1e-2], plain[kci > 1e-2], rtol=1e-9, atol=1e-11 * float(plain.abs().max()))


@both_backends
@of_gradient_cases
def test_a_gradient_is_the_finite_difference_of_its_own_values(rng, chain, index, backend):
    torch.autograd.gradcheck(compiled(chain, index, backend), configurations(rng, chain, 3).requires_grad_())


@both_backends
@both_indices
def test_differentiation_by_torch_gives_the_same_gradient(rng, batch_shape, name, backend):
    q = torch.from_numpy(rng.uniform(-3, 3, (*batch_shape, 6))).requires_grad_()
    weights = torch.from_numpy(rng.normal(size=batch_shape))
    f = compiled(PUMA, Index(name), backend)
    (gradient,) = torch.autograd.grad(f(q), q, weights)
    value, own = f.value_and_gradient(q)
    assert_close(gradient, weights[..., None] * own, rtol=1e-15, atol=0)
    assert_close(f(q), value, rtol=1e-13, atol=1e-16)
    assert not value.requires_grad
    assert not own.requires_grad


@both_backends
def test_where_nothing_is_differentiated_nothing_is_remembered(backend):
    f = compiled(PUMA, Index(W), backend)
    q = torch.ones(6, dtype=torch.float64, requires_grad=True)
    assert f(q).requires_grad
    assert not f(q.detach()).requires_grad
    with torch.no_grad():
        assert not f(q).requires_grad


# ---- input and output ------------------------------------------------------------------------------


@both_backends
@both_indices
def test_leading_axes_are_kept(rng, batch_shape, name, backend):
    q = torch.from_numpy(rng.uniform(-3, 3, (*batch_shape, 6)))
    f = compiled(PUMA, Index(name), backend)
    value, gradient = f.value_and_gradient(q)
    assert value.shape == batch_shape
    assert gradient.shape == q.shape
    assert_close(f(q), Index(name).bind(PUMA)(q), rtol=1e-9, atol=1e-13)
    assert_close(value, f(q), rtol=1e-13, atol=1e-16)


@both_backends
@both_indices
def test_a_value_is_the_same_alone_and_in_a_batch(rng, name, backend):
    """Whatever the number of those beside it: C works on sixteen at a time, torch on eight thousand."""
    f = compiled(PUMA, Index(name), backend)
    q = configurations(rng, PUMA, 8_200)
    values = f(q)
    for i in (0, 15, 16, 8_191, 8_192, 8_199):
        assert_close(f(q[i]), values[i], rtol=1e-13, atol=1e-16)
    for some in (1, 15, 16, 17, 33):
        assert_close(f(q[:some]), values[:some], rtol=1e-13, atol=1e-16)


@both_backends
def test_the_layout_in_memory_does_not_count(rng, backend):
    f = compiled(PUMA, Index(W), backend)
    q = torch.from_numpy(rng.uniform(-3, 3, (6, 4, 5)))
    turned, stepped, repeated = q.permute(1, 2, 0), q[:, ::2].permute(2, 1, 0), q[:, 0, 0].expand(3, 6)
    for view in (turned, stepped, repeated, q[:, 1, 2]):
        assert not view.is_contiguous() or view.ndim == 1
        for ours, theirs in zip(f.value_and_gradient(view), f.value_and_gradient(view.clone()), strict=True):
            assert_close(ours, theirs, rtol=1e-14, atol=0)


@both_backends
def test_lists_arrays_and_other_dtypes_are_taken(backend):
    f = compiled(PUMA, Index(W), backend)
    numbers = [1, 2, -1, 0, 2, 1]
    expected = f(torch.tensor(numbers, dtype=torch.float64))
    assert expected > 0
    for q in (
        numbers,
        tuple(map(float, numbers)),
        np.array(numbers),
        np.array(numbers, dtype=np.float32),
        torch.tensor(numbers),
        torch.tensor(numbers, dtype=torch.float32),
    ):
        value, gradient = f.value_and_gradient(q)
        assert value.dtype is gradient.dtype is f(q).dtype is torch.float64
        assert_close(value, expected, rtol=1e-14, atol=0)
        assert_close(f(q), expected, rtol=1e-14, atol=0)


@pytest.mark.skipif(not torch.cuda.is_available(), reason="there is no GPU")
@both_backends
@both_indices
def test_results_are_where_the_configurations_are(rng, name, backend):
    f = compiled(PUMA, Index(name), backend)
    q = configurations(rng, PUMA).cuda()
    for on_gpu, on_cpu in zip(f.value_and_gradient(q), f.value_and_gradient(q.cpu()), strict=True):
        assert on_gpu.device == q.device
        assert_close(on_gpu.cpu(), on_cpu, rtol=1e-9, atol=1e-13)
    assert f(q).device == q.device


@both_backends
@both_indices
@pytest.mark.parametrize("magnitude", [1e2, 1e4, 1e5, 1.1e5, 1e7, 1e9])
def test_large_angles_are_as_exact_as_they_are_given(rng, magnitude, name, backend):
    q = configurations(rng, PUMA) * magnitude
    value, plain = compiled(PUMA, Index(name), backend)(q), Index(name).bind(PUMA)(q)
    # Joint angles are added where axes are parallel, and a sum is rounded.
    rounding = 10 * np.finfo(float).eps * magnitude
    assert_close(value, plain, rtol=0, atol=rounding)


@both_backends
def test_a_compiled_index_says_what_it_is(backend):
    index = Index(W, "body")
    f = compiled(PUMA, index, backend)
    assert f.chain == SymbolicChain.from_chain(PUMA)
    assert f.index is index
    assert repr(f) == f"CompiledIndex(Index('manipulability', 'body') of 'puma560', backend {backend!r})"


@both_backends
def test_a_symbolic_chain_of_numbers_may_be_compiled(backend):
    index = Index(W)
    q = torch.ones(6, dtype=torch.float64)
    f = symbolic.compile_index(SymbolicChain.from_chain(PUMA), index, backend)
    assert_close(f(q), compiled(PUMA, index, backend)(q), rtol=0, atol=0)


@both_backends
def test_a_chain_brings_its_rates_along(rng, backend):
    rates = (0.3, 1.0, 0.7, 2.0, 1.0, 3.0)
    chain = dx.Chain(ARM.screws, ARM.home, name=ARM.name, rates=rates)
    q = configurations(rng, chain)
    expected = compiled(ARM, Index(W), backend)(q) * math.prod(rates)
    assert_close(compiled(chain, Index(W), backend)(q), expected, rtol=1e-11, atol=0)


# ---- bad input -------------------------------------------------------------------------------------


@both_backends
@both_indices
@pytest.mark.parametrize("poison", [math.nan, math.inf, -math.inf])
def test_joint_values_that_are_not_finite_are_refused(name, backend, poison):
    f = compiled(PUMA, Index(name), backend)
    for row in (0, 15, 16, 32):
        q = torch.ones(33, 6, dtype=torch.float64)
        q[row, 2] = poison
        for function in (f, f.value_and_gradient, lambda q, f=f: f(q.requires_grad_())):
            with pytest.raises(ValueError, match=r"^q is not finite: it holds NaN or an infinity"):
                function(q)
    with pytest.raises(ValueError, match=r"^q is not finite"):
        f([poison] * 6)


@both_backends
@pytest.mark.parametrize("shape", [(), (0,), (5,), (7,), (6, 1), (6, 5), (2, 3, 12)], ids=str)
def test_joint_values_of_the_wrong_shape_are_refused(backend, shape):
    f = compiled(PUMA, Index(W), backend)
    for function in (f, f.value_and_gradient):
        with pytest.raises(ValueError, match=r"^q has shape \(.*; the chain has 6 joints: \(\.\.\., 6\)"):
            function(torch.zeros(shape, dtype=torch.float64))


@pytest.mark.usefixtures("annotations_unchecked")
@pytest.mark.parametrize("backend", ["numpy", "C", "", None])
def test_an_unknown_backend_is_refused(backend):
    with pytest.raises((TypeError, ValueError), match=r"^backend is .*torch, inductor, c"):
        symbolic.compile_index(PUMA, Index(W), backend)


@both_backends
@both_indices
def test_fewer_than_six_joints_are_refused(name, backend):
    chain = dx.Chain.from_dh([{"a": 1}] * 5, name="short arm")
    with pytest.raises(ValueError, match=r"^short arm has 5 joints; with fewer than 6 the .* is zero"):
        symbolic.compile_index(chain, Index(name), backend)


@both_backends
def test_lengths_without_a_value_are_refused(backend):
    chain = SymbolicChain.from_description(robots.describe("docking_arm"))
    with pytest.raises(ValueError, match=r"^docking_arm has lengths without a value: l0, l1, l2, sideways"):
        symbolic.compile_index(chain, Index(W), backend)


@both_backends
@pytest.mark.parametrize(
    ("rates", "message"),
    [
        ({"joint_rates": (1.0,) * 7}, r"joint_rates has shape \(7,\); \(6,\) is needed"),
        ({"joint_rates": (1.0,) * 5 + (-1.0,)}, "joint_rates holds a negative rate"),
        ({"tool_rates": (1.0,) * 7}, r"tool_rates has shape \(7,\); \(6,\) is needed"),
        ({"tool_rates": (1.0,) * 5 + (0.0,)}, "tool_rates must be positive"),
    ],
    ids=str,
)
def test_rates_that_do_not_fit_are_refused(backend, rates, message):
    with pytest.raises(ValueError, match=f"^{message}"):
        symbolic.compile_index(PUMA, Index(W, **rates), backend)


# ---- inductor --------------------------------------------------------------------------------------


from_torch = pytest.mark.filterwarnings("ignore:.*script_method.*is deprecated:DeprecationWarning")


@pytest.fixture
def inductor(monkeypatch, tmp_path):
    """Settings of torch's compiler: a new cache, and no vectors, whose kinds take a compilation each."""
    from torch._inductor import config

    monkeypatch.setenv("TORCHINDUCTOR_CACHE_DIR", str(tmp_path))
    with config.patch({"cpp.vec_isa_ok": False}):
        yield config


@from_torch
@pytest.mark.usefixtures("inductor")
def test_torch_compile_gives_the_same_manipulability(rng):
    f = symbolic.compile_index(GANTRY, Index(W), "inductor")
    q = configurations(rng, GANTRY)
    assert_agrees(f(q), GANTRY, Index(W), q)
    assert_close(f.value_and_gradient(q)[1], compiled(GANTRY, Index(W)).value_and_gradient(q)[1])


@from_torch
def test_a_missing_cpp_compiler_is_named_and_the_way_out(inductor):
    torch.compiler.reset()
    said = r'(?s)/nonexistent/c\+\+.*backend="torch" needs none'
    with inductor.patch({"cpp.cxx": ("/nonexistent/c++",)}), pytest.raises(CompilationFailed, match=said):
        symbolic.compile_index(GANTRY, Index(W), "inductor")


def test_another_fault_is_not_taken_for_a_missing_compiler(monkeypatch):
    def out_of_order(*_: object, **__: object) -> Callable[..., object]:
        raise RuntimeError("out of order")

    monkeypatch.setattr(torch, "compile", out_of_order)
    with pytest.raises(RuntimeError, match=r"^out of order$"):
        symbolic.compile_index(PUMA, Index(W), "inductor")


# ---- random robots ---------------------------------------------------------------------------------

SEEDS = range(7)  # each number of joints once
SEEDS_IN_C = range(0, 7, 2)


def random_chain(seed: int) -> dx.Chain:
    """Chain in general position that turns about at least three axes, so that no index is zero everywhere."""
    drawn = (random_robot(np.random.default_rng([seed, 6, k]), joints=6 + seed % 7).chain() for k in count())
    return next(chain for chain in drawn if chain.kinds.count("revolute") >= 3)


@both_indices
@pytest.mark.parametrize(
    ("seed", "backend"),
    [(seed, way) for seed in SEEDS for way in ("torch", "c") if way == "torch" or seed in SEEDS_IN_C],
)
def test_an_index_of_a_random_chain_is_the_plain_one(in_the_middle_link, seed, name, backend):
    chain = random_chain(seed)
    q = configurations(np.random.default_rng([seed, 7]), chain)
    assert_agrees(symbolic.compile_index(chain, Index(name), backend)(q), chain, Index(name), q)


def test_the_random_chains_have_six_to_twelve_joints():
    assert {random_chain(seed).joints for seed in SEEDS} == set(range(6, 13))
    assert {random_chain(seed).joints for seed in SEEDS_IN_C} == {6, 8, 10, 12}
