"""Notebooks in plain Markdown, as they are downloaded."""

from types import SimpleNamespace

import nbformat
import pytest
from docutils import nodes
from pybtex.database import Entry, Person

from dexterity_study.page.plain import References, markdown, plain

PAGE = "part/page"


def citation(key, *authors):
    entry = Entry("article", {"year": "2016"}, {"author": [Person(name) for name in authors]})
    return SimpleNamespace(key=key, entry=entry)


@pytest.fixture
def references():
    cited = [citation("two", "Ann One", "Bob Two"), citation("many", "Ann One", "Bob Two", "Cy Three")]
    env = SimpleNamespace(
        domaindata={
            "std": {
                "anonlabels": {"fig-a": ("part/page", "fig-a"), "tab-b": ("part/page", "tab-b")},
                "labels": {"section": ("part/page", "section", "A section")},
            },
            "math": {"objects": {"eq-c": ("part/page", 3)}},
        },
        toc_fignumbers={
            "part/page": {
                "figure": {"fig-a": (1, 2)},
                "table": {"tab-b": (1, 1)},
                "displaymath": {"equation-eq-c": (1, 3)},
            }
        },
        titles={"part/other": nodes.title("", "Another page")},
        relfn2path=lambda target, page: (f"{page.rpartition('/')[0]}/{target}", ""),
        get_domain=lambda name: SimpleNamespace(citations=cited),
    )
    return References(env)


@pytest.mark.parametrize(
    ("myst", "shown"),
    [
        ("See {numref}`fig-a` and {numref}`tab-b`.", "See Figure 1.2 and Table 1.1."),
        ("By {eq}`eq-c`, a {term}`screw`.", "By (1.3), a screw."),
        ("See {doc}`other` and {doc}`here <other>`.", 'See "Another page" and here.'),
        ("See {ref}`section`.", 'See "A section".'),
        ("As {cite:t}`two` and {cite:p}`many` say.", "As One and Two (2016) and (One et al., 2016) say."),
        ("```{math}\n:label: eq-c\nx = 1\n```", "$$\nx = 1\n \\tag{1.3}\n$$"),
        (":::{dropdown} Notation\n| a |\n|---|\n:::", "**Notation**\n\n| a |\n|---|"),
        (":::{table} Errors\n:name: tab-b\n| a |\n:::", "**Table 1.1. Errors**\n\n| a |"),
        ("```bash\nmake {book}`x`\n```", "```bash\nmake {book}`x`\n```"),
        ("(section)=\n## Title", "## Title"),
    ],
)
def test_directives_and_references_become_plain_markdown(references, myst, shown):
    assert markdown(myst, PAGE, references) == shown


def test_a_role_that_has_no_plain_form_is_an_error(references):
    with pytest.raises(ValueError, match="cannot show the role 'odd'"):
        markdown("{odd}`x`", PAGE, references)


def test_captions_follow_their_cells_links_go_and_scenes_come_alive(references):
    figure = {"name": "fig-a", "caption": "What is\nseen, {term}`screw`."}
    shown = nbformat.v4.new_output(
        "display_data", {"text/html": '<a class="verdict" href="../x.html#y">holds</a>'}
    )
    glued = nbformat.v4.new_output(
        "display_data",
        {"application/papermill.record/text/plain": "'2 mm'"},
        metadata={"scrapbook": {"name": "error", "mime_prefix": "application/papermill.record/"}},
    )
    cell = nbformat.v4.new_code_cell(
        "show()", outputs=[shown, glued], metadata={"mystnb": {"figure": figure}}
    )
    text = nbformat.v4.new_markdown_cell("The error is {glue:text}`error`.")
    notebook = nbformat.v4.new_notebook(cells=[cell, text], metadata={"dexterity": {"key": "k"}})
    made = plain(notebook, PAGE, references, lambda html: html.upper())
    code, caption, prose = made.cells
    assert code.outputs[0].data["text/html"] == "HOLDS"
    assert caption.source == "**Figure 1.2.** What is seen, screw."
    assert prose.source == "The error is 2 mm."
    assert made.metadata == {}
    nbformat.validate(made)
