"""Robots that the package describes, and robots of one's own from URDF and TOML files.

``load`` takes a name or a file. The functions named after robots are the same with their options.
:mod:`dexterity.robots.description` explains the format of robot files.

Examples
--------
>>> import dexterity as dx
>>> panda = dx.robots.load("panda")
>>> panda.joints, round(float(panda.home[2, 3]), 3)
(7, 0.926)
>>> dx.robots.puma560().joint_names
('waist', 'shoulder', 'elbow', 'wrist roll', 'wrist pitch', 'flange')
>>> dx.robots.uvms(l2=0.5).home[:3, 3].tolist()
[0.0, 1.65, 0.0]
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Literal

from dexterity import store
from dexterity.chain import Chain
from dexterity.robots.description import Description, build, has_joints, nearest, read_description
from dexterity.spatial import TensorLike

__all__ = [
    "Description",
    "build",
    "describe",
    "docking_arm",
    "load",
    "names",
    "panda",
    "puma560",
    "read_description",
    "ur5e",
    "uvms",
]


def load(name_or_path: str | os.PathLike[str], *, base: str | None = None, tip: str | None = None) -> Chain:
    """Chain of a robot that the package describes, of a URDF, or of a robot file.

    Parameters
    ----------
    name_or_path
        One of :func:`names`; a path that ends in ``.urdf`` or the text of a URDF; or a path that ends in
        ``.toml``, a robot file with axes, frames or Denavit–Hartenberg rows.
    base, tip
        Links of a URDF between which the chain lies, see :meth:`dexterity.chain.Chain.from_urdf`.

    Raises
    ------
    ValueError
        If the name is unknown (the nearest names are given), the file cannot be read as its kind, or `base`
        or `tip` is given for a robot that is no URDF.
    TypeError
        If `name_or_path` is neither a text nor a path.
    FileNotFoundError
        If there is no such file.
    """
    if not isinstance(name_or_path, str | os.PathLike):
        raise TypeError(f"name_or_path is {name_or_path!r}; the name of a robot or a path is needed")
    text = os.fsdecode(name_or_path)
    if "<" in text or text.lower().endswith((".urdf", ".xacro", ".xml")):
        return Chain.from_urdf(name_or_path, base, tip)
    if base is not None or tip is not None:
        raise ValueError(f"base and tip are links of a URDF; {text!r} is none")
    if text.lower().endswith(".toml"):
        return build(read_description(text))
    if isinstance(name_or_path, os.PathLike) or {"/", "\\", "."} & set(text):
        raise ValueError(
            f"name_or_path is {text!r}; a file that ends in .urdf or .toml, or one of {', '.join(names())}"
            " is needed"
        )
    return build(describe(text))


def names() -> tuple[str, ...]:
    """Names of the serial chains that the package describes; the crane has a module of its own."""
    files = store.data_path("robots").glob("*.toml")
    return tuple(sorted(path.stem for path in files if has_joints(path)))


def describe(name: str) -> Description:
    """Read the description of one of the package's robots.

    Raises
    ------
    ValueError
        If there is no robot of that name; the nearest names are given.
    TypeError
        If `name` is no text.
    """
    if not isinstance(name, str):
        raise TypeError(f"name is {name!r}; the name of a robot is needed")
    path = store.data_path("robots") / f"{name}.toml"
    # Only its own file is read, unless the name is unknown.
    if "\0" in name or Path(name).name != name or not path.is_file() or not has_joints(path):
        raise ValueError(f"name is {name!r}; {nearest(name, names())}")
    return read_description(path)


def uvms(
    *,
    l1: float | None = None,
    l2: float | None = None,
    l3: float | None = None,
    y_MB: float | None = None,
    rates: TensorLike | None = None,
) -> Chain:
    """Twelve-joint underwater vehicle-manipulator system of paper A.

    Parameters
    ----------
    l1, l2, l3
        Base to shoulder (0), shoulder to elbow (0.6) and elbow to wrist (0.4), [m].
    y_MB
        Centre of gravity to the arm's base (0.75), [m].
    rates
        (12,) largest joint rates, [m/s] and [rad/s]; all 1 by default.

    References
    ----------
    Sotiropoulos & Aspragathos (2016), section 2.1 and Table 2. The paper prints neither l1, l2, l3 nor
    the velocity limits; the defaults are the book's assumptions.
    """
    lengths = {"l1": l1, "l2": l2, "l3": l3, "y_MB": y_MB}
    return build(describe("uvms"), {k: v for k, v in lengths.items() if v is not None}, rates=rates)


def docking_arm(variant: Literal["stated", "fitted"] = "stated") -> Chain:
    """Six-joint elbow arm of paper B.

    Parameters
    ----------
    variant
        ``"stated"``: the lengths that the paper gives. ``"fitted"``: lengths inferred from the joint
        angles of its Table 4, which the stated arm does not reproduce.

    References
    ----------
    Sotiropoulos, Aspragathos & Andritsos (2011), section IV, Table 1.
    """
    return build(describe("docking_arm"), variant=None if variant == "stated" else variant)


def puma560() -> Chain:
    """Unimation PUMA 560, tool point at the wrist centre, base frame at the shoulder.

    References
    ----------
    Corke & Armstrong-Hélouvry (1994), A search for consensus among model parameters reported for the
    PUMA 560 robot.
    """
    return build(describe("puma560"))


def panda() -> Chain:
    """Seven-joint arm Franka Emika Panda, tool frame at the flange.

    References
    ----------
    Franka Emika, Franka Control Interface documentation: Denavit–Hartenberg parameters (Craig's convention)
    and limits in joint space.
    """
    return build(describe("panda"))


def ur5e() -> Chain:
    """Six-joint arm Universal Robots UR5e, tool frame at the flange.

    References
    ----------
    Universal Robots, DH parameters for calculations of kinematics and dynamics; UR5e technical
    specifications.
    """
    return build(describe("ur5e"))
