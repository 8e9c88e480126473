import copy
import dataclasses
import enum
import itertools
import os
import struct
from pathlib import Path
from types import MappingProxyType

import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st

from dexterity import store
from dexterity.store import content_key, data_path, repository, write_atomically


@dataclasses.dataclass(frozen=True)
class Point:
    x: float
    y: float = 0.0


@dataclasses.dataclass(frozen=True)
class Vector:
    x: float
    y: float = 0.0


class Color(enum.StrEnum):
    RED = "red"
    BLUE = "blue"


class Count(int):
    pass


primitives = st.none() | st.booleans() | st.integers() | st.floats() | st.text() | st.binary()
values = st.recursive(
    primitives,
    lambda inner: (
        st.lists(inner, max_size=3)
        | st.lists(inner, max_size=3).map(tuple)
        | st.dictionaries(st.text(max_size=2) | st.integers(-2, 2), inner, max_size=3)
    ),
    max_leaves=6,
)


def identical(one: object, other: object) -> bool:
    """Tell whether two values are the same to a computation that looks at their types too."""
    if type(one) is not type(other):
        return False
    if isinstance(one, float):
        return (one != one and other != other) or struct.pack(">d", one) == struct.pack(">d", other)
    if isinstance(one, tuple | list):
        return len(one) == len(other) and all(map(identical, one, other))
    if isinstance(one, dict):
        # Looking a key up is not enough: 1 and True are found alike.
        found = [[pair for pair in other.items() if identical(pair, mine)] for mine in one.items()]
        return len(one) == len(other) and all(len(pairs) == 1 for pairs in found)
    return one == other


@given(values)
def test_a_key_is_sixteen_hex_digits_and_the_same_for_a_copy(value):
    key = content_key(value)
    assert len(key) == 16
    assert set(key) <= set("0123456789abcdef")
    assert key == content_key(copy.deepcopy(value))


@given(values, values)
def test_keys_are_equal_exactly_if_values_are_identical(one, other):
    assert (content_key(one) == content_key(other)) == identical(one, other)


@given(st.lists(st.text("ab", max_size=3), max_size=4), st.lists(st.text("ab", max_size=3), max_size=4))
def test_neighbouring_texts_do_not_run_together(one, other):
    assert (content_key(*one) == content_key(*other)) == (one == other)


def test_types_shapes_and_names_are_part_of_the_content():
    different = [
        *(
            None,
            False,
            True,
            0,
            1,
            -1,
            0.0,
            -0.0,
            1.0,
            float("nan"),
            float("inf"),
            "",
            "1",
            "None",
            b"",
            b"1",
        ),
        *((), [], {}, (1,), [1], {1: 1}, {"1": 1}, {1: 1.0}, ((1,),), (1, (2,)), ((1,), 2), (1, 2)),
        *(np.float64(1), np.float32(1), np.int64(1), np.array(1.0), np.array([1.0]), np.array([[1.0]])),
        *(np.array([1]), np.array([1], dtype=np.int32), np.array([True]), np.array(["1"]), np.zeros((0, 3))),
        *(np.zeros((3, 0)), torch.tensor(1.0), torch.tensor([1.0]), torch.tensor([1.0]).double()),
        *(torch.tensor([1]), torch.tensor([True]), torch.zeros(0, 3), torch.zeros(3, 0)),
        *(Point(1.0), Point(1.0, 1.0), Vector(1.0), (1.0, 0.0), Color.RED, Color.BLUE, "red"),
    ]
    for one, other in itertools.combinations(different, 2):
        assert content_key(one) != content_key(other), (one, other)
    assert content_key() != content_key(())
    assert content_key(1, 2) != content_key((1, 2))


def test_a_key_does_not_depend_on_the_process():
    content = ("name", 1, -2.5, True, None, {"b": (1,), "a": [2.0]}, np.arange(3.0), torch.arange(2))
    assert content_key(*content) == "94690e9b70ace1d8"


@given(st.dictionaries(st.text(), st.integers()), st.randoms())
def test_the_order_of_a_mapping_does_not_count(mapping, random):
    items = list(mapping.items())
    random.shuffle(items)
    assert content_key(mapping) == content_key(dict(items)) == content_key(MappingProxyType(dict(items)))


