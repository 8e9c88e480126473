"""The command from its words to its answer, in this process; two runs of its own process."""

import json
import os
import subprocess
import sys
import tomllib

import numpy as np
import pytest
import torch
from asking import ask, refusal

import dexterity as dx
from dexterity import store
from dexterity.command.application import application

SUBCOMMANDS = [command.name or command.callback.__name__ for command in application.registered_commands]


def in_a_process(*words: str, **options: object) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "dexterity.command", *words],
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
        **options,
    )


def test_help_comes_without_torch():
    code = (
        "import sys; from dexterity.command import main; main(['--help']); assert 'torch' not in sys.modules"
    )
    shown = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=True
    )
    for name in SUBCOMMANDS:
        assert name in shown.stdout
    assert "Exit codes" in shown.stdout


@pytest.mark.parametrize("name", SUBCOMMANDS)
def test_each_subcommand_has_help_with_an_example_of_itself(capsys, name):
    shown = ask(capsys, name, "--help")
    assert "Examples:" in shown
    assert f"dexterity {name}" in shown


def test_a_process_of_its_own_reads_standard_input_and_ends_with_the_code():
    done = in_a_process(
        "evaluate", "puma560", "w", "--file", "-", "--json", input="[[0, 0.5, 0.25, 0, 0.5, 0]]"
    )
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["rows"][0]["manipulability"] == pytest.approx(0.0087, abs=1e-4)


def test_robots_are_listed_and_described(capsys, tmp_path):
    listed = json.loads(ask(capsys, "robots", "--json"))["rows"]
    assert tuple(row["robot"] for row in listed) == dx.robots.names()
    described = json.loads(ask(capsys, "robots", "panda", "--json"))
    panda = dx.robots.load("panda")
    assert [row["joint"] for row in described["rows"]] == list(panda.joint_names)
    assert [row["upper"] for row in described["rows"]] == panda.upper.tolist()
    assert [row["rate"] for row in described["rows"]] == panda.rates.tolist()
    assert {row["kind"] for row in described["rows"]} == {"revolute"}


def test_indices_are_listed_and_described(capsys):
    listed = json.loads(ask(capsys, "indices", "--json"))["rows"]
    assert tuple(row["index"] for row in listed) == dx.indices.names()
    described = {
        row["entry"]: row["value"] for row in json.loads(ask(capsys, "indices", "kci", "--json"))["rows"]
    }
    assert described["name"] == "kinematic_conditioning"
    assert described["better"] == "larger"


def test_evaluate_gives_the_values_of_the_library_to_the_last_digit(capsys, tmp_path):
    panda = dx.robots.load("panda")
    q = np.random.default_rng(0).uniform(panda.lower, panda.upper, (5, 7))
    np.save(tmp_path / "q.npy", q)
    index = dx.Index("kci", "body", rows=("vx", "vy", "wz"))
    words = [
        "evaluate",
        "panda",
        "kci",
        "--file",
        tmp_path / "q.npy",
        "--frame",
        "body",
        "--rows",
        "vx,vy,wz",
    ]
    shown = ask(capsys, *words, "--csv").splitlines()
    assert shown[0] == "configuration,kinematic_conditioning"
    assert [float(line.split(",")[1]) for line in shown[1:]] == index.bind(panda)(q).tolist()

    rows = json.loads(ask(capsys, *words, "--gradient", "--json"))["rows"]
    slopes = [[row[f"d/d {name}"] for name in panda.joint_names] for row in rows]
    at = torch.tensor(q, requires_grad=True)
    index(panda, at).sum().backward()
    assert slopes == at.grad.tolist()


def test_evaluate_compiled_gives_the_same(capsys):
    words = ["evaluate", "puma560", "w", "--q", "0,0.5,0.25,0,0.5,0.1", "--gradient", "--json"]
    (exact,) = json.loads(ask(capsys, *words))["rows"]
    (compiled,) = json.loads(ask(capsys, *words, "--compiled"))["rows"]
    assert compiled == pytest.approx(exact, rel=1e-10, abs=1e-12)


