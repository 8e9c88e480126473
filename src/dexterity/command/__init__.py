"""The command ``dexterity``: the library from a shell.

It reads a robot of the package, a URDF or a robot file, and configurations from arguments, a file or standard
input; it answers with a table, CSV or JSON.

====  =============================================================================
exit  meaning
====  =============================================================================
0     an answer
1     a negative answer: a pose out of reach, a network that misses its goal
2     an argument or a file that cannot be used; the message names it
3     a machine that fails, such as one without a C compiler
130   Ctrl-C; what is finished is written
====  =============================================================================

The package installs it with the extra ``command``.

Examples
--------
>>> from dexterity.command import main
>>> q = "0,0.5,0.25,0,0.5,0"
>>> main(["evaluate", "puma560", "manipulability", "--q", q, "--csv"])
configuration,manipulability
0,0.0087178561...
0
"""

from __future__ import annotations

import sys
from collections.abc import Sequence

from dexterity import checks

__all__ = ["main"]


@checks.arguments(arguments=checks.OrNone(checks.Each(checks.Instance(str))))
def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command and return its exit code.

    Parameters
    ----------
    arguments
        Words after ``dexterity``; those of the process by default.

    Returns
    -------
    0, 1, 2, 3 or 130, as the module says.
    """
    try:
        from dexterity.command.application import run
    except ModuleNotFoundError as error:
        # A fault in the package is a fault, and no missing extra.
        if (error.name or "").partition(".")[0] not in {"typer", "rich"}:
            raise
        sys.stderr.write(
            f"dexterity: the command needs {error.name}, which is not installed. "
            "Install it with the extra: pip install 'dexterity-study[command]'\n"
        )
        return 3
    return run(list(sys.argv[1:] if arguments is None else arguments))
