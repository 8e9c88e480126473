"""Files of networks: whole, the same, never executed, and refused where anything is amiss."""

import hashlib
import io
import json
import os
import pickle
import re
import time
import zipfile
from pathlib import Path

import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st

import dexterity as dx
from dexterity import store
from dexterity.networks import NetworkFileError, load, save
from dexterity.networks.network import Network
from example_networks import PLAIN, examples, feed_forward, radial_basis, random_configurations

CARD = {"chain": "uvms", "errors": [0.0015, None], "seen by θ5 … θ11": {"rows": 5000, "guarded": True}}
NETWORKS = examples()
COMMENT = b"dexterity network, sha256 "


def written(folder: Path, network: Network, card: dict | None = None) -> bytes:
    save(network, folder / "network.npz", card)
    return (folder / "network.npz").read_bytes()


def sealed(arrays: dict[str, np.ndarray], pickled: bool = False) -> bytes:
    """Return the bytes of an archive with any content whose checksum is right."""
    archive = io.BytesIO()
    np.savez(archive, allow_pickle=pickled, **arrays)
    length = len(COMMENT) + 64
    body = archive.getvalue()[:-2] + length.to_bytes(2, "little")
    return body + COMMENT + hashlib.sha256(body).hexdigest().encode()


def taken_apart(content: bytes) -> tuple[dict, dict[str, np.ndarray]]:
    arrays = dict(np.load(io.BytesIO(content)))
    return json.loads(arrays.pop("header").tobytes()), arrays


def put_together(header: dict, arrays: dict[str, np.ndarray]) -> bytes:
    return sealed({"header": np.frombuffer(json.dumps(header).encode(), np.uint8), **arrays})


def refused(folder: Path, content: bytes) -> str:
    """Message with which a file of these bytes is refused, without the path that it begins with."""
    path = folder / "refused.npz"
    path.write_bytes(content)
    with pytest.raises(NetworkFileError) as caught:
        load(path)
    assert str(caught.value).startswith(f"{path} ")
    return str(caught.value).removeprefix(f"{path} ")


# ---- there and back --------------------------------------------------------------------------------


@pytest.mark.parametrize("network", NETWORKS.values(), ids=NETWORKS)
def test_a_network_comes_back_as_it_was(tmp_path, rng, network):
    written(tmp_path, network, CARD)
    again = load(tmp_path / "network.npz")
    q = random_configurations(rng, 20)
    assert type(again) is type(network)
    assert torch.equal(again(q), network(q))
    assert again.card == CARD
    assert (again.joints, again.inputs, again.neurons) == (network.joints, network.inputs, network.neurons)


def test_a_card_goes_with_the_network_until_another_is_given(tmp_path, rng):
    network = feed_forward(rng, "identity")
    assert network.card == {}
    written(tmp_path, network, CARD)
    again = load(tmp_path / "network.npz")
    written(tmp_path, again)
    assert load(tmp_path / "network.npz").card == CARD
    written(tmp_path, again, {})
    assert load(tmp_path / "network.npz").card == {}


def test_equal_networks_make_equal_files_at_all_times(tmp_path, monkeypatch):
    content = written(tmp_path, NETWORKS["cone, origin and joints"], CARD)
    monkeypatch.setattr(time, "time", lambda: 1.5e9)
    again = load(tmp_path / "network.npz")
    assert written(tmp_path, again, dict(reversed(CARD.items()))) == content


def test_numpy_alone_reads_a_file(tmp_path, rng):
    network = radial_basis(rng)
    written(tmp_path, network, CARD)
    with np.load(tmp_path / "network.npz") as archive:
        np.testing.assert_array_equal(archive["centres"], network.state_dict()["centres"])
        assert json.loads(archive["header"].tobytes())["card"] == CARD


def test_an_older_file_stays_where_writing_fails(tmp_path, rng):
    network = feed_forward(rng, "identity")
    content = written(tmp_path, network, CARD)
    wrong = (
        ({"worst": float("nan")}, ValueError),
        ({"when": object()}, TypeError),
        ({"n": 10**5000}, ValueError),
    )
    for card, error in wrong:
        with pytest.raises(error):
            save(network, tmp_path / "network.npz", card)
    assert (tmp_path / "network.npz").read_bytes() == content
    assert [path.name for path in tmp_path.iterdir()] == ["network.npz"]


def test_a_network_of_another_kind_is_not_saved(tmp_path):
    class Constant(Network):
        neurons = 0

        def answer(self, x: torch.Tensor) -> torch.Tensor:
            return x[..., 0] * 0

    with pytest.raises(TypeError, match=r"^network is a Constant; FeedForward and RadialBasis can be saved"):
        save(Constant(PLAIN), tmp_path / "network.npz")