def test_a_table_is_short_and_says_so(capsys, tmp_path):
    np.save(tmp_path / "q.npy", np.zeros((100, 6)))
    shown = ask(capsys, "evaluate", "puma560", "w", "--file", tmp_path / "q.npy")
    assert "40 more rows; --csv prints all 100" in shown


def test_rank_lists_the_best_first(capsys, tmp_path):
    ur5e = dx.robots.load("ur5e")
    q = torch.rand(20, 6, dtype=torch.float64, generator=torch.Generator().manual_seed(0)) * 3
    np.save(tmp_path / "q.npy", q.numpy())
    words = ["--file", tmp_path / "q.npy", "--best", 3, "--json"]
    report = json.loads(ask(capsys, "rank", "ur5e", "welding", *words))
    ranking = dx.tasks.rank(ur5e, q, "welding")
    assert [row["configuration"] for row in report["rows"]] == ranking.best(3).tolist()
    assert [row[ur5e.joint_names[0]] for row in report["rows"]] == q[ranking.best(3), 0].tolist()
    assert "times the median" in report["effect"]

    by_index = json.loads(ask(capsys, "rank", "ur5e", "tool_deviation", "--rows", "translational", *words))
    index = dx.Index("tool_deviation", "geometric", rows="translational")
    assert [row["configuration"] for row in by_index["rows"]] == index(ur5e, q).argsort()[:3].tolist()


def test_ik_lists_every_configuration_of_a_ur5e(capsys, tmp_path):
    ur5e = dx.robots.load("ur5e")
    q = torch.tensor([[0.3, -1.2, 1.5, -0.4, 0.8, 0.1], [-1.0, -0.7, 1.1, 0.2, -0.9, 2.0]]).double()
    np.save(tmp_path / "T.npy", ur5e.forward(q).numpy())
    report = json.loads(ask(capsys, "ik", "ur5e", "--poses", tmp_path / "T.npy", "--json"))
    assert report["finds all"] is True
    assert report["poses reached"] == "2 of 2"
    found = [[row[name] for name in ur5e.joint_names] for row in report["rows"]]
    found = torch.tensor(found, dtype=torch.float64)
    poses = torch.tensor([row["pose"] for row in report["rows"]])
    torch.testing.assert_close(ur5e.forward(found), ur5e.forward(q)[poses], rtol=0, atol=1e-8)
    for pose in range(2):
        assert (found[poses == pose] - q[pose]).abs().amax(-1).min() < 1e-6

    # What ik prints is what evaluate reads.
    (tmp_path / "q.csv").write_text(ask(capsys, "ik", "ur5e", "--poses", tmp_path / "T.npy", "--csv"))
    values = ask(capsys, "evaluate", "ur5e", "kci", "--file", tmp_path / "q.csv", "--csv").splitlines()
    assert len(values) == len(found) + 1


def test_ik_begins_with_the_configuration_near_the_robot(capsys):
    near = "0.3,-1.2,1.5,-0.4,0.8,6.2831853"
    T = dx.robots.load("ur5e").forward([0.3, -1.2, 1.5, -0.4, 0.8, 0.0])
    pose = " ".join(map(repr, T.flatten().tolist()))
    first = json.loads(ask(capsys, "ik", "ur5e", "--pose", pose, "--near", near, "--json"))["rows"][0]
    assert list(first.values())[2:] == pytest.approx([0.3, -1.2, 1.5, -0.4, 0.8, 2 * np.pi], abs=1e-6)


def test_a_pose_out_of_reach_is_a_negative_answer(capsys):
    shown = ask(capsys, "ik", "ur5e", "--pose", "3,0,0", "--csv", code=1)
    assert len(shown.splitlines()) == 1
    assert "0 of 1" in ask(capsys, "ik", "ur5e", "--pose", "3,0,0", code=1)


