"""Pages as notebooks: read from the text of the book, and kept with their outputs once executed.

An executed notebook carries the key of all that can change its outputs. Prose is no part of the key; an edit
of prose renews the text around the stored outputs.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import nbformat
import yaml
from myst_nb.core.read import is_myst_markdown_notebook, read_myst_markdown_notebook
from myst_parser.config.main import MdParserConfig
from nbformat import NotebookNode
from sphinx_external_toc.parsing import parse_toc_yaml

from dexterity import store
from dexterity_study.page.dependencies import page_key


@dataclass(frozen=True)
class Layout:
    """Folders and files of a build.

    Attributes
    ----------
    book, config
        Folder of the pages with its `_toc.yml`, and the settings of the book.
    output
        Folder of everything that is built.
    """

    book: Path
    config: Path
    output: Path

    @property
    def html(self) -> Path:
        """Folder of the pages for a browser."""
        return self.output / "html"

    @property
    def executions(self) -> Path:
        """Folder of the pages as they were executed."""
        return self.output / "executed"

    @property
    def durations(self) -> Path:
        """File of how long each page took."""
        return self.output / "durations.json"

    def source(self, page: str) -> Path:
        """Return the file that a page is written in."""
        return self.book / f"{page}.md"

    def executed(self, page: str) -> Path:
        """Return the file of a page's executed notebook."""
        return self.executions / f"{page}.ipynb"

    def pages(self) -> list[str]:
        """Return the pages of the table of contents, in its order."""
        return list(parse_toc_yaml(self.book / "_toc.yml"))


@dataclass(frozen=True)
class Page:
    """A page with code cells.

    Attributes
    ----------
    name
        Path below the book's folder, without suffix.
    notebook
        Prose and code cells, without outputs.
    lines
        Line of the source at which each cell begins.
    key
        Digest of everything that can change the outputs.
    """

    name: str
    notebook: NotebookNode
    lines: tuple[int, ...]
    key: str


def read_pages(layout: Layout, names: Iterable[str]) -> list[Page]:
    """Read those of the named pages that have code cells."""
    settings = yaml.safe_load(layout.config.read_text("utf-8"))
    extensions = settings["sphinx"]["config"]["myst_enable_extensions"]
    syntax = MdParserConfig(enable_extensions=set(extensions))
    return list(_read_pages(layout, names, syntax))


def _read_pages(layout: Layout, names: Iterable[str], syntax: MdParserConfig) -> Iterator[Page]:
    for name in names:
        text = layout.source(name).read_text("utf-8")
        if not is_myst_markdown_notebook(text):
            continue
        notebook = read_myst_markdown_notebook(
            text, config=syntax, add_source_map=True, path=layout.source(name)
        )
        lines = tuple(line + 1 for line in notebook.metadata.pop("source_map"))
        for number, cell in enumerate(notebook.cells):
            cell.id = f"cell-{number}"  # nbformat draws it otherwise
        yield Page(name, notebook, lines, page_key(name, notebook))


def read_executed(layout: Layout, page: Page) -> NotebookNode | None:
    """Return the stored outputs with the page's present prose, or None if they are of another key or damaged."""
    try:
        stored = nbformat.reads(store.read_bytes(layout.executed(page.name)).decode(), as_version=4)
        if stored.metadata["dexterity"]["key"] != page.key:
            return None
        outputs = [cell for cell in stored.cells if cell.cell_type == "code"]
        notebook = nbformat.from_dict(page.notebook)
        cells = [cell for cell in notebook.cells if cell.cell_type == "code"]
        for cell, executed in zip(cells, outputs, strict=True):
            cell.outputs, cell.execution_count = executed.outputs, executed.execution_count
        notebook.metadata.update(stored.metadata)
    except (FileNotFoundError, ValueError, LookupError, TypeError, AttributeError, RecursionError):
        return None
    return notebook


def write_executed(layout: Layout, page: Page, notebook: NotebookNode) -> None:
    """Write an executed notebook with its key, if that changes the file."""
    notebook.metadata = nbformat.from_dict(_metadata(page, notebook.metadata))
    text = nbformat.writes(notebook) + "\n"
    path = layout.executed(page.name)
    if not path.is_file() or path.read_bytes() != text.encode():
        path.parent.mkdir(parents=True, exist_ok=True)
        store.write_atomically(path, text)


def _metadata(page: Page, executed: dict[str, Any]) -> dict[str, Any]:
    kept: dict[str, Any] = {name: executed[name] for name in ("language_info", "widgets") if name in executed}
    kernel = {"name": "python3", "display_name": "Python 3", "language": "python"}
    return {"kernelspec": kernel, **kept, "dexterity": {"page": page.name, "key": page.key}}


def remove_strays(layout: Layout, pages: Iterable[Page]) -> None:
    """Remove the executed notebooks of pages that are no longer in the book."""
    wanted = {layout.executed(page.name) for page in pages}
    for file in layout.executions.rglob("*.ipynb"):
        if file not in wanted:
            file.unlink()
