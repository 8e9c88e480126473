"""URDFs of one's own: the public cases, what is refused and in which words, mutated documents."""

import math
import re
import warnings

import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from torch.testing import assert_close

import dexterity as dx
from dexterity import urdf

MIXED = """<robot name="mixed">
  <link name="base"/><link name="l1"/><link name="l2"/><link name="l3"/><link name="l4"/><link name="tip"/>
  <link name="plinth"/>
  <joint name="c" type="prismatic"><parent link="l2"/><child link="l3"/><origin xyz="0 0.1 0" rpy="0 0.5 0"/>
    <axis xyz="0 0 1"/><limit lower="0" upper="0.2" effort="1" velocity="0.5"/></joint>
  <joint name="f1" type="fixed"><parent link="base"/><child link="plinth"/>
    <origin xyz="0.1 0 0.4" rpy="0 0 1.5707963267948966"/></joint>
  <joint name="a" type="revolute"><parent link="plinth"/><child link="l1"/>
    <origin xyz="0 0 0.2" rpy="0.3 0 0"/><axis xyz="0 0.6 0.8"/>
    <limit lower="-1" upper="1" effort="1" velocity="2"/></joint>
  <joint name="b" type="continuous"><parent link="l1"/><child link="l2"/><origin xyz="0.3 0 0"/></joint>
  <joint name="d" type="prismatic"><parent link="l3"/><child link="l4"/><origin xyz="0 0 0.1"/>
    <axis xyz="1 0 0"/><mimic joint="c" multiplier="-2" offset="0.05"/>
    <limit lower="-1" upper="1" effort="1" velocity="0.5"/></joint>
  <joint name="f2" type="fixed"><parent link="l4"/><child link="tip"/>
    <origin xyz="0 0 0.05" rpy="0 0 0.7"/></joint>
</robot>
"""
MIMIC = '<mimic joint="c" multiplier="-2" offset="0.05"/>'
FREE = MIXED.replace(MIMIC, "")
A = '<joint name="a" type="revolute"><parent link="plinth"/>'
LIMIT = 'lower="-1" upper="1" effort="1" velocity="2"'
EXTRA = '<joint name="e" type="fixed"><parent link="{parent}"/><child link="{child}"/></joint></robot>'


def replaced(old: str, new: str, text: str = FREE) -> str:
    assert text.count(old) == 1
    return text.replace(old, new)


# ---- the public case (pytorch_kinematics PR #4, pyroki PR #10, pinocchio#2753, ikpy#104, #134, ----------
# ---- giskardpy#186, differentiable-robot-model#37) ------------------------------------------------------


def test_a_mimic_joint_on_the_way_is_refused_by_name():
    with pytest.raises(ValueError, match=r"^the URDF text: joint 'd' mimics joint 'c'"):
        dx.Chain.from_urdf(MIXED, base="base", tip="tip")


def test_the_mixed_robot_is_read_as_the_specification_says():
    chain = dx.Chain.from_urdf(MIXED, tip="l3")
    assert chain.joint_names == ("a", "b", "c")
    assert chain.kinds == ("revolute", "revolute", "prismatic")
    assert chain.lower.tolist() == [-1, -math.inf, 0]
    assert chain.upper.tolist() == [1, math.inf, 0.2]
    assert chain.rates.tolist() == [2, 1, 0.5]
    printed = [
        [-0.761150, -0.606457, -0.229913, -0.107654],
        [0.430344, -0.737456, 0.520541, 0.267422],
        [-0.485237, 0.297268, 0.822300, 0.851589],
        [0, 0, 0, 1],
    ]
    a, b, c = 0.3, -0.4, 0.1
    whole = dx.Chain.from_urdf(FREE)
    assert_allclose(whole.forward([a, b, c, -2 * c + 0.05]), printed, rtol=0, atol=5e-7)
    # What follows joint c is a constant where joint d is held.
    behind = dx.spatial.translation(-2 * c + 0.05, 0, 0.1) @ dx.spatial.from_rpy([0, 0, 0.7], [0, 0, 0.05])
    assert_allclose(chain.with_tool(behind).forward([a, b, c]), printed, rtol=0, atol=5e-7)


