"""The rule book: what each word of a verdict needs, the same for all claims of all papers.

The ledger names the rule of a claim. A rule grades the values of one reading; the grades of all readings that
were run give the outcome. What is printed is read from the ledger and never passed in.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from enum import IntEnum
from types import MappingProxyType
from typing import Any

import numpy as np
import pandas as pd

from dexterity_study.claims.design import DesignShare
from dexterity_study.claims.ledger import Claim, load_paper
from dexterity_study.claims.outcome import Outcome, Verdict
from dexterity_study.engine.readings import Assumption
from dexterity_study.page.numbers import with_range

FEW, HALF, MOST = 0.1, 0.5, 0.9
"""Shares of the seeds up to which a statement is refuted, from which it is in shape, and is reproduced."""

WEAK, STRONG = 0.3, 0.8
"""Kendall's τ from which a trend is in shape, and is reproduced; at 0 and below it is refuted."""

FACTOR = 2.0
"""Factor between our median and a printed number up to which the number is in shape."""

WIDE = 4.0
"""Factor between our largest and smallest value beyond which a number is not decided."""

ROUNDING = 1e-9
"""Largest relative deviation of a formula that is put down to rounding."""

RULES: Mapping[str, str] = MappingProxyType(
    {
        "number": (
            "reproduced: the printed number, give or take its rounding, lies within our range over the seeds; in "
            f"shape: it is within a factor of {FACTOR:g} of our median; underspecified: our largest value is more "
            f"than {WIDE:g} times our smallest; else not reproduced. Several numbers: each has to be"
        ),
        "bound": f"as a share: the seeds whose value keeps the printed bound, {MOST:.0%} and {HALF:.0%} of them",
        "order": "as a share: the seeds, or the pairs of seeds, in which the order holds",
        "share": (
            f"reproduced: the statement holds in at least {MOST:.0%} of the seeds; in shape: in at least {HALF:.0%}; "
            f"refuted: in at most {FEW:.0%}; else not reproduced"
        ),
        "trend": (
            f"reproduced: Kendall's τ has a median of at least {STRONG:g} over the seeds; in shape: at least {WEAK:g}; "
            "refuted: 0 or less; else not reproduced"
        ),
        "formula": f"reproduced: it holds to {ROUNDING:.0e}, which is rounding; else refuted",
        "cases": "reproduced: the statement holds in all cases that it names; in shape: in some; refuted: in none",
    }
)
"""What a rule needs, by its name in the ledger."""

WORDS: Mapping[Outcome, str] = MappingProxyType(
    {
        Outcome.REPRODUCED: "the rule of the claim grants it, in all admissible readings that were run",
        Outcome.IN_SHAPE: "the rule grants the weaker grade",
        Outcome.NOT_REPRODUCED: "the rule grants neither grade, and other readings may still do so",
        Outcome.LOGGED: (
            "the rule grants it, at least in part, on training logs that the authors published; nothing was run here, so it "
            "reproduces nothing"
        ),
        Outcome.CONTRADICTED: "refuted in every admissible reading, by logic, or by the authors' own published logs",
        Outcome.UNDERSPECIFIED: (
            "admissible readings, or seeds where the paper has one draw, disagree; where a space-filling design of "
            f"readings was run, more than {FEW:.0%} of them disagree with the chosen one"
        ),
        Outcome.MISPRINT: "refuted as printed, and other numbers of the paper show what was meant",
        Outcome.FITTED: "a value of ours was chosen so that it comes out; this reproduces nothing",
        Outcome.NOT_RUN: "what the claim needs was not run, or not to its end",
        Outcome.OUT_OF_SCOPE: "cannot be judged by computing, such as what was measured on a machine that is gone",
    }
)
"""What each word means."""


class Grade(IntEnum):
    """How far the values of one reading bear a claim out."""

    REFUTED = 0
    MISSED = 1
    UNDECIDED = 2
    IN_SHAPE = 3
    REPRODUCED = 4

    @property
    def holds(self) -> bool:
        """Whether the claim is borne out, at least in shape."""
        return self >= Grade.IN_SHAPE


