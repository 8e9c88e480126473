"""What networks see of a configuration."""

import math
import subprocess
import sys

import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st
from torch.testing import assert_close

import dexterity as dx
from dexterity import spatial
from dexterity.chain import Chain
from dexterity.networks.feed_forward import FeedForward
from dexterity.networks.network import View, checked


def configurations(count, joints=12, seed=0):
    return torch.from_numpy(np.random.default_rng(seed).uniform(-2, 2, (count, joints)))


@given(st.sets(st.integers(0, 6), min_size=1))
def test_chosen_joints_are_seen_in_their_order(joints):
    q = configurations(5, 7)
    view = View(7, sorted(joints))
    assert view.width == len(joints)
    assert torch.equal(view(q), q[:, sorted(joints)])


@pytest.mark.parametrize("carried", [1, 6, 8, 12])
def test_the_origin_is_seen_from_the_carried_link(carried):
    """The link is the tool of a chain of the joints that carry it, lying on the world at home."""
    screws = dx.robots.uvms().screws[:carried]
    q = configurations(7)
    view = View(12, [10, 11], carriers=screws)
    seen = view(q)
    T_world_link = Chain(screws, torch.eye(4)).forward(q[:, :carried])
    T_link_world = torch.linalg.inv(T_world_link)
    assert view.width == 5
    assert_close(seen[:, :3], T_link_world[:, :3, 3], rtol=0, atol=1e-12)
    assert torch.equal(seen[:, 3:], q[:, 10:])


def test_spatial_kci_depends_on_the_first_four_joints_through_the_origin_alone():
    """The reason for carriers: another place and roll with the same view have the same KCI."""
    chain = dx.robots.uvms()
    kci = dx.indices.Index("kinematic_conditioning", frame="spatial").bind(chain)
    view = View(12, range(4, 12), carriers=chain.screws[:6])
    q = configurations(4)
    rolled = q.clone()
    rolled[:, 3] += 0.7
    rolled[:, :3] = 0
    R_world_vehicle = Chain(chain.screws[:6], torch.eye(4)).forward(rolled[:, :6])[:, :3, :3]
    rolled[:, :3] = -(R_world_vehicle @ view(q)[:, :3, None])[..., 0]
    assert_close(view(rolled), view(q), rtol=0, atol=1e-12)
    assert_close(kci(rolled), kci(q), rtol=1e-9, atol=0)


def test_views_keep_batch_axes(batch_shape):
    q = configurations(math.prod(batch_shape)).reshape(*batch_shape, 12)
    view = View(12, [4, 5], carriers=dx.robots.uvms().screws[:6])
    assert view(q).shape == (*batch_shape, 5)


def test_views_are_differentiable():
    view = View(12, [0, 11], carriers=dx.robots.uvms().screws[:6])
    q = configurations(2).requires_grad_()
    assert torch.autograd.gradcheck(view, q)


@pytest.mark.parametrize(
    ("joints", "inputs", "carriers", "message"),
    [
        (3, [], (), "inputs is"),
        (3, [1, 0], (), "rising order"),
        (3, [0, 0], (), "rising order"),
        (3, [0, 3], (), "from 0 to 2"),
        (3, [-1], (), "from 0 to 2"),
        (1, [0], np.eye(6)[:2], "carriers has 2 screws"),
        (3, [0], np.zeros((1, 6)), r"carriers\[0\] turns by 0"),
        (3, [0], np.ones((3, 2)), r"carriers has shape \(3, 2\)"),
        (3, [0], np.ones(6), r"carriers has shape \(6,\)"),
        (3, [0], np.ones((1, 6)), r"carriers\[0\] turns by 1.73205"),
        (3, [0], np.full((1, 6), math.nan), "finite"),
    ],
)
def test_bad_views(joints, inputs, carriers, message):
    with pytest.raises(ValueError, match=message):
        View(joints, inputs, carriers)


@pytest.mark.parametrize("inputs", [3, None, "01", [0.5], [True]])
@pytest.mark.usefixtures("annotations_unchecked")
def test_inputs_that_are_no_numbers_of_joints_are_refused(inputs):
    with pytest.raises(TypeError, match=r"^inputs"):
        View(3, inputs)