def test_joints_beside_the_way_do_no_harm():
    beside = """<link name="x1"/><link name="x2"/><link name="x2"/><link name="x3"/>
    <joint name="w" type="floating"><parent link="l1"/><child link="x1"/></joint>
    <joint name="w" type="planar"><parent link="l1"/><child link="x2"/></joint>
    <joint name="loop" type="revolute"><parent link="x1"/><child link="x2"/></joint>
    <joint name="v" type="screw"><parent link="l2"/><child link="x3"/></joint></robot>"""
    chain = dx.Chain.from_urdf(replaced("</robot>", beside), tip="tip")
    assert_close(chain.home, dx.Chain.from_urdf(FREE).home, rtol=0, atol=0)


@pytest.mark.parametrize("length", [1e-200, 1e-6, 1, 5, 1e200])
def test_axes_have_any_length(length):
    chain = dx.Chain.from_urdf(replaced('xyz="0 0.6 0.8"', f'xyz="0 {3 * length} {4 * length}"'))
    assert_close(chain.screws, dx.Chain.from_urdf(FREE).screws, rtol=0, atol=1e-15)


def test_what_is_left_out_has_the_values_of_the_specification():
    text = """<robot name="r"><link name="a"/><link name="b"/>
    <joint name="j" type="prismatic"><parent link="a"/><child link="b"/><limit upper="2"/></joint></robot>"""
    chain = dx.Chain.from_urdf(text)
    assert chain.screws.tolist() == [[1, 0, 0, 0, 0, 0]]
    assert (chain.lower.tolist(), chain.upper.tolist(), chain.rates.tolist()) == ([0], [2], [1])
    assert_close(chain.home, torch.eye(4, dtype=torch.float64), rtol=0, atol=0)
    assert chain.inertias is None
    assert chain.name == "r"
    assert dx.Chain.from_urdf(text, name="slider").name == "slider"


def test_a_joint_with_velocity_zero_is_locked_with_a_warning():
    with pytest.warns(UserWarning, match="joint 'a' has velocity 0, which locks it"):
        chain = dx.Chain.from_urdf(replaced('velocity="2"', 'velocity="0"'))
    assert chain.rates[0] == 0


def test_limits_that_leave_one_value_are_said():
    """urdfdom#36, urdf-loaders#9: lower and upper are 0 where they are left out; users expect no limits."""
    with pytest.warns(UserWarning, match="joint 'a' has lower and upper limit 0, so that it cannot move"):
        chain = dx.Chain.from_urdf(replaced(LIMIT, 'effort="1" velocity="2"'))
    assert (chain.lower[0], chain.upper[0]) == (0, 0)


def test_an_origin_may_turn_by_a_quaternion():
    """urdfdom#194, of URDF 1.2: the scalar part comes last."""
    x, y, z, w = dx.spatial.quaternion(dx.spatial.from_rpy([0.3, -1.2, 2.5]), order="xyzw").tolist()
    by_angles = replaced('rpy="0.3 0 0"', 'rpy="0.3 -1.2 2.5"')
    by_quaternion = replaced('rpy="0.3 0 0"', f'quat_xyzw="{x} {y} {z:.6f} {w}"')
    one, other = dx.Chain.from_urdf(by_angles), dx.Chain.from_urdf(by_quaternion)
    assert_close(one.screws, other.screws, rtol=0, atol=1e-6)
    assert other.adjusted == 0


def test_angles_in_degrees_are_said():
    with pytest.warns(
        UserWarning, match=r"joint 'a': origin has rpy '0 0 90', more than a full turn: .*radian"
    ):
        dx.Chain.from_urdf(replaced('rpy="0.3 0 0"', 'rpy="0 0 90"'))