class Judge:
    """Judges the claims of one paper.

    Parameters
    ----------
    paper
        Key of the paper.
    """

    def __init__(self, paper: str) -> None:
        self.paper = load_paper(paper)

    def __call__(
        self,
        claim: str,
        values: Any,
        note: str = "",
        *,
        form: str = "{:.3g}",
        unit: str = "",
        ours: str = "",
        design: DesignShare | None = None,
    ) -> Verdict:
        """Judge a claim by the rule that the ledger names.

        Parameters
        ----------
        claim
            Id of the claim.
        values
            Our values: a series over readings and seeds, as `Table.values` returns, a sequence over seeds of the
            chosen reading, or one value. Numbers for the rules number and bound, truth values for share and
            order, Kendall's τ for trend, a relative deviation for formula, and a mapping of truth values for
            cases. A number with several parts is a sequence of such values, one for each part.
        note
            Reason, in one sentence.
        form, unit
            Form of our value in the table, and its unit.
        ours
            Our value as a text, where the values are not what is to be read.
        design
            Readings of a space-filling design in which the claim holds, as `in_design` returns.
        """
        entry = self.paper.claim(claim)
        by_reading = _by_reading(entry, values)
        grades = {reading: _RULES[entry.rule](entry, own) for reading, own in by_reading.items()}
        chosen = grades.get("chosen")
        if chosen is None:
            raise ValueError(f"claim {claim} has no value for the chosen reading; it has {list(grades)}")
        admissible = _admissible(self._assumptions(entry, grades))
        run = {
            name: grade
            for name, grade in grades.items()
            if name == "chosen" or admissible.issuperset(name.split("+"))
        }
        return Verdict(
            paper=self.paper.key,
            claim=claim,
            outcome=_outcome(chosen, run, admissible, design),
            ours=ours or _written(entry, values, by_reading["chosen"], form, unit),
            spread="" if entry.rule == "cases" else _over(entry, values, by_reading["chosen"]),
            sentence=note,
            readings=_share(run, admissible),
            flips=tuple(name for name, grade in run.items() if grade.holds != chosen.holds),
            design=str(design) if design else "",
        )

    def in_design(
        self, claim: str, values: pd.Series | pd.DataFrame, factors: pd.DataFrame | None = None
    ) -> DesignShare:
        """Judge a claim in each reading of a space-filling design.

        Parameters
        ----------
        claim
            Id of the claim.
        values
            What the rule of the claim judges, indexed by reading and repetition: numbers, truth values, or Kendall's
            τ; columns for a number with several parts and for cases, of which each holds if it does in half of the
            repetitions. A loop that does not end has the value infinity.
        factors
            What each reading has of each factor that was varied; the verdict then says what it turns on.

        Raises
        ------
        ValueError
            If the index has not two levels, or occurs twice, or a value is missing.
        """
        entry = self.paper.claim(claim)
        return DesignShare.of(
            values, lambda own: _RULES[entry.rule](entry, _of_reading(entry, own)).holds, factors
        )

    def refuted(self, claim: str, note: str, ours: str = "") -> Verdict:
        """Contradict a claim by logic; the note has the argument."""
        return self._plain(claim, Outcome.CONTRADICTED, ours, note)

    def logged(self, claim: str, values: Any, note: str, told: str = "") -> Verdict:
        """Judge a claim, by the rule that the ledger names, on what the authors logged and published.

        The verdict has no value of ours; its sentence ends with the logged one.

        Parameters
        ----------
        claim
            Id of the claim.
        values
            Logged values, as for a call; readings do not apply.
        note
            Reason, in one sentence; it says that the values are logged.
        told
            Logged value as a text, where the values are not what is to be read.
        """
        entry = self.paper.claim(claim)
        (own,) = _by_reading(entry, values).values()
        grade = _RULES[entry.rule](entry, own)
        refuted = Outcome.CONTRADICTED if grade == Grade.REFUTED else Outcome.NOT_REPRODUCED
        outcome = Outcome.LOGGED if grade.holds else refuted
        told = told or _written(entry, values, own, "{:.3g}", "")
        return self._plain(claim, outcome, "", f"{note} In the logs: {told}." if told else note)

    def misprint(self, claim: str, note: str, ours: str = "") -> Verdict:
        """Call a claim a misprint; the note names the numbers of the paper that show what was meant."""
        return self._plain(claim, Outcome.MISPRINT, ours, note)

    def fitted(self, claim: str, note: str, ours: str = "") -> Verdict:
        """Say that a value was chosen so that the claim comes out."""
        return self._plain(claim, Outcome.FITTED, ours, note)

    def underspecified(self, claim: str, note: str, ours: str = "") -> Verdict:
        """Say that the paper leaves open what decides the claim; the note names it."""
        return self._plain(claim, Outcome.UNDERSPECIFIED, ours, note)

    def not_run(self, claim: str, note: str, ours: str = "") -> Verdict:
        """Say that what a claim needs was not run."""
        return self._plain(claim, Outcome.NOT_RUN, ours, note)

    def out_of_scope(self, claim: str, note: str, ours: str = "") -> Verdict:
        """Say that computing cannot judge a claim."""
        return self._plain(claim, Outcome.OUT_OF_SCOPE, ours, note)

    def printed(self, name: str) -> Any:
        """Return the printed value of a claim or a setting."""
        return self.paper.printed(name)

    def _plain(self, claim: str, outcome: Outcome, ours: str, note: str) -> Verdict:
        return Verdict(self.paper.key, self.paper.claim(claim).id, outcome, ours, "", note)

    def _assumptions(self, claim: Claim, readings: Iterable[str]) -> list[Assumption]:
        """Return what a claim rests on: what the ledger lists, or its chapter's assumptions and those varied."""
        if claim.assumes is not None:
            return [one for one in self.paper.assumptions if one.id in claim.assumes]
        varied = {pair.partition("=")[0] for reading in readings for pair in reading.split("+")}
        return [one for one in self.paper.assumptions if one.chapter == claim.chapter or one.id in varied]


