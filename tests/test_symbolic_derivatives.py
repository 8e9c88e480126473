"""Derivatives of compiled indices of every order and mode, never zero in silence; torch's other tools."""

import math
import pickle

import mpmath
import pytest
import torch
from torch.autograd import forward_ad
from torch.testing import assert_close

import dexterity as dx
from dexterity import indices, symbolic
from dexterity.chain import Chain
from dexterity.indices import Index
from warm_process import WarmProcess

pytestmark = pytest.mark.filterwarnings("ignore:.*torch.jit.script.* is deprecated:DeprecationWarning")
PUMA = dx.robots.puma560()
NAMES = ("manipulability", "kinematic_conditioning", "isotropy", "limited_manipulability", "guaranteed_speed")


@pytest.fixture(scope="module", params=NAMES)
def both(request):
    """Plain and compiled index."""
    index = Index(request.param, "geometric")
    return index.bind(PUMA), symbolic.compile_index(PUMA, index)


def some_q() -> torch.Tensor:
    return torch.tensor([0.3, -0.5, 0.7, 0.2, 0.9, -0.4], dtype=torch.float64)


SECOND = {
    "functional.hessian": torch.autograd.functional.hessian,
    "functional.hessian, vectorised": lambda f, q: torch.autograd.functional.hessian(f, q, vectorize=True),
    "functional.hessian, forward over reverse": lambda f, q: torch.autograd.functional.hessian(
        f, q, vectorize=True, outer_jacobian_strategy="forward-mode"
    ),
    "functional.hvp": lambda f, q: torch.autograd.functional.hvp(f, q, torch.ones_like(q))[1],
    "functional.vhp": lambda f, q: torch.autograd.functional.vhp(f, q, torch.ones_like(q))[1],
    "func.hessian": lambda f, q: torch.func.hessian(f)(q),
    "func.jacfwd twice": lambda f, q: torch.func.jacfwd(torch.func.jacfwd(f))(q),
    "func.jacrev twice": lambda f, q: torch.func.jacrev(torch.func.jacrev(f))(q),
    "grad of grad": lambda f, q: torch.func.jacrev(torch.func.grad(f))(q),
}

FIRST = {
    "func.jvp": lambda f, q: torch.func.jvp(f, (q,), (torch.ones_like(q),))[1],
    "func.jacfwd": lambda f, q: torch.func.jacfwd(f)(q),
    "func.jacrev": lambda f, q: torch.func.jacrev(f)(q),
    "func.grad": lambda f, q: torch.func.grad(f)(q),
    "functional.jvp": lambda f, q: torch.autograd.functional.jvp(f, q, torch.ones_like(q))[1],
    "functional.jacobian": torch.autograd.functional.jacobian,
    "functional.jacobian, forward": lambda f, q: torch.autograd.functional.jacobian(
        f, q, strategy="forward-mode", vectorize=True
    ),
    "per sample": lambda f, q: torch.func.vmap(torch.func.grad(f))(torch.stack([q, 2 * q])),
}


@pytest.mark.parametrize("derivative", [*FIRST.values(), *SECOND.values()], ids=[*FIRST, *SECOND])
def test_derivatives_of_all_kinds_are_those_of_the_plain_index(both, derivative):
    plain, compiled = both
    expected = derivative(plain, some_q())
    assert expected.abs().max() > 1e-6
    assert_close(derivative(compiled, some_q()), expected, rtol=1e-8, atol=1e-11)


def test_dual_numbers_carry_a_tangent(both):
    plain, compiled = both
    with forward_ad.dual_level():
        q = forward_ad.make_dual(some_q(), torch.ones(6, dtype=torch.float64))
        ours, theirs = (forward_ad.unpack_dual(f(q)) for f in (compiled, plain))
        assert_close(ours.primal, theirs.primal, rtol=1e-10, atol=0)
        assert_close(ours.tangent, theirs.tangent, rtol=1e-9, atol=0)