QUIRKS = {
    "blanks and other scripts": (FREE.replace('"a"', '"joint 1 (左) ünï"'), 4),
    "signs and points": (replaced('xyz="0 0.6 0.8"', 'xyz="+0 .6 8.e-1"'), 4),
    "lines and tabs": (replaced('xyz="0 0.6 0.8"', 'xyz="0\n0.6\t0.8"'), 4),
    "a comment": (replaced('<joint name="a" ', '<!-- <joint name="a"/> --><joint name="a" '), 4),
    "a character by its number": (replaced('velocity="2"', 'velocity="&#50;"'), 4),
    "a namespace": (replaced("<robot ", '<robot xmlns:xacro="http://ros.org/wiki/xacro" version="1.2" '), 4),
    "no effort": (replaced('effort="1" velocity="2"', 'effort="0" velocity="2"'), 4),
    "what drives it": (
        replaced(
            "</robot>",
            """<transmission name="t"><joint name="a"/></transmission><gazebo reference="l1"><joint name="a"/>
            </gazebo><ros2_control name="c"><joint name="a"><limit/></joint></ros2_control></robot>""",
        ),
        4,
    ),
    "what protects it": (
        replaced(
            'velocity="2"/>',
            """velocity="2" acceleration="9"/><safety_controller soft_lower_limit="-0.5" k_velocity="1"/>
            <dynamics damping="1"/><calibration rising="0"/>""",
        ),
        4,
    ),
    "a mimic joint beside the way": (
        replaced(
            "</robot>",
            """<link name="finger"/><joint name="e" type="prismatic"><parent link="tip"/>
            <child link="finger"/><mimic joint="d"/></joint></robot>""",
        ),
        4,
    ),
    "fixed joints one behind the other": (
        replaced("</robot>", '<link name="x"/>' + EXTRA.format(parent="tip", child="x")),
        4,
    ),
}


@pytest.mark.parametrize(("text", "joints"), QUIRKS.values(), ids=QUIRKS)
def test_quirks_of_files_do_no_harm(text, joints):
    chain = dx.Chain.from_urdf(text, base="base", tip="tip")
    assert chain.joints == joints
    assert_close(chain.screws, dx.Chain.from_urdf(FREE).screws, rtol=0, atol=1e-15)


# ---- up the tree ---------------------------------------------------------------------------------------

FORK = """<robot name="fork">
  <link name="trunk"/><link name="l1"/><link name="l2"/><link name="r1"/><link name="r2"/>
  <joint name="la" type="revolute"><parent link="trunk"/><child link="l1"/>
    <origin xyz="0 0.2 0.5" rpy="0.1 0 0.4"/><axis xyz="0 1 0"/>
    <limit lower="-1" upper="2" velocity="3"/></joint>
  <joint name="lb" type="prismatic"><parent link="l1"/><child link="l2"/><origin xyz="0.3 0 0"/>
    <axis xyz="1 0 1"/><limit lower="0" upper="1" velocity="1"/></joint>
  <joint name="ra" type="continuous"><parent link="trunk"/><child link="r1"/><origin xyz="0 -0.2 0.5"/>
    <axis xyz="0 0 1"/></joint>
  <joint name="rb" type="revolute"><parent link="r1"/><child link="r2"/><origin xyz="0.3 0 0" rpy="0 0 1"/>
    <axis xyz="0 1 0"/><limit lower="-2" upper="2" velocity="1"/></joint>
</robot>"""


def test_a_way_up_the_tree_is_one_hand_seen_from_the_other(rng):
    """Two arms that hold one thing: rtb-python#379 (dual arms)."""
    chain = dx.Chain.from_urdf(FORK, base="l2", tip="r2")
    left, right = (dx.Chain.from_urdf(FORK, tip=tip) for tip in ("l2", "r2"))
    assert chain.joint_names == ("lb", "la", "ra", "rb")
    assert chain.upper.tolist() == [1, 2, math.inf, 2]
    for lb, la, ra, rb in rng.uniform(-1, 1, (5, 4)):
        expected = dx.spatial.inverse(left.forward([la, lb])) @ right.forward([ra, rb])
        assert_close(chain.forward([lb, la, ra, rb]), expected, rtol=0, atol=1e-14)


