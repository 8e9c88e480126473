"""Figures, tables and scenes of the chapter on inverse kinematics."""

from __future__ import annotations

import matplotlib.pyplot as plt
import pandas as pd
import torch
from matplotlib.figure import Figure
from torch import Tensor

from dexterity import scenes
from dexterity.chain import Chain
from dexterity.inverse_kinematics import spherical_wrist
from dexterity.scenes.colors import COLORS
from dexterity_study.engine.evidence import Evidence
from dexterity_study.engine.table import Table
from dexterity_study.page.markup import Markup
from dexterity_study.page.tables import show

PALETTE = tuple(COLORS[name] for name in ("blue", "vermillion", "bluish green", "reddish purple"))


def configurations(arm: Chain, pose: Tensor) -> Tensor:
    """Return the branches (8, 6) of a tool pose, those of one wrist after those of the other."""
    q, valid = spherical_wrist(arm, pose)
    return torch.cat([q[valid][0::2], q[valid][1::2]])


def four_ways(title: str, arm: Chain, pose: Tensor) -> scenes.Scene:
    """Set the four branches of a pose that differ in shoulder and elbow."""
    scene = scenes.Scene(title, view_from=(0.6, -1, 0.5))
    branches = configurations(arm, pose)[:4]
    places = arm.joint_frames(branches)[..., :3, 3]
    alike = torch.isclose(places[:, None], places).flatten(2).all(-1)
    for i, color in enumerate(PALETTE):
        same = alike[i].nonzero().flatten().tolist()
        if same[0] == i:
            name = " and ".join(f"branch {one}" for one in same)
            scene.add_chain(arm, branches[i], name=name, axes=False, color=color)
    return scene


def round_trips(stored: Evidence, live: Table) -> Markup:
    """Set pose errors and shares of the round trips by arm, stored and live."""
    rows = pd.concat({"stored": stored["round_trips"].where(), "live": live.where()}, names=["run"])
    rows = rows.reset_index("run").set_index(["run", "arm"])
    heads = {"found": "own configuration found [%]", "refused": "out of reach, flagged [%]"}
    errors = rows["pose_error"].map("{:.0e}".format).rename("largest pose error")
    values = rows["values_of_w"].rename("different w at most")
    return show(pd.concat([errors, 100 * rows[list(heads)].rename(columns=heads), values], axis=1), "{:.4g}")


def both_angles(angles: Tensor) -> Markup:
    """Set the two solutions (2) [rad] of a subproblem in degrees."""
    return show(pd.Series(torch.rad2deg(angles).numpy(), ["first", "second"], name="angle [°]"), "{:.2f}")


def counts(stored: Evidence) -> Markup:
    """Set shares [%] of the poses by number of branches, and by number of those within the limits."""
    rows = 100 * stored["round_trips"].where().set_index("arm")
    parts = {"all": rows.filter(like="branches_"), "within limits": rows.filter(like="within_").dropna()}
    numbered = {title: part.set_axis(range(9), axis="columns") for title, part in parts.items()}
    return show(pd.concat(numbered, names=["branches"]))


def joint_table(chain: Chain, q: Tensor) -> Markup:
    """Set configurations (m, n) [rad], a row for each."""
    return show(pd.DataFrame(q, columns=chain.joint_names), "{:.2f}")


def border(live: Table) -> Figure:
    """Draw how far both elbows are apart against the distance from the border."""
    fig, ax = plt.subplots()
    ax.loglog(live.array("short")[0, :-1], live.array("apart")[0, :-1])
    ax.invert_xaxis()
    ax.set(xlabel="distance to the border of the workspace [m]", ylabel="largest difference of a joint [rad]")
    return fig
