"""Robots: their papers' points and axes, lengths by name, and robot files with something wrong in them."""

import math
from pathlib import Path

import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st
from torch.testing import assert_close

import dexterity as dx
from dexterity import robots, store

NAMES = (
    "bluerov2", "docking_arm", "fanuc_am120ib", "girona500", "iiwa14", "oberon7", "panda", "puma560",
    "reach_alpha5", "reach_bravo7", "ur5e", "uvms",
)  # fmt: skip
LINKAGES = ("patu655",)
FORMS = ("uvms", "puma560", "iiwa14", "bluerov2")  # lengths, rows, frames with masses, a vehicle with an arm
FILES = {name: store.data_path("robots", f"{name}.toml").read_text(encoding="utf-8") for name in FORMS}


# ---- the robots there are --------------------------------------------------------------------------


def test_each_file_is_a_robot_with_source_and_licence():
    assert robots.names() == NAMES
    assert {path.stem for path in store.data_path("robots").iterdir()} == {*NAMES, *LINKAGES}
    for name in NAMES:
        description = robots.describe(name)
        assert description.name == name
        assert len(description.source) > 20
        assert "MIT" in description.licence
        chain = robots.build(description)
        assert chain.name == name
        assert chain.forward(torch.zeros(chain.joints)).shape == (4, 4)


def test_the_uvms_has_the_papers_twelve_axes():
    uvms = dx.robots.uvms()
    assert uvms.joint_names == ("x", "y", "z", "θx", "θy", "θz", "θm1", "θm2", "θm3", "θm4", "θm5", "θm6")
    assert uvms.kinds == ("prismatic",) * 3 + ("revolute",) * 9
    x, y, z = torch.eye(3, dtype=torch.float64)
    assert_close(uvms.screws[:3, :3], torch.eye(3, dtype=torch.float64), rtol=0, atol=0)
    assert_close(uvms.screws[3:, 3:], torch.stack([x, y, z, z, -x, -x, z, -x, y]), rtol=0, atol=0)


def test_the_uvms_has_the_papers_points_on_its_axes():
    y_MB, l1, l2, l3 = 0.8, 0.1, 0.5, 0.3
    uvms = dx.robots.uvms(y_MB=y_MB, l1=l1, l2=l2, l3=l3)
    q1, q2 = [0, 0, 0], [0, y_MB, l1]
    q3, q4 = [0, y_MB + l2, l1], [0, y_MB + l2 + l3, l1]
    points = torch.tensor([q1] * 3 + [q2] * 2 + [q3] + [q4] * 3, dtype=torch.float64)
    omega = uvms.screws[3:, 3:]
    # Eq. 1: v = -ω × q for the points that the paper gives.
    assert_close(uvms.screws[3:, :3], -torch.linalg.cross(omega, points), rtol=0, atol=1e-15)
    home = torch.eye(4, dtype=torch.float64)
    home[:3, 3] = torch.tensor(q4, dtype=torch.float64)
    assert_close(uvms.home, home, rtol=0, atol=1e-15)


def test_the_uvms_reaches_what_table_2_prints():
    """Table 2: r_max = 1 and r_min = 0.2 from the arm's base to its wrist, y_MB half the vehicle's length."""
    lengths = robots.describe("uvms").lengths
    assert lengths["l2"] + lengths["l3"] == pytest.approx(1.0)
    assert abs(lengths["l2"] - lengths["l3"]) == pytest.approx(0.2)
    _, vehicle_length, _ = robots.describe("uvms").vehicle_size
    assert lengths["y_MB"] == vehicle_length / 2


@pytest.mark.parametrize(("length", "row"), [("l1", 2), ("l2", 1), ("l3", 1), ("y_MB", 1)])
def test_a_length_of_the_uvms_moves_its_tool(length, row):
    longer = robots.describe("uvms").lengths[length] + 0.25
    change = dx.robots.uvms(**{length: longer}).home[:3, 3] - dx.robots.uvms().home[:3, 3]
    expected = torch.zeros(3, dtype=torch.float64)
    expected[row] = 0.25
    assert_close(change, expected, rtol=0, atol=1e-15)


