"""Subcommands that answer at once: robots, indices, evaluate, rank and ik.

They import the library when they run, so that help is there at once.

Examples
--------
>>> from dexterity.command.questions import indices
>>> indices.__doc__
'List the dexterity indices, or describe one.'
"""

from __future__ import annotations

from typing import Annotated

import typer

from dexterity.command.options import (
    Configurations,
    IndexOptions,
    Poses,
    ReportOptions,
    RobotOptions,
    grouped,
)
from dexterity.command.shell import INDEX, NEGATIVE, application, examples

__all__ = ["evaluate", "ik", "indices", "rank", "robots"]


@application.command(
    epilog=examples(
        "robots", "robots panda", "robots my_arm.urdf --base base_link --tip flange", "robots dh.csv --json"
    )
)
@grouped
def robots(
    *,
    robot: Annotated[
        str | None, typer.Argument(help="Name, URDF or robot file; all names by default.", show_default=False)
    ] = None,
    base: Annotated[
        str | None, typer.Option("--base", help="Link of the URDF where the chain begins.")
    ] = None,
    tip: Annotated[str | None, typer.Option("--tip", help="Link of the URDF where the chain ends.")] = None,
    form: ReportOptions,
) -> None:
    """List the robots of the package, or the joints of one robot."""
    from dexterity.command import listing

    form.give(listing.robots() if robot is None else listing.joints(RobotOptions(robot, base, tip).chain()))


@application.command(epilog=examples("indices", "indices kci"))
@grouped
def indices(
    *,
    index: Annotated[
        str | None,
        typer.Argument(help="Name or alias of an index; all of them by default.", show_default=False),
    ] = None,
    form: ReportOptions,
) -> None:
    """List the dexterity indices, or describe one."""
    from dexterity.command import listing

    form.give(listing.indices() if index is None else listing.measure(index))


@application.command(
    epilog=examples(
        "evaluate panda kci --q 0,-pi/4,0,-3pi/4,0,pi/2,pi/4",
        "evaluate ur5e manipulability --file poses.csv --rows translational --csv",
        "evaluate arm.urdf smallest_singular_value --file - --gradient --json < poses.json",
    )
)
@grouped
def evaluate(
    *,
    robot: RobotOptions,
    index: Annotated[str, typer.Argument(help=INDEX, show_default=False)],
    configurations: Configurations,
    gradient: Annotated[
        bool, typer.Option("--gradient", help="Derivatives by the joint values too.")
    ] = False,
    compiled: Annotated[
        bool,
        typer.Option(
            "--compiled", help="By compiled C: some seconds once, then millions of rows per second."
        ),
    ] = False,
    meaning: IndexOptions,
    form: ReportOptions,
) -> None:
    """Evaluate an index at configurations."""
    from dexterity.command import evaluation

    chain = robot.chain()
    asked = meaning.index(index, chain.joints)
    form.give(evaluation.evaluate(chain, asked, configurations.read(chain), gradient, compiled))


@application.command(
    epilog=examples(
        "rank panda welding --file candidates.csv --best 5",
        "rank ur5e kci --file candidates.npy --frame body --csv",
    )
)
@grouped
def rank(
    *,
    robot: RobotOptions,
    task: Annotated[str, typer.Argument(help="A task, such as welding, or an index.", show_default=False)],
    configurations: Configurations,
    best: Annotated[int, typer.Option("--best", min=1, help="How many candidates are listed.")] = 10,
    meaning: IndexOptions,
    form: ReportOptions,
) -> None:
    """Order candidate configurations by a task or an index, best first."""
    from dexterity.command import evaluation

    chain = robot.chain()
    form.give(evaluation.rank(chain, task, meaning, configurations.read(chain), best))


@application.command(
    epilog=examples(
        "ik panda --pose 0.4,0,0.5,pi,0,0",
        "ik ur5e --poses weld.csv --near 0,-pi/2,pi/2,0,pi/2,0 --csv",
        "ik arm.urdf --pose 0.3,0.1,0.2 --rows translational",
        "ik scara.urdf --pose 0.3,0.1,0.2,0,0,pi/2 --rows vx,vy,vz,wz --frame geometric",
    )
)
@grouped
def ik(
    *,
    robot: RobotOptions,
    poses: Poses,
    rows: Annotated[
        str, typer.Option("--rows", help="Rows of the tool's twist that count, such as translational.")
    ] = "full",
    frame: Annotated[
        str, typer.Option("--frame", help="Axes of the rows: body (the tool's) or geometric (the world's).")
    ] = "body",
    near: Annotated[
        str | None, typer.Option("--near", help="Configuration of the robot: the nearest come first.")
    ] = None,
    seeds: Annotated[
        int, typer.Option("--seeds", min=1, help="Seeds of a search, where there is no closed form.")
    ] = 64,
    limit_tolerance: Annotated[
        float, typer.Option("--limit-tolerance", min=0, help="By how much a limit may be exceeded (rad, m).")
    ] = 1e-9,
    beyond_limits: Annotated[
        bool, typer.Option("--beyond-limits", help="List configurations outside of the limits too.")
    ] = False,
    form: ReportOptions,
) -> int:
    """Find all configurations at tool poses. Exit code 1 if a pose is out of reach within the limits."""
    from dexterity.command import inputs, reaching
    from dexterity.typed import numbers

    chain = robot.chain()
    report, reached = reaching.inverse_kinematics(
        chain,
        poses.read(),
        beyond_limits=beyond_limits,
        rows=inputs.rows(rows),
        frame=frame,
        near=None if near is None else numbers(near, "--near", chain.joints),
        seeds=seeds,
        limit_tolerance=limit_tolerance,
    )
    form.give(report)
    return 0 if reached else NEGATIVE
