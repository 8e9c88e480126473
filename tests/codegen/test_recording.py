"""Functions of torch recorded, printed as JavaScript and run by node, against themselves."""

import numpy as np
import pytest
import torch
from numpy.testing import assert_allclose
from torch import Tensor

from dexterity import spatial
from dexterity.codegen.recorded_functions import Recorded, recorded_module
from dexterity.codegen.recording import record
from run_in_node import called, needs_node


def module_of(function, *samples: Tensor) -> str:
    return recorded_module(["A test."], {}, {"own": Recorded(record(function, *samples), "Of numbers.")})


def element_by_element(x: Tensor) -> Tensor:
    a, b = x[:3], x[3:]
    return torch.stack([
        a + 2 * b, a - b / 3, -a * b, 1 / (b.abs() + 1), a.square() - b**3, a.sin() * b.cos(),
        torch.atan2(a, b),
        a.tanh().exp(), torch.acos(b.tanh()), torch.hypot(a, b), torch.minimum(a, b), torch.maximum(a, b),
        a.clamp(min=0).sqrt(), b.clamp(-0.5, 0.5), torch.where(a > b, a, 0.5),
        torch.remainder(a, 0.7), a.sign(),
        (10 * a).round(), b.floor(), torch.rsub(a, 1.0), torch.add(a, b, alpha=2),
    ])  # fmt: skip


def along_axes(x: Tensor) -> Tensor:
    matrix = x.reshape(2, 3)
    parts = [
        matrix.sum(0), matrix.mean(1), matrix.amax(1), matrix.amin(0), matrix.norm(dim=-1), matrix.prod(0),
        (matrix > 0).sum(1).double(), (matrix > 0).all(0).double(), (matrix > 0).any(1).double(),
        (matrix - matrix.mean(1, keepdim=True)).flatten(), x.max()[None], matrix.norm()[None],
    ]  # fmt: skip
    return torch.cat(parts)


def matrices(x: Tensor) -> Tensor:
    A = x[:4].reshape(2, 2) + 3 * torch.eye(2, dtype=x.dtype)
    batch = torch.stack([A, A.mT, A @ A])
    solved = torch.linalg.solve(batch, x.new_tensor([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]).expand(3, 2, 3))
    outer = torch.outer(x[:2], x[4:])
    return torch.cat([solved.flatten(), (batch @ outer).flatten(), A @ x[4:], (x[:2] @ x[4:])[None]])


def moved_about(x: Tensor) -> Tensor:
    row = x.new_zeros(4, 3)
    row[1] += x[:3]
    row[:, 1] = 7.0
    row[2:, 0] -= x[4:]
    row.mul_(2)
    padded = torch.nn.functional.pad(row, (1, 0), value=5.0)
    return torch.cat([padded.roll(1, 0).flatten(), x.flip(0), x.repeat(2), x.repeat_interleave(2), row.T[1]])


def differentiated(x: Tensor) -> Tensor:
    with torch.enable_grad():
        q = torch.ones(3, dtype=x.dtype, requires_grad=True)
        away = q * x[:3] - x[3:]
        energy = away.norm() * away.cos().sum() + torch.atan2(away[0], away[1] ** 2) / q.square().sum()
        return torch.autograd.grad(energy, q)[0]


def chosen_by_a_number(x: Tensor) -> Tensor:
    place = (x[:4] > 0).sum()
    return torch.nn.functional.one_hot(place[None], 5).double()[0] * x[5] + x[4]


@needs_node
@pytest.mark.parametrize(
    "function",
    [
        element_by_element,
        along_axes,
        matrices,
        moved_about,
        differentiated,
        chosen_by_a_number,
        spatial.wrap_to_pi,
    ],
    ids=lambda function: function.__name__,
)
def test_a_recording_is_the_function(tmp_path, rng, function):
    inputs = 2 * rng.standard_normal((100, 6))
    module = module_of(function, torch.from_numpy(inputs[0]))
    results = called(tmp_path, module, "own", [[row] for row in inputs.tolist()])
    expected = np.stack([function(torch.from_numpy(row)).numpy() for row in inputs])
    assert_allclose(np.array(results, dtype=float), expected, rtol=1e-11, atol=1e-12)


def raises_below_zero(x: Tensor) -> Tensor:
    if (x < 0).any():
        raise ValueError("x holds a negative number")
    return x.sqrt()


@needs_node
def test_beyond_its_conditions_a_recording_is_not_defined(tmp_path):
    module = module_of(raises_below_zero, torch.ones(2, dtype=torch.float64))
    inside, outside = called(tmp_path, module, "own", [[[4.0, 9.0]], [[4.0, -9.0]]])
    assert inside == [2, 3]
    assert outside == {"error": "RangeError", "message": "input is beyond where own is defined"}


@needs_node
def test_bad_input_is_a_range_error(tmp_path):
    module = module_of(torch.sin, torch.ones(2, dtype=torch.float64))
    results = called(tmp_path, module, "own", [[[1.0]], [[1.0, None]], [[[1.0], [2.0]]]])
    assert [result["message"] for result in results[:2]] == [
        "input has 1 numbers, 2 are needed",
        "input is not finite: it holds NaN or an infinity",
    ]
    assert_allclose(results[2], np.sin([1.0, 2.0]))


@needs_node
def test_numbers_that_are_not_finite_come_out_as_they_are(tmp_path):
    module = module_of(torch.acos, torch.zeros(2, dtype=torch.float64))
    (result,) = called(tmp_path, module, "own", [[[1.0, 2.0]]])
    assert result == [0, "NaN"]


def test_what_is_not_known_is_not_recorded():
    with pytest.raises(NotImplementedError, match="torch's cumsum cannot be recorded"):
        record(lambda x: x.cumsum(0), torch.ones(2, dtype=torch.float64))


def test_equal_operations_are_recorded_once():
    recording = record(
        lambda x: torch.stack([x.sin() + 1, x.sin() + 1]), torch.tensor(0.3, dtype=torch.float64)
    )
    assert recording.outputs[0] == recording.outputs[1]
    assert [row[0] for row in recording.tape.rows].count("sin") == 1


def test_constants_are_worked_out():
    recording = record(
        lambda x: x + torch.ones(3, dtype=x.dtype).exp().sum(), torch.zeros((), dtype=torch.float64)
    )
    name, _, constant = recording.tape.rows[recording.outputs[0]]
    assert name == "add"
    assert recording.tape.value(constant) == pytest.approx(3 * np.e, rel=1e-15)


def test_a_function_needs_a_name():
    recorded = Recorded(record(torch.sin, torch.zeros((), dtype=torch.float64)), "A sine.")
    with pytest.raises(ValueError, match=r"^name is '2x'"):
        recorded_module([], {}, {"2x": recorded})
