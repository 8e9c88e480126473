"""Stored results and verdicts from the command line: `python -m dexterity.studies full|probe|check`."""

import argparse
import sys
from collections.abc import Iterable, Iterator, Sequence

from dexterity.report.claims import ledger_faults, load_papers
from dexterity.report.provenance import ProbeMissed, check_stored, load_stored, write_stored
from dexterity.studies import STUDIES, acceptances, verdicts_by_study


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; the exit code is 0 if nothing was found wrong."""
    parser = argparse.ArgumentParser(prog="python -m dexterity.studies", description=__doc__)
    commands = parser.add_subparsers(dest="command", required=True)
    full = commands.add_parser("full", help="run studies at full scale and store their results")
    full.add_argument("study", nargs="?", choices=STUDIES, help="one study; all if none is named")
    commands.add_parser("probe", help="repeat the probe of every stored result")
    commands.add_parser("check", help="check verdicts against the ledgers, and the acceptance figures")
    options = parser.parse_args(arguments)
    if options.command == "full":
        return _full([options.study] if options.study else STUDIES)
    return _report(_missed_probes() if options.command == "probe" else _faults())


def _full(names: Iterable[str]) -> int:
    for name in names:
        sys.stdout.write(f"{write_stored(name).name} written\n")
    return 0


def _missed_probes() -> Iterator[str]:
    for name in STUDIES:
        try:
            if load_stored(name) is not None:
                check_stored(name)
        except (ProbeMissed, ValueError) as error:
            yield str(error)


def _faults() -> Iterator[str]:
    yield from ledger_faults(load_papers(), verdicts_by_study())
    for name, figures in acceptances().items():
        for figure in figures:
            if not figure.holds:
                yield f"study {name}: {figure.name} is {figure.value:.3g}, its limit is {figure.limit:.3g}"


def _report(faults: Iterable[str]) -> int:
    found = list(faults)
    sys.stdout.write("".join(f"{fault}\n" for fault in found) or "all is well\n")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
