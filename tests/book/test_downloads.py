"""Executed notebooks that the pages offer: one for each page with code, and all of them in one archive.

What MyST-NB#124, sphinx-book-theme#639, #918 and nbsphinx#548 ask for.
"""

import re
import zipfile
from concurrent.futures import ThreadPoolExecutor

import nbformat
import pytest
from built_book import CHAPTERS, HTML, PAGES, Document, html_file, source_text
from playwright.sync_api import Browser
from visit import visit

from dexterity import scenes
from dexterity_study.page.execution import Execution

WITH_CODE = [page for page in PAGES if "{code-cell}" in source_text(page)]
FIRST_OF_PARTS = list({page.partition("/")[0]: page for page in reversed(CHAPTERS)}.values())


@pytest.mark.parametrize("page", WITH_CODE)
def test_page_offers_its_executed_notebook(page: str) -> None:
    file = HTML / "notebooks" / f"{page}.ipynb"
    targets = [(html_file(page).parent / link).resolve() for link in Document.of(page).links]
    assert file in targets
    assert HTML / "notebooks.zip" in targets
    notebook = nbformat.read(file, as_version=4)
    nbformat.validate(notebook)
    code = [cell for cell in notebook.cells if cell.cell_type == "code"]
    assert [cell.execution_count for cell in code] == list(range(1, len(code) + 1))
    assert any(cell.outputs for cell in code)
    assert all(output.output_type != "error" for cell in code for output in cell.outputs)


def test_archive_holds_all_notebooks() -> None:
    with zipfile.ZipFile(HTML / "notebooks.zip") as archive:
        packed = {name: archive.read(name) for name in archive.namelist()}
    assert packed == {f"notebooks/{page}.ipynb": _notebook(page) for page in WITH_CODE}


def test_start_page_links_the_archive() -> None:
    assert "notebooks.zip" in Document.of("index").links


@pytest.mark.parametrize("page", FIRST_OF_PARTS)
def test_downloaded_notebook_runs_as_it_is(browser: Browser, served_root: str, page: str) -> None:
    with visit(browser, served_root, page) as visited:
        visited.page.locator(".dropdown-download-buttons > button").click()
        with visited.page.expect_download() as download:
            visited.page.locator(".btn-download-notebook-button").click()
        text = download.value.path().read_bytes()
    assert text == _notebook(page)
    _run(text)


@pytest.mark.parametrize("page", [page for page in WITH_CODE if page not in FIRST_OF_PARTS])
def test_notebook_runs_as_it_is(page: str) -> None:
    _run(_notebook(page))


@pytest.mark.parametrize("page", WITH_CODE)
def test_notebook_is_plain_markdown_with_live_scenes(page: str) -> None:
    notebook = nbformat.reads(_notebook(page).decode(), as_version=4)
    prose = "\n".join(cell.source for cell in notebook.cells if cell.cell_type == "markdown")
    assert not re.search(r"\{[a-z:]+\}`|^(?:```|:::)\{", prose, flags=re.MULTILINE)
    shown = [
        output.data["text/html"]
        for cell in notebook.cells
        if cell.cell_type == "code"
        for output in cell.outputs
        if "text/html" in output.get("data", {})
    ]
    for html in shown:
        assert html == scenes.standalone(html), "a scene needs the viewer of the book"


def _run(notebook: bytes) -> None:
    execution = Execution(nbformat.reads(notebook.decode(), as_version=4), hung_after=600)
    # In a thread, because the browser's loop may run in this one.
    with ThreadPoolExecutor(1) as pool:
        pool.submit(execution.run).result()


def _notebook(page: str) -> bytes:
    return (HTML / "notebooks" / f"{page}.ipynb").read_bytes()
