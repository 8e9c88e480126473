"""Figures, tables and scenes of the chapter on inverse kinematics."""

from __future__ import annotations

from collections.abc import Mapping

import matplotlib.pyplot as plt
import pandas as pd
import torch
from matplotlib.figure import Figure
from torch import Tensor

from dexterity import indices, scenes
from dexterity.chain import Chain
from dexterity.inverse_kinematics import spherical_wrist
from dexterity.scenes.colors import COLORS
from dexterity_study.engine.evidence import Evidence
from dexterity_study.engine.table import Table
from dexterity_study.page import figures
from dexterity_study.page.markup import Markup
from dexterity_study.page.tables import show

PALETTE = tuple(COLORS[name] for name in ("blue", "vermillion", "bluish green", "reddish purple"))
ARMS = {
    "stated": "stated arm",
    "fitted": "fitted arm",
    "PUMA 560": "PUMA 560",
    "all axes skew": "skew axes",
}


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


def counts(stored: Evidence) -> Figure:
    """Draw the shares of the poses by the number of configurations within the joint limits."""
    rows = 100 * stored["round_trips"].where().set_index("arm").filter(like="within_").dropna()
    fig, ax = plt.subplots(figsize=(figures.WIDTH, 3.2))
    width = 0.8 / len(rows)
    for i, (arm, shares) in enumerate(rows.iterrows()):
        numbers = [number + (i - (len(rows) - 1) / 2) * width for number in range(len(shares))]
        ax.bar(numbers, shares, width, label=ARMS[str(arm)])
    ax.axvline(8, color="#595959", ls="--", lw=1.2, zorder=0, label="paper: up to eight")
    ax.set(xlabel="configurations within the joint limits", ylabel="share of the poses [%]")
    ax.set_xticks(range(9))
    fig.legend(loc="outside upper center", ncols=2)
    return fig


def branches(arms: Mapping[str, tuple[Chain, Tensor]]) -> Markup:
    """Set the joint values [rad] and w of the branches of a pose, in each row a pair by the sign of q5."""
    tables = {}
    for title, (arm, pose) in arms.items():
        q = configurations(arm, pose)
        w = indices.manipulability(arm.geometric_jacobian(q[:4]))
        columns = {f"$q_{n}$ [rad]": q[:4, n - 1].numpy() for n in (1, 2, 3)}
        columns |= {"$|q_5|$ [rad]": q[:4, 4].abs().numpy(), "$w$ [m³]": w.numpy()}
        tables[title] = pd.DataFrame(columns, [f"branch {n}" for n in range(1, 5)])
    return show(pd.concat(tables, names=["arm", "branch"]), "{:.2f}", forms={"$w$ [m³]": "{:.4f}"})


def round_trips(stored: Evidence, live: Table) -> Markup:
    """Set pose errors and shares of the round trips by arm, and the pose errors of a live run."""
    rows = stored["round_trips"].where().set_index("arm")
    shares = {
        "found": "drawn configuration found [%]",
        "refused": "out of reach, flagged [%]",
        "branches_8": "eight branches [%]",
    }
    errors = {
        f"pose error, {run}": table.where().set_index("arm")["pose_error"].astype(float)
        for run, table in (("stored", stored["round_trips"]), ("live", live))
    }
    table = pd.DataFrame(
        {
            **errors,
            **{head: 100 * rows[name].astype(float) for name, head in shares.items()},
            "different $w$, at most": rows["values_of_w"],
        }
    )
    return show(table.rename(ARMS), "{:.0f}", forms=dict.fromkeys(errors, "{:.0e}"))


def border(stored: Evidence) -> Figure:
    """Draw how far both elbows are apart against the distance from the border."""
    fig, ax = plt.subplots(figsize=(figures.WIDTH, 2.8))
    table = stored["border"]
    ax.loglog(table.array("short")[0, :-1], table.array("apart")[0, :-1])
    ax.invert_xaxis()
    ax.set(
        xlabel="distance to the border of the workspace [m]", ylabel="largest difference\nof a joint [rad]"
    )
    return fig