def test_rates_of_the_uvms_are_its_twelve_joints():
    rates = [0.5] * 3 + [0.3] * 3 + [1, 2, 3, 4, 5, 6]
    assert dx.robots.uvms(rates=rates).rates.tolist() == rates
    assert dx.robots.uvms().rates.tolist() == [1] * 12


def test_the_docking_arm_is_an_elbow_arm_with_a_roll_pitch_roll_wrist():
    arm = dx.robots.docking_arm()
    assert arm.kinds == ("revolute",) * 6
    omega = arm.screws[:, 3:]
    x, y, z = torch.eye(3, dtype=torch.float64)
    assert_close(omega, torch.stack([z, -y, -y, x, -y, x]), rtol=0, atol=0)
    assert_close(arm.home[:3, 3], torch.tensor([0.8, 0, 0.1], dtype=torch.float64), rtol=0, atol=1e-15)
    # Positive θ2 and θ3 raise the arm.
    for joint in (1, 2):
        q = torch.zeros(6)
        q[joint] = 0.1
        assert arm.forward(q)[2, 3] > 0.11


def test_the_fitted_docking_arm_is_longer_and_off_its_first_axis():
    arm = dx.robots.docking_arm("fitted")
    assert arm.name == "docking_arm (fitted)"
    assert_close(arm.home[:3, 3], torch.tensor([0.85, -0.05, 0.1], dtype=torch.float64), rtol=0, atol=1e-15)
    assert "fitted" in robots.describe("docking_arm").variants["fitted"]["note"]


def test_the_wrist_axes_of_the_arms_meet():
    for arm in (dx.robots.docking_arm(), dx.robots.docking_arm("fitted"), dx.robots.puma560()):
        q = torch.linspace(-0.9, 1.1, 6)
        wrist = arm.forward(q)[:3, 3]
        q[3:] += 1
        assert_close(arm.forward(q)[:3, 3], wrist, rtol=0, atol=1e-15)


def test_limits_given_in_degrees_are_radians():
    puma = dx.robots.puma560()
    assert_close(puma.upper, torch.deg2rad(torch.tensor([160, 225, 45, 170, 100, 266], dtype=torch.float64)))
    assert_close(
        puma.lower, torch.deg2rad(torch.tensor([-160, -45, -225, -110, -100, -266], dtype=torch.float64))
    )


# ---- what is asked for and is not there ------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "nearest"), [("umvs", "uvms"), ("puma", "puma560"), ("docking-arm", "docking_arm")]
)
def test_an_unknown_robot_is_refused_with_the_nearest_names(name, nearest):
    with pytest.raises(ValueError, match=f"^name is '{name}'; did you mean '{nearest}'"):
        robots.describe(name)


@given(name=st.text().filter(lambda name: name not in NAMES))
def test_any_unknown_robot_is_refused(name):
    with pytest.raises(ValueError, match=r"^name is .*ne of .*panda"):
        robots.describe(name)


def test_a_path_is_no_name_of_a_robot():
    with pytest.raises(ValueError, match=r"^name is '../robots/uvms'"):
        robots.describe("../robots/uvms")


@pytest.mark.usefixtures("annotations_unchecked")
def test_an_unknown_variant_is_refused_with_the_nearest_names():
    with pytest.raises(ValueError, match=r"^variant is 'fited'; did you mean 'fitted'"):
        dx.robots.docking_arm("fited")
    with pytest.raises(ValueError, match=r"^variant is 'fitted'"):
        robots.build(robots.describe("puma560"), variant="fitted")