# ---- refused ---------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def content(tmp_path_factory) -> bytes:
    return written(tmp_path_factory.mktemp("whole"), NETWORKS["cone, origin and joints"], CARD)


@given(data=st.data())
def test_no_changed_byte_passes(tmp_path_factory, content, data):
    place = data.draw(st.integers(0, len(content) - 1))
    change = data.draw(st.integers(1, 255))
    changed = bytearray(content)
    changed[place] ^= change
    assert re.match(
        "is corrupted|is no network file", refused(tmp_path_factory.getbasetemp(), bytes(changed))
    )


@given(data=st.data())
def test_no_part_of_a_file_passes(tmp_path_factory, content, data):
    start = data.draw(st.integers(0, len(content) - 1))
    end = data.draw(st.integers(start, len(content) - 1 if start == 0 else len(content)))
    refused(tmp_path_factory.getbasetemp(), content[start:end])


@given(junk=st.binary(max_size=300))
def test_nothing_else_passes(tmp_path_factory, junk):
    assert refused(tmp_path_factory.getbasetemp(), junk).startswith(("is no network file", "is corrupted"))


def test_bytes_before_or_after_are_refused(tmp_path, content):
    assert refused(tmp_path, b"x" + content).startswith("is corrupted")
    assert refused(tmp_path, content + b"x").startswith(("is no network file", "is corrupted"))


def test_a_missing_file_is_missing(tmp_path):
    with pytest.raises(FileNotFoundError, match=r"nothing\.npz"):
        load(tmp_path / "nothing.npz")


def test_other_archives_are_refused(tmp_path):
    archive = io.BytesIO()
    np.savez(archive, weights=np.ones(3))
    assert refused(tmp_path, archive.getvalue()).startswith(("is no network file", "is corrupted"))
    assert refused(tmp_path, sealed({"weights": np.ones(3)})).startswith("cannot be read as an archive")
    body = b"no archive"
    checksum = COMMENT + hashlib.sha256(body).hexdigest().encode()
    assert refused(tmp_path, body + checksum).startswith("cannot be read as an archive")


def test_a_later_format_is_refused(tmp_path, content):
    header, arrays = taken_apart(content)
    message = refused(tmp_path, put_together({**header, "version": 2}, arrays))
    assert message == "has version 2 of the format; this release reads version 1"


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"format": "weights"}, "is no network file: its header says 'weights'"),
        ({"kind": "transformer"}, "holds no network that can be built: kind is 'transformer'"),
        ({"inputs": [3, 3]}, "holds no network that can be built: inputs is (3, 3)"),
        ({"options": {}}, "holds no network that can be built"),
        ({"options": {"readout": "square"}}, "holds no network that can be built: readout is 'square'"),
        ({"joints": "twelve"}, "holds no network that can be built"),
        ({"card": [1]}, "holds no network that can be built: entries of a card are [1]"),
    ],
    ids=["format", "kind", "inputs", "no readout", "readout", "joints", "card"],
)
@pytest.mark.usefixtures("annotations_unchecked")
def test_a_header_that_fits_no_network_is_refused(tmp_path, content, change, message):
    header, arrays = taken_apart(content)
    assert refused(tmp_path, put_together({**header, **change}, arrays)).startswith(message)


@pytest.mark.parametrize(
    "change",
    [
        {"hidden_biases": np.full(5, np.nan)},
        {"hidden_biases": np.zeros(4)},
        {"hidden_biases": np.zeros(5, dtype="U3")},
        {"another": np.zeros(3)},
    ],
    ids=["not finite", "another shape", "no numbers", "one too many"],
)
def test_arrays_that_fit_no_network_are_refused(tmp_path, content, change):
    header, arrays = taken_apart(content)
    message = refused(tmp_path, put_together(header, {**arrays, **change}))
    assert message.startswith("holds no network that can be built: ")


@pytest.mark.parametrize("missing", ["format", "version", "kind", "options", "joints", "inputs", "card"])
def test_a_header_without_an_entry_is_refused(tmp_path, content, missing):
    header, arrays = taken_apart(content)
    del header[missing]
    refused(tmp_path, put_together(header, arrays))


class Trap:
    """Unpickled, it raises an error that no test expects."""

    def __reduce__(self):
        return exec, ("raise AssertionError('something in the file was executed')",)


def test_nothing_in_a_file_is_executed(tmp_path, content):
    header, arrays = taken_apart(content)
    trapped = sealed(
        {
            "header": np.frombuffer(json.dumps(header).encode(), np.uint8),
            **arrays,
            "another": np.array([Trap()]),
        },
        pickled=True,
    )
    assert refused(tmp_path, trapped).startswith("cannot be read as an archive of arrays: Object arrays")
    assert refused(tmp_path, pickle.dumps(Trap())).startswith(("is no network file", "is corrupted"))


