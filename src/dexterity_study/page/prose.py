"""The English of the book, checked by rule: words, openings, length and negations of each sentence.

    python -m dexterity_study.page.prose book README.md

The rules are those of the house style. A sentence that has to break one is listed, with its reason, in
`book/prose_exceptions.toml`; an exception that no sentence needs is a fault too.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from dexterity import store

MOST_WORDS, MOST_NEGATIONS = 30, 2
"""Largest number of words between colons and semicolons, and of negations, in a sentence."""

WORDS = {
    r"anew": "again",
    r"hangs? on": "depends on",
    r"dear(?:er|est)?": "expensive",
    r"farther|farthest": "further",
    r"stands? (?:beside|in for)": "is compared with, replaces",
    r"foretold|foretells?": "predicted",
    r"in the mean": "on average",
    r"before a side": "in front of a side",
    r"let out": "extend",
    r"bells?": "RBF units",
    r"in kind": "as in the paper",
    r"way of the tool": "tool path",
    r"alike": "equal, similar",
    r"to the contrary|with the contrary": "say what it is",
    r"(?:networks?|nets?|ind(?:ex|ices)|tables?) (?:know|see|feel|look|learn of|notice|tell|say)s?": "no persons",
    r"(?:is|are|was|were) told": "receives, takes",
    r"rungs?": "steps",
    r"(?:a|per) one": "per item",
    r"all over its": "over its",
}
"""Words that the house style replaces, and by what."""

OPENINGS = {
    r"What (?:\w+ ){1,6}(?:is|are|was|were)\b": "a what-clause as the subject: name the thing",
    r"(?:Nor|So little|So few)\b": "an inversion: subject first",
    r"(?:Never|Seldom|Rarely) (?:\w+ )*(?:is|are|does|do|can|has|have) \w+": "an inversion: subject first",
    r"(?:Here|There) (?:go|goes|stand|stands|lie|lies)\b": "an inversion: subject first",
}
"""Patterns at the beginning of a sentence, and what is wrong with them."""

_NEGATION = re.compile(
    r"\b(?:not|no|never|none|neither|nor|nothing|nowhere|cannot|without|\w+n't)\b", re.IGNORECASE
)
_FENCE = re.compile(r"(`{3,}|:{3,}|\$\$)")
_END = re.compile(r"(?<=[.?!])[\"')*]*\s+(?=[\"'(*]*[A-Z$`{])")
_ABBREVIATIONS = re.compile(r"\b(Eq|Eqs|Fig|Figs|Sec|no|vs|approx|cf|al|e\.g|i\.e)\.\s")


@dataclass(frozen=True)
class Fault:
    """A sentence that breaks a rule."""

    place: str
    sentence: str
    rule: str


def paragraphs(text: str) -> Iterator[tuple[int, str]]:
    """Yield line and text of each paragraph, list item and caption of a page; code, formulas and tables are left out."""
    lines = text.splitlines()
    inside = "---" if lines[:1] == ["---"] else None
    start, held = 0, list[str]()
    for number, line in enumerate([*lines, ""], start=1):
        fence = _FENCE.match(line.strip())
        prose = inside is None and fence is None and not line.startswith(("|", "#", "(", "---", "<!--"))
        if inside is not None:
            if line.strip() == inside and number > 1:
                inside = None
        elif fence is not None and not line.startswith(":::") and line.strip().count("$$") < 2:
            inside = fence[1]
        item = prose and re.match(r"\s*(?:[-*]|\d+\.)\s", line)
        if held and (item or not prose or not line.strip()):
            yield start, " ".join(held)
            held = []
        if prose and line.strip():
            start = start if held else number
            held.append(re.sub(r"^\s*(?:[-*]|\d+\.)\s+", "", line).strip())
    yield from _captions(lines)


def _captions(lines: Sequence[str]) -> Iterator[tuple[int, str]]:
    for number, line in enumerate(lines):
        start = re.fullmatch(r"(\s+)caption: (.*)", line)
        if start is None:
            continue
        held = [] if start[2] in ("|", ">") else [start[2]]
        for other in lines[number + 1 :]:
            if not other.startswith(start[1] + "  "):
                break
            held.append(other.strip())
        yield number + 1, " ".join(held)


def sentences(paragraph: str) -> list[str]:
    """Split a paragraph into sentences."""
    marked = _ABBREVIATIONS.sub("\\1.\N{NO-BREAK SPACE}", paragraph)
    return [part.replace("\N{NO-BREAK SPACE}", " ") for part in _END.split(marked) if part.strip()]


def broken_rules(sentence: str) -> Iterator[str]:
    """Yield what a sentence breaks."""
    plain = re.sub(r"`[^`]*`|\$[^$]*\$|\{[\w:]+\}", "x", sentence)
    bare = plain.lstrip("*\"'( ")
    for word, better in WORDS.items():
        if found := re.search(rf"\b(?:{word})\b", plain, re.IGNORECASE):
            yield f"{found[0]!r}: {better}"
    for opening, reason in OPENINGS.items():
        if re.match(opening, bare) and not bare.endswith("?"):
            yield reason
    if (count := max(len(re.findall(r"[\w'’-]+", part)) for part in re.split("[;:]", plain))) > MOST_WORDS:
        yield f"{count} words, at most {MOST_WORDS}"
    if (count := len(_NEGATION.findall(plain))) > MOST_NEGATIONS:
        yield f"{count} negations, at most {MOST_NEGATIONS}"


def faults(files: Iterable[Path], exceptions: Sequence[str]) -> Iterator[Fault]:
    """Yield the faults of some files, and the exceptions that none of them needs."""
    unused = set(exceptions)
    for file in files:
        for line, paragraph in paragraphs(file.read_text(encoding="utf-8")):
            for sentence in sentences(paragraph):
                rules = list(broken_rules(sentence))
                if rules and sentence in exceptions:
                    unused.discard(sentence)
                else:
                    yield from (Fault(f"{file}:{line}", sentence, rule) for rule in rules)
    for sentence in sorted(unused):
        yield Fault("book/prose_exceptions.toml", sentence, "no sentence needs this exception")


def main(arguments: Sequence[str]) -> int:
    """Print the faults of files and folders; the exit code is 0 if there are none."""
    paths = [Path(argument) for argument in arguments]
    files = [file for path in paths for file in (sorted(path.rglob("*.md")) if path.is_dir() else [path])]
    listed = store.read_toml("book/prose_exceptions.toml")
    found = list(faults(files, [one["sentence"] for one in listed.get("exceptions", ())]))
    for fault in found:
        sys.stdout.write(f"{fault.place}: {fault.rule}\n    {fault.sentence}\n")
    sys.stdout.write(f"{len(found)} faults in the English of {len(files)} files\n")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
