"""HTML of a scene: an iframe with everything in it but the viewer's script, which all scenes share."""

from __future__ import annotations

import base64
import html
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from importlib import resources
from string import Template

__all__ = ["Html", "iframe", "row"]


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
    grid: float,
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
    grid
        Width of the floor's squares [m].
    still, commands
        The picture, in SVG, and what meshcat's viewer is to do, packed.
    """
    rows = [
        f'<li><i style="background:{color}"></i>{html.escape(text)}</li>' for text, color in legend.items()
    ]
    template = (resources.files(__package__) / "scene.html").read_text(encoding="utf-8")
    page = Template(template).substitute(
        title=html.escape(title),
        alt=html.escape(f"{title}: {parts}"),
        legend="".join([*rows, f"<li>grid {grid:g} m</li>"]),
        still=base64.b64encode(still).decode(),
        commands=commands,
    )
    return (
        f'<iframe class="meshcat-scene" title="{html.escape(title)}" '
        f'style="width:100%;height:{height}px;border:0" srcdoc="{html.escape(page)}"></iframe>'
    )


def row(shown: Iterable[tuple[str, str]]) -> Html:
    """Set titled HTML in a row, the titles below; one under the other where the page is narrow."""
    cells = (
        '<figure style="flex:1 1 17rem;min-width:0;margin:0">'
        f"{content}<figcaption>{html.escape(title)}</figcaption></figure>"
        for title, content in shown
    )
    return Html(f'<div style="display:flex;flex-wrap:wrap;gap:0.75rem">{"".join(cells)}</div>')