def by_reading(values: Mapping[str, Any]) -> pd.Series:
    """Put values of several readings below one another, as a judge takes them.

    Parameters
    ----------
    values
        By the name of the reading: a value, a sequence over seeds, or truth values by case.
    """
    rows = {
        (reading, number): value
        for reading, own in values.items()
        for number, value in enumerate(own.values() if isinstance(own, Mapping) else np.atleast_1d(own))
    }
    return pd.Series(rows).rename_axis(["reading", "seed"])


# ---- rules -----------------------------------------------------------------------------------------


def share_grade(share: float) -> Grade:
    """Grade a statement by the share of seeds in which it holds."""
    if share >= MOST:
        return Grade.REPRODUCED
    if share >= HALF:
        return Grade.IN_SHAPE
    return Grade.REFUTED if share <= FEW else Grade.MISSED


def _number(claim: Claim, values: np.ndarray) -> Grade:
    if isinstance(claim.value, tuple):
        if len(values) != len(claim.value):
            raise ValueError(
                f"claim {claim.id} has {len(claim.value)} printed numbers and {len(values)} of ours"
            )
        return min(_one_number(claim, printed, own) for printed, own in zip(claim.value, values, strict=True))
    return _one_number(claim, float(claim.value or 0), values)


def _one_number(claim: Claim, printed: float, values: Any) -> Grade:
    own = np.atleast_1d(np.asarray(values, dtype=float))
    low, high, median = own.min(), own.max(), float(np.median(own))
    if low > 0 and high > WIDE * low:
        return Grade.UNDECIDED
    # A printed number is compared with our values to the last digit of a double.
    slack = claim.rounding + ROUNDING * abs(printed)
    if low - slack <= printed <= high + slack:
        return Grade.REPRODUCED
    if claim.near is not None:
        return Grade.IN_SHAPE if abs(median - printed) <= claim.near.within else Grade.MISSED
    near = median * printed > 0 and 1 / FACTOR <= median / printed <= FACTOR
    return Grade.IN_SHAPE if near else Grade.MISSED


def _bound(claim: Claim, values: np.ndarray) -> Grade:
    keeps = values < claim.value if claim.side == "below" else values > claim.value
    return share_grade(float(np.mean(keeps)))


def _shared(claim: Claim, values: np.ndarray) -> Grade:
    if values.dtype != bool:
        raise ValueError(f"claim {claim.id} is judged by a share, which needs truth values")
    return share_grade(float(values.mean()))


def _trend(_: Claim, values: np.ndarray) -> Grade:
    tau = float(np.median(values))
    if tau >= STRONG:
        return Grade.REPRODUCED
    if tau >= WEAK:
        return Grade.IN_SHAPE
    return Grade.REFUTED if tau <= 0 else Grade.MISSED


def _formula(_: Claim, values: np.ndarray) -> Grade:
    return Grade.REPRODUCED if float(np.max(np.abs(values))) <= ROUNDING else Grade.REFUTED


