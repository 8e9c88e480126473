"""Figures, tables and the scene of the chapter on the rigid crane."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import torch
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from dexterity import crane
from dexterity.crane.description import Linkage, Point
from dexterity.crane.kinematics import turned
from dexterity.scenes import Body, Scene, Slider
from dexterity.scenes.colors import COLORS
from dexterity_study.claims.ledger import load_paper
from dexterity_study.crane.cases import BOX
from dexterity_study.crane.kinematics.experiment import circles, direction
from dexterity_study.engine.evidence import Evidence
from dexterity_study.engine.table import Table
from dexterity_study.page import figures
from dexterity_study.page.markup import Markup
from dexterity_study.page.tables import over_seeds, show

PAPER = load_paper("rouvinen1999")
SLIDERS = ("s₁ lift [m]", "s₂ jib [m]", "s₃ extension [m]")


def strokes_of(points: Sequence[Sequence[float]]) -> Markup:
    """Set the strokes with the least extension for some points, the tip that they lead to, and whether they exist."""
    reach = crane.inverse(points)
    rows = torch.cat([torch.tensor(points, dtype=torch.float64), reach.strokes], dim=-1).numpy()
    heads = ["$x$ [m]", "$y$ [m]", "$s_1$ [m]", "$s_2$ [m]", "$s_3$ [m]"]
    frame = pd.DataFrame(rows, columns=heads).assign(**{"within the strokes": reach.within_limits.numpy()})
    return show(frame, "{:.3f}", forms=dict.fromkeys(heads[:2], "{:.1f}"))


def misprints(stored: Evidence) -> Markup:
    """Set printed sizes that the thesis contradicts, with what stands elsewhere and how much it matters."""
    shifts, rules = stored["formulas"].where().max(numeric_only=True), stored["rules"].where()
    area, short = (stored["working_area"].where(one).iloc[0] for one in ("chosen", "crane-jib-stroke=0.75"))
    up, rocker = PAPER.printed("crane-joints")[-1], math.hypot(*crane.patu655().linkage.coupler_pin)
    inner, at_end = PAPER.printed("crane-inner-radius"), area["inner_at_end"]
    longest = inner - rules.set_index("circle").loc["folded", "smallest"]
    heads = ["size", "printed", "elsewhere", "effect"]
    rows = (
        f"mounts of the lift cylinder, table | {PAPER.setting('crane-cylinder-mounts').printed} | other pairs in the listing | tip {shifts['table']:.1f} m off",
        f"height of IJ | {up:g} m | −{up:g} along an axis that points down | {1e3 * shifts['downwards']:.0f} mm, if taken for down",
        f"length of GI | {PAPER.setting('crane-rocker').printed} | {rocker:.5f} m by its two sizes | {1e3 * shifts['rocker']:.2f} mm",
        f"end of the jib cylinder | {short['jib_stroke']:g} m | {area['jib_stroke']:g} m in the training data | {1e3 * (short['inner_at_end'] - at_end):.0f} mm, folded",
        f"inner radius | {inner:g} m | {area['inner_least']:.3f} m at least, {at_end:.3f} m at the end | {1e3 * longest:.0f} mm of extension",
        f"square of a circle's radius | $r^2 + s_3^2$ | $(r + s_3)^2$ in the rule that follows | {rules['by_squares'].max():.1f} m of extension",
    )
    return show(pd.DataFrame([row.split(" | ") for row in rows], columns=heads).set_index("size"))


def stroke_ends(stored: Evidence) -> Markup:
    """Compare both ends of the jib cylinder."""
    rows = stored["working_area"].where(None)[["jib_stroke", "vectors", "area", "inner_at_end"]]
    heads = ["end of $s_2$ [m]", "training vectors", "working area [m²]", "inner radius at the end [m]"]
    rows = rows.set_axis(heads, axis=1).set_axis(["training data", "listing"])
    printed = [None, int(PAPER.printed("crane-training-vectors")), None, PAPER.printed("crane-inner-radius")]
    table = pd.concat([pd.DataFrame([printed], ["printed"], heads, dtype=object), rows.astype(object)])
    return show(table.rename_axis("stroke of"), "{:.3f}", forms={heads[2]: "{:.1f}"})


def gains(stored: Evidence, live: Table) -> Markup:
    """Set millimetres of the tip for a millimetre of each stroke, stored and live."""
    heads = {name: name for name in ("least", "median", "largest")} | {"at_tests": "tests"}
    table = over_seeds(stored["gains"].where(), "of", heads, "{:.1f}")
    names = {
        "lift": "$s_1$, lift",
        "jib": "$s_2$, jib",
        "extension": "$s_3$, extension",
        "largest singular value": "best combination",
        "smallest singular value": "worst combination",
    }
    table = table.assign(**{"median, live": live.where().set_index("of")["median"].map("{:.1f}".format)})
    return show(table.rename(index=names).rename_axis("stroke"))


def maps(stored: Evidence) -> Figure:
    """Draw the least extension and the amplification over the working area, with training and test points."""
    fig, panels = plt.subplots(1, 2, figsize=(figures.WIDTH, 5.2), sharey=True)
    labels = {"extension": "least extension [m]", "amplification": "tip / stroke [mm/mm]"}
    for ax, (name, label) in zip(panels, labels.items(), strict=True):
        values = stored["working_area"].array(name)[0]
        image = ax.imshow(values.T, origin="lower", extent=(*BOX[0], *BOX[1]))
        fig.colorbar(image, ax=ax, label=label, orientation="horizontal")
        ax.set(xlabel="x [m]", xlim=BOX[0], ylim=BOX[1], xticks=(0, 2, 4, 6))
        ax.grid(visible=False)
    for centre, radius in circles(crane.patu655()).values():
        x, y = centre.tolist()
        panels[0].add_patch(Circle((x, y), radius, fill=False, color=COLORS["orange"]))
    panels[0].plot([], [], color=COLORS["orange"], label="three circles")
    training = {"ms": 2.5, "color": COLORS["vermillion"], "label": "training points"}
    panels[0].plot(*_training_tips().T, ".", **training)
    tests = np.array(crane.TEST_POINTS)
    inside = crane.inverse(crane.TEST_POINTS).within_limits.numpy()
    for which, fill, label in ((inside, "full", "test points"), (~inside, "none", "test point out of reach")):
        look = {"ms": 5, "color": COLORS["vermillion"], "fillstyle": fill, "label": label}
        panels[1].plot(*tests[which].T, "o", **look)
    panels[0].set(ylabel="y [m]")
    fig.legend(loc="outside upper center", ncols=2)
    return fig


def _training_tips() -> np.ndarray:
    data = crane.training_set()
    return np.unique((data.tip - data.deflection).numpy().round(9), axis=0)


def scene() -> Scene:
    """Draw the crane with a slider for each stroke, and the tips of the training data."""
    title = "The rigid crane and where its tip was put for training"
    drawn = Scene(title, height=520, view_from=(0.15, -1.0, 0.1))
    drawn.look_at((-0.3, 0.0, -2.0), (6.0, 0.0, 5.5))
    upright = [[1, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]]
    drawn.add_mechanism(*mechanism(), name="crane", pose=upright)
    points = np.insert(_training_tips(), 1, 0.0, axis=1)
    drawn.add_points(points, name="tips of the training data", size=0.05, color="orange")
    return drawn


def mechanism(start: Sequence[float] = (0.25, 0.3, 0.5), steps: int = 61) -> tuple[list[Body], list[Slider]]:
    """Return the bodies of the crane, and sliders for its strokes that stand at a start [m]."""
    links, upper = crane.patu655().linkage, crane.patu655().upper
    values = [torch.linspace(0, end, steps, dtype=torch.float64) for end in upper]
    # Neither angle, that of the jib being taken from the lift arm, depends on another's stroke.
    place = crane.posture(torch.stack(values, dim=-1))
    fold, pin, (along, across) = place.jib - place.lift, place.crank_pin, links.extension_joint
    lift_rod = turned(place.lift, links.lift_cylinder_rod) + pin.new_tensor(links.lift_joint)
    coupler_pin = turned(fold, links.coupler_pin) + pin.new_tensor(links.jib_joint)
    slid = torch.stack([along + values[2], torch.full_like(values[2], across)], dim=-1)
    elbow, lift_arm = np.array(links.jib_joint), [(0, 0), links.jib_joint]
    for mount in (links.lift_cylinder_rod, links.jib_cylinder_foot, links.crank_joint):
        lift_arm += [elbow * (mount @ elbow) / (elbow @ elbow), mount]
    jib_arm = [links.coupler_pin, (along, across), (0, 0), (0, across), (0, 0), links.coupler_pin]
    pillar = [(0, 0), links.lift_joint, (-0.006, 0.075), links.lift_cylinder_foot]
    lift, jib, extension = SLIDERS
    parts: list[tuple[Any, ...]] = [
        ("lift arm", "pillar", lift, place.lift, links.lift_joint, lift_arm, 0.055, "blue"),
        ("jib arm", "lift arm", jib, fold, links.jib_joint, jib_arm, 0.055, "sky blue"),
        ("extension", "jib arm", extension, 0 * fold, slid, [(0, 0), (-1.95, 0)], 0.04, "vermillion"),
    ]
    lift_foot, lift_length = links.lift_cylinder_foot, links.lift_cylinder_length
    jib_foot, jib_length = links.jib_cylinder_foot, links.jib_cylinder_length
    # The rods of the cylinders are long enough to stay in their barrels.
    for name, on, slider, first, second, length, radius, color in (
        ("crank", "lift arm", jib, links.crank_joint, pin, links.crank, 0.04, "bluish green"),
        ("coupler", "lift arm", jib, pin, coupler_pin, links.coupler, 0.04, "bluish green"),
        ("lift cylinder", "pillar", lift, lift_foot, lift_rod, 0.92 * lift_length, 0.055, "black"),
        ("lift rod", "pillar", lift, lift_rod, lift_foot, 0.1 * lift_length + upper[0], 0.03, "black"),
        ("jib cylinder", "lift arm", jib, jib_foot, pin, 0.92 * jib_length, 0.055, "black"),
        ("jib rod", "lift arm", jib, pin, jib_foot, 0.1 * jib_length + upper[1], 0.03, "black"),
    ):
        ends = (torch.as_tensor(end, dtype=torch.float64) for end in (second, first))
        angle = direction(torch.sub(*ends))
        parts.append((name, on, slider, angle, first, [(0, 0), (length, 0)], radius, color))
    letters = _letters(links)
    bodies = [Body("pillar", rods=_rods(pillar), letters=letters["pillar"])]
    for name, on, slider, angle, origin, ends, radius, color in parts:
        T = torch.eye(4, dtype=torch.float64).repeat(steps, 1, 1)
        T[:, :2, 3] = torch.as_tensor(origin, dtype=torch.float64)
        T[:, :2, :2] = torch.stack([turned(angle, (1.0, 0.0)), turned(angle, (0.0, 1.0))], dim=-1)
        rods = _rods(ends)
        bodies.append(
            Body(name, on, slider, T.numpy(), rods, rods[0, :1], radius, color, letters.get(name, {}))
        )
    return bodies, [Slider(*one) for one in zip(SLIDERS, (own.numpy() for own in values), start, strict=True)]


def _letters(links: Linkage) -> dict[str, dict[str, np.ndarray]]:
    """Return the thesis's letters by body, with the points that they stand for in its frame [m]."""
    named = {
        "pillar": {"B": links.lift_joint, "C": links.lift_cylinder_foot},
        "lift arm": {
            "D": links.lift_cylinder_rod,
            "E": links.jib_cylinder_foot,
            "F": links.crank_joint,
            "G": links.jib_joint,
        },
        "crank": {"H": (links.crank, 0.0)},
        "jib arm": {"I": links.coupler_pin, "J": links.extension_joint},
        "extension": {"tip": (0.0, 0.0)},
    }
    return {body: {text: np.append(at, 0.0) for text, at in own.items()} for body, own in named.items()}


def _rods(ends: Sequence[Point | np.ndarray]) -> np.ndarray:
    return np.insert(np.array(ends, dtype=float), 2, 0.0, axis=1).reshape(-1, 2, 3)
