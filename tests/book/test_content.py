"""What the built pages say and link to, and the files that the book ships."""

import hashlib
import importlib
import pkgutil
import re
from functools import cache
from html import unescape
from pathlib import Path
from types import ModuleType
from urllib.parse import unquote, urlsplit

import pytest
from built_book import CHAPTERS, HTML, PAGES, SOURCE, Document, html_file, source_text
from playwright.sync_api import Browser
from visit import visit

import dexterity
from dexterity_study.claims import ledger, scorecard

MEGABYTE = 1_000_000
API_PAGES = [page for page in PAGES if page.startswith("reference/api")]
MATHJAX = SOURCE / "assets" / "mathjax"


def test_book_size() -> None:
    size = sum(file.stat().st_size for file in HTML.rglob("*") if file.is_file())
    assert size <= 60 * MEGABYTE, f"the built book has {size / MEGABYTE:.1f} MB"


def test_mathjax_is_the_published_one() -> None:
    lines = (MATHJAX / "SHA256SUMS").read_text(encoding="utf-8").splitlines()
    listed = {name: digest for digest, name in (line.split(maxsplit=1) for line in lines)}
    shipped = {
        f"./{file.relative_to(MATHJAX).as_posix()}": hashlib.sha256(file.read_bytes()).hexdigest()
        for file in MATHJAX.rglob("*")
        if file.is_file() and file.name not in ("README.md", "SHA256SUMS")
    }
    assert shipped == listed


# ---- links, anchors, images ----


@pytest.mark.parametrize("page", PAGES)
def test_internal_links_resolve(page: str) -> None:
    broken = []
    for link in Document.of(page).links:
        parts = urlsplit(link)
        if parts.scheme or parts.netloc or link == "#":
            continue
        target = (html_file(page).parent / unquote(parts.path)).resolve() if parts.path else html_file(page)
        if not target.is_file():
            broken.append(f"{link}: there is no such file")
        elif parts.fragment and unquote(parts.fragment) not in _anchors(target):
            broken.append(f"{link}: the page has no such anchor")
    assert not broken, f"{page}: {broken}"


@pytest.mark.parametrize("page", PAGES)
def test_anchors_are_unique(page: str) -> None:
    anchors = Document.of(page).anchors
    twice = sorted({anchor for anchor in anchors if anchors.count(anchor) > 1})
    assert not twice, f"{page}: {twice}"


@pytest.mark.parametrize("page", PAGES)
def test_images_have_alternative_texts(page: str) -> None:
    document = Document.of(page)
    images = [image for part in (document, *document.inner) for image in part.images]
    # Without a text of its own, an image gets its file's name.
    nameless = [image["src"][:120] for image in images if image.get("alt", "") in ("", image.get("src"))]
    assert not nameless, f"{page}: images without an alternative text: {nameless}"


@cache
def _anchors(file: Path) -> frozenset[str]:
    return frozenset(Document(file.read_text(encoding="utf-8")).anchors)


# ---- where numbers come from ----


@pytest.mark.parametrize("page", CHAPTERS)
def test_chapter_ends_with_its_provenance(browser: Browser, served_root: str, page: str) -> None:
    with visit(browser, served_root, page) as visited:
        last = visited.page.evaluate("checks.lastWords()")
    assert last["inProvenance"], f"{page} does not end with its provenance but with: {last['text'][:200]}"


# ---- API ----


def _public_modules() -> list[str]:
    """Name all modules of the library; of some packages the public face stands for what is inside."""
    names = [found.name for found in pkgutil.walk_packages(dexterity.__path__, f"{dexterity.__name__}.")]
    inner = re.compile(r"dexterity\.(chain|codegen|command|derivation|indices|scenes|urdf)\.")
    return [dexterity.__name__, *(name for name in names if not inner.match(name))]


# meshcat imports a part of zmq that is no longer needed.
@pytest.mark.filterwarnings("ignore:zmq.eventloop.ioloop is deprecated:DeprecationWarning")
@pytest.mark.parametrize("module_name", _public_modules())
def test_public_names_are_on_an_api_page(module_name: str) -> None:
    module = importlib.import_module(module_name)
    anchors = {anchor for page in API_PAGES for anchor in Document.of(page).anchors}
    names = getattr(module, "__all__", ())
    missing = [name for name in names if anchors.isdisjoint(_api_anchors(module, name))]
    assert not missing, f"{module_name}: the API pages have nothing on {missing}"


def _api_anchors(module: ModuleType, name: str) -> set[str]:
    """Return the anchors of a public name: under this module, at home, or under a module that hands it on."""
    thing = getattr(module, name)
    if isinstance(thing, ModuleType):
        return {f"module-{thing.__name__}"}
    home = f"{getattr(thing, '__module__', '')}.{getattr(thing, '__qualname__', '')}"
    handed_on = {f"{other}.{name}" for other in _public_modules() if _holds(other, name, thing)}
    return {f"{module.__name__}.{name}", home, *handed_on}


def _holds(module_name: str, name: str, thing: object) -> bool:
    return getattr(importlib.import_module(module_name), name, None) is thing


# ---- claims ----


def _shown(html: str, anchor: str) -> dict[str, str]:
    rows = rf'id="{anchor}-([^"]+)">.*?class="verdict [^"]*"[^>]*>([^<]*)</'
    return {name: unescape(verdict) for name, verdict in re.findall(rows, html, re.DOTALL)}


def test_scorecard_has_every_claim_with_its_verdict() -> None:
    pages = (html_file(f"reference/scorecard_{paper.letter.lower()}") for paper in ledger.load_papers())
    shown = {
        name: verdict for page in pages for name, verdict in _shown(page.read_text("utf-8"), "claim").items()
    }
    assert shown == {verdict.claim: str(verdict.outcome) for verdict in scorecard.all_verdicts()}
    assert shown.keys() == {claim.id for paper in ledger.load_papers() for claim in paper.claims}


@pytest.mark.parametrize("page", [page for page in PAGES if "scorecard." in source_text(page)])
def test_a_page_shows_the_verdicts_of_the_scorecard(page: str) -> None:
    html = html_file(page).read_text(encoding="utf-8")
    whole = {verdict.claim: str(verdict.outcome) for verdict in scorecard.all_verdicts()}
    shown = _shown(html, "claim") | _shown(html, "headline")
    assert shown.items() <= whole.items()
    if page == "index":
        assert shown.keys() == {name for paper in ledger.load_papers() for name in paper.headlines}