@pytest.mark.usefixtures("annotations_unchecked")
@pytest.mark.parametrize(
    ("lengths", "error", "message"),
    [
        ({"l4": 1}, ValueError, "lengths holds 'l4'; did you mean 'l"),
        ({"y_mb": 1}, ValueError, "lengths holds 'y_mb'; did you mean 'y_MB'"),
        ({"l2": math.nan}, ValueError, r"lengths\['l2'\] is not finite"),
        ({"l2": math.inf}, ValueError, r"lengths\['l2'\] is not finite"),
        ({"l2": "long"}, TypeError, r"lengths\['l2'\] "),
        ({"l2": True}, TypeError, r"lengths\['l2'\] "),
    ],
)
def test_bad_lengths_are_refused(lengths, error, message):
    with pytest.raises(error, match=f"^{message}"):
        robots.build(robots.describe("uvms"), lengths)


@pytest.mark.parametrize(
    "robot", [dx.robots.uvms, lambda rates: robots.build(robots.describe("puma560"), rates=rates)]
)
@pytest.mark.parametrize(
    ("rates", "message"),
    [
        ([1] * 5, r"rates has shape \(5,\); \((12|6),\) is needed"),
        ([[1] * 12], r"rates has shape \(1, 12\)"),
        (1.0, r"rates has shape \(\)"),
    ],
)
def test_rates_that_do_not_fit_the_robot_are_refused(robot, rates, message):
    with pytest.raises(ValueError, match=f"^{message}"):
        robot(rates=rates)


@settings(max_examples=20)
@given(joint=st.integers(0, 11), rate=st.floats(max_value=0, exclude_max=True, allow_infinity=False))
def test_negative_rates_of_a_robot_are_refused(joint, rate):
    rates = [1.0] * 12
    rates[joint] = rate
    with pytest.raises(ValueError, match=r"^rates must be finite and not negative"):
        dx.robots.uvms(rates=rates)


# ---- robot files -----------------------------------------------------------------------------------

SMALL = """
name = "arm"
source = "nobody"
licence = "MIT"
[lengths]
a = 0.5
[variants.long]
note = "twice as long"
a = 1.0
[vehicle]
size = [1, 2, 3]
[[joints]]
name = "slide"
kind = "prismatic"
axis = [0, 0, 1]
lower = -1
upper = 1
[[joints]]
name = "turn"
axis = [0, 1, 0]
step = { a = [1, 0, 0] }
"""
SMALL_DH = """
name = "arm"
source = "nobody"
licence = "MIT"
[[dh]]
name = "turn"
theta_deg = 90
a = 0.5
[[dh]]
name = "slide"
kind = "prismatic"
d = 0.25
lower = 0
upper = 1
"""


@pytest.fixture
def robot_file(tmp_path: Path):
    def write(content: str | bytes) -> Path:
        path = tmp_path / "strange_arm.toml"
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return path

    return write


def test_ones_own_robot_file_is_read(robot_file):
    description = robots.read_description(robot_file(SMALL))
    assert (description.name, description.source, description.licence) == ("arm", "nobody", "MIT")
    assert description.vehicle_size == (1, 2, 3)
    chain = robots.build(description)
    assert chain.joint_names == ("x", "y", "z", "θx", "θy", "θz", "slide", "turn")
    assert chain.kinds[6:] == ("prismatic", "revolute")
    assert chain.home[:3, 3].tolist() == [0.5, 0, 0]
    assert robots.build(description, variant="long").home[:3, 3].tolist() == [1, 0, 0]
    assert robots.build(description, {"a": 3}).home[:3, 3].tolist() == [3, 0, 0]
    assert chain.upper[6:].tolist() == [1, math.inf]


def test_ones_own_file_of_denavit_hartenberg_rows_is_read(robot_file):
    chain = robots.build(robots.read_description(str(robot_file(SMALL_DH))))
    assert chain.kinds == ("revolute", "prismatic")
    assert_close(chain.home[:3, 3], torch.tensor([0, 0.5, 0.25], dtype=torch.float64), rtol=0, atol=1e-15)
    assert chain.upper.tolist() == [math.inf, 1]