def test_a_way_up_alone_is_the_inverse_of_the_way_down(rng):
    down, up = dx.Chain.from_urdf(FORK, tip="l2"), dx.Chain.from_urdf(FORK, base="l2", tip="trunk")
    q = torch.from_numpy(rng.uniform(-1, 1, 2))
    assert_close(up.forward(q.flip(0)), dx.spatial.inverse(down.forward(q)), rtol=0, atol=1e-14)


def test_a_model_lists_its_links_and_ends():
    model = urdf.read(FORK)
    assert (model.name, model.roots, model.leaves()) == ("fork", ("trunk",), ("l2", "r2"))
    assert model.leaves("r1") == ("r2",)
    assert model.joint_names == ("la", "lb", "ra", "rb")


# ---- masses --------------------------------------------------------------------------------------------


def test_links_that_are_fixed_to_each_other_are_one_body():
    """A rod of 3 kg and 1 m, in two halves and a massless flange, about its end: m l² / 3."""
    half = """<inertial><origin xyz="0.25 0 0"/><mass value="1.5"/>
    <inertia iyy="0.03125" izz="0.03125"/></inertial>"""
    text = f"""<robot name="rod"><link name="wall"><inertial><mass value="100"/></inertial></link>
    <link name="first">{half}</link><link name="second">{half}</link><link name="flange"/>
    <joint name="hinge" type="continuous"><parent link="wall"/><child link="first"/>
      <axis xyz="0 0 1"/></joint>
    <joint name="weld" type="fixed"><parent link="first"/><child link="second"/>
      <origin xyz="0.5 0 0"/></joint>
    <joint name="end" type="fixed"><parent link="second"/><child link="flange"/>
      <origin xyz="0.5 0 0"/></joint></robot>"""
    rod = dx.Chain.from_urdf(text)
    assert rod.inertias.masses.tolist() == [3]
    assert_allclose(rod.inertias.centres, [[0.5, 0, 0]], rtol=0, atol=1e-15)
    assert_allclose(rod.mass_matrix([0.4]), [[1.0]], rtol=1e-14)


# ---- what is refused -----------------------------------------------------------------------------------

