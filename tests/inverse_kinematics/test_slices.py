"""Locked joints: complete within each slice, against forward kinematics, another library and the search."""

import math

import numpy as np
import pytest
import torch
from arms import IIWA, PANDA, UR5, apart, chain_of, random_configurations
from torch.testing import assert_close

import dexterity as dx
from dexterity.inverse_kinematics import slices, solve


@pytest.mark.parametrize(("chain", "joint"), [(PANDA, 4), (IIWA, 2)], ids=["Panda", "iiwa"])
def test_a_slice_holds_the_configuration_that_the_pose_came_from(chain, joint):
    name = chain.joint_names[joint]
    assert list(slices(chain, 3)) == [name]
    q = random_configurations(chain, 12, seed=4)
    found = solve(chain, chain.forward(q), locked={name: q[:, joint]})
    assert not found.complete
    assert found.locked.keys() == {name}
    assert found.reached.all()
    nearest = torch.where(found.usable, apart(found.q, q[:, None]), torch.inf).amin(-1)
    assert nearest.max() < 1e-7
    T = chain.forward(found.q)
    assert (T - chain.forward(q)[:, None]).abs().amax((-2, -1))[found.usable].max() < 1e-9
    off = (found.q[..., joint, None] - q[:, joint]).abs().amin(-1)
    assert off[found.valid].max() == 0


def test_every_solution_of_ssik_with_its_last_joint_locked():
    """personalrobotics/ssik, which resolves the last joint of a Panda as the redundancy."""
    from ssik.prebuilt.franka import panda_ik

    arm = chain_of(panda_ik.fk, 7)
    arm = dx.Chain(arm.screws, arm.home, lower=PANDA.lower, upper=PANDA.upper)
    total = 0
    for q in random_configurations(PANDA, 6, seed=8):
        T = arm.forward(q)
        theirs = torch.tensor(np.array([solution.q for solution in panda_ik.solve(T.numpy())]))
        found = solve(arm, T, locked={"joint 7": theirs[:, 6].clamp(arm.lower[6], arm.upper[6])})
        ours = found.q[found.valid]
        assert apart(theirs[:, None], ours).amin(1).max() < 1e-5
        total += len(theirs)
    assert total > 20


def test_more_slices_reach_more_and_all_that_a_search_reaches():
    T = PANDA.forward(random_configurations(PANDA, 40, seed=2))
    few, many = (solve(PANDA, T, locked=slices(PANDA, count)) for count in (4, 24))
    assert (many.count >= few.count).double().mean() > 0.9
    assert many.reached.double().mean() >= 0.95
    assert solve(PANDA, T, enough=1).reached.all()


def test_slices_serve_a_secondary_objective_and_a_seed():
    q = random_configurations(IIWA, 3)
    locked = slices(IIWA, 12)
    w = dx.Index("manipulability", "geometric").bind(IIWA)
    found = solve(IIWA, IIWA.forward(q), locked=locked, secondary=w)
    values = torch.where(found.usable, w(found.q), -1.0)
    assert (values.diff(dim=-1) <= 1e-12).all()
    near = solve(IIWA, IIWA.forward(q), locked=locked | {"joint 3": q[:, 2]}, near=q)
    assert_close(near.q[:, 0], q, rtol=0, atol=1e-8)


def test_values_run_over_the_limits_or_a_full_turn():
    (values,) = slices(IIWA, 5).values()
    assert_close(values, torch.linspace(float(IIWA.lower[2]), float(IIWA.upper[2]), 5, dtype=torch.float64))
    free = dx.Chain(IIWA.screws, IIWA.home)
    (values,) = slices(free, 8).values()
    assert_close(values.diff(), torch.full((7,), math.tau / 8, dtype=torch.float64))
    (one,) = slices(IIWA, 1).values()
    assert one.abs().max() < 1e-12


def test_what_it_says_and_shapes():
    T = PANDA.forward(random_configurations(PANDA, 6).reshape(2, 3, 7))
    found = solve(PANDA, T, locked={"joint 7": 0.3})
    assert found.q.shape[:2] == (2, 3)
    assert (found.q[found.valid][:, 6] == 0.3).all()
    assert "spherical shoulder, joint 7 locked (complete at 1 values)" in repr(found)
    none = solve(PANDA, T[:0], locked={"joint 7": 0.3})
    assert none.q.shape == (0, 3, 1, 7)


@pytest.mark.usefixtures("annotations_unchecked")
@pytest.mark.parametrize(
    ("options", "error", "message"),
    [
        ({"locked": {"joint 9": 0.0}}, ValueError, "locked is 'joint 9'"),
        ({"locked": {"joint 7": 9.0}}, ValueError, r"locked\['joint 7'\] is 9"),
        ({"locked": {"joint 7": math.nan}}, ValueError, r"locked\['joint 7'\] is not finite"),
        ({"locked": {"joint 7": []}}, ValueError, r"locked\['joint 7'\] has shape \(0,\)"),
        ({"locked": {"joint 7": torch.zeros(10_001)}}, ValueError, "locked makes 10001 slices"),
        ({"locked": {"joint 1": 0.0}}, ValueError, "locked holds joint 1 at 0, where the other joints"),
        ({"locked": {}}, TypeError, "locked is {}"),
        ({"locked": "joint 7"}, TypeError, "locked is 'joint 7'"),
        ({"locked": {"joint 7": 0.0}, "rows": "translational"}, ValueError, "locked holds joint 7"),
        ({"locked": {"joint 7": 0.0}, "method": "search"}, ValueError, "locked holds joint 7"),
    ],
)
def test_bad_slices_are_refused_by_name(options, error, message):
    with pytest.raises(error, match=rf"^{message}"):
        solve(PANDA, PANDA.home, **options)


def test_chains_without_slices_are_told():
    with pytest.raises(ValueError, match=r"^chain has 6 joints; slices are for seven"):
        slices(UR5)
    rng = np.random.default_rng(0)
    axes = rng.normal(size=(7, 3))
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    screws = np.hstack([np.cross(rng.normal(size=(7, 3)), axes), axes])
    with pytest.raises(ValueError, match=r"^chain 'chain' has no joint that leaves a closed form"):
        slices(dx.Chain(screws, np.eye(4)))
