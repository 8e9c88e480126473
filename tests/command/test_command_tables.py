"""Tables of numbers that the command reads."""

import csv
import io
import json
from pathlib import Path

import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st

import dexterity as dx
from dexterity.command.files import table
from dexterity.command.inputs import configurations, poses
from dexterity.command.reports import Report

NAMES = ("a", "b", "c")
OBJECTS = [{"a": 0.1, "b": 0.2, "c": 0.3, "note": "x"}, {"c": 3.0, "b": -2.5, "a": 1e-17}]
ROWS = [[0.1, 0.2, 0.3], [1e-17, -2.5, 3.0]]
finite = st.floats(allow_nan=False, allow_infinity=False)


@pytest.fixture
def write(tmp_path):
    def written(content: str | bytes, name: str = "rows.csv"):
        path = tmp_path / name
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return path

    return written


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("rows.csv", "a,b,c\n0.1,0.2,0.3\n1e-17,-2.5,3\n"),
        ("rows.csv", "\ufeffc, b ,x,a\n0.3,0.2,word,0.1\n\n3,-2.5,,1e-17\n"),
        ("rows.csv", '# a comment\n"a","b","c"\r\n"0.1","0.2","0.3"\r\n1e-17,-2.5,3\r\n'),
        ("rows.txt", "0.1,0.2,0.3\n1e-17,-2.5,3"),
        ("rows.json", json.dumps(ROWS)),
        ("rows.json", json.dumps(OBJECTS)),
        (
            "rows.json",
            json.dumps({"robot": "x", "rows": OBJECTS}),
        ),
    ],
)
def test_each_form_gives_the_same_rows(write, name, content):
    assert table(write(content, name), [NAMES]).tolist() == ROWS


def test_arrays_of_numpy(tmp_path):
    np.save(tmp_path / "rows.npy", np.array(ROWS, dtype=np.float32))
    assert table(tmp_path / "rows.npy", [NAMES]).tolist() == np.float32(ROWS).tolist()


@given(st.lists(st.tuples(finite, finite, finite), min_size=1, max_size=5))
def test_csv_keeps_every_bit(tmp_path_factory, rows):
    path = tmp_path_factory.mktemp("csv") / "rows.csv"
    path.write_text("b,c,a\n" + "".join(f"{b!r},{c!r},{a!r}\n" for a, b, c in rows))
    assert table(path, [NAMES]).tolist() == [list(row) for row in rows]


def test_standard_input(monkeypatch):
    monkeypatch.setattr("sys.stdin", io.StringIO("[[1, 2, 3]]"))
    assert table(Path("-"), [NAMES]).tolist() == [[1, 2, 3]]


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("q.csv", "", "is empty"),
        ("q.csv", "a,b,c\n", "no rows"),
        ("q.csv", "a,b\n1,2\n", "has the columns a, b; a, b, c are needed"),
        ("q.csv", "a,b,c,a\n1,2,3,4\n", "two columns 'a'"),
        ("q.csv", "a,b,c\n1,2\n", "line 2 has 2 columns"),
        ("q.csv", "1,2,3\n4,5\n", "line 2 has 2 columns; the first has 3"),
        ("q.csv", "a,b,c\n1,2,x\n", "line 2 holds 'x'"),
        ("q.csv", "a,b,c\n1,2,3\n1,nan,3\n", "row 2 holds a value that is not finite"),
        ("q.csv", b"\xff\xfe\x00", "is no text"),
        ("q.json", "[[1, 2], [3]]", "rows of different lengths"),
        ("q.json", "[[1, 2, true]]", "something else than numbers"),
        ("q.json", '[["1", "2", "3"]]', "something else than numbers"),
        ("q.json", "[[1, 2, NaN]]", "not finite"),
        ("q.json", '[{"a": 1, "b": 2, "c": 3}, {"a": 1}]', "row 2 does not hold"),
        ("q.json", "{", "is no JSON"),
        ("q.json", "[" * 100_000, "is no JSON"),
        ("q.json", "[]", "no list of rows"),
        ("q.npy", b"no array", "is no .npy file"),
        ("q.npy", b"\x93NUMPY\x01\0\x08\0(((((((\n", "is no .npy file"),
        ("q.json", "[" + "9" * 5_000 + "]", "is no JSON"),
        ("q.json", "[1.0, 1" + "0" * 400 + "]", "too large|something else than numbers"),
        ("q.csv", "a,b,c\n1,2," + "3" * 200_000 + "\n", "is no CSV|not finite|holds"),
        ("q.csv", "a,b," + "c" * 200_000 + "\n1,2,3\n", "is no CSV"),
    ],
)  # fmt: skip
def test_what_is_no_table_is_refused_by_name(write, name, content, message):
    path = write(content, name)
    with pytest.raises(ValueError, match=message) as caught:
        table(path, [NAMES])
    assert name in str(caught.value)