def test_a_report_is_written_whole_or_not_at_all(capsys, tmp_path, monkeypatch):
    words = ["evaluate", "puma560", "w", "--q", "0,0.5,0.25,0,0.5,0", "--output", tmp_path / "w.csv"]
    assert ask(capsys, *words) == ""
    written = (tmp_path / "w.csv").read_text()
    assert written.startswith("configuration,manipulability\n0,0.0087")

    def full(*arguments: object) -> None:
        raise OSError(28, "No space left on device", str(tmp_path / "w.csv"))

    monkeypatch.setattr(os, "fsync", full)
    assert "No space left on device" in refusal(capsys, *words)
    assert (tmp_path / "w.csv").read_text() == written
    assert [path.name for path in tmp_path.iterdir()] == ["w.csv"]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["evaluate", "pumma560", "w", "--q", "0"], "puma560"),
        (["evaluate", "puma560", "dexterousness", "--q", "0,0,0,0,0,0"], "dexterousness"),
        (["evaluate", "puma560", "w"], "there is no configuration"),
        (["evaluate", "reach_alpha5", "w", "--q", "0.1,0.2,0.3,0.4"], "zero everywhere"),
        (["evaluate", "puma560", "w", "--q", "1,2"], "--q holds 2 numbers; 6 are needed"),
        (["evaluate", "puma560", "w", "--q", "1,2,3,4,5,x"], "--q holds 'x'"),
        (["evaluate", "puma560", "w", "--q", "0,0,0,0,0,0", "--rows", "sideways"], "sideways"),
        (["evaluate", "puma560", "w", "--q", "0,0,0,0,0,0", "--tool-rates", "1,2"], "--tool-rates holds 2"),
        (["evaluate", "puma560", "w", "--q", "0,0,0,0,0,0", "--csv", "--json"], "exclude each other"),
        (["evaluate", "puma560", "w", "--q", "0,0,0,0,0,0", "-o", "w.txt"], "ends in .csv or .json"),
        (["evaluate", "puma560", "w", "--q", "0,0,0,0,0,0", "-o", "nowhere/w.csv"], "does not exist"),
        (["evaluate", "puma560", "w", "--file", "missing.csv"], "missing.csv: No such file"),
        (["evaluate", "puma560", "w", "--frame", "sideways", "--q", "0"], "--frame"),
        (["evaluate", "puma560", "velocity_ratio", "--q", "0,0,0,0,0,0"], "direction is missing"),
        (["evaluate", "missing.urdf", "w", "--q", "0"], "missing.urdf"),
        (["evaluate", "puma560", "w", "--base", "link0", "--q", "0,0,0,0,0,0"], "base"),
        (["validate", "uvms-manipulability-feed-forwards"], "did you mean 'uvms-manipulability-feed-f"),
        (["design", "puma560", "w", "--to", "w.txt"], "ends in .npz"),
        (["design", "puma560", "w", "--to", "nowhere/w.npz"], "does not exist"),
        (["design", "puma560", "w", "--to", "w.npz", "--sizes", "4.5"], "--sizes"),
        (["design", "puma560", "w", "--to", "w.npz", "--half-range", "1,2"], "--half-range holds 2"),
        (["design", "puma560", "w", "--to", "w.npz", "--middle", "9,9,9,9,9,9"], "outside the limits"),
        (["design", "puma560", "w"], "--to"),
        (["ik", "ur5e"], "there is no pose"),
        (["ik", "ur5e", "--pose", "0.3,0.1"], "--pose holds 2 numbers; 3 or 6 or 7 or 16 are needed"),
        (["ik", "ur5e", "--pose", "0.3,0.1,0.2", "--near", "1"], "--near holds 1 numbers"),
        (["ik", "ur5e", "--pose", "0.3,0.1,0.2", "--rows", "up"], "up"),
        (["ik", "ur5e", "--pose", "0.3,0.1,0.2", "--limit-tolerance", "-1"], "--limit-tolerance"),
        (["export", "puma560", "w", "--form", "onnx", "--to", "."], "--form is onnx"),
        (["export", "puma560", "w", "--form", "javascript", "--single", "--to", "."], "--single"),
        (["export", "puma560", "w", "--name", "int", "--to", "."], "int"),
        (["export", "puma560", "--to", "."], "no such file or network"),
        (["map", "ur5e", "--to", "map.txt"], "ends in .npz"),
        (["map", "ur5e", "--to", "map.npz", "--lower", "0,0,0"], "--lower and --upper"),
        (["map", "ur5e", "--to", "map.npz", "--lower", "0,0", "--upper", "1,1,1"], "--lower holds 2"),
        (["map", "ur5e", "--to", "map.npz", "--spacing", "0"], "spacing"),
        (["map", "ur5e", "--to", "map.npz", "--method", "magic"], "magic"),
        (["map", "ur5e", "--to", "map.npz", "--continue"], "map.npz: No such file"),
        (["rank", "puma560", "juggling", "--q", "0,0,0,0,0,0"], "welding"),
        (["rank", "puma560", "juggling", "--q", "0,0,0,0,0,0", "--frame", "body"], "juggling"),
        (["rank", "puma560", "welding", "--best", "0", "--q", "0,0,0,0,0,0"], "--best"),
        (["place", "ur5e"], "there is no pose"),
        (["place", "ur5e", "--seam", "0,0,0"], "--seam holds 3 numbers"),
        (["place", "ur5e", "--pose", "0.4,0,0.3", "--x", "0:1"], "--x is '0:1'"),
        (["place", "ur5e", "--pose", "0.4,0,0.3", "--by", "luck"], "luck"),
        (["validate", "pyproject.toml"], "no such file or network"),
        (["evalute"], "Did you mean 'evaluate'"),
        (["evaluate"], "Missing argument"),
        (["robots", "--colour"], "No such option"),
    ],
)  # fmt: skip
def test_bad_input_is_one_line_that_names_it(capsys, tmp_path, monkeypatch, words, message):
    monkeypatch.chdir(tmp_path)
    assert message in refusal(capsys, *words)
    assert not list(tmp_path.iterdir())


