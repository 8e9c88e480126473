"""Sealed files: what comes back, and what is refused, whether by chance or made by hand."""

import hashlib
import io
import json
import zipfile

import hypothesis
import hypothesis.strategies as st
import numpy as np
import pytest

from dexterity import sealed

HEADER = {"format": "test", "list": [1, 2.5, None, "θ"]}
ARRAYS = {
    "x": np.linspace(0, 1, 5),
    "counts": np.arange(6, dtype=np.int32).reshape(2, 3),
    "on": np.array([True]),
}
CONTENT = sealed.packed("test", HEADER, ARRAYS)


def by_hand(members: dict[str, bytes], compression: int = zipfile.ZIP_STORED) -> bytes:
    """Return any archive with a right checksum."""
    archive = io.BytesIO()
    with zipfile.ZipFile(archive, "w", compression) as file:
        for name, content in members.items():
            file.writestr(name, content)
    comment = b"dexterity test, sha256 "
    body = archive.getvalue()[:-2] + (len(comment) + 64).to_bytes(2, "little")
    return body + comment + hashlib.sha256(body).hexdigest().encode()


def npy(array: np.ndarray) -> bytes:
    file = io.BytesIO()
    np.save(file, array)
    return file.getvalue()


def text(content: str) -> bytes:
    return npy(np.frombuffer(content.encode(), np.uint8))


def test_what_was_packed_comes_back_and_equal_contents_are_equal_bytes():
    header, arrays = sealed.unpacked(CONTENT, "test")
    assert header == HEADER
    assert list(arrays) == list(ARRAYS)
    for name, array in ARRAYS.items():
        np.testing.assert_array_equal(arrays[name], array, strict=True)
    assert sealed.packed("test", HEADER, ARRAYS) == CONTENT
    with np.load(io.BytesIO(CONTENT)) as archive:
        np.testing.assert_array_equal(archive["x"], ARRAYS["x"])


@hypothesis.given(place=st.integers(0, len(CONTENT) - 1), bit=st.integers(0, 7))
def test_no_changed_bit_is_accepted(place, bit):
    changed = bytearray(CONTENT)
    changed[place] ^= 1 << bit
    with pytest.raises(sealed.SealedFileError):
        sealed.unpacked(bytes(changed), "test")


@hypothesis.given(length=st.integers(0, len(CONTENT) - 1))
def test_no_part_is_accepted(length):
    with pytest.raises(sealed.SealedFileError):
        sealed.unpacked(CONTENT[:length], "test")


def test_another_kind_is_refused_by_name():
    with pytest.raises(sealed.SealedFileError, match="is no network file"):
        sealed.unpacked(CONTENT, "network")


HEADS = (b"{'descr':", b"(((((((\n", b"  x\n y  ", b"'''     ")
BOMB = by_hand({"header.npy": text("{}"), "x.npy": npy(np.zeros(10**6))}, zipfile.ZIP_DEFLATED)
HUGE = npy(np.zeros(1)).replace(b"(1,)", b"(10000000000000,)", 1).replace(b" " * 17, b" " * 4, 1)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (by_hand({"header.npy": text("[1]")}), "its header is a list"),
        (by_hand({"header.npy": text("null")}), "its header is a NoneType"),
        (by_hand({"header.npy": text("[" * 200_000)}), "recursion|Expecting"),
        (by_hand({"header.npy": b"no array"}), "magic string"),
        *((by_hand({"header.npy": b"\x93NUMPY\x01\0\x08\0" + head}), "cannot be read") for head in HEADS),
        (by_hand({"x.npy": npy(np.zeros(3))}), "header"),
        (BOMB, "is compressed"),
        (by_hand({"header.npy": text("{}"), "x.npy": HUGE}), "does not hold what its shape says|header"),
        (by_hand({"header.npy": text("{}"), "x.npy": npy(np.zeros(3))[:-8]}), "does not hold what its shape"),
    ],
    ids=[
        "list",
        "null",
        "nested",
        "no array",
        *(f"head {i}" for i in range(4)),
        "no header",
        "deflated",
        "huge",
        "short",
    ],
)
def test_a_right_checksum_does_not_make_a_file_good(content, message):
    with pytest.raises(sealed.SealedFileError, match=message):
        sealed.unpacked(content, "test")


def test_pickled_objects_are_refused():
    archive = io.BytesIO()
    np.savez(archive, header=np.frombuffer(b"{}", np.uint8), x=np.array([{}], dtype=object))
    with zipfile.ZipFile(archive) as file:
        members = {name: file.read(name) for name in file.namelist()}
    with pytest.raises(sealed.SealedFileError, match="Object arrays"):
        sealed.unpacked(by_hand(members), "test")


@pytest.mark.parametrize(
    ("header", "arrays", "error"),
    [
        ({"x": float("nan")}, {}, ValueError),
        ({"x": object()}, {}, TypeError),
        ({}, {"header": np.zeros(1)}, ValueError),
        ({}, {"x": np.array([{}], dtype=object)}, ValueError),
    ],
)
def test_what_cannot_be_said_is_refused(header, arrays, error):
    with pytest.raises(error):
        sealed.packed("test", header, arrays)


def test_the_shipped_networks_are_of_this_format():
    from dexterity import store

    path = next((store.data_path() / "networks").glob("*.npz"))
    header, arrays = sealed.unpacked(path.read_bytes(), "network")
    assert header["format"] == "dexterity-network"
    assert sealed.packed("network", header, arrays) == path.read_bytes()
    assert json.dumps(header)
