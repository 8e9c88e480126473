"""Check verdicts against the ledgers, and acceptance figures against their limits: `python -m …claims.check`."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Iterator

from dexterity_study.claims.ledger import load_papers
from dexterity_study.claims.scorecard import all_verdicts, faults
from dexterity_study.engine.evidence import Evidence, chapters


def missed() -> Iterator[str]:
    """Yield a line for each acceptance figure that exceeds its limit."""
    for chapter in chapters():
        module = importlib.import_module(f"dexterity_study.{chapter}.verdicts")
        for figure in module.acceptance(Evidence(chapter)):
            if not figure.holds:
                yield f"{chapter}: {figure.name} is {figure.value:.3g}, its limit is {figure.limit:.3g}"


def main() -> int:
    """Print what is wrong; the exit code is 0 if nothing is."""
    wrong = [*faults(load_papers(), all_verdicts()), *missed()]
    sys.stdout.write("".join(f"{line}\n" for line in wrong) or "all is well\n")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
