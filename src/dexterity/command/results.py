"""Subcommands that make files or take a while: map, place, design, validate and export.

They import the library when they run, so that help is there at once.

Examples
--------
>>> from dexterity.command.results import export
>>> export.__doc__
'Write an exact index or a network as C with a header, as JavaScript, or as ONNX.'
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from dexterity.command.options import IndexOptions, Language, Poses, ReportOptions, RobotOptions, grouped
from dexterity.command.reports import require_file
from dexterity.command.shell import INDEX, INTERRUPTED, NEGATIVE, application, examples

PoseRows = Annotated[
    str, typer.Option("--pose-rows", help="Rows of the tool's pose that must fit, such as translational.")
]
"""Option of the subcommands that have an index with rows of its own."""

PoseFrame = Annotated[
    str,
    typer.Option("--pose-frame", help="Axes of these rows: body (the tool's) or geometric (the world's)."),
]
"""Axes of the rows of a pose."""

__all__ = ["design", "export", "place", "reach_map", "validate"]


@application.command(
    name="map",
    epilog=examples(
        "map ur5e --rotations 72 --index kci --to ur5e.npz",
        "map ur5e --index velocity_ratio --rows translational --direction vz --to lifting.npz",
        "map panda --lower 0.2,-0.4,0 --upper 0.8,0.4,0.6 --spacing 0.05 --to front.npz",
        "map panda --lower 0.2,-0.4,0 --upper 0.8,0.4,0.6 --spacing 0.05 --to front.npz --continue",
    ),
)
@grouped
def reach_map(
    *,
    robot: RobotOptions,
    to: Annotated[Path, typer.Option("--to", help="File of the map (.npz).")],
    lower: Annotated[str | None, typer.Option("--lower", help="Corner x,y,z of a box (m).")] = None,
    upper: Annotated[
        str | None, typer.Option("--upper", help="Its other corner; without both, all that may be in reach.")
    ] = None,
    spacing: Annotated[float, typer.Option("--spacing", min=0, help="Distance of positions (m).")] = 0.2,
    rotations: Annotated[int, typer.Option("--rotations", min=1, help="Least number of rotations.")] = 24,
    index: Annotated[
        str | None, typer.Option("--index", help="Index by which poses are valued; without it, reach alone.")
    ] = None,
    method: Annotated[str, typer.Option("--method", help="auto, closed form, search or sampling.")] = "auto",
    pose_rows: PoseRows = "full",
    pose_frame: PoseFrame = "body",
    seed: Annotated[int, typer.Option("--seed", min=0, help="Seed of all draws.")] = 0,
    threads: Annotated[
        int | None, typer.Option("--threads", min=1, help="All processors by default.")
    ] = None,
    go_on: Annotated[
        bool, typer.Option("--continue", help="Go on from the unfinished map in the file.")
    ] = False,
    meaning: IndexOptions,
    form: ReportOptions,
) -> int:
    """Survey positions and rotations of the tool: what is in reach, and how well.

    Ctrl-C ends the survey; the map of what is finished is written, with exit code 130.
    """
    from dexterity.command import inputs, reaching
    from dexterity.command.progress import Bar

    require_file("--to", to, ".npz")
    chain = robot.chain()
    if index is None and meaning != IndexOptions():
        raise ValueError(
            "--frame, --rows and the other options of an index are given without --index; "
            "--pose-rows says what of a pose must fit"
        )
    asked = None if index is None else meaning.index(index, chain.joints)
    where = reaching.positions(chain, lower, upper, spacing)
    with Bar("poses") as bar:
        report, finished = reaching.reach_map(
            chain,
            where,
            rotations,
            to,
            go_on,
            index=asked,
            method=method,
            rows=inputs.rows(pose_rows),
            frame=pose_frame,
            seed=seed,
            threads=threads,
            progress=bar,
        )
    form.give(report)
    return 0 if finished else INTERRUPTED


@application.command(
    epilog=examples(
        "place ur5e --seam=-0.25,0,0,0.25,0,0 --x=-0.4:0.4:5 --y=-0.7:-0.35:3 --yaw 0:pi/2:2",
        "place panda --poses valves.csv --x=-1:0:11 --index force_ratio --rows full --direction 0,0,0,0,0,1",
    )
)
@grouped
def place(
    *,
    robot: RobotOptions,
    poses: Poses,
    seam: Annotated[
        str | None, typer.Option("--seam", help="Straight seam: x,y,z of its start and of its end (m).")
    ] = None,
    count: Annotated[int, typer.Option("--count", min=2, help="Poses along the seam.")] = 5,
    tool: Annotated[
        str, typer.Option("--tool", help="Roll,pitch,yaw of the tool on the seam; downwards by default.")
    ] = "pi,0,0",
    x: Annotated[str, typer.Option("--x", help="x of the bases (m): a number, or first:last:count.")] = "0",
    y: Annotated[str, typer.Option("--y", help="y of the bases (m).")] = "0",
    yaw: Annotated[str, typer.Option("--yaw", help="Yaw of the bases (rad).")] = "0",
    height: Annotated[float, typer.Option("--height", help="Height of the bases (m).")] = 0.0,
    index: Annotated[str, typer.Option("--index", help="Index by which bases are valued.")] = "kci",
    by: Annotated[str, typer.Option("--by", help="worst or mean value over the poses.")] = "worst",
    pose_rows: PoseRows = "full",
    pose_frame: PoseFrame = "body",
    largest_step: Annotated[
        float | None,
        typer.Option("--largest-step", min=0, help="How far a joint may move from pose to pose (rad, m)."),
    ] = None,
    refine: Annotated[bool, typer.Option(help="Improve the best base between the candidates.")] = True,
    best: Annotated[int, typer.Option("--best", min=1, help="How many bases are listed.")] = 10,
    seed: Annotated[int, typer.Option("--seed", min=0, help="Seed of all draws.")] = 0,
    meaning: IndexOptions,
    form: ReportOptions,
) -> int:
    """Compare places for the base by what the robot does from there. Exit code 1 if none reaches all poses.

    With --largest-step, the poses are followed in order, and no joint may move farther from pose to pose.

    Ctrl-C ends the comparison; the bases that were looked at are listed, with exit code 130.
    """
    from dexterity.command import inputs, reaching
    from dexterity.command.progress import Bar

    chain = robot.chain()
    asked = meaning.index(index, chain.joints)
    wanted = poses.read() if seam is None else reaching.seam(seam, count, tool)
    with Bar("bases") as bar:
        report, found = reaching.placements(
            chain,
            wanted,
            x,
            y,
            yaw,
            height,
            best,
            index=asked,
            by=by,
            largest_step=largest_step,
            rows=inputs.rows(pose_rows),
            frame=pose_frame,
            refine=refine,
            seed=seed,
            progress=bar,
        )
    form.give(report)
    if not bool(found.examined.all()):
        return INTERRUPTED
    return 0 if bool((~found.scores.isnan()).any()) else NEGATIVE


@application.command(
    epilog=examples(
        "validate", "validate my_network.npz --goal 0.01", "validate my_network.npz --points 200000 --json"
    )
)
@grouped
def validate(
    *,
    network: Annotated[
        str | None,
        typer.Argument(
            help="File, or name of a network of the package; all names by default.", show_default=False
        ),
    ] = None,
    goal: Annotated[
        float | None,
        typer.Option("--goal", min=0, help="Relative error allowed; by default the worst case on the card."),
    ] = None,
    points: Annotated[int, typer.Option("--points", min=1, help="Number of fresh configurations.")] = 20_000,
    seed: Annotated[int, typer.Option("--seed", min=0, help="Seed of the points and of the search.")] = 1,
    form: ReportOptions,
) -> int:
    """Judge a network on fresh points and by a search for its worst case; exit code 1 if it misses."""
    from dexterity.command import judging

    if network is None:
        form.give(judging.networks())
        return 0
    report, holds = judging.validate(network, points=points, goal=goal, seed=seed)
    form.give(report)
    return 0 if holds else NEGATIVE


@application.command(
    epilog=examples(
        "design panda kci --half-range 20deg --goal 0.02 --to kci.npz",
        "design ur5e w --middle 0,-pi/3,pi/2,0,pi/2,0 --sizes 8,16 --to w.npz",
    )
)
@grouped
def design(
    *,
    robot: RobotOptions,
    index: Annotated[str, typer.Argument(help=INDEX, show_default=False)],
    to: Annotated[
        Path, typer.Option("--to", help="File of the network (.npz); its card is written beside it.")
    ],
    goal: Annotated[float, typer.Option("--goal", min=0, help="Largest error that is wanted.")] = 0.01,
    middle: Annotated[
        str | None,
        typer.Option("--middle", help="Configuration in the middle; by default that of the limits."),
    ] = None,
    half_range: Annotated[
        str, typer.Option("--half-range", help="How far joints vary: one number, or one a joint; 0 holds it.")
    ] = "20deg",
    sizes: Annotated[str, typer.Option("--sizes", help="Numbers of neurons to try.")] = "4,8,12,20,30,45",
    restarts: Annotated[int, typer.Option("--restarts", min=1, help="Networks of each size.")] = 3,
    training_rows: Annotated[
        int, typer.Option("--training-rows", min=8, help="Rows of the training set.")
    ] = 4096,
    epochs: Annotated[int, typer.Option("--epochs", min=1, help="Epochs of each training.")] = 120,
    seed: Annotated[int, typer.Option("--seed", min=0, help="Seed of all draws.")] = 0,
    meaning: IndexOptions,
    form: ReportOptions,
) -> int:
    """Learn an index: a judged network with its card. Exit code 1 if no network keeps the goal.

    Ctrl-C ends the search; the best network so far is judged and written, with exit code 130.
    """
    from dexterity.command import learning
    from dexterity.command.progress import Bar

    require_file("--to", to, ".npz")
    effort = learning.effort(sizes, training_rows, epochs, restarts, seed)
    chain = robot.chain()
    asked = meaning.index(index, chain.joints)
    where = learning.space(chain, asked, middle, half_range)
    with Bar("networks") as bar:
        report, learned = learning.design(chain, asked, where, goal, effort, to, bar.step)
    form.give(report)
    return INTERRUPTED if learned.interrupted else 0 if learned.success else NEGATIVE


@application.command(
    epilog=examples(
        "export panda kci --to onboard --name panda_kci",
        "export panda kinematics --to onboard --name panda",
        "export arm.urdf w --tip flange --rows translational --single --to onboard",
        "export my_network.npz --form onnx --to onboard",
    )
)
@grouped
def export(
    *,
    source: Annotated[
        str, typer.Argument(help="Robot of an index; or a network: a file, or its name.", show_default=False)
    ],
    index: Annotated[
        str | None,
        typer.Argument(help="Index, or kinematics, of the robot; without it, a network."),
    ] = None,
    to: Annotated[Path, typer.Option("--to", help="Folder of the files.")],
    form: Annotated[Language, typer.Option("--form", help="Language of the files.")] = Language.C,
    name: Annotated[
        str | None, typer.Option("--name", help="What all names in the files begin with.")
    ] = None,
    single: Annotated[bool, typer.Option("--single", help="Single precision (c, onnx).")] = False,
    base: Annotated[
        str | None, typer.Option("--base", help="Link of the URDF where the chain begins.")
    ] = None,
    tip: Annotated[str | None, typer.Option("--tip", help="Link of the URDF where the chain ends.")] = None,
    meaning: IndexOptions,
    report: ReportOptions,
) -> None:
    """Write an exact index or a network as C with a header, as JavaScript, or as ONNX."""
    from dexterity.command import exporting, judging

    if index is None:
        files = exporting.network_files(judging.load(source), form, name, single)
    else:
        chain = RobotOptions(source, base, tip).chain()
        if index == "kinematics":
            files = exporting.kinematics_files(chain, form, name, single)
        else:
            files = exporting.index_files(chain, meaning.index(index, chain.joints), form, name, single)
    report.give(exporting.write(files, to))