def test_a_fault_of_the_machine_has_a_code_of_its_own(capsys, monkeypatch, tmp_path):
    monkeypatch.setenv("CC", "no-such-compiler")
    monkeypatch.setenv("DEXTERITY_CACHE", str(tmp_path))
    said = refusal(capsys, "evaluate", "puma560", "w", "--q", "0,0,0,0,0,0", "--compiled", code=3)
    assert "compiler" in said


def test_control_c_has_a_code_of_its_own(capsys, monkeypatch):
    def interrupted(*arguments: object, **options: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(dx.robots, "load", interrupted)
    assert "interrupted" in refusal(capsys, "robots", "panda", code=130)


def test_a_closed_pipe_is_no_error():
    python = [sys.executable, "-m", "dexterity.command", "robots", "--csv"]
    with subprocess.Popen(python, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        process.stdout.close()
        assert process.stderr.read() == ""
        assert process.wait(timeout=60) == 0


def test_markup_in_names_is_shown_as_it_stands(capsys, tmp_path):
    joint = '<joint name="[red]j[/red]" type="revolute"><parent link="a"/><child link="b"/>'
    limit = '<limit lower="-1" upper="1" velocity="1" effort="1"/></joint>'
    path = tmp_path / "arm.urdf"
    path.write_text(f'<robot name="[bold]arm"><link name="a"/><link name="b"/>{joint}{limit}</robot>')
    shown = ask(capsys, "robots", path)
    assert "[red]j[/red]" in shown
    assert "[bold]arm" in shown


def test_a_missing_extra_is_named_with_the_way_to_install_it(capsys, monkeypatch):
    monkeypatch.setitem(sys.modules, "typer", None)
    monkeypatch.delitem(sys.modules, "dexterity.command.application")
    said = refusal(capsys, "robots", code=3)
    assert "pip install 'dexterity-study[command]'" in said


def test_the_script_is_declared():
    project = tomllib.loads((store.repository() / "pyproject.toml").read_text())["project"]
    assert project["scripts"] == {"dexterity": "dexterity.command:main"}
