"""Every page in a real browser, from a file and from a server, light and dark, at desktop and phone width.

From a file and without a network: jupyter-book#1003, #2630, bookdown#353, drake#18342.
"""

from urllib.parse import unquote, urlsplit

import pytest
from built_book import HTML, PAGES, SHARED, html_file
from playwright.sync_api import Browser
from visit import DESKTOP, PHONE, visit

from dexterity_study.claims.outcome import Outcome

MEGABYTE = 1_000_000


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("page", [*PAGES, "search", "genindex"])
def test_page_loads_typesets_and_fits(browser: Browser, root: str, page: str, scheme: str) -> None:
    with visit(browser, root, page, scheme) as visited:
        shown = visited.page.evaluate("document.documentElement.dataset.theme")
        problems = [] if shown == scheme else [f"is shown {shown} to a reader who asked for {scheme}"]
        problems += visited.page.evaluate("checks.untypesetFormulas()")
        for size in (DESKTOP, PHONE):
            visited.resize(size)
            problems += visited.page.evaluate("checks.wideElements()")
        visited.settle()
        problems += visited.problems
    assert not problems, _listed(page, problems)


def test_search_finds_a_word_of_the_book(browser: Browser, root: str) -> None:
    with visit(browser, root, "search?q=manipulability") as visited:
        visited.page.locator("#search-results li a").first.wait_for()
        visited.settle()
        assert not visited.problems, _listed("search", visited.problems)


@pytest.mark.parametrize("word", ["manipulability", "KCI", "docking", "workspace", "sag"])
def test_search_answers_with_prose_first_and_shows_how_a_page_begins(
    browser: Browser, root: str, word: str
) -> None:
    with visit(browser, root, f"search?q={word}") as visited:
        first = visited.page.locator("#search-results li").first
        first.locator(".lead").wait_for()
        target = first.locator("a").first.get_attribute("href") or ""
    assert not target.startswith("reference/api"), f"{word}: {target} comes first"


@pytest.mark.parametrize("page", PAGES)
def test_page_weight(browser: Browser, served_root: str, page: str) -> None:
    with visit(browser, served_root, page) as visited:
        visited.page.evaluate("window.scrollTo(0, document.body.scrollHeight)")
        visited.settle()
        weights = {html_file(page): html_file(page).stat().st_size}
        for url in visited.requests:
            name = unquote(urlsplit(url).path).lstrip("/")
            if url.startswith(served_root) and not name.startswith(SHARED):
                weights[HTML / name] = (HTML / name).stat().st_size
    total = sum(weights.values())
    assert total <= 3 * MEGABYTE, f"{page} weighs {total / MEGABYTE:.1f} MB: {weights}"


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_verdicts_are_legible(browser: Browser, served_root: str, scheme: str) -> None:
    with visit(browser, served_root, "reference/scorecard", scheme) as visited:
        for outcome in Outcome:
            css_class = f"verdict-{outcome.replace(' ', '-')}"
            shown = visited.page.evaluate("css_class => checks.verdict(css_class)", css_class)
            assert shown["styled"], f"book.css has no colours for .{css_class}"
            assert shown["contrast"] >= 4.5, (
                f".{css_class} in the {scheme} scheme: contrast {shown['contrast']:.2f}"
            )


def _listed(page: str, problems: list[str]) -> str:
    return "\n".join([f"{page}:", *(f"  {problem}" for problem in problems)])
