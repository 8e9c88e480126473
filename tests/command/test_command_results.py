"""Subcommands that make files or take a while: their files, their negative answers, and Ctrl-C."""

import dataclasses
import json

import numpy as np
import pytest
import torch
from asking import ask, refusal

import dexterity as dx
from dexterity.command import main
from dexterity.command.progress import Bar

REGION = ["--lower", "0.2,-0.4,0", "--upper", "0.8,0.4,0.4", "--spacing", 0.2]


def test_a_map_is_surveyed_and_saved(capsys, tmp_path):
    words = ["map", "ur5e", *REGION, "--index", "kci", "--to", tmp_path / "map.npz", "--json"]
    entries = {row["entry"]: row["value"] for row in json.loads(ask(capsys, *words))["rows"]}
    found = dx.reach.ReachMap.load(tmp_path / "map.npz")
    assert entries["poses reached"] == int(found.reached.sum()) > 0
    assert entries["poses looked at"] == entries["poses"] == found.reached.numel()
    assert entries["best index"] == found.best[found.reached].max().item()


MEANING = ["--rows", "translational", "--direction", "0,0,2", "--joint-rates", "2"]


def test_the_index_of_a_map_is_said_in_the_words_of_evaluate(capsys, tmp_path):
    words = ["map", "ur5e", *REGION, "--index", "velocity_ratio", *MEANING, "--to", tmp_path / "map.npz"]
    ask(capsys, *words)
    found = dx.reach.ReachMap.load(tmp_path / "map.npz")
    at = found.reached.nonzero()[0]
    q = found.configurations[tuple(at)].tolist()
    row = ["evaluate", "ur5e", "velocity_ratio", *MEANING, "--q", ",".join(map(repr, q)), "--json"]
    (answer,) = json.loads(ask(capsys, *row))["rows"]
    assert found.best[tuple(at)].item() == pytest.approx(answer["velocity_ratio"], rel=1e-12)
    # To go on with another meaning would mix two indices.
    other = [*words, "--frame", "body", "--continue"]
    assert "method and index is needed" in refusal(capsys, *other)


@pytest.mark.parametrize("option", [["--rows", "translational"], ["--frame", "body"], ["--length", "0.5"]])
def test_options_of_an_index_need_an_index(capsys, tmp_path, option):
    words = ["map", "ur5e", *REGION, *option, "--to", tmp_path / "map.npz"]
    assert "without --index; --pose-rows says" in refusal(capsys, *words)


def test_the_rows_of_the_pose_are_no_rows_of_the_index(capsys, tmp_path):
    words = ["map", "reach_alpha5", "--lower=0.1,-0.1,0", "--upper", "0.2,0.1,0.1", "--spacing", "0.1"]
    words += ["--pose-rows", "translational", "--rotations", "1", "--to", tmp_path / "map.npz"]
    ask(capsys, *words, "--index", "w", "--rows", "translational")
    assert dx.reach.ReachMap.load(tmp_path / "map.npz").reached.any()


def test_control_c_keeps_the_poses_that_are_finished_and_continue_goes_on(capsys, tmp_path, monkeypatch):
    def interrupt(self: Bar, done: int, total: int) -> None:
        if 0 < done < total:
            raise KeyboardInterrupt

    words = ["map", "panda", *REGION, "--to", tmp_path / "map.npz", "--threads", 1, "--json"]
    with monkeypatch.context() as patch:
        patch.setattr(Bar, "__call__", interrupt)
        capsys.readouterr()
        assert main([str(word) for word in words]) == 130
    part = dx.reach.ReachMap.load(tmp_path / "map.npz")
    assert not part.finished
    assert 0 < part.examined.sum() < part.examined.numel()
    ask(capsys, *words, "--continue")
    assert dx.reach.ReachMap.load(tmp_path / "map.npz").finished


SEAM = ["--seam", "-0.25,0,0,0.25,0,0", "--x", "-0.4:0.4:3", "--y", "-0.5", "--yaw", "0:pi/2:2"]