LIGHT = '<inertial><mass value="-1"/></inertial>'
INSIDE_OUT = '<inertial><mass value="1"/><inertia ixx="1" iyy="-2" izz="1"/></inertial>'
MOMENTS = 'ixx="1" iyy="1" izz="1" ixy="-3" ixz="-3" iyz="-3"'
SHEARED = f'<inertial><mass value="1"/><inertia {MOMENTS}/></inertial>'
BAD = {
    "lower above upper": (
        replaced(LIMIT, 'lower="2" upper="1"'),
        r"joint 'a': limit has lower 2 above upper 1",
    ),
    "no limit": (
        replaced('<limit lower="-1" upper="1" effort="1" velocity="2"/>', ""),
        r"joint 'a' is revolute and has no limit; .*continuous",
    ),
    "negative velocity": (
        replaced('velocity="2"', 'velocity="-2"'),
        r"joint 'a': limit has velocity -2; .*negative",
    ),
    "velocity is a text": (
        replaced('velocity="2"', 'velocity="fast"'),
        r"joint 'a': limit has velocity 'fast'; a number",
    ),
    "limit is NaN": (replaced(LIMIT, 'lower="nan"'), r"'a': limit has lower 'nan'"),
    "axis of zeros": (replaced('xyz="0 0.6 0.8"', 'xyz="0 0 0"'), r"joint 'a': axis is 0 0 0"),
    "axis of two": (
        replaced('xyz="0 0.6 0.8"', 'xyz="0 1"'),
        r"joint 'a': axis has xyz '0 1'; 3 numbers are needed",
    ),
    "axis is infinite": (replaced('xyz="0 0.6 0.8"', 'xyz="0 inf 1"'), r"joint 'a': axis has xyz '0 inf 1'"),
    "origin with commas": (
        replaced('xyz="0 0 0.2"', 'xyz="0, 0, 0.2"'),
        r"joint 'a': origin has xyz '0, 0, 0.2'",
    ),
    "origin with digits in groups": (
        replaced('xyz="0 0 0.2"', 'xyz="0 0 1_0"'),
        r"joint 'a': origin has xyz",
    ),
    "rpy of four": (replaced('rpy="0.3 0 0"', 'rpy="0 0 0 1"'), r"joint 'a': origin has rpy '0 0 0 1'"),
    "floating": (
        replaced(A, A.replace("revolute", "floating")),
        r"joint 'a' has type 'floating', which is not read",
    ),
    "planar": (
        replaced(A, A.replace("revolute", "planar")),
        r"joint 'a' has type 'planar', which is not read",
    ),
    "unknown type": (
        replaced(A, A.replace("revolute", "ball")),
        r"joint 'a' has type 'ball', which is unknown",
    ),
    "no type": (replaced(A, A.replace(' type="revolute"', "")), r"joint 'a' has no type"),
    "no parent": (replaced(A, A.replace('<parent link="plinth"/>', "")), r"joint 'a' has no parent"),
    "no name": (replaced('<joint name="a" ', "<joint "), "a joint has no name"),
    "parent that is not there": (replaced('<link name="plinth"/>', ""), "link 'plinth' is named by a joint"),
    "two joints of a name": (replaced('<joint name="b" ', '<joint name="a" '), r"joint 'a' stands 2 times"),
    "two links of a name": (
        replaced('<link name="plinth"/>', '<link name="plinth"/><link name="plinth"/>'),
        "link 'plinth' stands 2 times",
    ),
    "two parents": (
        replaced("</robot>", EXTRA.format(parent="base", child="l2")),
        "link 'l2' is the child of the joints 'b' and 'e': closed loops are not read",
    ),
    "a computed value": (
        replaced('velocity="2"', 'velocity="${2*pi}"'),
        r"joint 'a': limit has velocity .* xacro",
    ),
    "a computed name": (replaced('<joint name="b" ', '<joint name="${p}b" '), "a joint has name .* xacro"),
    "a macro": (
        replaced("</robot>", '<xacro:arm prefix="left"/></robot>'),
        r"<xacro:arm>: expand it first, with `xacro ",
    ),
    "a document type": ('<!DOCTYPE robot [<!ENTITY a "b">]>' + FREE, "declares a document type"),
    "no XML": ("<robot", "is no URDF: "),
    "unclosed": (FREE.replace("</robot>", ""), "is no URDF: "),
    "two robots": (FREE + FREE, "is no URDF: "),
    "SDF": ("<sdf version='1.6'><model name='m'/></sdf>", "its outermost element is <sdf>"),
    "MJCF": ("<mujoco/>", "its outermost element is <mujoco>"),
    "no links": ('<robot name="r"/>', "it has no link"),
    "nothing moves": ('<robot name="r"><link name="a"/></robot>', "no moving links at an end; name the tip"),
    "a name that is not printable": (
        replaced('<joint name="b" ', '<joint name="b&#9;" '),
        r"joint_names\[1\]",
    ),
    "axis without numbers": (
        replaced('<axis xyz="0 0.6 0.8"/>', "<axis>0 0.6 0.8</axis>"),
        r"joint 'a': axis has xyz ''; 3 numbers",
    ),
    "an unknown attribute": (
        replaced('rpy="0.3 0 0"', 'rpyy="0.3 0 0"'),
        r"joint 'a': origin has rpyy, which is unknown; xyz, rpy, quat_xyzw are known",
    ),
    "angles and a quaternion": (
        replaced('rpy="0.3 0 0"', 'rpy="0.3 0 0" quat_xyzw="0 0 0 1"'),
        r"joint 'a': origin has both rpy and quat_xyzw",
    ),
    "a quaternion of another length": (
        replaced('rpy="0.3 0 0"', 'quat_xyzw="0 0 0 2"'),
        r"joint 'a': origin has quat_xyzw '0 0 0 2' of length 2; 1 is needed",
    ),
    "two origins": (replaced('<axis xyz="0 0.6 0.8"/>', "<origin/>"), r"joint 'a' has origin 2 times"),
    "two axes": (replaced('<axis xyz="0 0.6 0.8"/>', "<axis/><axis/>"), r"joint 'a' has axis 2 times"),
    "two limits": (replaced('<axis xyz="0 0.6 0.8"/>', "<limit/>"), r"joint 'a' has limit 2 times"),
    "two parents of a joint": (replaced(A, A + '<parent link="l4"/>'), r"joint 'a' has parent 2 times"),
    "an entity": ('<!DOCTYPE robot SYSTEM "file:///etc/passwd">' + FREE, "declares a document type"),
    "negative mass": (
        replaced('<link name="l1"/>', f'<link name="l1">{LIGHT}</link>'),
        "link 'l1': inertial has mass -1",
    ),
    "negative moment of inertia": (
        replaced('<link name="l1"/>', f'<link name="l1">{INSIDE_OUT}</link>'),
        "link 'l1': inertial has the moment of inertia -2",
    ),
    "a link between itself": (
        replaced('<child link="l1"/>', '<child link="plinth"/>'),
        "joint 'a' has the link 'plinth' as its parent and as its child",
    ),
}


