"""The check of the book's English."""

from pathlib import Path

import pytest

from dexterity_study.page import prose

PAGE = """---
kernelspec:
  name: python3
---

# What is a title

The index depends on the frame. It hangs on
the point, Eq. 5.

```{code-cell} python3
---
mystnb:
  figure:
    caption: |
      Errors are dear here.
---
nor_is_this_prose()
```

- A bold lead stands alone.
- Nor does this hold.

| a table | is not dear |
"""


def test_paragraphs_items_and_captions_are_read_and_code_is_not():
    found = dict(prose.paragraphs(PAGE))
    assert list(found.values()) == [
        "The index depends on the frame. It hangs on the point, Eq. 5.",
        "A bold lead stands alone.",
        "Nor does this hold.",
        "Errors are dear here.",
    ]
    assert PAGE.splitlines()[next(iter(found)) - 1].startswith("The index")


def test_sentences_do_not_end_at_abbreviations():
    assert prose.sentences("See Eq. 5 of it. The rest follows (Fig. 2). Why?") == [
        "See Eq. 5 of it.",
        "The rest follows (Fig. 2).",
        "Why?",
    ]


@pytest.mark.parametrize(
    ("sentence", "rule"),
    [
        ("It hangs on the point.", "'hangs on': depends on"),
        ("What is fast is leaving the loop.", "a what-clause as the subject: name the thing"),
        ("Nor does this hold.", "an inversion: subject first"),
        ("Networks know nothing.", "'Networks know': no persons"),
        ("No one is not without it.", "3 negations, at most 2"),
        (" ".join(["word"] * 31), "31 words, at most 30"),
    ],
)
def test_a_broken_rule_is_named(sentence, rule):
    assert list(prose.broken_rules(sentence)) == [rule]


@pytest.mark.parametrize(
    "sentence", ["What does it cost?", "`Nor` is a name of $w$.", "The index depends on the frame."]
)
def test_a_sound_sentence_passes(sentence):
    assert list(prose.broken_rules(sentence)) == []


def test_an_exception_passes_and_an_unused_one_is_a_fault(tmp_path: Path):
    page = tmp_path / "page.md"
    page.write_text("It hangs on the point.\n", encoding="utf-8")
    assert list(prose.faults([page], ["It hangs on the point."])) == []
    assert [one.rule for one in prose.faults([page], ["Other."])] == [
        "'hangs on': depends on",
        "no sentence needs this exception",
    ]
