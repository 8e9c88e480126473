"""The built book as files: which pages there are, and what each of them holds."""

from dataclasses import dataclass, field
from html.parser import HTMLParser
from pathlib import Path

from sphinx_external_toc.parsing import parse_toc_yaml

REPOSITORY = Path(__file__).parents[2]
SOURCE = REPOSITORY / "book"
HTML = REPOSITORY / "_build" / "html"

_TOC = parse_toc_yaml(SOURCE / "_toc.yml")

PAGES: tuple[str, ...] = tuple(_TOC)
"""Every page of the table of contents."""

CHAPTERS: tuple[str, ...] = tuple(
    page for page in PAGES[1:] if not page.startswith("reference/") and not page.endswith("/summary")
)
"""The pages that derive and run something, and so end with where their numbers come from."""

SHARED = ("_static/", "searchindex.js")
"""What all pages load, below the root of the book: theme, MathJax, fonts, viewer, search index."""


def html_file(page: str) -> Path:
    return HTML / f"{page}.html"


def source_text(page: str) -> str:
    return (SOURCE / f"{page}.md").read_text(encoding="utf-8")


@dataclass
class Document(HTMLParser):
    """What a page holds: anchors, links, images, and the documents inside its iframes."""

    html: str
    anchors: list[str] = field(default_factory=list)
    links: list[str] = field(default_factory=list)
    images: list[dict[str, str]] = field(default_factory=list)
    inner: list["Document"] = field(default_factory=list)

    def __post_init__(self) -> None:
        super().__init__()
        self.feed(self.html)
        self.close()

    @classmethod
    def of(cls, page: str) -> "Document":
        return cls(html_file(page).read_text(encoding="utf-8"))

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        attributes = {name: value or "" for name, value in attrs}
        if "id" in attributes:
            self.anchors.append(attributes["id"])
        self.links.extend(attributes[name] for name in ("href", "src") if attributes.get(name))
        if tag == "img":
            self.images.append(attributes)
        if "srcdoc" in attributes:
            self.inner.append(Document(attributes["srcdoc"]))
