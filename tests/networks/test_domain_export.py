"""Trained spaces in ECMAScript against the guards in torch."""

import numpy as np
import pytest

from dexterity import networks, sampling
from dexterity.networks import domain_export
from dexterity.networks.domain import Guarded
from dexterity.sampling import Box
from run_in_node import called, needs_node

INDICES = ("manipulability", "kinematic_conditioning")


def guard(name: str, turned: bool = False) -> Guarded:
    network = networks.load_shipped(f"uvms-{name.replace('_', '-')}-feed-forward")
    return Guarded(network, sampling.uvms_space(name, turned=turned))


def around(space: sampling.Space, rng: np.random.Generator) -> np.ndarray:
    """Configurations inside, on the border, a little outside of it, and anywhere."""
    q = sampling.sobol(space, 200, 0, overhang=0.3).numpy()
    out = q.copy()
    rows = np.arange(len(q))
    out[rows, rng.integers(0, space.joints, len(q))] += rng.choice([-1e-6, 1e-6, 1e-12, 0.3], len(q))
    return np.concatenate([q, out, rng.uniform(-1, 1, (100, space.joints))])


@needs_node
@pytest.mark.parametrize(("name", "turned"), [(INDICES[0], False), (INDICES[1], False), (INDICES[1], True)])
def test_inside_is_what_the_guard_says(tmp_path, rng, name, turned):
    guarded = guard(name, turned)
    q = around(guarded.space, rng)
    answers = called(
        tmp_path, domain_export.javascript_module(guarded), "contains", [[row] for row in q.tolist()]
    )
    wanted = guarded.contains(q).tolist()
    assert answers == wanted
    assert 100 < sum(wanted) < len(wanted) - 100


@needs_node
def test_joints_that_leave_are_named(tmp_path):
    guarded, q = guard(INDICES[0]), np.zeros((3, 12))
    q[0, [4, 9]] = 0.5
    q[1, 0] = 7  # the index does not depend on where the vehicle is
    answers = called(
        tmp_path, domain_export.javascript_module(guarded), "leaving", [[row] for row in q.tolist()]
    )
    assert answers == [[4, 9], [], []]


@needs_node
def test_a_held_joint_of_a_space_alone_is_not_free(tmp_path):
    space = Box([0.0, 1.0], [1.0, 1.0])
    calls = [[[0.5, 1.0]], [[0.5, 1.1]], [[1.0, 1.0 + 1e-10]], [[1.1, 1.0]]]
    assert called(tmp_path, domain_export.space_module(space), "contains", calls) == [
        True,
        False,
        True,
        False,
    ]


class Elsewhere:
    """A space of another kind, with all that a space has."""

    joints = dimensions = 3
    levels = (None,) * 3
    from_unit = to_unit = contains = staticmethod(lambda q: q)


def test_other_spaces_are_refused():
    with pytest.raises(TypeError, match=r"^space is a Elsewhere; Box and TaskSector can be exported"):
        domain_export.space_module(Elsewhere())
