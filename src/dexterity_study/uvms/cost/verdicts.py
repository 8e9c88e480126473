"""Verdicts on the operation counts of paper A."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial

import pandas as pd

from dexterity_study.claims.judge import Judge, by_reading
from dexterity_study.claims.outcome import Acceptance, Verdict
from dexterity_study.engine.evidence import Evidence
from dexterity_study.uvms.cost.experiment import INDICES

KINDS = ("additions", "multiplications")
PRINTED = {"feed-forward": "printed", "radial-basis": "norm"}
"""Form in which a network is counted as its equations are printed, with the norm that Eq. 18 leaves out."""

EXPRESSIONS = ("chosen", "analytical-expressions=shared", "analytical-expressions=reduced")
"""Readings of what the analytical expressions are: with nothing shared, with common terms named, and reduced."""


class Counts:
    """The counted operations, and the sums that Appendix A and Table 4 make of them.

    `exact` holds the operations of w and KCI as the paper counts, with terms shared, and reduced; `singular_values`
    the first two for the singular values alone, where the paper has m²n.
    """

    def __init__(self, evidence: Evidence) -> None:
        self.rows = evidence["counts"].where().set_index(["what", "form"])
        checks = evidence["checks"].where()
        self.steps, self.most_steps = int(checks["steps"].median()), int(checks["most_steps"].max())
        iteration = self.steps * self("Laguerre", "step") + self("root", "of a ratio")
        self.singular_values = 6**2 * 12, self("bidiagonal", "dense") + iteration
        written, shared = self("Jacobian", "written out"), self("Jacobian", "written out, terms shared")
        w_written = written + self("gram", "all") + self("determinant", "terms")
        w_shared = (
            shared + self("gram", "symmetric") + self("determinant", "elimination") + self("root", "one")
        )
        kci_written, kci_shared = written + self.singular_values[0], shared + self.singular_values[1]
        self.exact = {
            "w": (w_written, w_shared, self("w", "closed form")),
            "KCI": (kci_written, kci_shared, self("bidiagonal", "reduced") + iteration),
        }

    def __call__(self, what: str, form: str, kind: str = "operations") -> int:
        """Return a number of operations, additions or multiplications."""
        return int(self.rows[kind][what, form])


def verdicts(evidence: Evidence) -> Iterator[Verdict]:
    """Judge the claims of the chapter."""
    on, counts = Judge("sotiropoulos2016"), Counts(evidence)
    counted = partial(on, form="{:.0f}", unit="operations")
    yield from _on_statements(on, evidence, counts)
    yield from _on_parts(on, counted, counts)
    yield from _on_sums(on, counted, counts)
    yield from _on_networks(on, counted, counts)


def acceptance(evidence: Evidence) -> Iterator[Acceptance]:
    """Figures that must hold for the book to be accepted."""
    checks, exact = evidence["checks"].where(), Counts(evidence).exact
    yield Acceptance("Jacobian written out, against the chain's", checks["written"].max(), 1e-12)
    yield Acceptance("w in closed form, relative", checks["closed"].max(), 1e-10)
    yield Acceptance("KCI by Laguerre's iteration, relative", checks["laguerre"].max(), 1e-10)
    for name, limit in (("w", 0.02), ("KCI", 0.1)):
        share = exact[name][-1] / exact[name][0]
        yield Acceptance(f"operations of {name}, reduced over written out", share, limit)


def _on_statements(on: Judge, evidence: Evidence, counts: Counts) -> Iterator[Verdict]:
    algebra = evidence["algebra"].where().iloc[0]
    for claim in ("sine-by-exponentials", "cosine-by-exponentials"):
        yield on(claim, 0.0 if algebra["euler"] else 1.0, "An identity; sympy finds no difference.", ours="–")
    written, shared = counts("Jacobian", "written out"), counts("Jacobian", "written out, terms shared")
    reduced = {name: counts("Jacobian", f"reduced, for {name}") for name in INDICES}
    few = {name: counts(f"feed-forward {name}", "printed") for name in INDICES}
    jacobians = (dict.fromkeys(INDICES, written), dict.fromkeys(INDICES, shared), reduced)
    more = [[own[name] > few[name] for name in INDICES] for own in jacobians]
    yield on(
        "jacobian-is-expensive",
        by_reading(dict(zip(EXPRESSIONS, more, strict=True))),
        f"A great many is read as more than the paper's small network of the same index takes in all, {few['w']} (w) and "
        f"{few['KCI']} (KCI). The printed form does. With each common term computed once the same entries take "
        f"{written / shared:.0f} times fewer operations, and in better axes {reduced['w']} (w) and {reduced['KCI']} (KCI).",
        ours=f"{written} operations written out, {shared} with terms shared",
    )
    closed_form = counts("w", "closed form")
    note = f"Relative deviation of the closed form, {closed_form} operations, from the singular values."
    yield on("w-has-symbolic-form", evidence["checks"].values("closed"), note)
    yield on(
        "kci-has-no-closed-form",
        [not algebra["solvable"]],
        f"At a configuration with rational sines and cosines the polynomial of the squared singular values has the Galois "
        f"group {algebra['group']}: neither they nor their ratio can be written with roots. The iteration is short: "
        f"{counts.steps} steps of {counts('Laguerre', 'step')} operations.",
        ours=f"Galois group {algebra['group']}",
    )
    note = "Eqs. 13 to 18 hold joint values and weights alone. Training needs the index, and with it the Jacobian."
    yield on("networks-skip-the-jacobian", [True], note)
    yield from (_cheaper(on, counts, kind) for kind in PRINTED)
    cheaper = {
        name: counts(f"feed-forward {name}", "printed") < counts(f"radial-basis {name}", "norm")
        for name in INDICES
    }
    note = "For the printed numbers of neurons, and because of them: a single neuron costs about as much in either."
    yield on("feed-forward-cheaper-than-radial-basis", cheaper, note)


def _cheaper(on: Judge, counts: Counts, kind: str) -> Verdict:
    """Judge whether networks of a kind, for either index, take fewer operations than the exact index."""
    own = {name: counts(f"{kind} {name}", PRINTED[kind]) for name in INDICES}
    exact = {
        reading: [counts.exact[name][form] for name in INDICES] for form, reading in enumerate(EXPRESSIONS)
    }
    cases = {
        reading: [network < other for network, other in zip(own.values(), others, strict=True)]
        for reading, others in exact.items()
    }
    each = "; ".join(
        f"for {name} {' (nothing shared), '.join(str(counts.exact[name][form]) for form in (0, 1))} (terms shared) and "
        f"{counts.exact[name][2]} (reduced)"
        for name in INDICES
    )
    return on(
        f"{kind}-cheaper-than-analytical",
        by_reading(cases),
        f"Cases: indices. The exact index takes {each}.",
        ours=", ".join(f"{count} operations ({name})" for name, count in own.items()),
    )


def _on_parts(on: Judge, counted: Callable[..., Verdict], counts: Counts) -> Iterator[Verdict]:
    per_call = [counts("sine", "exponentials", kind) for kind in reversed(KINDS)]
    note = "Two exponentials, one sum and one quotient; the multiplication by i and the divisor are free."
    yield counted("sine-costs-four", per_call, note)
    as_printed = {"Jacobian": "written out", "gram": "all", "determinant": "terms"}
    for kind in ("operations", *KINDS):
        shared = counts("Jacobian", "written out, terms shared", kind)
        flat, raised = (counts("Jacobian", f"written out{l1}", kind) for l1 in (", l1 = 0", ""))
        note = (
            f"The Jacobian of the product of exponentials, nothing shared, with l1 = 0; with another l1 it takes {raised}, and "
            f"with common terms named {shared}."
        )
        yield counted(f"jacobian-{kind}", _by_height(flat, raised), note)
    for kind in KINDS:
        note = f"Of all 36 entries; the 21 that differ take {counts('gram', 'symmetric', kind)}."
        yield counted(f"gram-{kind}", counts("gram", "all", kind), note)
        elimination = counts("determinant", "elimination", kind)
        note = f"The sum over all permutations of six columns; Gauss' elimination takes {elimination}."
        yield counted(f"determinant-{kind}", counts("determinant", "terms", kind), note)
        parts = [int(on.printed(f"{part.lower()}-{kind}")) for part in as_printed]
        ours = sum(counts(part, form, kind) for part, form in as_printed.items())
        note = f"The printed parts {parts} add up to {sum(parts)}, which the appendix "
        note += f"{{}}; counted here they are {ours}."
        if slip := int(on.printed(f"w-{kind}")) - sum(parts):
            yield on.misprint(f"w-{kind}", note.format(f"misses by {abs(slip)}"), f"{sum(parts)} operations")
        else:
            yield counted(f"w-{kind}", sum(parts), note.format("prints"))


def _on_sums(on: Judge, counted: Callable[..., Verdict], counts: Counts) -> Iterator[Verdict]:
    w, kci = counts.exact["w"], counts.exact["KCI"]
    less = counts("Jacobian", "written out") - counts("Jacobian", "written out, l1 = 0")
    note = f"Jacobian, JJᵀ and determinant as the paper counts them, with l1 = 0; {w[0]} with another l1, {w[-1]} reduced."
    yield counted("w-operations-appendix", _by_height(w[0] - less, w[0]), note)
    table = [int(on.printed("jacobian-operations")), int(on.printed("gram-multiplications")), 6**3]
    fits = sum(table) == int(on.printed("w-operations-table"))
    yield (on.fitted if fits else on.underspecified)(
        "w-operations-table",
        "Only this sum of printed parts was found to give the number: the Jacobian, the multiplications of JJᵀ alone, and 6³ "
        f"for a determinant by elimination. The appendix counts {on.printed('w-operations-appendix'):.0f} for the same thing.",
        " + ".join(map(str, table)),
    )
    note = (
        "m²n is how the cost grows and not the cost: even the entries of JJᵀ that differ, of which the squared singular values "
        f"are the eigenvalues, take {counts('gram', 'symmetric')}."
    )
    yield counted("svd-operations", counts.singular_values[1], note)
    note = (
        f"Jacobian as the paper counts it, with l1 = 0, and m²n; {kci[0]} with another l1, {kci[-1]} reduced, with the "
        "iteration."
    )
    yield counted("kci-operations", _by_height(kci[0] - less, kci[0]), note)


def _on_networks(on: Judge, counted: Callable[..., Verdict], counts: Counts) -> Iterator[Verdict]:
    for name in INDICES:
        network = f"feed-forward {name}"
        note = "A neuron takes d + 3 additions and d + 6 multiplications for d inputs; with constants worked into the weights"
        note += f" the network takes {counts(network, 'folded')}."
        yield counted(f"feed-forward-{name.lower()}-operations", counts(network, "printed"), note)
    split = [counts("feed-forward KCI", "printed", kind) for kind in KINDS]
    note = "Eqs. 13 to 16 as printed: four exponentials and a division per neuron."
    yield counted("feed-forward-kci-split", split, note)
    yield from _on_radial_basis(on, counted, counts)


def _on_radial_basis(on: Judge, counted: Callable[..., Verdict], counts: Counts) -> Iterator[Verdict]:
    sizes = {name: counts(f"radial-basis {name}", "norm", "neurons") for name in INDICES}
    inputs = {name: counts(f"radial-basis {name}", "norm", "inputs") for name in INDICES}
    rule = {name: per_neuron(inputs[name]) for name in INDICES}
    explained = all(
        [int(part) for part in on.printed(f"radial-basis-{name.lower()}-split")]
        == [sizes[name] * part for part in rule["KCI"]]
        for name in INDICES
    )
    way = (
        f"Both printed counts are {rule['KCI'][0]} additions and {rule['KCI'][1]} multiplications per neuron: (d + 1) and "
        f"(d + 5) for d = {inputs['KCI']} inputs, which is Eq. 18 with its norm but without the d − 1 sums of squares under "
        "the root"
    )
    for name in INDICES:
        network, claim = f"radial-basis {name}", f"radial-basis-{name.lower()}"
        total, plain = counts(network, "norm"), counts(network, "printed", "multiplications") // sizes[name]
        ours = (
            f"With its norm Eq. 18 takes {total} for {inputs[name]} inputs and {sizes[name]} neurons; as printed, without the "
            f"norm, it has {plain} multiplications per neuron"
        )
        if explained and rule[name] != rule["KCI"]:
            same = [sizes[name] * part for part in rule[name]]
            note = f"{way}. The network for {name} has {inputs[name]} inputs; by the same rule it takes {sum(same)}. {ours}."
            yield on.misprint(f"{claim}-operations", note, f"{sum(same)} operations")
            yield on.misprint(f"{claim}-split", note, f"{', '.join(map(str, same))} operations")
        else:
            note = f"{way}. So the number of neurons is certain. {ours}." if explained else f"{ours}."
            yield counted(f"{claim}-operations", total, note)
            yield counted(f"{claim}-split", [counts(network, "norm", kind) for kind in KINDS], note)


def _by_height(flat: int, raised: int) -> pd.Series:
    """Return a count by the height l1 of the shoulder: any but zero gives the same count."""
    return by_reading({"chosen": flat, **{f"base-link-height={height}": raised for height in ("0.1", "0.2")}})


def per_neuron(inputs: int) -> tuple[int, int]:
    """Return additions and multiplications per neuron by which the paper's radial-basis counts come out.

    Additions are the differences and one sum at the output; multiplications the squares, a root, the bias, a square, an
    exponential and an output weight. The sums of squares under the root are not among them.
    """
    return inputs + 1, inputs + 5