def test_a_file_of_ones_own_needs_rows_alone(robot_file):
    chain = robots.load(robot_file("[[dh]]\na = 0.5\n[[dh]]\na = 0.25\n"))
    assert (chain.name, chain.joint_names) == ("strange_arm", ("joint 1", "joint 2"))
    assert chain.home[0, 3] == 0.75


TABLE = """# my arm, metres
name, kind, theta, d, a, alpha, lower, upper, rate
"the, turn", , pi/2, , 0.5, 90deg, -pi, pi, 2
slide, prismatic, , 0.25, , , 0, 1,
"""


@pytest.fixture
def table_file(tmp_path: Path):
    def write(content: str) -> Path:
        path = tmp_path / "My arm.CSV"
        path.write_text(content, encoding="utf-8")
        return path

    return write


def test_a_denavit_hartenberg_table_as_csv_is_read(table_file):
    chain = robots.load(str(table_file("\ufeff" + TABLE)))
    rows = [{"theta": math.pi / 2, "a": 0.5, "alpha": math.pi / 2}, {"kind": "prismatic", "d": 0.25}]
    expected = dx.Chain.from_dh(rows)
    assert (chain.name, chain.joint_names) == ("My arm", ("the, turn", "slide"))
    assert_close(chain.screws, expected.screws, rtol=0, atol=1e-15)
    assert_close(chain.home, expected.home, rtol=0, atol=1e-15)
    assert (chain.lower.tolist(), chain.upper.tolist()) == ([-math.pi, 0], [math.pi, 1])
    assert chain.rates.tolist() == [2, 1]


def test_a_table_in_craigs_convention_is_read(table_file):
    panda = robots.describe("panda")
    names = ("d", "a", "alpha_deg", "convention")
    lines = [
        ",".join(str(row.get(name, "modified" * (name == names[-1]))) for name in names)
        for row in panda.joints
    ]
    chain = robots.load(table_file("\n".join([",".join(names), *lines])))
    assert_close(chain.with_tool(panda.tool).home, dx.robots.panda().home, rtol=0, atol=1e-15)


def test_a_robot_in_millimetres_is_warned_of(table_file):
    urdf = """<robot name="long"><link name="base"/><link name="tool"/><joint name="j" type="continuous">
    <parent link="base"/><child link="tool"/><origin xyz="300 0 0"/></joint></robot>"""
    for read in (
        lambda: robots.load(table_file("d,a\n333,0\n0,400\n")),
        lambda: dx.Chain.from_dh([{"d": 333}, {"a": 400}]),
        lambda: dx.Chain.from_urdf(urdf),
    ):
        with pytest.warns(UserWarning, match=r"extends over [34]00 m: lengths are in metres, .* millimetres"):
            read()


BAD_TABLES = {
    "empty": ("", "a line of names, such as theta,d,a,alpha, and a line for each joint"),
    "names alone": ("d,a\n", "a line of names"),
    "no names": (
        "0.3,0,0,1.57\n0,0.5,0,0\n",
        "the first line names '0.3'; name, kind, convention, a, .* are known",
    ),
    "unknown column": ("d,aa\n1,2\n", "the first line names 'aa'; .*alpha_deg, .* are known"),
    "a column twice": ("d,d\n1,2\n", "two columns are called 'd'"),
    "a cell too few": ("d,a\n1\n", "joint 1 has 1 cells; 2 are named"),
    "a word": ("d,a\n1,2\n1,two\n", "a of joint 2 holds 'two'; a number such as 0.1, -pi/2 or 90deg"),
    "degrees": ("alpha\n90\n", "alpha of joint 1 is 90.0 rad, more than a turn; alpha_deg takes degrees"),
    "semicolons": ("d;a\n1;2\n", "the first line names 'd;a'"),
    "two conventions": ("d,convention\n1,standard\n1,modified\n", "convention is modified and standard"),
    "unknown convention": ("d,convention\n1,craig\n", "convention is 'craig'"),
    "an open quotation mark": ('d,name\n1,"a\n', "unexpected end of data"),
}


