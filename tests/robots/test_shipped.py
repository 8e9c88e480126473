"""The robots of the package against URDFs of others, another library's models, and printed poses."""

import importlib
import importlib.metadata
import math
import shutil
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
import roboticstoolbox
import torch
from numpy.testing import assert_allclose
from torch.testing import assert_close

import dexterity as dx
from dexterity import robots, spatial, store

NEW = ("panda", "ur5e", "iiwa14", "oberon7", "reach_alpha5", "reach_bravo7", "bluerov2", "girona500")
HEAVY = ("panda", "ur5e", "iiwa14")


def installed(distribution: str, file: str) -> Path:
    return Path(importlib.metadata.distribution(distribution).locate_file(file))


PANDA_URDF = installed(
    "example-robot-data",
    "cmeel.prefix/share/example-robot-data/robots/panda_description/urdf/panda.urdf",
)
IIWA_URDF = installed("rtb-data", "rtbdata/xacro/kuka_description/kuka_lbr_iiwa/urdf/lbr_iiwa_14_r820.urdf")


@pytest.mark.parametrize("name", NEW)
def test_a_function_and_a_name_give_the_same_robot(name):
    by_function, by_name = getattr(dx.robots, name)(), dx.robots.load(name)
    assert by_function.name == by_name.name == name
    assert_close(by_function.screws, by_name.screws, rtol=0, atol=0)
    assert by_function.adjusted == 0


# ---- Panda -------------------------------------------------------------------------------------------


def test_the_panda_is_the_urdf_of_its_maker(rng):
    ours, theirs = dx.robots.panda(), dx.Chain.from_urdf(PANDA_URDF, tip="panda_link8")
    for q in rng.uniform(ours.lower, ours.upper, (5, 7)):
        assert_close(ours.forward(q), theirs.forward(q), rtol=0, atol=1e-15)
        assert_close(ours.body_jacobian(q), theirs.body_jacobian(q), rtol=0, atol=1e-15)
    assert ours.joint_names == theirs.joint_names
    assert_close(ours.rates, theirs.rates, rtol=0, atol=0)
    # The seventh link carries the hand there.
    for part, other in zip(ours.inertias, theirs.inertias, strict=True):
        assert_close(part[:6], other[:6], rtol=0, atol=1e-15)


def test_the_panda_stands_where_mujoco_menagerie_85_prints_it():
    flange = dx.robots.panda().home
    expected = torch.diag(torch.tensor([1.0, -1, -1, 1], dtype=torch.float64))
    expected[:3, 3] = torch.tensor([0.088, 0, 0.926], dtype=torch.float64)
    assert_close(flange, expected, rtol=0, atol=1e-15)
    ready = dx.robots.panda().forward([0, -math.pi / 4, 0, -3 * math.pi / 4, 0, math.pi / 2, math.pi / 4])
    assert_allclose(ready[:3, 3], [0.3069, 0, 0.5903], rtol=0, atol=5e-5)


def test_the_panda_with_its_hand_has_the_indices_that_robotics_toolbox_python_tests():
    """tests/test_ETS.py: test_manip, test_cond and test_minsingular; tests/test_Robot.py."""
    hand = spatial.from_rpy([0, 0, -math.pi / 4], [0, 0, 0.1034])
    panda = dx.robots.panda().with_tool(hand)
    sigma = torch.linalg.svdvals(panda.geometric_jacobian([0, -0.3, 0, -2.2, 0, 2, math.pi / 4]))
    assert_allclose(sigma.prod(), 0.0837, rtol=0, atol=1e-4)
    assert_allclose(sigma[-1] / sigma[0], 0.11222, rtol=0, atol=5e-6)
    assert_allclose(sigma[-1], 0.209013, rtol=0, atol=5e-7)
    J = panda.geometric_jacobian([1.4, 0.2, 1.8, 0.7, 0.1, 3.1, 2.9])
    assert_allclose(torch.linalg.svdvals(J).prod(), 0.006559178, rtol=0, atol=5e-10)


# ---- UR5e --------------------------------------------------------------------------------------------


