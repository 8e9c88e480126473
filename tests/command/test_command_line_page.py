"""The page of the command line: each line that it shows prints what stands below it."""

import io
import re
import shlex

import pytest

from dexterity import store
from dexterity.command import main
from dexterity.command.application import application
from markdown_blocks import Block, blocks, difference

PAGE = store.repository() / "book" / "reference" / "command_line.md"
BLOCKS = [block for block in blocks(PAGE) if block.language == "console"]


@pytest.mark.parametrize("block", BLOCKS, ids=lambda block: block.code.strip()[:60])
def test_a_line_prints_what_the_page_shows(block: Block, capsys, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    for line in block.code.replace("\\\n", " ").splitlines():
        assert line.startswith("$ ")
        words = shlex.split(line.removeprefix("$ "))
        if words[0] == "printf":
            assert words[2] == ">"
            (tmp_path / words[3]).write_text(words[1].replace("\\n", "\n"), encoding="utf-8")
            continue
        if words[0] == "echo":
            assert words[2:4] == ["|", "dexterity"]
            monkeypatch.setattr("sys.stdin", io.StringIO(words[1]))
            words = words[3:]
        assert words[0] == "dexterity"
        assert main(words[1:]) in (0, 1)
    assert not (text := difference(block, capsys.readouterr().out)), text


def test_each_subcommand_is_in_the_table_and_shown():
    names = {command.name or command.callback.__name__ for command in application.registered_commands}
    text = PAGE.read_text(encoding="utf-8")
    assert set(re.findall(r"^\| `(\w+)` \|", text, re.MULTILINE)) == names
    assert {re.search(r"dexterity (\w+)", block.code).group(1) for block in BLOCKS} == names