def test_a_gradient_that_is_kept_is_differentiated_again(both):
    plain, compiled = both
    third = []
    for f in (plain, compiled):
        q = some_q().requires_grad_()
        (first,) = torch.autograd.grad(f(q).square(), q, create_graph=True)
        (second,) = torch.autograd.grad(first.square().sum(), q, create_graph=True)
        (all_three,) = torch.autograd.grad(second.sum(), q)
        third.append(all_three)
    assert_close(third[1], third[0], rtol=1e-7, atol=1e-10)


def test_value_and_gradient_are_followed_by_transforms(both):
    plain, compiled = both
    ours = torch.func.jacfwd(lambda q: compiled.value_and_gradient(q)[1])(some_q())
    assert_close(ours, torch.func.hessian(plain)(some_q()), rtol=1e-8, atol=1e-11)


TRACED = """
import torch, dexterity as dx
from dexterity import indices, symbolic
from dexterity.chain import Chain
from dexterity.indices import Index

class Module(torch.nn.Module):
    def __init__(self, f):
        super().__init__()
        self.f = f
    def forward(self, q):
        return self.f(q)

puma, close = dx.robots.puma560(), torch.testing.assert_close
q = torch.rand(5, 6, dtype=torch.float64)
for name in {names!r}:
    index = Index(name, "geometric", rows="translational")
    for f in (index.bind(puma), symbolic.compile_index(puma, index)):
        close(torch.compile(f, fullgraph=True, backend="eager")(q), f(q), rtol=1e-10, atol=1e-14)
        exported = torch.export.export(Module(f), (q,)).module()
        close(exported(2 * q), f(2 * q), rtol=1e-10, atol=1e-14)
        torch.compiler.reset()
"""


def test_compilation_and_export_by_torch_work():
    """In a process of its own: the run-time checks of annotations in the tests cannot be traced."""
    ended, printed = WarmProcess(TRACED.format(names=NAMES)).end()
    assert ended == 0, printed


def test_maps_of_torch_work(both):
    for f in both:
        Q = torch.stack([some_q(), 2 * some_q()])
        assert_close(torch.func.vmap(f)(Q), f(Q), rtol=1e-10, atol=1e-14)


def test_a_default_device_changes_nothing(both):
    Q = torch.stack([some_q(), 2 * some_q()])
    plain, compiled = both
    expected = plain(Q)
    with torch.device("meta"):
        assert_close(compiled.index.bind(PUMA)(Q), expected, rtol=0, atol=0)
        assert_close(compiled(Q), expected, rtol=1e-10, atol=1e-14)


@pytest.mark.parametrize("backend", ["torch"])
def test_a_compiled_index_can_be_pickled(backend):
    f = symbolic.compile_index(PUMA, "kci", backend)
    back = pickle.loads(pickle.dumps(f))
    assert back.index == f.index == Index("kci")
    assert back.backend == backend
    assert_close(back(some_q()), f(some_q()), rtol=0, atol=0)


@pytest.mark.usefixtures("annotations_unchecked")
@pytest.mark.parametrize("arguments", [(PUMA, 3), (PUMA, None), ("puma", "w"), (None, "w")])
def test_what_is_no_chain_or_index_is_refused(arguments):
    with pytest.raises(TypeError, match=r"^(index|chain) is "):
        symbolic.compile_index(*arguments)


def test_an_unknown_name_is_refused():
    with pytest.raises(ValueError, match=r"^name is 'dexterity'"):
        symbolic.compile_index(PUMA, "dexterity")


# ---- digits ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "q",
    [
        [0.3, 9e4 + 0.1, 9e4 + 0.2, 0.4, 0.8, 0.2],
        [0.3, 7e8 + 0.1, 6e8 + 0.2, 0.4, 0.8, 0.2],
        [0.3, 7e14 + 0.125, 6e14, 0.4, 0.8, 0.2],
        [1e15, -1e15, 3e14 + 0.5, 0.4, 1e15, 0.2],
    ],
)
def test_large_angles_keep_their_digits(q):
    """The docking arm's closed form in fifty digits; sums of large angles would lose them."""
    arm = dx.robots.docking_arm()
    with mpmath.workdps(50):
        _, q2, q3, _, q5, _ = map(mpmath.mpf, q)
        l1 = l2 = mpmath.mpf(0.4)
        exact = (
            l1 * l2 * abs(mpmath.sin(q3) * mpmath.sin(q5) * (l1 * mpmath.cos(q2) + l2 * mpmath.cos(q2 + q3)))
        )
        kci = float(Index("kci")(arm, q))
        for f in (Index("w").bind(arm), symbolic.compile_index(arm, "w")):
            assert abs(float(f(q)) / float(exact) - 1) < 5e-16 / kci