@pytest.mark.parametrize("q", [0.0, [1.0, 2.0], [[1.0, 2.0, math.nan]]])
def test_bad_configurations(q):
    view = View(3, [0])
    with pytest.raises(ValueError, match=r"q has shape|finite"):
        view(q)


def test_networks_say_what_they_see():
    q = configurations(10)
    view = View(12, [3, 7])
    network = FeedForward.untrained(view, 4, q, q[:, 3], torch.Generator().manual_seed(0))
    assert (network.joints, network.inputs, network.neurons) == (12, (3, 7), 4)
    with pytest.raises(ValueError, match="12 joints"):
        network(q[:, :5])


def test_arrays_are_checked_and_copied():
    given_array = np.ones(3, dtype=np.float32)
    array = checked({"a": given_array}, {"a": (3,)})["a"]
    given_array[0] = 5
    assert array.dtype == torch.float64
    assert array[0] == 1
    for arrays, message in [
        ({}, r"\['a'\] are needed"),
        ({"a": [1.0] * 3, "b": 1.0}, "there are arrays"),
        ({"a": [1.0, 2.0]}, r"a has shape \(2,\)"),
        ({"a": [1.0, 2.0, math.inf]}, "a .*finite"),
    ]:
        with pytest.raises(ValueError, match=message):
            checked(arrays, {"a": (3,)})


def test_the_origin_of_a_chain_that_does_not_move_is_its_own():
    view = View(2, [0], carriers=[[0.0, 0, 0, 0, 0, 1.0]])
    assert torch.equal(view([[0.3, 0.0]]), torch.tensor([[0.0, 0, 0, 0.3]], dtype=torch.float64))
    assert spatial.to_float64(view.carriers, "carriers").shape == (1, 6)


def test_a_view_does_not_change_with_its_callers_array():
    carriers = np.array([[0.0, 0, 0, 0, 0, 1]])
    view = View(2, (1,), carriers)
    before = view([0.3, 0.4])
    carriers[:] = 7
    assert torch.equal(view([0.3, 0.4]), before)


@pytest.mark.parametrize("convert", [torch.nn.Module.float, torch.nn.Module.half, torch.nn.Module.bfloat16])
def test_networks_stay_in_double_precision(convert):
    network = dx.networks.load_shipped("uvms-manipulability-feed-forward")
    convert(network)
    with pytest.raises(TypeError, match="networks compute in double precision"):
        network([0.1] * 12)


def test_devices_that_differ_are_named():
    network = dx.networks.load_shipped("uvms-manipulability-feed-forward")
    q = torch.zeros(3, 12, dtype=torch.float64, device="meta")
    with pytest.raises(ValueError, match="q is on the device meta"):
        network(q)
    assert network.to("meta")(q).shape == (3,)
    network = dx.networks.load_shipped("uvms-manipulability-feed-forward")
    torch.set_default_device("meta")
    try:
        assert network([0.1] * 12).is_cpu
    finally:
        torch.set_default_device(None)


GROWTH = """
import resource, torch
from dexterity import networks
torch.set_num_threads(1)
for kind in ("feed-forward", "radial-basis"):
    network = networks.load_shipped(f"uvms-manipulability-{kind}")
    q = torch.rand(200_000, 12, dtype=torch.float64) / 4
    with torch.no_grad():
        network(q[:20_000])
        before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        values = network(q)
    growth = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) * 1024 / len(q)
    assert growth <= 500, (kind, growth)
    torch.testing.assert_close(values[::10_000], network(q[::10_000]), rtol=1e-12, atol=1e-14)
"""


def test_a_large_batch_takes_at_most_500_bytes_a_configuration():
    """pinocchio#1634, curobo#625, of networks, which took 1200 and 2700."""
    done = subprocess.run([sys.executable, "-c", GROWTH], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_many_configurations_of_a_network_with_two_values_are_as_few():
    q = torch.rand(40_000, 2, dtype=torch.float64)
    values = torch.stack([q.sum(-1), q.prod(-1)], -1)
    network = FeedForward.untrained(View(2, [0, 1]), 3, q, values, torch.Generator().manual_seed(0))
    with torch.no_grad():
        many = network(q.reshape(4, 10_000, 2))
        few = torch.stack([network(row[:7]) for row in q.reshape(4, 10_000, 2)])
    assert many.shape == (4, 10_000, 2)
    assert_close(many[:, :7], few)