def _cases(claim: Claim, values: np.ndarray) -> Grade:
    if values.dtype != bool and values.size:
        raise ValueError(f"claim {claim.id} is judged by cases, which needs truth values")
    if values.all() and values.size:
        return Grade.REPRODUCED
    return Grade.IN_SHAPE if values.any() else Grade.REFUTED if values.size else Grade.MISSED


_RULES: Mapping[str, Callable[[Claim, np.ndarray], Grade]] = {
    "number": _number,
    "bound": _bound,
    "order": _shared,
    "share": _shared,
    "trend": _trend,
    "formula": _formula,
    "cases": _cases,
}


# ---- readings --------------------------------------------------------------------------------------


def _by_reading(claim: Claim, values: Any) -> dict[str, Any]:
    """Return the values of each reading, over its seeds; a list of them where a number has several parts."""
    if claim.rule == "cases" and isinstance(values, Mapping):
        return _split(list(values.values()))
    if claim.rule == "number" and isinstance(claim.value, tuple):
        parts = [_split(part) for part in values]
        return {name: [part[name] for part in parts] for name in parts[0]}
    return _split(values)


def _split(values: Any) -> dict[str, np.ndarray]:
    if isinstance(values, pd.Series) and values.index.names[:1] == ["reading"]:
        return {str(name): own.to_numpy() for name, own in values.groupby(level="reading", sort=False)}
    return {"chosen": np.atleast_1d(np.asarray(values))}


def _admissible(assumptions: Sequence[Assumption]) -> set[str]:
    """Return the names of the readings that differ from the chosen one in one assumption.

    A value that was chosen because it fits is no evidence, so it is not one of them.
    """
    return {
        f"{one.id}={other.name}"
        for one in assumptions
        for other in one.alternatives
        if other.origin != "fitted"
    }


def _of_reading(claim: Claim, values: pd.Series | pd.DataFrame) -> Any:
    """Return the values of one reading of a design as the rules take them."""
    if isinstance(values, pd.Series):
        return values.to_numpy()
    if claim.rule == "cases":
        return (values.mean() >= HALF).to_numpy()
    return [column.to_numpy() for _, column in values.items()]


def _outcome(
    chosen: Grade, run: Mapping[str, Grade], admissible: set[str], design: DesignShare | None = None
) -> Outcome:
    against = 0.0 if design is None else 1 - design.share if chosen.holds else design.share
    complete = admissible <= run.keys() and (design is None or design.count == 0)
    if complete and all(grade == Grade.REFUTED for grade in run.values()):
        return Outcome.CONTRADICTED
    if chosen == Grade.UNDECIDED or len({grade.holds for grade in run.values()}) > 1 or against > FEW:
        return Outcome.UNDERSPECIFIED
    words = {Grade.REPRODUCED: Outcome.REPRODUCED, Grade.IN_SHAPE: Outcome.IN_SHAPE}
    return words.get(chosen, Outcome.NOT_REPRODUCED)


def _share(run: Mapping[str, Grade], admissible: set[str]) -> str:
    if len(admissible) == 0:
        return ""
    holds = sum(grade.holds for grade in run.values())
    return f"Holds in {holds} of {len(run)} readings run; {len({'chosen'} | admissible | run.keys())} are admissible"


# ---- words -----------------------------------------------------------------------------------------


def _written(claim: Claim, values: Any, chosen: Any, form: str, unit: str) -> str:
    if claim.rule == "cases" and isinstance(values, Mapping):
        return ", ".join(f"{case}: {'yes' if holds else 'no'}" for case, holds in values.items())
    if claim.rule in ("share", "order", "cases"):
        return f"{np.sum(chosen)} of {len(chosen)}" if len(chosen) > 1 else ""
    if claim.rule == "formula":
        return f"{float(np.max(np.abs(chosen))):.0e}"
    parts = chosen if isinstance(claim.value, tuple) and claim.rule == "number" else [chosen]
    return ", ".join(with_range(part, form) for part in parts) + (f" {unit}" if unit else "")


def _over(claim: Claim, values: Any, chosen: Any) -> str:
    count = np.size(chosen[0] if isinstance(chosen, list) else chosen)
    # An order may be judged by all pairs of seeds; a series has one value for each seed.
    what = "comparisons" if claim.rule == "order" and not isinstance(values, pd.Series) else "seeds"
    return f"over {count} {what}" if count > 1 else ""
