"""Blocks of code in Markdown, and what they print: a fence of code, and at once a fence of text."""

from __future__ import annotations

import doctest
import re
from dataclasses import dataclass
from pathlib import Path

FENCE = re.compile(r"^```(python|console|text)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
HEADING = re.compile(r"^#+ (.*)$", re.MULTILINE)


@dataclass(frozen=True)
class Block:
    """Code under a heading, and the text that it is said to print, if any is."""

    heading: str
    language: str
    code: str
    printed: str | None


def blocks(path: Path) -> list[Block]:
    """Return the blocks of code of a page, in order."""
    text = path.read_text(encoding="utf-8")
    found: list[Block] = []
    for fence in FENCE.finditer(text):
        language, content = fence.groups()
        if language != "text":
            # A comment in code looks like a heading.
            before = FENCE.sub("", text[: fence.start()])
            heading = (HEADING.findall(before) or [""])[-1]
            found.append(Block(heading, language, content, None))
        elif found and not text[: fence.start()].rpartition("```\n")[2].strip():
            found[-1] = Block(found[-1].heading, found[-1].language, found[-1].code, content)
    return found


def difference(block: Block, printed: str) -> str:
    """Return how the output differs from the page; ``...`` on the page stands for anything."""
    if block.printed is None:
        return ""
    flags = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
    checker = doctest.OutputChecker()
    if checker.check_output(block.printed, printed, flags):
        return ""
    example = doctest.Example(block.code, block.printed)
    return f"{block.heading}:\n{checker.output_difference(example, printed, flags)}"


RUNNER = """
import contextlib, io, json, os, tempfile, traceback

results = []
for section in SECTIONS:
    names, printed = {"__name__": "section"}, []
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        try:
            for code in section:
                with contextlib.redirect_stdout(io.StringIO()) as output:
                    exec(compile(code, "section", "exec"), names)
                printed.append(output.getvalue())
        except Exception:
            printed.append(traceback.format_exc())
    results.append(printed)
print(json.dumps(results))
"""
"""Program that runs SECTIONS, lists of code that share their names, in an empty folder each.

It prints what each piece of code printed. Pages are run by a process of their own, without the checks of
annotations that the tests switch on: torch cannot compile those.
"""


def sections(path: Path, language: str = "python") -> dict[str, list[Block]]:
    """Return the blocks of a page by their headings."""
    found: dict[str, list[Block]] = {}
    for block in blocks(path):
        if block.language == language:
            found.setdefault(block.heading, []).append(block)
    return found