@pytest.mark.parametrize(("text", "message"), BAD.values(), ids=BAD)
def test_a_bad_urdf_is_refused_by_name(text, message):
    with pytest.raises(ValueError, match=message):
        dx.Chain.from_urdf(text)


NO_BODY = """<link name="l1"><inertial><mass value="1"/>
<inertia ixx="1" ixy="{}" ixz="0" iyy="1" iyz="0" izz="{}"/></inertial></link>"""


@pytest.mark.parametrize(("ixy", "izz", "moments"), [(0, 3, "1, 1, 3"), (1.2, 2, "-0.2, 2, 2.2")])
def test_a_link_whose_moments_no_body_has_is_named(ixy, izz, moments):
    """Published robots have such links: iCub, Romeo, TIAGo, ANYmal, PR2, and move all the same."""
    text = replaced('<link name="l1"/>', NO_BODY.format(ixy, izz))
    with pytest.warns(UserWarning, match=f"link 'l1': inertial has the principal moments {moments} kg"):
        dx.Chain.from_urdf(text)


def test_a_link_that_spoils_the_mass_matrix_is_refused_and_named():
    text = replaced('<link name="l1"/>', f'<link name="l1">{SHEARED}</link>')
    with (
        pytest.warns(UserWarning, match="link 'l1': inertial has the principal moments"),
        pytest.raises(ValueError, match=r"inertias.tensors\[0\] has the principal moment -5"),
    ):
        dx.Chain.from_urdf(text)


def test_a_rod_and_a_plate_are_bodies():
    for izz in (0, 2):  # without a thickness, the largest moment is the sum of the others
        dx.Chain.from_urdf(replaced('<link name="l1"/>', NO_BODY.format(0, izz)))


def test_a_cycle_is_refused():
    other, joint = '<link name="other"/>', EXTRA.format(parent="tip", child="base")
    with pytest.raises(ValueError, match=r"joint '[a-z0-9]+' closes a cycle of links"):
        dx.Chain.from_urdf(replaced("</robot>", other + joint), base="other", tip="tip")
    with pytest.raises(ValueError, match="name the base"):
        dx.Chain.from_urdf(replaced("</robot>", joint))


@pytest.mark.usefixtures("annotations_unchecked")
@pytest.mark.parametrize(
    ("links", "error", "message"),
    [
        ({"tip": "hand"}, ValueError, "tip is 'hand'; the URDF text has the links trunk, l1, l2, r1, r2"),
        ({"base": "foot"}, ValueError, "base is 'foot'"),
        ({}, ValueError, "the URDF text has 2 moving links at an end: l2, r2; name the tip"),
        ({"base": "l2"}, ValueError, "the URDF text has no moving links at an end; name the tip"),
        ({"tip": 3}, TypeError, "tip is 3"),
        ({"tip": "trunk"}, ValueError, "the URDF text: the path from trunk to trunk has no joint that moves"),
        ({"tip": "l2", "name": 3}, TypeError, "name is 3"),
    ],
)
def test_links_that_do_not_make_a_chain_are_refused(links, error, message):
    with pytest.raises(error, match=f"^{message}"):
        dx.Chain.from_urdf(FORK, **links)


