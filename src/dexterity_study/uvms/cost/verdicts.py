"""Verdicts on the operation counts of paper A."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import partial
from typing import Any

from dexterity_study.claims.judge import Judge
from dexterity_study.claims.outcome import Acceptance, Verdict
from dexterity_study.engine.evidence import Evidence
from dexterity_study.uvms.cost.experiment import INDICES


class Counts:
    """The counted operations, and the sums that Appendix A and Table 4 make of them."""

    def __init__(self, evidence: Evidence) -> None:
        self.rows = evidence["counts"].where().set_index(["what", "form"])
        steps = evidence["checks"].where()
        self.steps, self.most_steps = int(steps["steps"].median()), int(steps["most_steps"].max())

    def __call__(self, what: str, form: str, kind: str = "operations") -> int:
        """Return a number of operations, additions or multiplications."""
        return int(self.rows[kind][what, form])

    @property
    def iterated(self) -> int:
        """Singular values of a Jacobian without zeros."""
        return (
            self("bidiagonal", "dense") + self.steps * self("Laguerre", "step") + self("root", "of a ratio")
        )

    @property
    def svd(self) -> int:
        """The paper's m²n."""
        return 6**2 * 12

    def sums(self) -> dict[str, dict[str, int]]:
        """Return the operations of w and KCI as the paper counts, with terms shared, and reduced."""
        J, shared = self("Jacobian", "written out"), self("Jacobian", "written out, terms shared")
        w_shared = (
            shared + self("gram", "symmetric") + self("determinant", "elimination") + self("root", "one")
        )
        kci_reduced = (
            self("bidiagonal", "reduced") + self.steps * self("Laguerre", "step") + self("root", "of a ratio")
        )
        return {
            "written out": {"w": J + self("gram", "all") + self("determinant", "terms"), "KCI": J + self.svd},
            "terms shared": {"w": w_shared, "KCI": shared + self.iterated},
            "reduced": {"w": self("w", "closed form"), "KCI": kci_reduced},
        }


def verdicts(evidence: Evidence) -> Iterator[Verdict]:
    """Judge the claims of the chapter."""
    on = Judge("sotiropoulos2016")
    counts = Counts(evidence)
    yield from _on_statements(on, evidence, counts)
    yield from _on_exact_counts(on, counts)
    yield from _on_networks(on, counts)


def acceptance(evidence: Evidence) -> Iterator[Acceptance]:
    """Figures that must hold for the book to be accepted."""
    checks, sums = evidence["checks"].where(), Counts(evidence).sums()
    yield Acceptance("Jacobian written out, against the chain's", checks["written"].max(), 1e-12)
    yield Acceptance("w in closed form, relative", checks["closed"].max(), 1e-10)
    yield Acceptance("KCI by Laguerre's iteration, relative", checks["laguerre"].max(), 1e-10)
    yield Acceptance(
        "ways of the ladder from each other, relative", evidence["ladder"].where()["deviation"].max(), 1e-9
    )
    for name, limit in (("w", 0.02), ("KCI", 0.1)):
        share = sums["reduced"][name] / sums["written out"][name]
        yield Acceptance(f"operations of {name}, reduced over written out", share, limit)


def _on_statements(on: Judge, evidence: Evidence, counts: Counts) -> Iterator[Verdict]:
    algebra, checks = evidence["algebra"].where().iloc[0], evidence["checks"]
    for claim in ("sine-by-exponentials", "cosine-by-exponentials"):
        yield on(claim, 0.0 if algebra["euler"] else 1.0, "An identity; sympy finds no difference.", ours="–")
    per_call = [counts("sine", "exponentials", kind) for kind in ("multiplications", "additions")]
    yield _counted(
        on,
        "sine-costs-four",
        per_call,
        "Two exponentials, one sum and one quotient; the multiplication by i and the divisor are free.",
    )
    written, shared = counts("Jacobian", "written out"), counts("Jacobian", "written out, terms shared")
    yield on(
        "jacobian-is-expensive",
        {"written out": True, "terms shared": shared > written / 10},
        f"The printed form is expensive: with each common term computed once the same entries take {written / shared:.0f} "
        f"times fewer operations, and in better axes {counts('Jacobian', 'reduced, for KCI')} (KCI) and "
        f"{counts('Jacobian', 'reduced, for w')} (w).",
        ours=f"{written} operations written out, {shared} with terms shared",
    )
    yield on(
        "w-has-symbolic-form",
        checks.values("closed"),
        f"Relative deviation of the closed form, {counts('w', 'closed form')} operations, from the singular values.",
    )
    yield on(
        "kci-has-no-closed-form",
        [not algebra["solvable"]],
        f"At a configuration with rational sines and cosines the polynomial of the squared singular values has the Galois "
        f"group {algebra['group']}: neither they nor their ratio can be written with roots. The iteration is short: "
        f"{counts.steps} steps of {counts('Laguerre', 'step')} operations.",
        ours=f"Galois group {algebra['group']}",
    )
    yield on(
        "networks-skip-the-jacobian",
        [True],
        "Eqs. 13 to 18 hold joint values and weights alone. Training needs the index, and with it the Jacobian.",
    )
    reduced = counts.sums()["reduced"]
    networks = {
        f"{kind} {name}": counts(f"{kind} {name}", form)
        for kind, form in _PRINTED.items()
        for name in INDICES
    }
    factors = {title: reduced[title.split()[-1]] / own for title, own in networks.items()}
    yield on(
        "networks-cheaper-than-analytical",
        {title: factor > 1 for title, factor in factors.items()},
        "Cases: operations of the printed networks against the reduced exact indices, "
        f"{reduced['w']} (w) and {reduced['KCI']} (KCI). Against an exact index that is written out all networks win. The "
        + "; ".join(
            f"{title} network has {own} ({1 / factors[title]:.1f} times as many)"
            for title, own in networks.items()
        )
        + ".",
    )
    yield on(
        "feed-forward-cheaper-than-radial-basis",
        {name: networks[f"feed-forward {name}"] < networks[f"radial-basis {name}"] for name in INDICES},
        "For the printed numbers of neurons, and because of them: a single neuron costs about as much in either.",
    )


