"""Sphinx extension of the book: all verdicts as a file, beside the start page."""

from pathlib import Path
from typing import Any

from sphinx.application import Sphinx

from dexterity import store
from dexterity_study.claims import overview

SCORECARD = "scorecard.json"
"""Name of the file."""


def setup(app: Sphinx) -> dict[str, Any]:
    """Connect the extension."""
    app.connect("build-finished", _write)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def _write(app: Sphinx, exception: Exception | None) -> None:
    if exception is None:
        store.write_atomically(Path(app.outdir) / SCORECARD, overview.as_json())
