"""Encodings there and back, the gate, files."""

import itertools
import math
from functools import cache

import hypothesis
import hypothesis.strategies as st
import numpy as np
import pytest
import torch
from torch.testing import assert_close

from dexterity import spatial
from dexterity.workspace import dataset, jacobian_net, reachability, training
from dexterity.workspace.archive import ArchiveError, read_archive, write_archive
from dexterity.workspace.dataset import JacobianData, Samples, Scaling
from dexterity.workspace.jacobian_net import Architecture, JacobianNet, decode, encode, inputs_of

WIDTHS = {"columns": 96, "relevant": 10, "rotation": 16, "plane": 6}
ENTRIES = {"tool": 23, "world": 21, "plane": 11}
TINY = Architecture(encoder=(8, 7), confidence=(6, 5), estimation=(9,), normalised=(1, 1), dropout=0.5)


@cache
def data() -> JacobianData:
    return dataset.jacobian_data(600, seed=0)


def network(inputs="plane", entries="plane", architecture=TINY, seed=0) -> JacobianNet:
    return training.network_for(architecture, inputs, entries, data(), seed)


@pytest.mark.parametrize("entries", ENTRIES)
def test_entries_lead_back_to_the_jacobian(entries):
    y = encode(data().jacobian, data().samples, entries)
    assert y.shape == (600, ENTRIES[entries])
    assert (y.std(0) > 1e-3).all(), "no entry is constant"
    back = decode(y, data().samples.position, data().samples.rotation(), entries)
    assert_close(back, data().jacobian, atol=1e-13, rtol=0)


def test_the_plane_of_the_arm_is_there_on_the_first_axis_too():
    links = torch.tensor([[0.0, 0.3, 0.4, 0.1]])
    samples = Samples(links.double(), torch.tensor([[0.0, 0.0, 0.2]]).double(), torch.ones(1, 3).double())
    q, reach = reachability.inverse(links, spatial.pose(samples.rotation(), samples.position))
    assert reach.all()
    J = reachability.geometric_jacobian(links, q)
    back = decode(encode(J, samples, "plane"), samples.position, samples.rotation(), "plane")
    assert_close(back, J, atol=1e-13, rtol=0)


@pytest.mark.parametrize("kind", WIDTHS)
def test_inputs_have_their_width(kind):
    assert inputs_of(data().samples, kind).shape == (600, WIDTHS[kind])


def test_what_is_seen_in_the_plane_does_not_change_with_a_turn_about_the_first_axis():
    turn = dataset.rotation([0.0, 0.0, 0.7])
    turned = data().samples._replace(position=data().samples.position @ turn.mT)
    assert_close(inputs_of(turned, "plane"), inputs_of(data().samples, "plane"), atol=1e-14, rtol=0)


@pytest.mark.parametrize(("inputs", "entries"), [*itertools.product(["rotation", "plane"], ENTRIES)])
def test_poses_are_answered_as_samples_are(inputs, entries):
    net = network(inputs, entries)
    by_samples = net.estimate(data().samples)
    T = spatial.pose(data().samples.rotation(), data().samples.position)
    by_poses = net.answer(data().samples.links, T)
    for one, other in zip(by_samples, by_poses, strict=True):
        assert_close(one, other)
    assert by_samples.jacobian.isfinite().all()


def test_batches_are_broadcast():
    estimate = network().answer(data().samples.links[0], torch.eye(4).expand(2, 3, 4, 4))
    assert estimate.confidence.shape == (2, 3)
    assert estimate.jacobian.shape == (2, 3, 6, 6)


def test_the_gate_is_the_threshold():
    net = network()
    confidence = net.estimate(data().samples).confidence
    for threshold in (0.0, float(confidence.median()), 1.0):
        net.threshold = threshold
        assert torch.equal(net.estimate(data().samples).mask, confidence >= threshold)


def test_the_papers_size_is_what_its_code_is_told_to_have():
    data = dataset.jacobian_data(20, 0)
    net = training.network_for(jacobian_net.PAPER_SIZE, "columns", "tool", data, 0)
    assert 6.0e6 < net.parameter_count < 7.0e6
    dense = [part for part in net.encoder if isinstance(part, torch.nn.Linear)]
    assert len(dense) == 9
    assert dense[-1].out_features == 2150
    for head in (net.confidence, net.estimation):
        assert sum(isinstance(part, torch.nn.Linear) for part in head) == 8


def test_the_same_seed_gives_the_same_weights_whatever_the_global_one_is():
    torch.manual_seed(1)
    one = network(seed=3)
    torch.manual_seed(2)
    same, other = network(seed=3), network(seed=4)
    for a, b, c in zip(one.parameters(), same.parameters(), other.parameters(), strict=True):
        assert torch.equal(a, b)
        assert a.ndim == 1 or not torch.equal(a, c)


def test_a_file_gives_the_network_back(tmp_path):
    net = network()
    net.save(tmp_path / "net.npz")
    again = JacobianNet.load(tmp_path / "net.npz")
    for one, other in zip(net.estimate(data().samples), again.estimate(data().samples), strict=True):
        assert torch.equal(one, other)