def test_the_ur5e_stands_where_its_maker_and_ssik_put_it():
    ours = dx.robots.ur5e()
    assert_allclose(ours.home[:3, 3], [-0.8172, -0.2329, 0.0628], rtol=0, atol=1e-15)
    # In the URDF of the maker the base is turned by half a turn.
    ssik_home = importlib.import_module("ssik.prebuilt.universal_robots.ur5e_ik").T_HOME
    turned = ours.with_base(spatial.from_rpy([0, 0, math.pi]))
    assert_allclose(turned.home, ssik_home, rtol=0, atol=1e-9)


# ---- iiwa --------------------------------------------------------------------------------------------


def test_the_iiwa_is_the_urdf_of_kuka_experimental_to_its_half_millimetre(rng):
    """Their second joint lies 0.436 mm off the first axis, and their limits are rounded."""
    ours, theirs = dx.robots.iiwa14(), dx.Chain.from_urdf(IIWA_URDF, tip="tool0")
    for q in rng.uniform(ours.lower, ours.upper, (5, 7)):
        assert_close(ours.forward(q), theirs.forward(q), rtol=0, atol=1e-3)
    for limit in ("lower", "upper", "rates"):
        assert_allclose(getattr(ours, limit), getattr(theirs, limit), rtol=0, atol=4e-4)
    ssik_home = importlib.import_module("ssik.prebuilt.kuka.iiwa14_ik").T_HOME
    assert_allclose(ours.home, ssik_home, rtol=0, atol=1e-12)


def test_the_iiwa_has_the_brochures_lengths(rng):
    """d = 0.36, 0.42, 0.4, 0.126 m between axes that meet, as Denavit–Hartenberg rows."""
    right = math.pi / 2
    rows = [
        {"d": 0.36, "alpha": -right}, {"alpha": right}, {"d": 0.42, "alpha": right}, {"alpha": -right},
        {"d": 0.4, "alpha": -right}, {"alpha": right}, {"d": 0.126},
    ]  # fmt: skip
    theirs = dx.Chain.from_dh(rows)
    for q in rng.uniform(-2, 2, (5, 7)):
        assert_close(dx.robots.iiwa14().forward(q), theirs.forward(q), rtol=0, atol=1e-15)


# ---- underwater arms ---------------------------------------------------------------------------------


def test_the_oberon_7_is_its_urdf(rng):
    """Joint origins of uuv_manipulators, read by the reader of URDFs."""
    origins = [
        ("0 0 0", "0 0 0"), ("0.06955 0.00015 0.01536", "1.5707963267948966 0 0"),
        ("0.55616 -0.01229 0", "0 0 0"), ("0.1349014 -0.1936267 0", "1.5707963267948966 0 0"),
        ("0 0 0.3159576", "-1.5707963267948966 -1.5707963267948966 0"), ("0.19304 0 0", "0 0 0"),
    ]  # fmt: skip
    joints = "".join(
        f'<joint name="j{i}" type="continuous"><parent link="l{i}"/><child link="l{i + 1}"/>'
        f'<origin xyz="{xyz}" rpy="{rpy}"/><axis xyz="{"0 0 1" if i < 5 else "1 0 0"}"/></joint>'
        for i, (xyz, rpy) in enumerate(origins)
    )
    links = "".join(f'<link name="l{i}"/>' for i in range(7))
    theirs = dx.Chain.from_urdf(f'<robot name="oberon7">{links}{joints}</robot>')
    ours = dx.robots.oberon7()
    for q in rng.uniform(-1, 1, (5, 6)):
        assert_close(ours.forward(q), theirs.forward(q), rtol=0, atol=1e-15)
    assert_allclose(ours.upper, [1.047, 1.571, 1.047, 2.356, 1.571, math.inf], rtol=0, atol=5e-4)


