"""Sphinx extension of the book: captions, hover texts, downloads of notebooks, the viewer of the scenes."""

import html
import importlib
import json
import shutil
import zipfile
from pathlib import Path
from typing import Any

import joblib
import nbformat
from docutils import nodes
from sphinx.application import Sphinx

from dexterity import scenes, store
from dexterity_study.page import captions, hovers, summaries
from dexterity_study.page.plain import References, plain

ARCHIVE = "notebooks.zip"
"""All executed notebooks, beside the start page."""

LEADS = "leads.js"
"""First paragraphs of all pages, for the search."""

_LONG_AGO = (1980, 1, 1, 0, 0, 0)  # the same bytes whenever the archive is made


def setup(app: Sphinx) -> dict[str, Any]:
    """Connect the extension."""
    captions.setup(app)
    app.set_html_assets_policy("always")  # ledgers have formulas that Sphinx does not see
    app.connect("source-read", _depend_on_outputs)
    app.connect("doctree-resolved", hovers.explain)
    app.connect("missing-reference", _where_it_is_described)
    app.connect("autodoc-process-docstring", summaries.add_summary)
    app.connect("env-updated", _write_in_parallel)
    app.connect("html-page-context", _offer_notebooks, priority=502)  # after the theme's own buttons
    app.connect("html-page-context", _describe)
    app.connect("build-finished", _copy_files)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def _where_it_is_described(app: Sphinx, env: Any, node: Any, content: Any) -> Any:
    """Resolve the public name of a package, such as `dexterity.spatial.pose`, to the module that describes it."""
    package, _, name = node.get("reftarget", "").rpartition(".")
    if node.get("refdomain") != "py" or not package.startswith("dexterity."):
        return None
    try:
        thing = getattr(importlib.import_module(package), name)
        described = f"{thing.__module__}.{thing.__qualname__}"
    except (ImportError, AttributeError):
        return None
    domain = env.get_domain("py")
    return domain.resolve_xref(env, node["refdoc"], app.builder, node["reftype"], described, node, content)


def _executed(app: Sphinx, page: str) -> Path:
    return Path(app.outdir).parent / "executed" / f"{page}.ipynb"


def _depend_on_outputs(app: Sphinx, page: str, source: list[str]) -> None:
    """Have a page read again when it has been executed again."""
    if "{code-cell}" in source[0]:
        app.env.note_dependency(str(_executed(app, page)))


def _write_in_parallel(app: Sphinx, _env: Any) -> None:
    """Use all cores from here on; not earlier, since some extensions cannot read in parallel."""
    app.parallel = joblib.cpu_count()


def _offer_notebooks(app: Sphinx, page: str, _template: str, context: dict[str, Any], _tree: Any) -> None:
    """Put the executed notebook of a page, and all of them, into the menu of downloads."""
    for group in context.get("header_buttons", ()):
        if group.get("label") == "download-buttons":
            group["buttons"][:0] = _buttons(app, page, context["pathto"])


def _buttons(app: Sphinx, page: str, pathto: Any) -> list[dict[str, str]]:
    offers = [(ARCHIVE, "all .ipynb", "Download the executed notebooks of all pages", "archive")]
    if _executed(app, page).is_file():
        offers.insert(0, (f"notebooks/{page}.ipynb", ".ipynb", "Download the executed notebook", "notebook"))
    return [
        {
            "type": "link",
            "url": pathto(target, 1),
            "text": text,
            "tooltip": tooltip,
            "icon": "fas fa-code",
            "label": f"download-{kind}-button",
        }
        for target, text, tooltip, kind in offers
    ]


def _describe(app: Sphinx, page: str, _template: str, context: dict[str, Any], tree: Any) -> None:
    """Describe a page by its first paragraph; the search shows it, from a file that it loads."""
    if page == "search":
        app.add_js_file(LEADS)
    elif tree is not None and (text := lead(tree)):
        context["metatags"] += f'\n<meta name="description" content="{html.escape(text)}">'


def lead(tree: nodes.document) -> str:
    """Return the first paragraph of a page as plain text, empty if it has none."""
    first = next(iter(tree.findall(nodes.paragraph)), None)
    return "" if first is None else " ".join(first.astext().split())


def _copy_files(app: Sphinx, exception: Exception | None) -> None:
    if exception is not None:
        return
    root = Path(app.outdir)
    scenes.copy_viewer(root / "_static" / "meshcat")
    leads = {page: lead(app.env.get_doctree(page)) for page in sorted(app.env.found_docs)}
    store.write_atomically(
        root / "_static" / LEADS, f"window.leads = {json.dumps(leads, ensure_ascii=False)};\n"
    )
    notebooks = root.parent / "notebooks"
    _write_notebooks(app, notebooks)
    shutil.rmtree(root / "notebooks", ignore_errors=True)
    shutil.copytree(notebooks, root / "notebooks")
    pack(notebooks, root / ARCHIVE)


def _write_notebooks(app: Sphinx, folder: Path) -> None:
    """Write the executed notebooks of all pages for a reader's own Jupyter."""
    shutil.rmtree(folder, ignore_errors=True)
    references = References(app.env)
    for page in sorted(app.env.found_docs):
        if (source := _executed(app, page)).is_file():
            notebook = plain(nbformat.read(source, as_version=4), page, references, scenes.standalone)
            (folder / page).parent.mkdir(parents=True, exist_ok=True)
            store.write_atomically(folder / f"{page}.ipynb", nbformat.writes(notebook) + "\n")


def pack(folder: Path, archive: Path) -> None:
    """Pack the notebooks of a folder; the same notebooks give the same bytes."""
    with zipfile.ZipFile(archive, "w") as packed:
        for file in sorted(folder.rglob("*.ipynb")):
            entry = zipfile.ZipInfo(f"notebooks/{file.relative_to(folder).as_posix()}", _LONG_AGO)
            entry.external_attr = 0o644 << 16
            packed.writestr(entry, file.read_bytes(), zipfile.ZIP_DEFLATED)
