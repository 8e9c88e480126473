"""HTML of a scene: an iframe with everything in it but the viewer's script, which all scenes share.

Examples
--------
>>> import dexterity as dx
>>> scene = dx.scenes.Scene("A PUMA 560")
>>> scene.add_chain(dx.robots.puma560(), [0.0] * 6)
>>> shown = dx.scenes.side_by_side(scene).text
>>> len(dx.scenes.standalone(shown)) > len(shown)
True
"""

from __future__ import annotations

import base64
import hashlib
import html
import zlib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from importlib import resources
from string import Template

from dexterity import checks

__all__ = ["Html", "iframe", "row", "standalone"]


@dataclass(frozen=True)
class Html:
    """HTML that a notebook shows when it is the last value of a cell."""

    text: str = field(repr=False)

    def _repr_html_(self) -> str:
        return self.text


def iframe(
    title: str,
    parts: str,
    height: int,
    *,
    legend: Mapping[str, str],
    remarks: Sequence[str],
    still: bytes,
    commands: str,
) -> str:
    """Return ``scene.html`` in an iframe.

    Parameters
    ----------
    title, parts
        What the scene shows and what is in it, read out to those who do not see it.
    height
        [CSS pixels].
    legend
        Colours of what has an entry.
    remarks
        What else the legend says.
    still, commands
        The picture, in SVG, and what meshcat's viewer is to do, packed.
    """
    swatch = '<i style="background:{0}" data-color="{0}"></i>'
    entries = [f"{swatch.format(color)}{html.escape(text)}" for text, color in legend.items()]
    script = "\n" + _dense(_text("panel.js") + _text("viewer.js")) + "\n"
    page = Template(_text("scene.html")).substitute(
        policy=_policy(script),
        title=html.escape(title),
        alt=html.escape(f"{title}: {parts}"),
        style=_dense(_text("scene.css")),
        script=script.strip("\n"),
        legend="".join(f"<li>{entry}</li>" for entry in [*entries, *map(html.escape, remarks)]),
        still=base64.b64encode(still).decode(),
        commands=commands,
    )
    return (
        f'<iframe class="meshcat-scene" title="{html.escape(title)}" '
        f"style=\"width:100%;height:{height}px;border:0\" srcdoc='{_quoted(page)}'></iframe>"
    )


def row(shown: Iterable[tuple[str, str]]) -> Html:
    """Set titled HTML in a row, the titles below; one under the other where the page is narrow."""
    cells = (
        '<figure style="flex:1 1 17rem;min-width:0;margin:0">'
        f'{content}<figcaption class="mathjax_ignore">{html.escape(title)}</figcaption></figure>'
        for title, content in shown
    )
    return Html(f'<div style="display:flex;flex-wrap:wrap;gap:0.75rem">{"".join(cells)}</div>')


@checks.arguments(shown=checks.Instance(str))
def standalone(shown: str) -> str:
    """Put meshcat's viewer into each scene of some HTML, which then moves outside of a book too.

    Each scene then has a copy of the viewer, compressed to about 0.3 MB, and needs neither a server nor the
    other scenes.

    Parameters
    ----------
    shown
        HTML with any number of scenes, such as the output of a notebook's cell. The rest stays as it is.
    """
    inlined = base64.b64encode(zlib.compress(_viewer(), 9)).decode()
    return shown.replace(_quoted(_EMPTY), _quoted(_EMPTY.replace("><", f">{inlined}<")))


def _policy(script: str) -> str:
    """Let the page run its script and the viewer that this one loads, and nothing that stands in a name."""
    hashes = (
        base64.b64encode(hashlib.sha256(text).digest()).decode() for text in (script.encode(), _viewer())
    )
    scripts = " ".join(f"'sha256-{each}'" for each in hashes)
    allowed = (
        f"default-src 'none'; script-src {scripts} 'strict-dynamic'; style-src 'unsafe-inline'; "
        "img-src data: blob:; font-src data:"
    )
    return f'<meta http-equiv="Content-Security-Policy" content="{allowed}">'


@cache
def _viewer() -> bytes:
    return (resources.files("meshcat") / "viewer" / "dist" / "main.min.js").read_bytes()


_EMPTY = '<script id="inlined-viewer" type="text/plain"></script>'


def _quoted(text: str) -> str:
    """Escape a text for an attribute in single quotes, of which it has few, and no more than it needs."""
    return text.replace("&", "&amp;").replace("'", "&#39;")


def _dense(text: str) -> str:
    """Leave out indents and lines of comment, because each scene carries the whole text."""
    lines = map(str.strip, text.splitlines())
    return "\n".join(line for line in lines if line and not line.startswith(("//", "/*")))


def _text(name: str) -> str:
    return (resources.files(__package__) / name).read_text(encoding="utf-8")
