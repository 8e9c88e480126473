"""Executed notebooks as they are downloaded: in plain Markdown, with captions as text, for any Jupyter.

The book writes its pages in MyST. Here directives become paragraphs, and references what they name: "Figure 1.2",
the title of a chapter, the authors and the year of a source.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import nbformat
from nbformat import NotebookNode
from sphinx.environment import BuildEnvironment

_ROLE = re.compile(r"\{(?P<role>[a-z:]+)\}`(?P<text>[^`]+)`")
_FENCE = re.compile(r"(?P<fence>`{3,}|:{3,})\{(?P<name>[\w-]+)\}\s*(?P<title>.*)")
_OPTION = re.compile(r":(?P<name>[\w-]+):\s*(?P<value>.*)")
_TARGET = re.compile(r"\([\w-]+\)=")
_LINK = re.compile(r'<a\b[^>]*\bhref="(?:#|\.\./|[\w/]+\.html)[^>]*>(.*?)</a>', re.DOTALL)


@dataclass(frozen=True)
class References:
    """What references name, as Sphinx has numbered it.

    Attributes
    ----------
    env
        Environment of a build that has read all pages.
    glued
        Texts that the cells of the page have put under a name.
    """

    env: BuildEnvironment
    glued: Mapping[str, str] = field(default_factory=dict)

    def text(self, page: str, role: str, text: str) -> str:
        """Return what a reference on a page reads as."""
        named: Mapping[str, Callable[[], str]] = {
            "doc": lambda: self._title(page, text),
            "numref": lambda: self.number(text),
            "ref": lambda: f'"{self.env.domaindata["std"]["labels"][text][2]}"',
            "eq": lambda: f"({self.equation(text)})",
            "glue:text": lambda: self.glued[text],
            "term": lambda: text.partition("<")[0].strip(),
            "cite:t": lambda: self._cited(text, "{authors} ({year})"),
            "cite:p": lambda: f"({self._cited(text, '{authors}, {year}')})",
        }
        if role not in named:
            raise ValueError(
                f"{page}: the notebook cannot show the role {role!r}; it knows {', '.join(named)}"
            )
        return named[role]()

    def number(self, label: str) -> str:
        """Return the number of a figure or a table, such as "Figure 1.2"."""
        page, anchor, *_ = self.env.domaindata["std"]["anonlabels"][label]
        for kind, numbers in self.env.toc_fignumbers[page].items():
            if anchor in numbers:
                return f"{kind.capitalize()} {'.'.join(map(str, numbers[anchor]))}"
        raise ValueError(f"{label} has no number")

    def equation(self, label: str) -> str:
        """Return the number of an equation, such as "1.2"."""
        page, _ = self.env.domaindata["math"]["objects"][label]
        return ".".join(map(str, self.env.toc_fignumbers[page]["displaymath"][f"equation-{label}"]))

    def _title(self, page: str, text: str) -> str:
        written, _, target = text.rpartition("<")
        if written:
            return written.strip()
        document, _ = self.env.relfn2path(target, page)
        return f'"{self.env.titles[document].astext()}"'

    def _cited(self, keys: str, form: str) -> str:
        entries = {one.key: one.entry for one in self.env.get_domain("cite").citations}  # type: ignore[attr-defined]
        return "; ".join(
            form.format(authors=_authors(entries[key.strip()]), year=entries[key.strip()].fields["year"])
            for key in keys.split(",")
        )


def _authors(entry: Any) -> str:
    names = [" ".join(person.last_names) for person in entry.persons["author"]]
    return f"{names[0]} et al." if len(names) > 2 else " and ".join(names)


def plain(
    notebook: NotebookNode, page: str, references: References, live: Callable[[str], str]
) -> NotebookNode:
    """Return an executed notebook for any Jupyter.

    Parameters
    ----------
    notebook
        Page of the book as it was executed.
    page
        Its name.
    references
        What its references name.
    live
        Turns the HTML of an output that needs the book's files into one that stands alone.
    """
    references = replace(references, glued=_glued(notebook))
    cells = [cell for source in notebook.cells for cell in _cells(source, page, references, live)]
    for number, cell in enumerate(cells):
        cell["id"] = f"cell-{number}"
    metadata = {name: value for name, value in notebook.metadata.items() if name != "dexterity"}
    return nbformat.from_dict({**notebook, "cells": cells, "metadata": metadata})


def _glued(notebook: NotebookNode) -> dict[str, str]:
    outputs = (output for cell in notebook.cells for output in cell.get("outputs", ()))
    kept = [(output.get("metadata", {}).get("scrapbook"), output) for output in outputs]
    return {
        note["name"]: str(ast.literal_eval(output["data"][f"{note.get('mime_prefix', '')}text/plain"]))
        for note, output in kept
        if note
    }


def _cells(
    cell: NotebookNode, page: str, references: References, live: Callable[[str], str]
) -> Iterator[NotebookNode]:
    if cell.cell_type != "code":
        yield nbformat.from_dict({**cell, "source": markdown(cell.source, page, references), "metadata": {}})
        return
    shown = nbformat.from_dict({**cell, "metadata": {}})
    for output in shown.outputs:
        if "text/html" in output.get("data", {}):
            output.data["text/html"] = live(_LINK.sub(r"\1", output.data["text/html"]))
    yield shown
    figure = cell.metadata.get("mystnb", {}).get("figure", {})
    if figure:
        caption = " ".join(figure["caption"].split())
        text = f"**{references.number(figure['name'])}.** {_roles(caption, page, references)}"
        yield nbformat.v4.new_markdown_cell(text)


def markdown(text: str, page: str, references: References) -> str:
    """Return MyST as plain Markdown."""
    return "\n".join(_lines(text.splitlines(), page, references))


def _lines(lines: Sequence[str], page: str, references: References) -> Iterator[str]:
    waiting = iter(lines)
    for line in waiting:
        start = _FENCE.fullmatch(line)
        if start is not None:
            inner = list(iter(waiting.__next__, start["fence"]))
            yield from _directive(start["name"], start["title"], inner, page, references)
        elif line.startswith("```"):
            yield line
            yield from iter(waiting.__next__, "```")
            yield "```"
        elif not _TARGET.fullmatch(line):
            yield _roles(line, page, references)


def _directive(name: str, title: str, inner: list[str], page: str, references: References) -> Iterator[str]:
    options = {}
    while inner and (option := _OPTION.fullmatch(inner[0])):
        options[option["name"]] = option["value"]
        del inner[0]
    if name == "math":
        tag = rf" \tag{{{references.equation(options['label'])}}}" if "label" in options else ""
        yield from ("$$", *inner, *filter(None, [tag]), "$$")
        return
    if title:
        number = f"{references.number(options['name'])}. " if "name" in options else ""
        yield from (f"**{number}{_roles(title, page, references)}**", "")
    yield from _lines(inner, page, references)


def _roles(line: str, page: str, references: References) -> str:
    return _ROLE.sub(lambda role: references.text(page, role["role"], role["text"]), line)
