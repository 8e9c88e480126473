"""The closed form in torch and in C against angles, frames and determinants."""

import itertools
import math
import re
import shutil
import subprocess

import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st
from torch.testing import assert_close

from dexterity import spatial
from dexterity.workspace import closed_form, compiled, dataset, reachability
from dexterity.workspace.compiled import CompiledArm
from dexterity.workspace.reachability import Branch

PUMA = (0.15, 0.4318, 0.4318, 0.0203)
BRANCHES = [Branch(*signs) for signs in itertools.product([True, False], repeat=3)]
PARTS = ("cosines", "sines", "jacobian", "manipulability")
in_c = pytest.mark.skipif(shutil.which("cc") is None, reason="there is no C compiler")


def drawn(count: int, seed: int = 0) -> tuple[torch.Tensor, torch.Tensor]:
    """Manipulators, and poses whether in reach or not."""
    samples = dataset.confidence_data(count, seed).samples
    return samples.links, spatial.pose(samples.rotation(), samples.position)


def exact(links, T, branch: Branch) -> tuple[torch.Tensor, torch.Tensor]:
    """All parts from joint angles, and whether the poses are in reach."""
    q, reach = reachability.inverse(links, T, branch)
    J = reachability.geometric_jacobian(links, q)
    w = torch.linalg.det(J).abs()[..., None]
    return torch.cat([q.cos(), q.sin(), J.flatten(-2), w], -1), reach


@pytest.mark.parametrize("branch", BRANCHES)
def test_every_branch_is_the_one_of_the_angles(branch):
    links, T = drawn(5_000)
    values = closed_form.in_torch(branch, *PARTS)(links, T)
    wanted, reach = exact(links, T, branch)
    assert torch.equal(~values[:, -1].isnan(), reach)
    assert_close(values[reach], wanted[reach], rtol=0, atol=1e-12)


@pytest.mark.parametrize("branch", [BRANCHES[0], BRANCHES[5]])
@in_c
def test_compiled_it_is_the_same(branch):
    _, T = drawn(20_000)
    solution = CompiledArm(PUMA, branch).solve(T)
    wanted, reach = exact(PUMA, T, branch)
    assert torch.equal(solution.reached, reach)
    values = torch.cat(
        [solution.cosines, solution.sines, solution.jacobian.flatten(1), solution.manipulability[:, None]], 1
    )
    assert_close(values[reach], wanted[reach], rtol=0, atol=1e-12)
    assert values[~reach].isnan().any(1).all()
    forward = reachability.forward(PUMA, solution.q[reach])
    assert_close(forward, T[reach], rtol=0, atol=1e-12)
    assert_close(CompiledArm(PUMA, branch).manipulability(T), solution.manipulability, equal_nan=True)


@given(st.lists(st.floats(0.02, 0.5), min_size=4, max_size=4), st.integers(0, 2**32))
def test_w_is_a_product(links, seed):
    random = torch.Generator().manual_seed(seed)
    q = (2 * torch.rand(6, generator=random, dtype=torch.float64) - 1) * math.pi
    J = reachability.geometric_jacobian(links, q)
    _, d4, a2, a3 = links
    forearm = math.hypot(a3, d4)
    elbow = q[2] + math.atan2(d4, a3)
    ahead = a2 * q[1].cos() + forearm * (q[1] + elbow).cos()
    product = a2 * forearm * elbow.sin().abs() * ahead.abs() * q[4].sin().abs()
    assert_close(torch.linalg.det(J).abs(), product, rtol=0, atol=1e-15)


def test_angles_that_may_be_anything_are_those_of_the_angles():
    # Over the first axis of an arm without offset, and with the tool along the forearm.
    q, _ = reachability.inverse(PUMA, drawn(1)[1])
    T = reachability.forward(PUMA, q * torch.tensor([1, 1, 1, 1, 0, 1]))
    values = closed_form.in_torch(reachability.NAMED_BRANCH, *PARTS)(torch.tensor(PUMA).double(), T)
    assert values.isfinite().all()
    assert values[0, -1] < 1e-8
    links = torch.tensor([0.0, 0.3, 0.4, 0.0], dtype=torch.float64)
    above = torch.eye(4, dtype=torch.float64)
    above[2, 3] = 0.5
    values = closed_form.in_torch(reachability.NAMED_BRANCH, *PARTS)(links, above)
    wanted, reach = exact(links, above, reachability.NAMED_BRANCH)
    assert reach
    assert_close(values, wanted, rtol=0, atol=1e-12)