def test_arrays_with_pickles_are_refused(tmp_path):
    np.save(tmp_path / "q.npy", np.array([{}, 1], dtype=object))
    with pytest.raises(ValueError, match=r"q\.npy is no \.npy file"):
        table(tmp_path / "q.npy", [NAMES])


def test_configurations_are_matched_to_the_joints(write):
    puma = dx.robots.puma560()
    backwards = puma.joint_names[::-1]
    file = write(f"{','.join(backwards)}\n6,5,4,3,2,1\n")
    assert configurations(puma, ["0,0,0,0,0,pi"], file)[1].tolist() == [1, 2, 3, 4, 5, 6]
    with pytest.raises(ValueError, match=r"q\.csv has 2 columns; the robot has 6 joints: waist"):
        configurations(puma, [], write("1,2\n", "q.csv"))
    with pytest.raises(ValueError, match="there is no configuration"):
        configurations(puma, [], None)


def test_poses_in_each_form_are_the_same(write, tmp_path):
    T = dx.spatial.from_rpy([0.1, -0.2, 0.3], [0.4, 0.5, 0.6])
    q = dx.spatial.quaternion(T, order="xyzw").tolist()
    np.save(tmp_path / "poses.npy", T.numpy())
    found = [
        poses(["0.4,0.5,0.6,0.1,-0.2,0.3"], None),
        poses([",".join(map(repr, [0.4, 0.5, 0.6, *q]))], None),
        poses([" ".join(map(repr, T.flatten().tolist()))], None),
        poses([], tmp_path / "poses.npy"),
        poses([], write("yaw,pitch,roll,x,y,z\n0.3,-0.2,0.1,0.4,0.5,0.6\n")),
        poses([], write('{"x": 0.4, "y": 0.5, "z": 0.6, "roll": 0.1, "pitch": -0.2, "yaw": 0.3}')),
        poses([], write(json.dumps(T.tolist()))),
    ]
    for T_found in found:
        torch.testing.assert_close(T_found, T[None], rtol=0, atol=1e-14)


def test_no_poses(write):
    with pytest.raises(ValueError, match="there is no pose"):
        poses([], None)
    with pytest.raises(ValueError, match="--pose is no pose"):
        poses(["0,0,0,0,0,0,0"], None)
    with pytest.raises(ValueError, match="the shape"):
        poses([], write("1,2\n"))


def test_no_name_becomes_a_formula_and_its_table_is_read_back(tmp_path):
    names = ("=cmd|' /C calc'!A0", "+a", "-b", "@c", "'=d", "e")
    report = Report({**{name: [0.5] for name in names}, "note": ["=1+1"]})
    text = report.as_csv()
    cells = [cell for row in csv.reader(io.StringIO(text)) for cell in row]
    assert not [cell for cell in cells if cell[0] in "=+-@"]
    (tmp_path / "q.csv").write_text(text)
    assert table(tmp_path / "q.csv", [names]).tolist() == [[0.5] * 6]


def test_a_name_moves_no_cursor(capsys):
    Report({"name": ["a\x1b[2Jb\x07"]}, {"card": "\x1b]0;title\x07"}).show()
    assert "\x1b" not in (shown := capsys.readouterr().out)
    assert "\x07" not in shown
