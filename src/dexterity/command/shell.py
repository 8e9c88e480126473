"""The typer application, its exit codes, and what all subcommands share.

Examples
--------
>>> from dexterity.command.shell import examples
>>> examples("robots", "robots panda").splitlines()
['Examples:', '', '  dexterity robots', '', '  dexterity robots panda']
"""

from __future__ import annotations

from typing import Annotated

import typer

import dexterity

__all__ = ["BAD_INPUT", "FAILED", "INDEX", "INTERRUPTED", "NEGATIVE", "application", "examples"]

NEGATIVE, BAD_INPUT, FAILED, INTERRUPTED = 1, 2, 3, 130
"""Exit codes: a negative answer, an unusable argument or file, a machine that fails, and Ctrl-C."""

INDEX = "Name or alias of an index, as `dexterity indices` lists them."
"""Help of an argument."""

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


def examples(*lines: str) -> str:
    """Return the lower part of a subcommand's help."""
    return "\n\n".join(["Examples:", *(f"  dexterity {line}" for line in lines)])