@given(st.integers(0x7FF0000000000001, 0x7FFFFFFFFFFFFFFF))
def test_every_nan_has_the_same_key(bits):
    (nan,) = struct.unpack(">d", struct.pack(">Q", bits))
    assert content_key(nan) == content_key(float("nan")) == content_key(-nan)


def test_the_memory_layout_does_not_count():
    array = np.arange(6.0).reshape(2, 3)
    assert content_key(array) == content_key(np.asfortranarray(array)) == content_key(array.T.copy().T)
    tensor = torch.arange(6.0).reshape(2, 3)
    assert content_key(tensor) == content_key(tensor.T.contiguous().T)
    assert content_key(tensor) == content_key(tensor.clone().requires_grad_())
    conjugate = torch.tensor([1 + 2j]).conj()
    assert content_key(conjugate) == content_key(conjugate.resolve_conj())
    assert content_key(torch.zeros(2, dtype=torch.bfloat16)) != content_key(torch.zeros(2, dtype=torch.half))


@pytest.mark.parametrize(
    ("value", "name"),
    [
        (object(), "builtins.object"),
        ({1}, "builtins.set"),
        (range(3), "builtins.range"),
        (1j, "builtins.complex"),
        (Point, "builtins.type"),
        (Count(1), "test_store.Count"),
        (Path(), "Path"),
        (np.array([object()]), "dtype object"),
        (np.zeros(1, dtype=[("a", float)]), "'a'"),
        (torch.eye(2).to_sparse(), "sparse_coo"),
    ],
    ids=lambda part: part if isinstance(part, str) else type(part).__name__,
)
def test_a_value_of_another_type_is_named(value, name):
    for wrapped in (value, [value], {"inside": (value,)}):
        with pytest.raises(TypeError, match=name):
            content_key(wrapped)


@given(content=st.text() | st.binary(), older=st.none() | st.binary())
def test_a_file_holds_exactly_what_was_written(tmp_path_factory, content, older):
    path = tmp_path_factory.mktemp("written") / "new" / "folder" / "file"
    if older is not None:
        write_atomically(path, older)
    write_atomically(path, content)
    assert path.read_bytes() == (content if isinstance(content, bytes) else content.encode())
    assert list(path.parent.iterdir()) == [path]


@pytest.mark.parametrize("step", ["fsync", "replace"])
@pytest.mark.parametrize("failure", [OSError("disk full"), KeyboardInterrupt()], ids=repr)
def test_a_failure_leaves_the_older_file_and_nothing_else(tmp_path, monkeypatch, step, failure):
    def fail(*_):
        raise failure

    path = tmp_path / "file"
    write_atomically(path, "older")
    monkeypatch.setattr(*((os, "fsync") if step == "fsync" else (Path, "replace")), fail)
    with pytest.raises(type(failure)):
        write_atomically(path, "newer")
    assert path.read_text() == "older"
    assert list(tmp_path.iterdir()) == [path]


def test_what_is_no_content_is_refused_before_anything_is_touched(tmp_path):
    with pytest.raises(TypeError):
        write_atomically(tmp_path / "folder" / "file", 3)
    assert list(tmp_path.iterdir()) == []


def test_a_file_has_the_permissions_of_any_other(tmp_path):
    (tmp_path / "plain").write_text("")
    write_atomically(tmp_path / "file", "")
    assert (tmp_path / "file").stat().st_mode == (tmp_path / "plain").stat().st_mode


def test_data_is_found_in_the_source_tree():
    root = repository()
    assert root is not None
    assert data_path() == root / "data"
    assert data_path("robots", "uvms.toml").is_file()


def test_data_is_found_in_an_installed_package(tmp_path, monkeypatch):
    # A target folder inside some other project must not be mistaken for the source tree.
    package = tmp_path / "libraries" / "dexterity"
    (package / "_data" / "robots").mkdir(parents=True)
    (package / "_data" / "robots" / "uvms.toml").touch()
    (tmp_path / "pyproject.toml").touch()
    monkeypatch.setattr(store, "PACKAGE", package)
    assert repository() is None
    assert data_path("robots", "uvms.toml") == package / "_data" / "robots" / "uvms.toml"


@pytest.mark.parametrize("parts", [("robots", "no-such.toml"), ("no-such",), ("no-such", "x", "y")])
def test_a_data_file_that_is_not_there_is_named(parts):
    with pytest.raises(FileNotFoundError, match="/".join(parts)):
        data_path(*parts)