# ---- hand-made files whose checksum is right: cases of the review, faults #24 --------------------------


@pytest.mark.parametrize("header", [[1], 3, None, "text"])
def test_a_header_that_is_no_mapping_is_refused(tmp_path, content, header):
    refused(tmp_path, put_together(header, taken_apart(content)[1]))


def test_deep_nesting_is_refused(tmp_path, content):
    arrays = taken_apart(content)[1]
    nested = np.frombuffer(b"[" * 200_000, np.uint8)
    refused(tmp_path, sealed({"header": nested, **arrays}))


def test_a_shape_of_more_numbers_than_the_file_is_refused(tmp_path, content):
    header, arrays = taken_apart(content)
    whole = put_together(header, {**arrays, "hidden_biases": np.zeros((1, 9999999))[:, :1]})
    body = whole[: -len(COMMENT) - 64].replace(b"'shape': (1, 1), }", b"'shape': (10**9,)}")
    refused(tmp_path, body + COMMENT + hashlib.sha256(body).hexdigest().encode())


@pytest.mark.parametrize("method", [zipfile.ZIP_DEFLATED, zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA])
def test_compressed_members_are_refused_before_they_are_read(tmp_path, content, method):
    """A bomb of a gigabyte has a megabyte."""
    archive = io.BytesIO()
    with zipfile.ZipFile(archive, "w", method) as bomb:
        bomb.writestr("header.npy", b"\0" * 10_000_000)
    body = archive.getvalue()[:-2] + (len(COMMENT) + 64).to_bytes(2, "little")
    start = time.perf_counter()
    assert "compressed" in refused(tmp_path, body + COMMENT + hashlib.sha256(body).hexdigest().encode())
    assert time.perf_counter() - start < 1


@pytest.mark.parametrize("dtype", [np.float32, np.int64, np.complex128, bool])
def test_arrays_of_another_kind_of_number_are_refused(tmp_path, content, dtype):
    header, arrays = taken_apart(content)
    changed = {**arrays, "hidden_biases": np.zeros(5, dtype)}
    assert "float64 is needed" in refused(tmp_path, put_together(header, changed))


@pytest.mark.parametrize("shape", [(2, 2, 2, 2, 2), (6,), (1, 7)])
def test_carriers_that_are_no_screws_are_refused(tmp_path, content, shape):
    header, arrays = taken_apart(content)
    assert "carriers" in refused(tmp_path, put_together(header, {**arrays, "carriers": np.ones(shape)}))


def test_what_is_no_file_is_refused(tmp_path):
    with pytest.raises(NetworkFileError, match="names no file"):
        load("\0")
    with pytest.raises(NetworkFileError, match="no plain file"):
        load(tmp_path)
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(NetworkFileError, match="no plain file"):
        load(tmp_path / "pipe")
    with (tmp_path / "huge").open("wb") as file:
        file.truncate(1 << 40)
    with pytest.raises(NetworkFileError, match=r"at most .* are read"):
        load(tmp_path / "huge")


@pytest.mark.parametrize(
    ("card", "error"),
    [
        ([1], TypeError),
        ("abc", TypeError),
        (3, TypeError),
        (True, TypeError),
        ({1: "a"}, TypeError),
        ({1: "a", "1": "b"}, TypeError),
        ({"a": (1, 2)}, TypeError),
        ({"a": float("inf")}, ValueError),
        ({"a": "\ud800"}, ValueError),
    ],
)
@pytest.mark.usefixtures("annotations_unchecked")
def test_a_card_that_would_not_come_back_is_refused_before_writing(tmp_path, rng, card, error):
    """Case of the review, faults #11."""
    with pytest.raises(error, match=r"^card"):
        save(feed_forward(rng, "identity"), tmp_path / "network.npz", card)
    assert list(tmp_path.iterdir()) == []


# ---- shipped ---------------------------------------------------------------------------------------


def test_shipped_networks_are_found_by_name(tmp_path, monkeypatch, rng):
    monkeypatch.setattr(store, "data_path", lambda *parts: tmp_path.joinpath(*parts))
    assert dx.networks.shipped() == ()
    for name in ("uvms-b", "uvms-a"):
        save(feed_forward(rng, "identity"), tmp_path / "networks" / f"{name}.npz", {"name": name})
    assert dx.networks.shipped() == ("uvms-a", "uvms-b")
    assert dx.networks.load_shipped("uvms-b").card == {"name": "uvms-b"}
    with pytest.raises(ValueError, match=r"^name is 'uvms-c'; did you mean 'uvms-b'"):
        dx.networks.load_shipped("uvms-c")