def test_parts_that_are_not_connected_are_refused():
    apart = FORK.replace("</robot>", '<link name="cup"/></robot>')
    with pytest.raises(ValueError, match="has 2 links without a parent: trunk, cup; name the base"):
        dx.Chain.from_urdf(apart, tip="l2")
    with pytest.raises(ValueError, match="link 'cup' is not connected with 'trunk'"):
        dx.Chain.from_urdf(apart, base="trunk", tip="cup")
    assert dx.Chain.from_urdf(apart, base="trunk", tip="l2").joints == 2


@pytest.mark.usefixtures("annotations_unchecked")
@pytest.mark.parametrize(
    ("source", "error", "message"),
    [
        ("", ValueError, "source is ''"),
        ("arm.urdf", FileNotFoundError, "there is no URDF file arm.urdf"),
        ("a\0b", ValueError, "source is "),
        ("a" * 5000, FileNotFoundError, "there is no URDF file aaa"),
        (3, TypeError, "source is a int"),
        (None, TypeError, "source is a NoneType"),
        (b"<robot/>", TypeError, "source is a bytes"),
        (
            "robot.urdf.xacro",
            ValueError,
            "robot.urdf.xacro is a xacro file: .*`xacro robot.urdf.xacro > robot.urdf`",
        ),
    ],
)
def test_what_is_no_urdf_is_refused(source, error, message):
    with pytest.raises(error, match=f"^{message}"):
        dx.Chain.from_urdf(source)


def test_files_of_any_encoding_are_read_and_large_ones_refused(tmp_path):
    path = tmp_path / "arm.urdf"
    for content in (
        FREE.encode("utf-8-sig"),
        FREE.encode("utf-16"),
        b'<?xml version="1.0"?>\n' + FREE.encode(),
    ):
        path.write_bytes(content)
        assert dx.Chain.from_urdf(path).joints == 4
    path.write_bytes(b"\xff\xff<robot>")
    with pytest.raises(ValueError, match=r"^arm.urdf is no URDF"):
        dx.Chain.from_urdf(path)
    with path.open("wb") as file:
        file.truncate(40 * 2**20)
    with pytest.raises(ValueError, match=r"^arm.urdf has 41943040 bytes; at most"):
        dx.Chain.from_urdf(path)
    with pytest.raises(FileNotFoundError):
        dx.Chain.from_urdf(tmp_path)


def test_a_text_nested_a_lot_is_read_or_refused_without_a_crash():
    deep = "<a>" * 100_000 + "</a>" * 100_000
    assert dx.Chain.from_urdf(replaced("</robot>", deep + "</robot>")).joints == 4


# ---- mutated documents ---------------------------------------------------------------------------------

PIECES = re.findall(r"<[^>]+>|[\w.\-]+|\"", FREE)


def chain_or_refused(text: str) -> dx.Chain | None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            return dx.Chain.from_urdf(text)
        except (ValueError, FileNotFoundError):
            return None


@given(
    piece=st.sampled_from(sorted(set(PIECES))),
    other=st.sampled_from(["", "nan", "-1e400", "0", "1 2 3", '"', "<link/>", "${x}", "\0", "é", *PIECES]),
    count=st.integers(1, 3),
)
def test_a_mutated_urdf_is_a_chain_or_is_refused(piece, other, count):
    chain = chain_or_refused(FREE.replace(piece, other, count))
    if chain is not None:
        assert torch.isfinite(chain.forward(np.zeros(chain.joints))).all()


@given(start=st.integers(0, len(FREE)), length=st.integers(1, 200))
def test_a_urdf_with_a_hole_is_a_chain_or_is_refused(start, length):
    chain_or_refused(FREE[:start] + FREE[start + length :])


@given(text=st.text(max_size=100))
def test_any_text_is_refused(text):
    with pytest.raises((ValueError, FileNotFoundError)):
        dx.Chain.from_urdf(text)
