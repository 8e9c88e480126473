"""The command with all its subcommands: how its words are run, and how each error ends.

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

import typer
from typer.main import get_command

# Subcommands enter the application when their modules are imported.
from dexterity.command import questions, results  # noqa: F401
from dexterity.command.reports import say
from dexterity.command.shell import BAD_INPUT, FAILED, INTERRUPTED, application

__all__ = ["application", "run"]


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