def test_what_killed_writers_have_left_is_swept_after_a_day(tmp_path):
    old, fresh = tmp_path / ".0123456789abcdef.tmp", tmp_path / ".fedcba9876543210.tmp"
    other = tmp_path / ".mine.tmp"
    for file in (old, fresh, other):
        file.touch()
    for file in (old, other):
        os.utime(file, (0, 0))
    write_atomically(tmp_path / "a.txt", "a")
    assert {path.name for path in tmp_path.iterdir()} == {fresh.name, other.name, "a.txt"}


@pytest.mark.parametrize(
    "content",
    [b"a = ", b"\xff", b"[" * 100_000, b"a = " + b"9" * 5_000, b"a." * 50_000 + b"b = 1", b"a = 1\na = 2"],
    ids=range(6),
)
def test_toml_that_cannot_be_read_is_named(tmp_path, content):
    (tmp_path / "robot.toml").write_bytes(content)
    with pytest.raises(ValueError, match=r"^robot\.toml cannot be read as TOML"):
        store.read_toml(tmp_path / "robot.toml")


def test_toml_may_have_a_byte_order_mark_and_must_be_a_file(tmp_path):
    (tmp_path / "robot.toml").write_text('a = "π"', encoding="utf-8-sig")
    assert store.read_toml(tmp_path / "robot.toml") == {"a": "π"}
    with pytest.raises(ValueError, match="is no plain file"):
        store.read_toml(tmp_path)
    with pytest.raises(FileNotFoundError):
        store.read_toml(tmp_path / "none.toml")


def test_what_is_no_plain_file_is_refused_by_name(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "large").write_bytes(b"12345")
    for path, message in (
        (tmp_path, "no plain file"),
        (tmp_path / "pipe", "no plain file"),
        ("a\0b", "names no"),
    ):
        with pytest.raises(ValueError, match=message):
            store.read_bytes(path)
    with pytest.raises(ValueError, match="has 5 bytes; at most 4"):
        store.read_bytes(tmp_path / "large", largest=4)
    assert store.read_bytes(tmp_path / "large", largest=5) == b"12345"


@pytest.mark.parametrize("step", ["fsync", "replace", "folder"])
def test_a_set_that_cannot_be_written_leaves_the_older_one_or_is_noticed(tmp_path, monkeypatch, step):
    store.write_set(tmp_path, "x.sha256", {"a": "old", "b": "old"})
    calls = itertools.count()

    def fail_at_the_second(original):
        def call(*arguments):
            if next(calls):
                raise OSError("disk full")
            return original(*arguments)

        return call

    if step == "folder":
        (tmp_path / "c").mkdir()
    else:
        owner = os if step == "fsync" else Path
        monkeypatch.setattr(owner, step, fail_at_the_second(getattr(owner, step)))
    with pytest.raises(OSError, match=r"disk full|is a folder"):
        store.write_set(tmp_path, "x.sha256", {"a": "new", "b": "new", "c": "new"})
    monkeypatch.undo()
    assert not list(tmp_path.glob(".*.tmp"))
    if step == "replace":
        with pytest.raises(FileNotFoundError):
            store.read_set(tmp_path, "x.sha256")
    else:
        assert store.read_set(tmp_path, "x.sha256") == {"a": b"old", "b": b"old"}


@pytest.mark.parametrize("name", ["../x", "a/b", "/etc/x", "", ".."])
def test_no_file_of_a_set_leaves_its_folder(tmp_path, name):
    with pytest.raises(ValueError, match="is no name of a file in the folder"):
        store.write_set(tmp_path / "set", "x.sha256", {name: "x"})


@pytest.mark.parametrize(
    "listed", [b"\xff\xfe", b"abc", b"0  ../x", b"0  "], ids=["bytes", "word", "path", "none"]
)
def test_a_list_of_checksums_that_is_none_is_refused(tmp_path, listed):
    (tmp_path / "x.sha256").write_bytes(listed)
    with pytest.raises(ValueError, match="is no list of checksums"):
        store.read_set(tmp_path, "x.sha256")


def test_a_file_does_not_take_the_place_of_a_folder(tmp_path):
    with pytest.raises(IsADirectoryError, match=f"^{tmp_path} is a folder; a file was to take its place"):
        write_atomically(tmp_path, "text")
