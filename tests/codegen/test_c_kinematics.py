"""Kinematics in C against those of the chain, in both precisions, and rates against numpy."""

import ctypes
import subprocess
from functools import cache

import numpy as np
import pytest
import torch
from numpy.testing import assert_allclose

import dexterity as dx
from dexterity import robots
from dexterity.codegen import c_kinematics, library
from dexterity.symbolic import SymbolicChain
from serial_chains import random_robot

CHAINS = {
    "uvms": dx.robots.uvms(),
    "puma": dx.robots.puma560(),
    "short": dx.Chain.from_dh([{"a": 0.5}, {"kind": "prismatic", "d": 0.2}, {"alpha": 0.7}], name="short"),
    "gantry": dx.Chain.from_dh([{"kind": "prismatic"}, {"kind": "prismatic", "alpha": 1.5}], name="gantry"),
    "random": random_robot(np.random.default_rng(3), 7).chain(),
}
MAPS = {
    "pose": "forward",
    "geometric_jacobian": "geometric_jacobian",
    "spatial_jacobian": "spatial_jacobian",
    "body_jacobian": "body_jacobian",
}
DTYPES = {"double": np.float64, "float": np.float32}


@cache
def compiled(name: str, precision: str) -> ctypes.CDLL:
    return library.compiled_library(c_kinematics.c_source(CHAINS[name], "arm", precision))


def pointer(array: np.ndarray | None) -> ctypes.c_void_p:
    return ctypes.c_void_p(None if array is None else array.ctypes.data)


@pytest.mark.parametrize("precision", ["double", "float"])
@pytest.mark.parametrize("name", CHAINS)
def test_pose_and_jacobians_are_those_of_the_chain(rng, name, precision):
    chain, loaded, dtype = CHAINS[name], compiled(name, precision), DTYPES[precision]
    q = rng.uniform(-3, 3, (37, chain.joints)).astype(dtype)
    if precision == "double":
        q[::3, [kind == "revolute" for kind in chain.kinds]] *= 1e3
    for function, method in MAPS.items():
        expected = getattr(chain, method)(torch.from_numpy(q.astype(np.float64))).numpy()
        results = np.empty(expected.shape, dtype)
        batch = getattr(loaded, f"arm_{function}_batch")
        sizes = ctypes.c_size_t(len(q)), ctypes.c_size_t(chain.joints)
        assert batch(pointer(q), *sizes, pointer(results)) == 0
        scale = np.abs(expected).max() * np.finfo(dtype).eps
        assert_allclose(results, expected, rtol=0, atol=40 * scale)
        alone = np.empty(expected.shape[1:], dtype)
        assert getattr(loaded, f"arm_{function}")(pointer(q[5].copy()), pointer(alone)) == 0
        assert_allclose(alone, results[5], rtol=0, atol=4 * scale)


def resolved(J, twist, damping, weights, wish):
    precision = "double"
    rates, joints = np.full(J.shape[1], -7.0), J.shape[1]
    name = {12: "uvms", 6: "puma", 7: "random"}[joints]
    error = compiled(name, precision).arm_resolve(
        pointer(J), pointer(twist), ctypes.c_double(damping), pointer(weights), pointer(wish), pointer(rates)
    )
    return error, rates


@pytest.mark.parametrize("name", ["uvms", "puma", "random"])
@pytest.mark.parametrize("damping", [0.0, 0.1])
def test_rates_are_those_of_the_weighted_damped_pseudo_inverse(rng, name, damping):
    chain = CHAINS[name]
    for _ in range(20):
        J = chain.body_jacobian(rng.uniform(-2, 2, chain.joints)).numpy().copy()
        twist, wish = rng.normal(size=6), rng.normal(size=chain.joints)
        weights = rng.uniform(0.1, 2, chain.joints)
        for W, wanted in ((weights, wish), (None, wish), (weights, None), (None, None)):
            D = np.diag(np.ones(chain.joints) if W is None else W)
            extra = np.zeros(chain.joints) if wanted is None else wanted
            inverse = D @ J.T @ np.linalg.inv(J @ D @ J.T + damping**2 * np.eye(6))
            error, rates = resolved(J, twist, damping, W, wanted)
            assert error == 0
            condition = np.linalg.cond(J @ D @ J.T + damping**2 * np.eye(6))
            expected = inverse @ (twist - J @ extra) + extra
            assert_allclose(rates, expected, rtol=0, atol=1e-14 * condition * (1 + np.abs(expected).max()))


def test_a_wish_in_the_null_space_moves_no_tool_and_a_weight_of_zero_locks_its_joint(rng):
    chain = CHAINS["uvms"]
    J = chain.geometric_jacobian(rng.uniform(-1, 1, 12)).numpy().copy()
    weights = np.ones(12)
    weights[3:5] = 0
    error, rates = resolved(J, np.zeros(6), 0.0, None, rng.normal(size=12))
    assert error == 0
    assert np.abs(rates).max() > 0.1
    assert_allclose(J @ rates, 0, atol=1e-12)
    error, rates = resolved(J, rng.normal(size=6), 0.0, weights, None)
    assert error == 0
    assert (rates[3:5] == 0).all()


def test_what_has_no_inverse_or_is_not_finite_is_an_error(rng):
    J, twist = np.zeros((6, 6)), rng.normal(size=6)
    assert resolved(J, twist, 0.0, None, None)[0] == 5
    assert resolved(J, twist, 0.1, None, None)[0] == 0
    assert resolved(J, np.full(6, np.nan), 0.1, None, None)[0] == 3
    assert resolved(J, twist, np.inf, None, None)[0] == 3
    J[2, 3] = np.nan
    assert resolved(J, twist, 0.1, None, None)[0] == 3
    assert compiled("puma", "double").arm_resolve(None, None, ctypes.c_double(0), None, None, None) == 1


@pytest.mark.parametrize("compiler", ["gcc", "clang", "g++", "clang++"])
@pytest.mark.parametrize("precision", ["double", "float"])
def test_files_compile_without_warnings_also_as_cpp(tmp_path, compiler, precision):
    warnings = ("-Wall", "-Wextra", "-pedantic", "-Wconversion", "-Wshadow", "-Werror", "-fsyntax-only")
    for name in ("uvms", "gantry"):
        paths = dx.codegen.write_c(tmp_path, CHAINS[name], precision=precision)
        assert [path.suffix for path in paths] == [".c", ".h"]
        language = ("-x", "c++") if compiler.endswith("++") else ()
        subprocess.run([compiler, *warnings, *language, paths[0]], check=True)


@pytest.mark.usefixtures("annotations_unchecked")
def test_a_chain_with_open_lengths_and_a_wrong_subject_are_refused():
    chain = SymbolicChain.from_description(robots.describe("docking_arm"))
    with pytest.raises(ValueError, match=r"^docking_arm has lengths without a value"):
        dx.codegen.c_files(chain)
    with pytest.raises(TypeError, match=r"^subject is .* dexterity.symbolic.derive\(chain, index\)"):
        dx.codegen.c_files("puma")
    with pytest.raises((TypeError, ValueError), match="precision"):
        dx.codegen.c_files(CHAINS["puma"], precision="half")