def test_files_of_something_else_are_refused(tmp_path):
    path = tmp_path / "net.npz"
    with pytest.raises(FileNotFoundError):
        JacobianNet.load(path)
    path.write_bytes(b"no archive")
    with pytest.raises(ArchiveError, match="end is missing"):
        JacobianNet.load(path)
    network().save(path)
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) // 2])
    with pytest.raises(ArchiveError, match="end is missing"):
        JacobianNet.load(path)
    header, tensors = network().header(), network().state_dict()
    for change in (
        {"architecture": {"encoder": [3]}},
        {"architecture": [1]},
        {"inputs": None},
        {"threshold": 2},
    ):
        write_archive(path, "jacobian-net", header | change, tensors)
        with pytest.raises(ArchiveError, match="no network that can be built"):
            JacobianNet.load(path)
    write_archive(path, "training", header, tensors)
    with pytest.raises(ArchiveError, match="no jacobian-net file"):
        JacobianNet.load(path)


@pytest.mark.parametrize(
    ("name", "change"),
    [
        ("confidence.0.weight", lambda part: part * math.nan),
        ("unit_in", lambda part: part * math.inf),
        ("confidence.0.weight", lambda part: part.double()),
        ("confidence.0.weight", lambda part: part.int()),
        ("confidence.0.weight", lambda part: part != 0),
        ("confidence.0.weight", lambda part: part + 0j),
        ("confidence.0.weight", lambda part: part[:1]),
        ("confidence.0.weight", lambda _: None),
    ],
)
def test_weights_that_are_none_are_refused(tmp_path, name, change):
    tensors = network().state_dict()
    tensors[name] = change(tensors[name])
    present = {key: part for key, part in tensors.items() if part is not None}
    write_archive(tmp_path / "net.npz", "jacobian-net", network().header(), present)
    with pytest.raises(ArchiveError, match="no network that can be built"):
        JacobianNet.load(tmp_path / "net.npz")


@hypothesis.given(place=st.integers(0), bit=st.integers(0, 7))
def test_no_changed_bit_of_a_file_is_accepted(tmp_path_factory, place, bit):
    path = tmp_path_factory.getbasetemp() / "net.npz"
    network().save(path)
    content = bytearray(path.read_bytes())
    content[place % len(content)] ^= 1 << bit
    path.write_bytes(content)
    with pytest.raises(ArchiveError):
        JacobianNet.load(path)


@pytest.mark.usefixtures("annotations_unchecked")
@pytest.mark.parametrize("field", ["encoder", "confidence", "estimation", "normalised", "dropout"])
@pytest.mark.parametrize("value", [math.nan, "3", None, (2.5,), (-1, -1), [True, 1], np.ones(2)])
def test_an_architecture_that_is_none_is_named(field, value):
    with pytest.raises((TypeError, ValueError), match=rf"^{field}(\[\d\])? (is|has) "):
        Architecture(**{field: value})


@pytest.mark.usefixtures("annotations_unchecked")
def test_unknown_choices_are_named():
    with pytest.raises(ValueError, match=r"^entries is 'x'"):
        training.network_for(TINY, "plane", "x", data(), 0)
    with pytest.raises(ValueError, match=r"^inputs is 'x'"):
        training.network_for(TINY, "x", "plane", data(), 0)
    with pytest.raises(TypeError, match=r"^data is None"):
        training.network_for(TINY, "plane", "plane", None, 0)
    with pytest.raises(TypeError, match=r"^samples is 3"):
        jacobian_net.inputs_of(3, "plane")


def test_samples_of_another_kind_are_told_by_their_dynamics():
    net = network("columns", "tool")
    with pytest.raises(ValueError, match="dynamics=True"):
        training.confidence_rows(net, dataset.confidence_data(20, 0))


def test_archives_hold_what_was_put_in(tmp_path):
    tensors = {"a": torch.arange(6).reshape(2, 3), "b/c": torch.tensor(1.5)}
    write_archive(tmp_path / "a.npz", "test", {"said": [1, "two"]}, tensors)
    header, back = read_archive(tmp_path / "a.npz", "test")
    assert header == {"said": [1, "two"]}
    assert back.keys() == tensors.keys()
    assert all(torch.equal(back[name], tensors[name]) for name in tensors)
    with pytest.raises(ValueError, match="the header's name"):
        write_archive(tmp_path / "a.npz", "test", {}, {"header": torch.zeros(1)})


def test_a_threshold_is_a_share():
    scaling = Scaling(torch.zeros(6).double(), torch.ones(6).double())
    with pytest.raises(ValueError, match=r"threshold is 1\.5"):
        JacobianNet(TINY, "plane", "plane", scaling, scaling, torch.Generator(), 1.5)


def test_a_network_of_columns_cannot_answer_for_a_pose():
    with pytest.raises(ValueError, match="of a pose alone"):
        network("columns", "tool").answer([0.1, 0.2, 0.3, 0.1], torch.eye(4))
    with pytest.raises(ValueError, match="T_base_tool"):
        network().answer([0.1, 0.2, 0.3, 0.1], 2 * torch.eye(4))
    with pytest.raises(ValueError, match="links has shape"):
        network().answer([0.1, 0.2, 0.3], torch.eye(4))
