"""What a caller gives: every kind of array, and torch's compilation, export, transforms and devices."""

from fractions import Fraction

import numpy as np
import pytest
import torch
from torch.testing import assert_close

import dexterity as dx
from dexterity import spatial
from warm_process import WarmProcess

Q = [0.3, -0.5, 0.7, 0.2, 0.9, -0.4]


@pytest.mark.parametrize(
    "value",
    [
        np.ones((1, 6))[::-1],
        np.ones((6, 1))[:, ::-1].T,
        np.broadcast_to(1.0, (6,)),
        np.ones(6, dtype=">f8"),
        np.ones(6, dtype=np.longdouble),
        np.ones(6, dtype=np.float16),
        np.ones(6, dtype=np.uint16),
        [np.float32(1)] * 6,
        [np.ones(1)] * 6,
        [torch.ones(())] * 6,
        [torch.ones((), dtype=torch.float32), 1, 1.0, np.float64(1), np.ones(()), torch.tensor(1)],
        torch.ones(6, dtype=torch.bfloat16),
        torch.nn.Parameter(torch.ones(6)),
    ],
    ids=lambda value: f"{type(value).__name__} {getattr(value, 'dtype', '')}",
)
def test_real_numbers_in_any_form(value):
    taken = spatial.to_float64(value, "q")
    assert taken.dtype == torch.float64
    assert_close(taken.detach().reshape(6), torch.ones(6, dtype=torch.float64), rtol=0, atol=0)


def test_a_row_that_runs_backwards():
    puma = dx.robots.puma560()
    q = np.array([Q])
    assert_close(puma.forward(q[::-1]), puma.forward(q), rtol=0, atol=0)


def test_scalars_that_require_gradients_pass_them_on():
    scalars = [torch.tensor(x, dtype=torch.float64, requires_grad=True) for x in Q]
    for q in (scalars, [scalars], [[*scalars[:3], *Q[3:]]]):
        z = dx.robots.puma560().forward(q)[..., 2, 3].sum()
        slopes = torch.autograd.grad(z, scalars[:3])
        assert all(slope.abs() > 0 for slope in slopes[1:])


@pytest.mark.parametrize(
    "value",
    [
        np.ma.array([1.0, 2.0], mask=[True, False]),
        torch.ones(2).to_sparse(),
        10**400,
        [Fraction(1, 3)],
        [[1.0], [1.0, 2.0]],
        [torch.ones(2), torch.ones(3)],
        [torch.ones(2), [1.0]],
        [None],
        "12",
        {1.0},
        {"a": 1},
        object(),
        np.array(["2020-01-01"], dtype="datetime64[D]"),
        [torch.tensor(True), 1.0],
    ],
    ids=lambda value: type(value).__name__,
)
def test_what_is_no_array_of_real_numbers_is_refused_by_name(value, annotations_unchecked):
    with pytest.raises(TypeError, match=r"^speed "):
        spatial.to_float64(value, "speed")


def test_the_callers_array_is_never_written_to():
    array = np.eye(4, dtype=np.float64)
    before = array.copy()
    spatial.log(spatial.compose(array, array))
    np.testing.assert_array_equal(array, before)


# ---- torch's own tools (pytorch_kinematics PR #26, #66; pytorch_kinematics#39) -----------------------


def functions() -> dict:
    arm, crane = dx.robots.puma560(), dx.crane.patu655()
    return {
        "forward": arm.forward,
        "spatial": arm.spatial_jacobian,
        "body": arm.body_jacobian,
        "geometric": arm.geometric_jacobian,
        "frames": arm.joint_frames,
        "exponential": spatial.exp,
        "logarithm": lambda q: spatial.log(arm.forward(q)),
        "adjoint": lambda q: spatial.adjoint(arm.forward(q)),
        "inverse": lambda q: spatial.compose(spatial.inverse(arm.forward(q)), arm.forward(2 * q)),
        "quaternion": lambda q: spatial.quaternion(arm.forward(q), order="xyzw"),
        "rpy": lambda q: spatial.from_rpy(spatial.rpy(arm.forward(q)), q[..., :3]),
        "nearest": lambda q: spatial.nearest_rigid(1.0001 * arm.forward(q)),
        "normalised": lambda q: dx.indices.normalise(arm.geometric_jacobian(q), [2.0] * 6, [1.0] * 6),
        "ellipsoid": lambda q: dx.indices.velocity_ellipsoid(arm.geometric_jacobian(q)).semi_axes,
        "reach": lambda q: dx.workspace.reachable(q[..., :4], q[..., 3:])[..., None] * q,
        "crane": lambda q: dx.crane.tip_position(0.3 + 0.1 * q[..., :3], crane),
        "crane, back": lambda q: dx.crane.inverse(2 + q[..., :2], 0.5 + 0 * q[..., 0], crane).strokes,
    }