PRINTED = {  # theta [°], d, a [mm], alpha [°]
    "ur5e": [
        (0, 162.5, 0, 90), (0, 0, -425, 0), (0, 0, -392.2, 0),
        (0, 133.3, 0, 90), (0, 99.7, 0, -90), (0, 99.6, 0, 0),
    ],
    "reach_alpha5": [
        (180, 46.2, 20, 90), (-74.60827, 0, 150.705, 180), (-74.60827, 0, 20, -90), (90, -180, 0, 90),
    ],
    "reach_bravo7": [
        (180, 107.4, 46, 90), (-90 + 1.014843, 0, 293.6, 0), (-90 - 1.014843, 0, 40.8, -90),
        (180, -160, 40.8, -90), (0, 0, 40.8, -90), (0, -223.5, 0, 90),
    ],
}  # fmt: skip


@pytest.mark.parametrize("name", PRINTED)
def test_arms_are_their_makers_denavit_hartenberg_rows_in_roboticstoolbox(rng, name):
    links = [
        roboticstoolbox.RevoluteDH(
            d=d / 1000, a=a / 1000, alpha=math.radians(alpha), offset=math.radians(theta)
        )
        for theta, d, a, alpha in PRINTED[name]
    ]
    theirs, ours = roboticstoolbox.DHRobot(links), dx.robots.load(name)
    for q in rng.uniform(0, 3, (5, ours.joints)):
        assert_allclose(ours.forward(q), theirs.fkine(q).A, rtol=0, atol=1e-7)


# ---- vehicles ----------------------------------------------------------------------------------------


def test_the_bluerov_carries_its_arm_below_its_bow():
    rov = dx.robots.bluerov2()
    assert rov.joint_names[:6] == ("roll", "pitch", "yaw", "x", "y", "z")
    assert rov.rates[:6].tolist() == [0, 0, 1, 1.5, 1, 1]
    q = torch.cat([torch.zeros(6), torch.tensor([1.0, 2.0, 1.5, 3.0])])
    mount = spatial.from_rpy([math.pi, 0, 0], [0.203, 0, -0.1317])
    assert_close(rov.forward(q), mount @ dx.robots.reach_alpha5().forward(q[6:]), rtol=0, atol=1e-15)
    # Passive roll and pitch: the motors move the tool by the other eight joints alone.
    assert int((rov.rates > 0).sum()) == 8


def test_a_vehicle_carries_another_arm():
    panda = dx.robots.panda()
    rov = dx.robots.girona500(panda)
    assert rov.joint_names == ("yaw", "x", "y", "z", *panda.joint_names)
    assert dx.robots.girona500().joints == 10
    with pytest.raises(ValueError, match=r"^arm is given, and panda is no vehicle"):
        dx.robots.build(dx.robots.describe("panda"), arm=panda)


# ---- masses ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", HEAVY)
def test_masses_are_those_of_bodies(name):
    """Positive tensors whose principal values fulfil the triangle inequality, and a positive mass matrix."""
    chain = dx.robots.load(name)
    principal = torch.linalg.eigvalsh(chain.inertias.tensors)
    assert (principal[:, 0] > 0).all()
    assert (principal[:, 0] + principal[:, 1] > principal[:, 2]).all()
    q = torch.rand(100, chain.joints, generator=torch.Generator().manual_seed(0), dtype=torch.float64)
    assert (torch.linalg.eigvalsh(chain.mass_matrix(q)) > 0).all()


def test_masses_are_those_of_the_data_sheets():
    assert_allclose(dx.robots.ur5e().inertias.masses.sum(), 17.7, rtol=0, atol=1e-9)
    # 29.9 kg with the foot of 7.05 kg, in the brochure.
    assert_allclose(dx.robots.iiwa14().inertias.masses.sum() + 7.05, 29.9, rtol=0, atol=0.05)
    # At home the links of the iiwa lie one above the other.
    heights = dx.robots.iiwa14().inertias.centres[:, 2].tolist()
    assert all(low < high for low, high in pairwise(heights))


# ---- loading -----------------------------------------------------------------------------------------


