"""Runs of the command in this process, for tests."""

import pytest

from dexterity.command import main


def ask(capsys: pytest.CaptureFixture[str], *words: object, code: int = 0) -> str:
    """Run the command, and return what it prints."""
    capsys.readouterr()
    assert main([str(word) for word in words]) == code, capsys.readouterr().err
    return capsys.readouterr().out


def refusal(capsys: pytest.CaptureFixture[str], *words: object, code: int = 2) -> str:
    """Run the command, and return its one line of complaint."""
    capsys.readouterr()
    assert main([str(word) for word in words]) == code
    said = capsys.readouterr()
    assert said.out == ""
    assert len(said.err.splitlines()) == 1, said.err
    assert "Traceback" not in said.err
    return said.err