@pytest.mark.parametrize(("content", "message"), BAD_TABLES.values(), ids=BAD_TABLES)
def test_a_table_that_is_no_robot_is_refused_by_file_and_cell(table_file, content, message):
    with pytest.raises(ValueError, match=rf"^My arm.CSV is not a robot file: .*{message}"):
        robots.load(table_file(content))


def test_a_byte_order_mark_is_passed_over(robot_file):
    assert robots.read_description(robot_file(b"\xef\xbb\xbf" + SMALL.encode())).name == "arm"


def test_rows_of_craigs_convention_with_a_tool_and_rates_are_read(robot_file):
    panda = store.data_path("robots", "panda.toml").read_text(encoding="utf-8")
    chain = robots.load(robot_file(panda.replace('"panda"', '"mine"')))
    assert chain.name == "mine"
    assert_close(chain.home, dx.robots.panda().home, rtol=0, atol=0)
    assert chain.rates.tolist() == [2.175] * 4 + [2.61] * 3


def test_a_base_moves_robots_of_each_form(robot_file):
    for text in (SMALL, SMALL_DH):
        plain = robots.load(robot_file(text))
        moved = robots.load(robot_file("base = { xyz = [1, 2, 3], rpy_deg = [90, 0, 0] }\n" + text))
        arm = [name for name in plain.joint_names if name in ("turn", "slide")]
        others = [name for name in plain.joint_names if name not in arm]
        T = dx.spatial.from_rpy([math.pi / 2, 0, 0], [1, 2, 3])
        expected = plain.lock(others) if others else plain
        found = moved.lock(others) if others else moved
        assert_close(found.screws, expected.with_base(T).screws, rtol=0, atol=1e-15)
        assert_close(found.home, expected.with_base(T).home, rtol=0, atol=1e-15)


def test_frames_are_those_of_a_urdf(robot_file):
    """The case of a reach of three kinds of origins: in radians, in degrees, and none."""
    text = """
name = "frames"
source = "nobody"
licence = "MIT"
base = { xyz = [0, 0, 1] }
tool = { xyz = [0, 0, 0.1], rpy_deg = [0, 0, 90] }
[[frames]]
name = "a"
xyz = [0.1, 0.2, 0.3]
rpy = [0.1, 0.2, 0.3]
axis = [0, 0.6, 0.8]
[[frames]]
name = "b"
kind = "prismatic"
rpy_deg = [0, 90, 0]
upper = 1
"""
    urdf = """<robot name="frames"><link name="world"/><link name="base"/><link name="l1"/>
<link name="l2"/><link name="tool"/>
<joint name="f" type="fixed"><parent link="world"/><child link="base"/><origin xyz="0 0 1"/></joint>
<joint name="a" type="continuous"><parent link="base"/><child link="l1"/>
<origin xyz="0.1 0.2 0.3" rpy="0.1 0.2 0.3"/><axis xyz="0 3 4"/></joint>
<joint name="b" type="prismatic"><parent link="l1"/><child link="l2"/><origin rpy="0 1.5707963267948966 0"/>
<axis xyz="0 0 1"/><limit lower="0" upper="1"/></joint>
<joint name="t" type="fixed"><parent link="l2"/><child link="tool"/>
<origin xyz="0 0 0.1" rpy="0 0 1.5707963267948966"/></joint></robot>"""
    file, chain = robots.load(robot_file(text)), robots.load(urdf)
    q = [0.7, 0.3]
    assert_close(file.forward(q), chain.forward(q), rtol=0, atol=1e-15)
    assert_close(file.spatial_jacobian(q), chain.spatial_jacobian(q), rtol=0, atol=1e-15)


def replaced(old: str, new: str, content: str = SMALL) -> str:
    assert content.count(old) == 1
    return content.replace(old, new)