@pytest.mark.parametrize("name", functions())
def test_function_transforms(name):
    f = functions()[name]
    q = torch.rand(5, 6, generator=torch.Generator().manual_seed(0), dtype=torch.float64)
    assert_close(torch.func.vmap(f)(q), f(q), rtol=0, atol=1e-12)
    alone = torch.stack([torch.autograd.functional.jacobian(f, row) for row in q])
    assert_close(torch.func.vmap(torch.func.jacrev(f))(q), alone, rtol=0, atol=1e-10)


TRACED = """
import sys, torch, dexterity as dx
sys.path.insert(0, {folder!r})
from test_values import functions

q = torch.rand(5, 6, dtype=torch.float64)
class Module(torch.nn.Module):
    def __init__(self, f):
        super().__init__()
        self.f = f
    def forward(self, q):
        return self.f(q)
for name, f in functions().items():
    torch.testing.assert_close(torch.compile(f, fullgraph=True, backend="eager")(q), f(q))
    exported = torch.export.export(Module(f), (q,)).module()
    torch.testing.assert_close(exported(q), f(q))
    assert f(q.to("meta")).is_meta
"""


def test_compilation_export_and_a_device_without_values():
    """In a process of its own: the run-time checks of annotations in the tests cannot be traced."""
    from pathlib import Path

    code = TRACED.format(folder=str(Path(__file__).parent))
    ended, printed = WarmProcess(code).end()
    assert ended == 0, printed


@pytest.mark.filterwarnings("ignore:The PyTorch API of nested tensors")
def test_nested_and_sparse_tensors_are_refused_by_name():
    puma = dx.robots.puma560()
    functions = [puma.forward, dx.Index("w").bind(puma), dx.symbolic.compile_index(puma, "w", "c")]
    ragged = [torch.ones(6, dtype=torch.float64)] * 2
    tensors = [torch.nested.nested_tensor(ragged), torch.stack(ragged).to_sparse()]
    tensors.append(torch.nested.nested_tensor(ragged, layout=torch.jagged))
    for f in functions:
        for q in tensors:
            with pytest.raises(TypeError, match=r"^q is a"):
                f(q)


@pytest.mark.parametrize("shape", [(), (2,), (3, 4), (4, 3, 3)])
def test_the_last_axes_are_those_asked_for(shape):
    with pytest.raises(ValueError, match=r"^points has shape .*; \(\.\.\., 4, 4\) is needed$"):
        spatial.batch_of(np.zeros(shape), "points", (4, 4))
    assert spatial.batch_of(np.zeros((*shape, 3)), "points", (3,)).shape == (*shape, 3)


def test_batch_axes_that_do_not_broadcast_are_named():
    assert spatial.common_batch(q=(5, 1), links=(4,)) == (5, 4)
    with pytest.raises(ValueError, match=r"^a, b and c have batch axes \(2,\) and \(3,\) and \(\), which"):
        spatial.common_batch(a=(2,), b=(3,), c=())


@pytest.mark.parametrize("mode", [torch.inference_mode, torch.no_grad, torch.enable_grad])
def test_slopes_in_every_mode_of_torch(mode):
    with mode():
        x = torch.tensor([[1.0, 2.0], [3.0, 4.0]], dtype=torch.float64)
        values, slopes = spatial.value_and_gradient(lambda x: x.square().sum(-1), x)
    assert not values.requires_grad
    assert_close(values, x.square().sum(-1))
    assert_close(slopes, 2 * x)


def test_what_torch_cannot_differentiate_is_named():
    x = torch.ones(2, 3, dtype=torch.float64)
    with pytest.raises(ValueError, match=r"^staircase cannot be differentiated by torch$"):
        spatial.value_and_gradient(lambda x: x.detach().floor().sum(-1), x, "staircase")


def test_a_rotation_is_taken_as_that_of_a_pose():
    R = spatial.from_rpy([[0.3, 0.4, 0.5], [0.0, 0.0, 0.0]])[:, :3, :3]
    assert torch.equal(spatial.require_rotation(R, "R"), R)
    printed = (R * 1e6).round() / 1e6
    assert float(spatial.rotation_miss(spatial.require_rotation(printed, "R")).max()) < 1e-15
    for wrong, why in ((-R, "reflection"), (1.1 * R, "orthonormality"), (R[0, 0], r"\(\.\.\., 3, 3\)")):
        with pytest.raises(ValueError, match=f"^R .*{why}"):
            spatial.require_rotation(wrong, "R")


def test_the_memory_of_what_is_read_holds_its_values():
    """The imaginary part of a conjugate is a view of its negatives, which compiled code would read."""
    given = torch.complex(torch.ones(2, dtype=torch.float64), -torch.ones(2, dtype=torch.float64)).conj().imag
    assert given.is_neg()
    assert not spatial.to_float64(given, "x").is_neg()
    assert spatial.to_float64(given, "x").tolist() == [1, 1]
    assert not spatial.to_float64(torch._neg_view(torch.ones(2)), "x").is_neg()
