"""Subcommands of ``dexterity``: their arguments, their help, and how each error ends.

The subcommands import the library when they run, so that help is there at once.

Examples
--------
>>> from dexterity.command.application import run
>>> run(["robots", "puma560", "--csv"])
joint,kind,lower,upper,rate
waist,revolute,-2.792526803...,2.792526803...,1.0
...
0
"""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer
from typer.main import get_command

import dexterity
from dexterity.command.options import (
    Configurations,
    IndexOptions,
    Language,
    Poses,
    ReportOptions,
    RobotOptions,
    grouped,
)
from dexterity.command.reports import require_file, say

__all__ = ["BAD_INPUT", "FAILED", "INTERRUPTED", "NEGATIVE", "application", "run"]

NEGATIVE, BAD_INPUT, FAILED, INTERRUPTED = 1, 2, 3, 130
"""Exit codes: a negative answer, an unusable argument or file, a machine that fails, and Ctrl-C."""

application = typer.Typer(
    name="dexterity",
    help=(
        "Dexterity of any serial robot: indices, inverse kinematics, reach maps, base placement, networks, "
        "C code."
    ),
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode="rich",
    context_settings={"help_option_names": ["-h", "--help"]},
    epilog=(
        "Exit codes: 0 an answer; 1 a negative answer, such as a pose out of reach; 2 an argument or a file "
        "that cannot be used; 3 a machine that fails; 130 Ctrl-C, which leaves what is finished."
    ),
)


def run(words: Sequence[str]) -> int:
    """Run the command with the words behind its name, and return its exit code.

    An error is a line on standard error. ``DEXTERITY_TRACEBACK=1`` raises it instead.
    """
    try:
        command = get_command(application)
        with command.make_context("dexterity", list(words)) as context:
            code = command.invoke(context)
        sys.stdout.flush()
        return int(code or 0)
    except typer.Exit as end:
        return end.exit_code
    except typer.TyperException as error:
        return _end(error.format_message(), error.exit_code)
    except (KeyboardInterrupt, typer.Abort):
        return _end("interrupted", INTERRUPTED)
    except BrokenPipeError:
        # The reader has seen enough, as `head` has; what is still buffered must not fail at the exit.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except Exception as error:
        if os.environ.get("DEXTERITY_TRACEBACK"):
            raise
        return _end(
            _one_line(error), BAD_INPUT if isinstance(error, ValueError | TypeError | OSError) else FAILED
        )


def _end(message: str, code: int) -> int:
    # Help without a subcommand is an error without a message.
    if message:
        say(f"dexterity: {message}")
    return code


def _one_line(error: Exception) -> str:
    text = " ".join(str(error).split()) or type(error).__name__
    if isinstance(error, OSError) and error.filename is not None:
        return f"{error.filename}: {error.strerror}"
    return text


def _version(wanted: bool | None) -> None:
    if wanted:
        typer.echo(f"dexterity {dexterity.__version__}")
        raise typer.Exit


@application.callback()
def _all(
    version: Annotated[
        bool | None,
        typer.Option("--version", callback=_version, is_eager=True, help="Show the version and exit."),
    ] = None,
) -> None:
    pass


INDEX = "Name or alias of an index, as `dexterity indices` lists them."


def _examples(*lines: str) -> str:
    return "\n\n".join(["Examples:", *(f"  dexterity {line}" for line in lines)])


@application.command(
    epilog=_examples("robots", "robots panda", "robots my_arm.urdf --base base_link --tip flange --json")
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


@application.command(epilog=_examples("indices", "indices kci"))
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
    epilog=_examples(
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
    epilog=_examples(
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
    epilog=_examples(
        "ik panda --pose 0.4,0,0.5,pi,0,0",
        "ik ur5e --poses weld.csv --near 0,-pi/2,pi/2,0,pi/2,0 --csv",
        "ik arm.urdf --pose 0.3,0.1,0.2 --rows translational",
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
    from dexterity.command.typed import numbers

    chain = robot.chain()
    report, reached = reaching.inverse_kinematics(
        chain,
        poses.read(),
        beyond_limits=beyond_limits,
        rows=inputs.rows(rows),
        near=None if near is None else numbers(near, "--near", chain.joints),
        seeds=seeds,
        limit_tolerance=limit_tolerance,
    )
    form.give(report)
    return 0 if reached else NEGATIVE


@application.command(
    name="map",
    epilog=_examples(
        "map ur5e --rotations 72 --index kci --to ur5e.npz",
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
    index: Annotated[str | None, typer.Option("--index", help="Index by which poses are valued.")] = None,
    method: Annotated[str, typer.Option("--method", help="auto, closed form, search or sampling.")] = "auto",
    rows: Annotated[
        str, typer.Option("--rows", help="Rows of the tool's pose that must fit, such as translational.")
    ] = "full",
    seed: Annotated[int, typer.Option("--seed", min=0, help="Seed of all draws.")] = 0,
    threads: Annotated[
        int | None, typer.Option("--threads", min=1, help="All processors by default.")
    ] = None,
    go_on: Annotated[
        bool, typer.Option("--continue", help="Go on from the unfinished map in the file.")
    ] = False,
    form: ReportOptions,
) -> int:
    """Survey positions and rotations of the tool: what is in reach, and how well.

    Ctrl-C ends the survey; the map of what is finished is written, with exit code 130.
    """
    from dexterity.command import inputs, reaching
    from dexterity.command.progress import Bar

    require_file("--to", to, ".npz")
    chain = robot.chain()
    where = reaching.positions(chain, lower, upper, spacing)
    with Bar("poses") as bar:
        report, finished = reaching.reach_map(
            chain,
            where,
            rotations,
            to,
            go_on,
            index=index,
            method=method,
            rows=inputs.rows(rows),
            seed=seed,
            threads=threads,
            progress=bar,
        )
    form.give(report)
    return 0 if finished else INTERRUPTED


@application.command(
    epilog=_examples(
        "place ur5e --seam=-0.25,0,0,0.25,0,0 --x=-0.4:0.4:5 --y=-0.7:-0.35:3 --yaw 0:pi/2:2",
        "place panda --poses valves.csv --x=-1:0:11 --y 0 --index w --by mean --csv",
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
    refine: Annotated[bool, typer.Option(help="Improve the best base between the candidates.")] = True,
    best: Annotated[int, typer.Option("--best", min=1, help="How many bases are listed.")] = 10,
    seed: Annotated[int, typer.Option("--seed", min=0, help="Seed of all draws.")] = 0,
    form: ReportOptions,
) -> int:
    """Compare places for the base by what the robot does from there. Exit code 1 if none reaches all poses.

    Ctrl-C ends the comparison; the bases that were looked at are listed, with exit code 130.
    """
    from dexterity.command import reaching
    from dexterity.command.progress import Bar

    chain = robot.chain()
    wanted = poses.read() if seam is None else reaching.seam(seam, count, tool)
    with Bar("bases") as bar:
        report, found = reaching.placements(
            chain, wanted, x, y, yaw, height, best, index=index, by=by, refine=refine, seed=seed, progress=bar
        )
    form.give(report)
    if not bool(found.examined.all()):
        return INTERRUPTED
    return 0 if bool((found.reached == len(wanted)).any()) else NEGATIVE


@application.command(
    epilog=_examples(
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
    epilog=_examples(
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
    epilog=_examples(
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