def test_a_base_is_placed_along_a_seam(capsys):
    report = json.loads(ask(capsys, "place", "ur5e", *SEAM, "--json"))
    down = dx.spatial.from_rpy([np.pi, 0, 0])[:3, :3]
    seam = dx.reach.seam([-0.25, 0, 0], [0.25, 0, 0], 5, down)
    bases = dx.reach.planar_bases([-0.4, 0, 0.4], [-0.5], [0, np.pi / 2])
    placed = dx.reach.place(dx.robots.load("ur5e"), seam, bases, "kci")
    assert report["bases looked at"] == "6 of 6"
    assert [row["worst"] for row in report["rows"]] == [row["worst"] for row in placed.table(10)]
    assert report["rows"][0]["worst"] >= 0.14


def test_a_base_is_placed_by_the_torque_about_the_axis_of_a_valve(capsys):
    about_z = ["--index", "force_ratio", "--direction", "0,0,0,0,0,1", "--length", "0.5"]
    report = json.loads(ask(capsys, "place", "ur5e", *SEAM, *about_z, "--json"))
    assert report["index"] == repr(
        dx.Index("force_ratio", "geometric", direction=(0, 0, 0, 0, 0, 1), characteristic_length=0.5)
    )
    assert report["rows"][0]["worst"] > 0


def test_an_arm_with_three_joints_is_placed_by_positions_and_told_why(capsys, tmp_path):
    file = tmp_path / "arm.csv"
    file.write_text("d,a,alpha,lower,upper\n0.3,0,pi/2,-pi,pi\n0,0.5,0,-pi/2,pi/2\n0,0.4,0,0,150deg\n")
    words = [
        "place",
        file,
        "--seam=-0.1,0,0.4,0.1,0,0.4",
        "--y=-0.6",
        "--index",
        "w",
        "--rows",
        "translational",
    ]
    assert main([str(word) for word in words]) == 1
    assert "arm has 3 joints and meets hardly any pose in all 6 rows" in capsys.readouterr().err
    report = json.loads(ask(capsys, *words, "--pose-rows", "translational", "--json"))
    assert report["bases that reach all poses"] == 1


def test_no_base_that_reaches_all_poses_is_a_negative_answer(capsys):
    report = json.loads(ask(capsys, "place", "ur5e", "--pose", "9,0,0", "--x", "0:1:2", "--json", code=1))
    assert report["bases that reach all poses"] == 0


def test_control_c_lists_the_bases_that_were_looked_at(capsys, monkeypatch):
    place = dx.reach.place

    def interrupted(*arguments: object, **options: object) -> object:
        found = place(*arguments, **options)
        return dataclasses.replace(found, examined=torch.arange(len(found.bases)) < 4)

    monkeypatch.setattr(dx.reach, "place", interrupted)
    report = json.loads(ask(capsys, "place", "ur5e", *SEAM, "--json", code=130))
    assert report["bases looked at"] == "4 of 6"


def test_networks_are_listed(capsys):
    rows = json.loads(ask(capsys, "validate", "--json"))["rows"]
    assert tuple(row["network"] for row in rows) == dx.networks.shipped()
    assert all(0 < row["worst case"] < 1 for row in rows)


def test_a_network_that_holds_and_one_that_misses(capsys, tmp_path):
    name = "uvms-manipulability-feed-forward"
    words = [name, "--points", 2000, "--json"]
    report = json.loads(ask(capsys, "validate", *words))
    rows = {row["error"]: row for row in report["rows"]}
    assert report["holds"] is True
    assert rows["worst case found"]["here"] <= 1.05 * rows["worst case found"]["on the card"]
    missed = json.loads(ask(capsys, "validate", *words, "--goal", 1e-6, code=1))
    assert missed["holds"] is False
    # The same network with one weight moved is found out by its own card.
    network = dx.networks.load_shipped(name)
    with torch.no_grad():
        next(network.parameters()).mul_(1.1)
    dx.networks.save(network, tmp_path / "moved.npz", network.card)
    ask(capsys, "validate", tmp_path / "moved.npz", "--points", 2000, code=1)


SMALL = ["--middle", "0,0.6,-0.9,0,0.8,0", "--half-range", "0,0.2,0.2,0,0.2,0", "--restarts", 1]
SMALL += ["--training-rows", 300, "--epochs", 20, "--sizes", "3,5"]