_PRINTED: Mapping[str, str] = {"feed-forward": "printed", "radial-basis": "norm"}


def _on_exact_counts(on: Judge, counts: Counts) -> Iterator[Verdict]:
    counted = partial(_counted, on)
    sums = counts.sums()
    unshared = "The Jacobian as the product of exponentials gives it, nothing shared; with common terms named"
    for kind in ("operations", "additions", "multiplications"):
        shared = counts("Jacobian", "written out, terms shared", kind)
        yield counted(
            f"jacobian-{kind}", [counts("Jacobian", "written out", kind)], f"{unshared} it takes {shared}."
        )
    for kind in ("multiplications", "additions"):
        symmetric, elimination = counts("gram", "symmetric", kind), counts("determinant", "elimination", kind)
        yield counted(
            f"gram-{kind}",
            [counts("gram", "all", kind)],
            f"Of all 36 entries; the 21 that differ take {symmetric}.",
        )
        yield counted(
            f"determinant-{kind}",
            [counts("determinant", "terms", kind)],
            f"The sum over all permutations of six columns; Gauss' elimination takes {elimination}.",
        )
        parts = [int(on.printed(f"{part}-{kind}")) for part in ("jacobian", "gram", "determinant")]
        ours = (
            counts("Jacobian", "written out", kind)
            + counts("gram", "all", kind)
            + counts("determinant", "terms", kind)
        )
        slip = int(on.printed(f"w-{kind}")) - sum(parts)
        if slip:
            yield on.refuted(
                f"w-{kind}",
                f"The printed parts {parts} add up to {sum(parts)}, which the appendix misses by {abs(slip)}; counted here "
                f"they are {ours}.",
                f"{sum(parts)} operations",
            )
        else:
            yield counted(f"w-{kind}", [ours], f"The printed parts {parts} add up to the printed sum.")
    yield counted(
        "w-operations-appendix",
        [sums["written out"]["w"]],
        f"Jacobian, JJᵀ and determinant as the paper counts them; {sums['reduced']['w']} operations reduced.",
    )
    table = [int(on.printed("jacobian-operations")), int(on.printed("gram-multiplications")), 6**3]
    of_table, of_appendix = int(on.printed("w-operations-table")), int(on.printed("w-operations-appendix"))
    yield (on.fitted if sum(table) == of_table else on.underspecified)(
        "w-operations-table",
        "Only this sum of printed parts was found to give the number: the Jacobian, the multiplications of JJᵀ alone, and 6³ "
        f"for a determinant by elimination. The appendix counts {of_appendix} for the same thing.",
        " + ".join(map(str, table)),
    )
    yield counted(
        "svd-operations",
        [counts.iterated],
        "m²n is how the cost grows and not the cost: even the entries of JJᵀ that differ, of which the squared singular values "
        f"are the eigenvalues, take {counts('gram', 'symmetric')}.",
    )
    yield counted(
        "kci-operations",
        [sums["written out"]["KCI"]],
        f"Jacobian as the paper counts it, and m²n; {sums['reduced']['KCI']} operations reduced, with the iteration.",
    )


def _on_networks(on: Judge, counts: Counts) -> Iterator[Verdict]:
    for name in INDICES:
        yield _counted(
            on,
            f"feed-forward-{name.lower()}-operations",
            [counts(f"feed-forward {name}", "printed")],
            "Each neuron takes d + 3 additions and d + 6 multiplications for d inputs; with constants worked into the weights "
            f"the network takes {counts(f'feed-forward {name}', 'folded')}.",
        )
    both = ("additions", "multiplications")
    ours = [counts("feed-forward KCI", "printed", kind) for kind in both]
    yield _counted(
        on,
        "feed-forward-kci-split",
        ours,
        "Eqs. 13 to 16 as printed: four exponentials and a division per neuron.",
    )
    for name in INDICES:
        network = f"radial-basis {name}"
        neurons, inputs = (counts(network, "norm", column) for column in ("neurons", "inputs"))
        inferred = "" if name == "w" else f"With {neurons} neurons, a number inferred from this very count. "
        yield _counted(
            on,
            f"radial-basis-{name.lower()}-operations",
            [counts(network, "norm")],
            f"{inferred}Eq. 18 with its norm takes {counts(network, 'norm') // neurons} operations per neuron for {inputs} inputs; "
            f"as printed, without the norm, {counts(network, 'printed')} in all, without the needless root "
            f"{counts(network, 'shared')}.",
        )
        printed = [int(one) // neurons for one in on.printed(f"radial-basis-{name.lower()}-split")]
        ours = [counts(network, "norm", kind) for kind in both]
        yield _counted(
            on,
            f"radial-basis-{name.lower()}-split",
            ours,
            f"The paper has {printed} per neuron for seven inputs and for eleven, which no formula in the number of inputs gives; "
            f"ours has {[one // neurons for one in ours]} for {inputs}.",
        )


def _counted(on: Judge, claim: str, ours: list[int], note: str) -> Verdict:
    values: Any = ours if isinstance(on.printed(claim), tuple) else ours[0]
    return on(claim, values, note, ours=f"{', '.join(map(str, ours))} operations")