def test_a_program_has_no_angles():
    program = closed_form.derive()
    assert len(program.outputs) == closed_form.PARTS["defect"].stop
    text = " ".join(str(expression) for _, expression in program.steps)
    assert not re.search(r"sin|cos|tan|exp|log", text)


@in_c
def test_shapes_and_single_poses():
    arm = CompiledArm(PUMA)
    _, T = drawn(3 * 17)
    whole = arm.solve(T)
    shaped = arm.solve(T.reshape(3, 17, 4, 4))
    assert shaped.jacobian.shape == (3, 17, 6, 6)
    assert_close(shaped.jacobian.flatten(0, 1), whole.jacobian, rtol=0, atol=0, equal_nan=True)
    one = arm.solve(T[3].tolist())
    assert one.manipulability.shape == ()
    assert_close(one.manipulability, whole.manipulability[3], rtol=1e-12, atol=0, equal_nan=True)
    assert arm.manipulability(T[:0]).shape == (0,)
    assert_close(arm.manipulability(T.mT.contiguous().mT), whole.manipulability, equal_nan=True)


def with_entry(row: int, column: int, value: float) -> torch.Tensor:
    T = torch.eye(4, dtype=torch.float64)
    T[row, column] = value
    return T


@pytest.mark.parametrize(
    ("T", "message"),
    [
        (with_entry(0, 0, 1.1), "misses orthonormality"),
        (with_entry(0, 0, -1.0), "reflection"),
        (with_entry(3, 3, 2.0), "last row"),
        (with_entry(3, 0, 0.1), "last row"),
        (with_entry(1, 3, math.nan), "not finite"),
        (with_entry(1, 3, math.inf), "not finite"),
        (torch.zeros(3, 4), r"T_base_tool has shape \(3, 4\)"),
    ],
)
@in_c
def test_a_pose_that_is_none_is_named(T, message):
    with pytest.raises(ValueError, match=message):
        CompiledArm(PUMA).solve(T)
    with pytest.raises(ValueError, match=message):
        CompiledArm(PUMA).manipulability(T)


@pytest.mark.parametrize(
    ("links", "message"),
    [
        ((0.1, 0.2, 0.3), r"links has shape \(3,\)"),
        ((0.1, 0.2, -0.3, 0.1), "links holds -0.3"),
        ((0.1, 0.2, 0.0, 0.1), "an upper arm and a forearm with lengths"),
        ((0.1, 0.0, 0.2, 0.0), "an upper arm and a forearm with lengths"),
    ],
)
def test_an_arm_that_is_none_is_named(links, message):
    with pytest.raises(ValueError, match=message):
        CompiledArm(links)


@pytest.mark.parametrize("outputs", [(), ("torque",)])
def test_unknown_outputs_are_named(outputs):
    with pytest.raises(ValueError, match=r"cosines, sines, jacobian, manipulability (are|is) needed"):
        compiled.c_source(outputs=outputs)


@pytest.mark.parametrize("compiler", ["gcc", "clang"])
def test_the_source_is_plain_c(compiler, tmp_path):
    if shutil.which(compiler) is None:
        pytest.skip(f"there is no {compiler}")
    path = tmp_path / "arm.c"
    path.write_text(compiled.c_source(), encoding="utf-8")
    warnings = ["-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wshadow", "-Werror"]
    subprocess.run(
        [compiler, "-std=c99", "-O1", *warnings, "-c", str(path), "-o", str(tmp_path / "arm.o")], check=True
    )


@in_c
def test_an_arm_stays_as_it_is_when_the_callers_array_changes():
    links = np.array(PUMA)
    arm, T = CompiledArm(links), drawn(5)[1]
    before = arm.manipulability(T)
    links[2] = 0.5
    assert_close(arm.manipulability(T), before, rtol=0, atol=0, equal_nan=True)


@pytest.mark.parametrize("name", ["x; } int main(void) {", "1a", "", "a b", "int", "class", "π", "a\n"])
def test_a_name_that_is_none_in_c_is_refused(name):
    with pytest.raises(ValueError, match=r"^name is "):
        compiled.c_source(name)
