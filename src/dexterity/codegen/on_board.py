"""Standard C to take on board: an index with its gradient, or a chain's kinematics, as a header and a file.

Examples
--------
>>> import tempfile
>>> import dexterity as dx
>>> folder = tempfile.mkdtemp()
>>> paths = dx.codegen.write_c(folder, dx.robots.puma560(), name="puma")
>>> [path.name for path in paths]
['puma.c', 'puma.h']
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path

from dexterity import checks, store
from dexterity.chain import Chain
from dexterity.codegen import c99, c_kinematics
from dexterity.codegen.c_file import Precision
from dexterity.derivation import Derivation, SymbolicChain

__all__ = ["c_files", "write_c"]


def c_files(
    subject: Derivation | Chain | SymbolicChain, name: str | None = None, precision: Precision = "double"
) -> dict[str, str]:
    """Return a header and a C file, by their file names.

    Parameters
    ----------
    subject
        A derived index (:func:`dexterity.symbolic.derive`) for its value and gradient, or a chain for its
        pose, its Jacobians, and joint rates for a twist.
    name
        What all names in the files begin with; by default it says what is computed, and ends in eight digits
        that distinguish all variants.
    precision
        Type of all numbers: ``"double"``, or ``"float"`` for processors without doubles.

    Raises
    ------
    TypeError
        If the subject is nothing that can be written, or the name no text.
    ValueError
        If the name cannot be used in C and C++, the precision is unknown, a number is not finite or too
        large for it, or the chain has lengths without a value or too few joints for the index.
    """
    if isinstance(subject, Derivation):
        return c99.c_files(subject, name, precision)
    if isinstance(subject, Chain | SymbolicChain):
        return c_kinematics.c_files(subject, name, precision)
    raise TypeError(
        f"subject is {checks.shown(subject)}; a Chain is needed, or an index that is derived for one: "
        "dexterity.symbolic.derive(chain, index)"
    )


@checks.arguments(folder=checks.path)
def write_c(
    folder: str | os.PathLike[str],
    subject: Derivation | Chain | SymbolicChain | Mapping[str, str],
    name: str | None = None,
    precision: Precision = "double",
) -> list[Path]:
    """Write a header and a C file into a folder as one set, and return their paths.

    A list of their checksums is written last, beside them: ``sha256sum --check`` and
    :func:`dexterity.store.read_set` notice files of two different sets.

    Parameters
    ----------
    folder
        Where to write; made if it is missing.
    subject
        As of :func:`c_files`, or texts by their file names, such as those of a network.
    name, precision
        As of :func:`c_files`.

    Raises
    ------
    TypeError, ValueError
        As :func:`c_files`.
    OSError
        If a file cannot be written.
    """
    if isinstance(subject, Mapping):
        files = checks.Named(checks.Instance(str))(subject, "subject")
    else:
        files = c_files(subject, name, precision)
    stem = min(files, default="c").partition(".")[0]
    return list(store.write_set(folder, f"{stem}.sha256", dict(sorted(files.items()))))