def test_a_designed_network_is_judged_and_written_with_its_card(capsys, tmp_path):
    words = ["design", "puma560", "w", *SMALL, "--to", tmp_path / "w.npz", "--json"]
    entries = {row["entry"]: row["value"] for row in json.loads(ask(capsys, *words, "--goal", 0.5))["rows"]}
    network = dx.networks.Guarded.load(tmp_path / "w.npz")
    w = dx.Index("w", "geometric")(dx.robots.puma560(), [0, 0.6, -0.9, 0, 0.8, 0])
    with torch.no_grad():
        learned = float(network([0, 0.6, -0.9, 0, 0.8, 0]))
    assert learned == pytest.approx(float(w), rel=0.5)
    assert entries["goal kept"] is True
    assert entries["better answer"] in ("exact", "network")
    assert "worst" in (tmp_path / "w.md").read_text()
    assert (tmp_path / "w.html").read_text().startswith("<!doctype html>")
    # A goal that no network keeps is a negative answer; what was learned is written all the same.
    (tmp_path / "w.npz").unlink()
    ask(capsys, *words, "--goal", 1e-9, code=1)
    assert (tmp_path / "w.npz").exists()


def test_control_c_keeps_the_networks_that_are_finished(capsys, tmp_path, monkeypatch):
    def interrupt(self: Bar, text: str, done: int, total: int) -> None:
        if done >= 1:
            raise KeyboardInterrupt

    monkeypatch.setattr(Bar, "step", interrupt)
    words = ["design", "puma560", "w", *SMALL, "--goal", 1e-9, "--to", tmp_path / "w.npz"]
    capsys.readouterr()
    assert main([str(word) for word in words]) == 130
    assert dx.networks.load(tmp_path / "w.npz").card["worst_case"]["error"] > 0


def test_an_index_is_exported_as_the_library_writes_it(capsys, tmp_path):
    derivation = dx.symbolic.derive(dx.robots.puma560(), dx.Index("w", "geometric"))
    for flags, precision in (([], "double"), (["--single"], "float")):
        ask(capsys, "export", "puma560", "w", "--name", "puma_w", "--to", tmp_path / precision, *flags)
        for name, content in dx.codegen.c_files(derivation, "puma_w", precision).items():
            assert (tmp_path / precision / name).read_text() == content
        sums = (tmp_path / precision / "puma_w.sha256").read_text()
        assert set(dx.store.read_set(tmp_path / precision, "puma_w.sha256")) == {"puma_w.c", "puma_w.h"}, sums
    ask(capsys, "export", "puma560", "w", "--form", "javascript", "--name", "puma_w", "--to", tmp_path)
    assert (tmp_path / "puma_w.js").read_text() == dx.codegen.javascript_module(derivation)


def test_kinematics_are_exported(capsys, tmp_path):
    ask(capsys, "export", "puma560", "kinematics", "--name", "puma", "--to", tmp_path)
    for name, content in dx.codegen.c_files(dx.robots.puma560(), "puma").items():
        assert (tmp_path / name).read_text() == content


def test_a_network_is_exported(capsys, tmp_path):
    name = "uvms-manipulability-feed-forward"
    files = json.loads(ask(capsys, "export", name, "--to", tmp_path, "--json"))["rows"]
    assert [row["file"].rpartition(".")[2] for row in files] == ["h", "c"]
    pytest.importorskip("onnx")
    ask(capsys, "export", name, "--to", tmp_path, "--form", "onnx")
    model = dx.networks.onnx_models.onnx_model(dx.networks.load_shipped(name))
    written = tmp_path / "uvms_manipulability_feed_forward.onnx"
    assert written.read_bytes() == model.SerializeToString(deterministic=True)


@pytest.mark.parametrize("form", ["c", "javascript", "onnx"])
def test_the_name_on_a_card_is_no_path(capsys, tmp_path, form):
    network = dx.networks.load_shipped("uvms-manipulability-feed-forward")
    named = network.card.with_entries(name="../../evil; x'")
    dx.networks.save(network, tmp_path / "net.npz", named)
    ask(capsys, "export", tmp_path / "net.npz", "--form", form, "--to", tmp_path / "a" / "b" / "out")
    assert {path.stem for path in (tmp_path / "a" / "b" / "out").iterdir()} == {"evil_x"}
    assert {path.name for path in tmp_path.iterdir()} == {"net.npz", "a"}
    words = ["export", str(tmp_path / "net.npz"), "--form", form, "--name", "../evil", "--to", str(tmp_path)]
    assert main(words) == 2
    assert "'../evil'" in capsys.readouterr().err