@pytest.mark.parametrize("bend", [1e-2, 1e-6, 1e-10, 1e-12])
def test_the_gradient_of_kci_keeps_its_digits_toward_a_singularity(bend):
    """Singular vectors, and no division by the small singular value: as autograd of the plain index."""
    f, plain = symbolic.compile_index(PUMA, "kci"), Index("kci").bind(PUMA)
    q = torch.tensor([0.3, -0.5, 0.7, 0.2, bend, -0.4], dtype=torch.float64, requires_grad=True)
    value = plain(q)
    (expected,) = torch.autograd.grad(value, q)
    gradient = f.value_and_gradient(q)[1]
    assert (gradient - expected).norm() <= 1e-13 * expected.norm()


def test_logarithms_are_minus_infinity_and_not_nan_at_singularities():
    f = symbolic.compile_index(PUMA, "log_w")
    q = [[0.3, 0.5, 0.7, 0.2, 0.0, 0.1], [0.3, 0.5, 0.7, 0.2, 0.4, 0.1]]
    value, gradient = f.value_and_gradient(q)
    assert value[0] < -30
    assert value[1].isfinite()
    assert gradient.isfinite().all()
    exactly = symbolic.compile_index(dx.robots.docking_arm(), "log_w")([0.0] * 6)
    assert exactly == -math.inf


# ---- memory ----------------------------------------------------------------------------------------


def peak_of(f, q) -> float:
    """Bytes a configuration that torch's CPU allocator holds at most beyond what it held before."""
    with torch.profiler.profile(
        activities=[torch.profiler.ProfilerActivity.CPU], profile_memory=True
    ) as profile:
        f(q)
    held = most = 0
    for event in profile.profiler.kineto_results.events():
        if event.name() == "[memory]":
            held += event.nbytes()
            most = max(most, held)
    return most / len(q)


@pytest.mark.parametrize("name", ["manipulability", "kinematic_conditioning"])
def test_a_large_batch_takes_at_most_500_bytes_a_configuration(name):
    """pinocchio#1634, differentiable-robot-model#23, curobo#625: w of the 12-joint UVMS, 200 000 at once."""
    uvms = dx.robots.uvms()
    q = torch.rand(200_000, 12, dtype=torch.float64)
    for f in (Index(name).bind(uvms), symbolic.compile_index(uvms, name)):
        assert 0 < peak_of(f, q) <= 500


@pytest.mark.parametrize("backend", ["torch", "c"])
@pytest.mark.parametrize("name", indices.names())
def test_no_gradient_is_nan_at_a_fold(name, backend):
    """A stretched and a folded planar arm, where a triangle of the elimination has an exact zero."""
    arm = Chain.from_dh([{"a": 1}, {"a": 1}, {"a": 0.5}], lower=[-3] * 3, upper=[3] * 3, name="planar")
    q = torch.tensor([[0.0, 0, 0], [0.3, 0, 0.7], [0.3, torch.pi, 0.2], [0.5, 0.4, 0.2]]).double()
    needs = indices.describe(name).needs
    if "inertias" in needs or (name == "guaranteed_speed" and backend == "c"):
        pytest.skip("has no such form")
    direction = (1.0, 2.0, 3.0) if "direction" in needs else None
    index = Index(name, "geometric", rows=("vx", "vy", "wz"), direction=direction)
    compiled = symbolic.compile_index(arm, index, backend)
    values, gradients = compiled.value_and_gradient(q)
    assert not values.isnan().any()
    assert not gradients.isnan().any()
    x = q.clone().requires_grad_()
    (plain,) = torch.autograd.grad(index(arm, x).sum(), x)
    assert not plain.isnan().any()
    assert torch.allclose(gradients[-1], plain[-1], rtol=1e-9, atol=1e-12)