def test_a_robot_is_loaded_by_name_from_a_urdf_and_from_a_file(tmp_path):
    assert dx.robots.load("ur5e").name == "ur5e"
    assert dx.robots.load(PANDA_URDF, tip="panda_link8").joints == 7
    assert dx.robots.load(str(PANDA_URDF), base="panda_link3", tip="panda_link8").joints == 4
    assert dx.robots.load(PANDA_URDF.read_text(), tip="panda_link8").joints == 7
    copy = tmp_path / "my.arm.toml"
    copy.write_text(dx.store.data_path("robots", "ur5e.toml").read_text(encoding="utf-8"), encoding="utf-8")
    assert dx.robots.load(copy).joints == 6


@pytest.mark.usefixtures("annotations_unchecked")
@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        (("pandas",), ValueError, "name_or_path is 'pandas'; did you mean 'panda'"),
        ((3,), TypeError, "name_or_path is 3"),
        ((None,), TypeError, "name_or_path is None"),
        (("arm.stl",), ValueError, r"name_or_path is 'arm.stl'; a file that ends in .urdf, .toml or .csv"),
        ((Path("panda"),), ValueError, "name_or_path is 'panda'; a file that ends in"),
        (("nowhere.urdf",), FileNotFoundError, "there is no URDF file nowhere.urdf"),
        (("nowhere.toml",), FileNotFoundError, ".*nowhere.toml"),
        (
            ("arm.urdf.xacro",),
            ValueError,
            r"arm.urdf.xacro is a xacro file: .*xacro arm.urdf.xacro > arm.urdf",
        ),
        (("",), ValueError, "name_or_path is ''"),
        (("a\0b",), ValueError, "name_or_path is "),
        ((" ",), ValueError, "name_or_path is ' '"),
        (("a" * 5000,), ValueError, "name_or_path is 'aaa"),
    ],
)
def test_what_is_no_robot_is_refused(arguments, error, message):
    with pytest.raises(error, match=rf"^{message}"):
        dx.robots.load(*arguments)


@pytest.mark.usefixtures("annotations_unchecked")
@pytest.mark.parametrize("variant", [{}, [], 3, np.ones(2)])
def test_a_variant_that_is_no_name_is_refused(variant):
    with pytest.raises(TypeError, match=r"^variant is "):
        dx.robots.build(dx.robots.describe("docking_arm"), variant=variant)


@pytest.mark.usefixtures("annotations_unchecked")
@pytest.mark.parametrize(
    ("call", "argument"),
    [
        (lambda: dx.robots.describe(3), "name"),
        (lambda: dx.robots.read_description(3), "path"),
        (lambda: dx.robots.build("panda"), "description"),
        (lambda: dx.robots.build(dx.robots.describe("uvms"), [1]), "lengths"),
        (lambda: dx.robots.build(dx.robots.describe("bluerov2"), arm="panda"), "arm"),
        (lambda: dx.robots.build(dx.robots.describe("panda"), rates="1234567"), "rates"),
    ],
)
def test_a_wrong_type_is_refused_by_the_name_of_the_argument(call, argument):
    with pytest.raises(TypeError, match=rf"^{argument} "):
        call()


def test_links_are_chosen_in_urdfs_alone():
    with pytest.raises(ValueError, match=r"^base and tip are links of a URDF; 'panda' is none"):
        dx.robots.load("panda", tip="panda_link8")


def test_a_robot_is_built_once_until_its_file_changes(tmp_path, monkeypatch):
    shutil.copytree(store.data_path("robots"), tmp_path / "robots")
    monkeypatch.setattr(store, "data_path", lambda *parts: tmp_path.joinpath(*parts))
    carried, panda = robots.load("bluerov2"), robots.panda()
    assert robots.load("bluerov2") is robots.bluerov2() is carried
    file = tmp_path / "robots" / "reach_alpha5.toml"
    text = file.read_text(encoding="utf-8")
    file.write_text(text.replace("0.0462", "0.0562"), encoding="utf-8")
    assert not torch.equal(robots.load("bluerov2").home, carried.home)
    assert robots.load("panda") is panda
    file.write_text(text, encoding="utf-8")
    assert torch.equal(robots.load("bluerov2").home, carried.home)
