"""The system's C compiler: which one it is, and how it is run.

Examples
--------
>>> from dexterity.codegen.compiler import words_of
>>> words_of("gcc -O2"), words_of("  ")
(['gcc', '-O2'], [])
"""

from __future__ import annotations

import os
import shlex
import shutil
import signal
import subprocess
from collections.abc import Sequence

__all__ = ["CompilationFailed", "command", "run", "words_of"]

PATIENCE = 600.0
"""Seconds after which a compiler that has not ended is stopped."""


class CompilationFailed(RuntimeError):  # noqa: N818  # as it reads in an except clause
    """There is no compiler, it refused its work, or what it made computes something else."""


def command() -> list[str]:
    """Return how the compiler is called: ``$CC``, or one of ``cc``, ``gcc`` and ``clang``.

    Raises
    ------
    CompilationFailed
        If there is none.
    """
    named = os.environ.get("CC", "")
    for words in [words_of(named)] if named.strip() else [["cc"], ["gcc"], ["clang"]]:
        if words and shutil.which(words[0]):
            return words
    tried = f"CC is {named!r}" if named.strip() else "cc, gcc and clang were tried"
    raise CompilationFailed(
        f'there is no C compiler ({tried}): install one, or use backend="torch", which needs none'
    )


def words_of(named: str) -> list[str]:
    """Return a command's words as a shell would separate them; a program's path may hold spaces."""
    if shutil.which(named):
        return [named]
    try:
        return shlex.split(named)
    except ValueError:  # a quotation mark without its partner
        return named.split()


def run(words: Sequence[str]) -> str:
    """Run a compiler, and return what it printed.

    Raises
    ------
    CompilationFailed
        If it fails, or has not ended after ten minutes.
    """
    try:
        process = subprocess.Popen(  # noqa: S603
            words,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
    except OSError as error:
        raise CompilationFailed(f"{words[0]} cannot be run: {error}") from error
    try:
        output, _ = process.communicate(timeout=PATIENCE)
    except BaseException as error:
        # With all that it has started itself, which otherwise would keep its output open.
        if hasattr(os, "killpg"):
            os.killpg(process.pid, signal.SIGKILL)
        process.kill()
        process.communicate()
        if not isinstance(error, subprocess.TimeoutExpired):
            raise
        raise CompilationFailed(f"{words[0]} was stopped after {PATIENCE:g} s without an end") from error
    text = output.decode("utf-8", errors="replace")
    if process.returncode != 0:
        raise CompilationFailed(f"{words[0]} failed with status {process.returncode}: {_last_lines(text)}")
    return text


def _last_lines(text: str) -> str:
    return "\n".join(text.strip().splitlines()[-20:]) or "it printed nothing"
