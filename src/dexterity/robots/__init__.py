"""Robots that the package describes, and robots of one's own from URDF, TOML and CSV files.

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
from typing import Literal

from dexterity import checks
from dexterity.chain import Chain
from dexterity.robots.description import (
    Description,
    Vehicle,
    build,
    describe,
    names,
    read_description,
    shipped_chain,
)
from dexterity.spatial import TensorLike

__all__ = [
    "Description",
    "Vehicle",
    "bluerov2",
    "build",
    "describe",
    "docking_arm",
    "girona500",
    "iiwa14",
    "load",
    "names",
    "oberon7",
    "panda",
    "puma560",
    "reach_alpha5",
    "reach_bravo7",
    "read_description",
    "ur5e",
    "uvms",
]


def load(name_or_path: str | os.PathLike[str], *, base: str | None = None, tip: str | None = None) -> Chain:
    """Chain of a robot that the package describes, of a URDF, or of a robot file.

    Parameters
    ----------
    name_or_path
        One of :func:`names`; a path that ends in ``.urdf`` or the text of a URDF; or a robot file, see
        :mod:`dexterity.robots.description`: a path that ends in ``.toml``, with axes, frames or
        Denavit–Hartenberg rows, or in ``.csv``, a Denavit–Hartenberg table.
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
        raise TypeError(
            f"name_or_path is {checks.shown(name_or_path)}; the name of a robot or a path is needed"
        )
    text = os.fsdecode(name_or_path)
    if "\0" in text or not text.strip():
        raise ValueError(f"name_or_path is {checks.shown(text)}; the name of a robot or a path is needed")
    if "<" in text or text.lower().endswith((".urdf", ".xacro", ".xml")):
        return Chain.from_urdf(name_or_path, base, tip)
    if base is not None or tip is not None:
        raise ValueError(f"base and tip are links of a URDF; {text!r} is none")
    if text.lower().endswith((".toml", ".csv")):
        return build(read_description(text))
    if isinstance(name_or_path, os.PathLike) or {"/", "\\", "."} & set(text):
        raise ValueError(
            f"name_or_path is {checks.shown(text)}; a file that ends in .urdf, .toml or .csv, "
            f"or one of {', '.join(names())} is needed"
        )
    return shipped_chain(text, "name_or_path")


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
    changed = {name: checks.real(value, name) for name, value in lengths.items() if value is not None}
    if not changed and rates is None:
        return shipped_chain("uvms")
    return build(describe("uvms"), changed, rates=rates)


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
    if isinstance(variant, str) and variant == "stated":
        return shipped_chain("docking_arm")
    return build(describe("docking_arm"), variant=variant)


def puma560() -> Chain:
    """Unimation PUMA 560, tool point at the wrist centre, base frame at the shoulder.

    References
    ----------
    Corke & Armstrong-Hélouvry (1994), A search for consensus among model parameters reported for the
    PUMA 560 robot.
    """
    return shipped_chain("puma560")


def panda() -> Chain:
    """Seven-joint arm Franka Emika Panda with its masses, tool frame at the flange.

    References
    ----------
    Franka Emika, Franka Control Interface documentation: Denavit–Hartenberg parameters (Craig's convention)
    and limits in joint space. Gaz, Cognetti, Oliva, Robuffo Giordano & De Luca (2019), Dynamic identification
    of the Franka Emika Panda robot with retrieval of feasible parameters using penalty-based optimization,
    IEEE Robotics and Automation Letters 4(4).
    """
    return shipped_chain("panda")


def ur5e() -> Chain:
    """Six-joint arm Universal Robots UR5e with its masses, tool frame at the flange.

    The base frame is that of the controller. The frame ``base_link`` of the maker's URDF is turned by half a
    turn about z.

    References
    ----------
    Universal Robots, DH parameters for calculations of kinematics and dynamics; UR5e technical
    specifications.
    """
    return shipped_chain("ur5e")


def iiwa14() -> Chain:
    """Seven-joint arm KUKA LBR iiwa 14 R820 with masses of its CAD model, tool frame at the flange.

    References
    ----------
    KUKA, Sensitive robotics: LBR iiwa (brochure), dimensions, axis data. Huber et al. (2024), LBR-Stack,
    Journal of Open Source Software 9(103): masses.
    """
    return shipped_chain("iiwa14")


def oberon7() -> Chain:
    """Six-joint hydraulic underwater arm Schilling Oberon 7, tool frame at the wrist.

    References
    ----------
    Manhães et al. (2016), UUV Simulator, OCEANS MTS/IEEE Monterey; its package uuv_manipulators.
    """
    return shipped_chain("oberon7")


def reach_alpha5() -> Chain:
    """Four-joint electric underwater arm Reach Alpha 5, whose fifth function is the jaws.

    References
    ----------
    Reach Robotics (Blueprint Lab), Reach Alpha: kinematic parameters and data sheet.
    """
    return shipped_chain("reach_alpha5")


def reach_bravo7() -> Chain:
    """Six-joint electric underwater arm Reach Bravo 7, whose seventh function is the jaws.

    References
    ----------
    Reach Robotics (Blueprint Lab), Reach Bravo: kinematic parameters and data sheet.
    """
    return shipped_chain("reach_bravo7")


def bluerov2(arm: Chain | None = None) -> Chain:
    """Underwater vehicle like a BlueROV2 with an arm below its bow: roll and pitch are passive.

    Parameters
    ----------
    arm
        The arm, its base frame as that of the Reach Alpha 5, which is the default.

    References
    ----------
    Blue Robotics, BlueROV2 data sheet: size and speed. The mount is one of the integration kit for the
    Reach Alpha; see ``data/robots/bluerov2.toml`` for what is assumed.
    """
    return shipped_chain("bluerov2") if arm is None else build(describe("bluerov2"), arm=arm)


def girona500(arm: Chain | None = None) -> Chain:
    """Underwater vehicle like a Girona 500 with an arm at its bow: it stays upright by its own weight.

    Parameters
    ----------
    arm
        The arm, its base frame as that of the Reach Bravo 7, which is the default.

    References
    ----------
    Ribas, Palomeras, Ridao, Carreras & Mallios (2012), Girona 500 AUV: from survey to intervention, IEEE/ASME
    Transactions on Mechatronics 17(1); see ``data/robots/girona500.toml`` for what is assumed.
    """
    return shipped_chain("girona500") if arm is None else build(describe("girona500"), arm=arm)