BAD_VARIANT = replaced('[variants.long]\nnote = "twice as long"\na = 1.0', "[variants]\nlong = 2")
BAD_VEHICLE = replaced("[vehicle]\nsize = [1, 2, 3]", "").replace("[lengths]", "vehicle = 1\n[lengths]")
BAD_ANGLE = replaced("theta_deg = 90", 'theta_deg = "90"', SMALL_DH)
BAD_FILES = {
    "empty source": (replaced('"nobody"', '" "'), "source of the file is ' '"),
    "name is a number": (replaced('"arm"', "3"), "name of the file is 3"),
    "unknown entry": (replaced('licence = "MIT"', 'license = "MIT"'), r"the file holds \['license'\]"),
    "no joints": (SMALL.split("[[joints]]")[0], "the file has no joints"),
    "empty joints": ('joints = []\n' + SMALL.split("[[joints]]")[0], r"joints is \[\]"),
    "joints are a number": ("joints = 3\n" + SMALL.split("[[joints]]")[0], "joints is 3"),
    "joints are numbers": ("joints = [3]\n" + SMALL.split("[[joints]]")[0], "joint 1 is 3"),
    "joints of both kinds": (SMALL + '[[dh]]\nname = "roll"\n', "the file holds .*'joints'"),
    "one name for two joints": (replaced('"turn"', '"slide"'), "joint_names holds"),
    "unknown kind": (replaced('"prismatic"', '"helical"'), "kind of joint 1 is 'helical'"),
    "kind is a number": (replaced('"prismatic"', "1"), "kind of joint 1 is 1"),
    "unknown entry of a joint": (replaced("lower = -1", "low = -1"), r"joint 1 holds \['low'\]"),
    "no axis": (replaced("axis = [0, 1, 0]", ""), "joint 2 has no axis"),
    "axis of two": (replaced("[0, 1, 0]", "[0, 1]"), r"axis of joint 2 is \[0, 1\]"),
    "axis is a text": (replaced("[0, 1, 0]", '"010"'), "axis of joint 2 is '010'"),
    "axis of texts": (replaced("[0, 1, 0]", '[0, "1", 0]'), "axis of joint 2 is '1'"),
    "axis holds NaN": (replaced("[0, 1, 0]", "[0, nan, 0]"), "axis of joint 2 is nan"),
    "long axis of rotation": (replaced("[0, 1, 0]", "[0, 2, 0]"), r"axis of joint 2 is .*, of length 2"),
    "long axis of translation": (replaced("[0, 0, 1]", "[0, 1, 1]"), "axis of joint 1 is .*, of length 1.41"),
    "axis of zeros": (replaced("[0, 1, 0]", "[0, 0, 0]"), "axis of joint 2 is .*, of length 0; 1 is needed"),
    "lower limit is a text": (replaced("lower = -1", 'lower = "-1"'), "lower of joint 1 is '-1'"),
    "lower limit above the upper": (replaced("lower = -1", "lower = 2"), "lower exceeds upper at joint 1"),
    "step by an unknown length": (replaced("{ a =", "{ b ="), r"step of joint 2 holds \['b'\]"),
    "step is a number": (replaced("{ a = [1, 0, 0] }", "0.5"), "step of joint 2 is 0.5"),
    "step by a number": (replaced("{ a = [1, 0, 0] }", "{ a = 1 }"), "step a of joint 2 is 1"),
    "length is a text": (replaced("a = 0.5", 'a = "0.5"'), "a of lengths is '0.5'"),
    "length is a truth value": (replaced("a = 0.5", "a = true"), "a of lengths is True"),
    "length is infinite": (replaced("a = 0.5", "a = inf"), "a of lengths is inf"),
    "length is a date": (replaced("a = 0.5", "a = 1979-05-27"), "a of lengths is datetime"),
    "lengths are a number": ("lengths = 1\n" + replaced("[lengths]\na = 0.5", ""), "lengths is 1"),
    "variant without note": (replaced('note = "twice as long"', ""), "variant long has no note"),
    "variant of an unknown length": (replaced("a = 1.0", "b = 1.0"), r"variant long holds \['b'\]"),
    "variant of a text": (replaced("a = 1.0", 'a = "1.0"'), "a of variant long is '1.0'"),
    "variant is a number": (BAD_VARIANT, "variant long is 2"),
    "vehicle without size": (replaced("size = [1, 2, 3]", ""), "vehicle has no size"),
    "vehicle of two sides": (replaced("size = [1, 2, 3]", "size = [1, 2]"), r"size of vehicle is \[1, 2\]"),
    "unknown entry of the vehicle": (replaced("size =", "mass = 3\nsize ="), r"vehicle holds \['mass'\]"),
    "vehicle is a number": (BAD_VEHICLE, "vehicle is 1"),
    "lengths beside rows": (SMALL_DH + "[lengths]\na = 1\n", r"the file holds \['lengths'\]"),
    "row entry is a text": (replaced("a = 0.5", 'a = "0.5"', SMALL_DH), "a of joint 1 is '0.5'"),
    "row angle is a text": (BAD_ANGLE, "theta_deg of joint 1 is '90'"),
    "unknown row entry": (replaced("theta_deg = 90", "angle = 90", SMALL_DH), r"joint 1 holds \['angle'\]"),
    "huge integer": (replaced("d = 0.25", f"d = {10**400}", SMALL_DH), ""),
    "not TOML": ("name: arm\n", ""),
    "empty": ("", "the file has no"),
    "binary": (bytes(range(256)), ""),
    "UTF-16": (SMALL.encode("utf-16"), ""),
}  # fmt: skip
BODY = "{ mass = 1, centre = [0, 0, 0], inertia = [0, 0, 0, 0, 0, 0] }"
BAD_FILES |= {
    "two units": (
        replaced("theta_deg = 90", "theta_deg = 90\ntheta = 1.57", SMALL_DH),
        "holds theta and theta_deg",
    ),
    "two units of a limit": (
        replaced("lower = 0", "lower = 0\nlower_deg = 0", SMALL_DH),
        "holds lower and lower_deg",
    ),
    "degrees of a slide": (
        replaced("lower = 0", "lower_deg = -90", SMALL_DH),
        "joint 2 is prismatic and holds lower_deg",
    ),
    "rate in degrees of a slide": (
        replaced("lower = 0", "rate_deg = 9", SMALL_DH),
        "prismatic and holds rate_deg; rate",
    ),
    "negative rate": (replaced("lower = 0", "rate = -1", SMALL_DH), "rates must be finite and not negative"),
    "degrees taken for radians": (
        replaced("theta_deg = 90", "alpha = 90", SMALL_DH),
        "alpha of joint 1 is 90 rad, .*alpha_deg",
    ),
    "nearest key": (replaced("theta_deg = 90", "tetha_deg = 90", SMALL_DH), "did you mean 'theta_deg'"),
    "unknown convention": ('convention = "craig"\n' + SMALL_DH, "convention is 'craig'"),
    "tool that is no table": (
        replaced('licence = "MIT"', 'licence = "MIT"\ntool = [0, 0, 1]', SMALL_DH),
        "tool is ",
    ),
    "tool in two units": (
        "tool = { rpy = [0, 0, 1], rpy_deg = [0, 0, 1] }\n" + SMALL_DH,
        "tool holds rpy and rpy_deg",
    ),
    "tool of two numbers": ("tool = { xyz = [0, 1] }\n" + SMALL_DH, r"xyz of tool is \[0, 1\]"),
    "negative vehicle": (replaced("[1, 2, 3]", "[-1, 0, 1]"), "size of vehicle is .*three positive lengths"),
    "vehicle with axes of its tool": (replaced("size =", 'axes = "tool"\nsize ='), "axes is 'tool'"),
    "vehicle with an arm and joints": (
        replaced("size =", 'arm = "panda"\nsize ='),
        "vehicle has an arm and the file has",
    ),
    "vehicle of an unknown joint": (
        replaced("size = [1, 2, 3]", 'size = [1, 2, 3]\njoints = [{ name = "w" }]'),
        "joints is 'w'",
    ),
    "vehicle that slides by degrees": (
        replaced("size = [1, 2, 3]", 'size = [1, 2, 3]\njoints = [{ name = "x", lower_deg = 1 }]'),
        "prismatic and holds lower_deg",
    ),
    "one inertial": (
        replaced('name = "slide"', f'name = "slide"\ninertial = {BODY}'),
        "joint 2 has no inertial",
    ),
    "inertial without a mass": (
        SMALL_DH + "inertial = { centre = [0, 0, 0] }\n",
        "joint 2 has an inertial; all joints need one",
    ),
    "5000 digits": (replaced("d = 0.25", "d = " + "1" * 5000, SMALL_DH), ""),
    "nested a lot": (SMALL_DH + "a = " + "[" * 5000 + "]" * 5000 + "\n", ""),
    "key of many parts": ("x." * 20000 + "y = 1\n" + SMALL_DH, "line 1 has more than"),
    "name that is not printable": (replaced('"turn"', '"tu\\u0007rn"'), r"joint_names\[1\] is"),
}


