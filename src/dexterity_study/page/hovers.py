"""Hover texts: a reference to a term of the glossary shows its definition, as citations show what they cite."""

from docutils import nodes
from sphinx.application import Sphinx

GLOSSARY = "reference/glossary"


def explain(app: Sphinx, doctree: nodes.document, _page: str) -> None:
    """Give each reference to a term its definition as a title."""
    if GLOSSARY not in app.env.found_docs:
        return
    definitions = {
        name: " ".join(part.astext() for part in item.findall(nodes.definition))
        for item in app.env.get_doctree(GLOSSARY).findall(nodes.definition_list_item)
        for term in item.findall(nodes.term)
        for name in term["ids"]
    }
    for reference in doctree.findall(nodes.reference):
        target = str(reference.get("refuri", "")).rpartition("#")[2] or str(reference.get("refid", ""))
        if target in definitions:
            reference["reftitle"] = definitions[target]
