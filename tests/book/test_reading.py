"""How far a reader has to go: length, picture, advice and code of a chapter; tables on a phone; barriers."""

import re
from importlib import resources
from statistics import median
from typing import Any

import pytest
from built_book import CHAPTERS, HTML, PAGES
from playwright.sync_api import Browser
from visit import visit

from dexterity import store

SCREEN = (1366, 900)
NARROW = (360, 800)
MOST_SCREENS, MOST_LINES, MOST_PRINTED = 8, 40, 8
SUMMARIES = [page for page in PAGES if page.endswith("/summary")]
AXE = (resources.files("axe_playwright_python") / "axe.min.js").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def measured(browser: Browser, served_root: str) -> dict[str, dict[str, Any]]:
    """Measures of all chapters, also kept as a table in `_build/reading.txt`."""
    found = {}
    for page in CHAPTERS:
        with visit(browser, served_root, page) as visited:
            visited.resize(SCREEN)
            visited.page.evaluate("checks.untypesetFormulas()")
            found[page] = visited.page.evaluate("checks.reading()")
    lines = [f"{'chapter':28} screens  picture at  advice at  lines of code"] + [
        f"{page:28} {own['screens']:7.1f} {own['picture']:8} px {own['advice']:7} px {own['lines']:8}"
        for page, own in found.items()
    ]
    lines.append(f"median: {median(own['screens'] for own in found.values()):.1f} screens")
    # Printed by `make check`, since the workers of pytest-xdist print nothing.
    store.write_atomically(HTML.parent / "reading.txt", "\n".join(lines) + "\n")
    return found


def test_a_chapter_is_short(measured: dict[str, dict[str, Any]]) -> None:
    assert median(own["screens"] for own in measured.values()) <= MOST_SCREENS


@pytest.mark.parametrize("page", CHAPTERS)
def test_a_chapter_begins_with_its_answer(measured: dict[str, dict[str, Any]], page: str) -> None:
    own = measured[page]
    assert own["picture"] < SCREEN[1], "no picture begins on the first screen"
    assert own["advice"] < 2 * SCREEN[1], "the advice does not begin on the first two screens"
    assert own["lines"] <= MOST_LINES, "more code is shown"


@pytest.mark.parametrize("page", SUMMARIES)
def test_a_summary_is_two_screens_at_most(browser: Browser, served_root: str, page: str) -> None:
    with visit(browser, served_root, page) as visited:
        visited.resize(SCREEN)
        assert visited.page.evaluate("checks.reading().screens") <= 2


@pytest.mark.parametrize("page", PAGES)
def test_tables_show_a_result_on_a_narrow_phone(browser: Browser, served_root: str, page: str) -> None:
    with visit(browser, served_root, page) as visited:
        visited.resize(NARROW)
        hidden = visited.page.evaluate("checks.tablesWithoutResults()")
    assert not hidden, f"{page}: no result column is on the screen in {hidden}"


@pytest.mark.parametrize("page", CHAPTERS)
def test_captions_are_numbered(browser: Browser, served_root: str, page: str) -> None:
    with visit(browser, served_root, page) as visited:
        assert visited.page.evaluate("checks.withoutCaption()") == []


@pytest.mark.parametrize("page", CHAPTERS)
def test_a_chapter_prints_on_few_pages(browser: Browser, served_root: str, page: str) -> None:
    with visit(browser, served_root, page) as visited:
        visited.page.evaluate("checks.untypesetFormulas()")
        printed = visited.page.pdf(
            format="A4", margin=dict.fromkeys(("top", "bottom", "left", "right"), "15mm")
        )
    assert len(re.findall(rb"/Type\s*/Page\b", printed)) <= MOST_PRINTED


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("page", [*PAGES, "search"])
def test_no_serious_barrier(browser: Browser, served_root: str, page: str, scheme: str) -> None:
    with visit(browser, served_root, page, scheme) as visited:
        visited.page.evaluate("checks.untypesetFormulas()")
        visited.page.evaluate(AXE)
        found = visited.page.evaluate(
            "axe.run(document, {resultTypes: ['violations'], iframes: false})"
            ".then(result => result.violations.filter(one => ['serious', 'critical'].includes(one.impact)))"
        )
    barriers = [f"{one['id']}: {one['nodes'][0]['html'][:200]}" for one in found]
    assert not barriers, f"{page}, {scheme}: {barriers}"