@pytest.mark.parametrize(("content", "message"), BAD_FILES.values(), ids=BAD_FILES)
def test_a_malformed_robot_file_is_refused_with_its_name_and_the_entry(robot_file, content, message):
    with pytest.raises(ValueError, match=rf"(?s)^strange_arm.toml is not a robot file: .*{message}"):
        robots.read_description(robot_file(content))


VALUES = [
    "",
    "true",
    '"text"',
    "nan",
    "-inf",
    "[]",
    "{}",
    "[1, 0]",
    "[[1]]",
    "1979-05-27",
    "-1",
    "0",
    "1e200",
    "{ l9 = [1, 0, 0] }",
]
VALUE_LINES = [
    (name, i)
    for name, text in FILES.items()
    for i, line in enumerate(text.splitlines())
    if " = " in line and not line.startswith("#")
]


@pytest.fixture(scope="module")
def scratch(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("robots") / "strange_arm.toml"


def joints_of_robot_or_refused(path: Path) -> int | None:
    """Return the number of joints, or None if the file is refused in words that name it."""
    try:
        return robots.build(robots.read_description(path)).joints
    except ValueError as error:
        if not str(error).startswith(f"{path.name} is not a robot file: "):
            raise
        return None


@settings(max_examples=30)
@given(place=st.sampled_from(VALUE_LINES), value=st.sampled_from(VALUES))
def test_a_robot_file_with_any_value_replaced_is_a_robot_or_is_refused(scratch, place, value):
    name, line = place
    lines = FILES[name].splitlines()
    lines[line] = lines[line].split(" = ")[0] + f" = {value}"
    scratch.write_text("\n".join(lines), encoding="utf-8")
    assert joints_of_robot_or_refused(scratch) in (None, dx.robots.load(name).joints)


@given(name=st.sampled_from(FORMS), places=st.sets(st.floats(0, 1, exclude_max=True), min_size=1, max_size=3))
def test_a_robot_file_with_lines_left_out_is_a_robot_or_is_refused(scratch, name, places):
    lines = FILES[name].splitlines()
    left_out = {int(place * len(lines)) for place in places}
    kept = [line for i, line in enumerate(lines) if i not in left_out]
    scratch.write_text("\n".join(kept), encoding="utf-8")
    joints = joints_of_robot_or_refused(scratch)
    assert joints is None or 0 < joints <= 12


@given(content=st.binary(max_size=200))
def test_any_bytes_are_a_robot_or_are_refused(scratch, content):
    scratch.write_bytes(content)
    with pytest.raises(ValueError, match=r"(?s)^strange_arm.toml is not a robot file: ."):
        robots.read_description(scratch)


def test_a_robot_file_that_is_not_there_is_said_so(tmp_path):
    with pytest.raises(FileNotFoundError, match=r"nowhere\.toml"):
        robots.read_description(tmp_path / "nowhere.toml")
