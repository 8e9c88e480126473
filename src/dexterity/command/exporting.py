"""``dexterity export``: an exact index or a network as files to take on board.

Examples
--------
>>> import dexterity as dx
>>> from dexterity.command.exporting import index_files
>>> from dexterity.command.options import Language
>>> files = index_files(dx.robots.puma560(), dx.Index("manipulability"), Language.C, "puma_w", single=False)
>>> sorted(files)
['puma_w.c', 'puma_w.h']
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import dexterity as dx
from dexterity import checks, codegen, store
from dexterity.chain import Chain
from dexterity.codegen.c99 import function_name
from dexterity.codegen.names import words
from dexterity.command.options import Language
from dexterity.command.reports import Report
from dexterity.indices import Index
from dexterity.networks import Network
from dexterity.networks import export as network_export

__all__ = ["index_files", "kinematics_files", "network_files", "write"]


def kinematics_files(chain: Chain, form: Language, name: str | None, single: bool) -> dict[str, str | bytes]:
    """Return pose, Jacobians and joint rates of a robot as C with a header, by file names.

    Raises
    ------
    ValueError
        If the form is another one, or the name cannot be used in C.
    """
    if form is not Language.C:
        raise ValueError(f"--form is {form.value}; kinematics are written as c")
    return {**codegen.c_files(chain, name, "float" if single else "double")}


def index_files(
    chain: Chain, index: Index, form: Language, name: str | None, single: bool
) -> dict[str, str | bytes]:
    """Source code of an exact index, by file names.

    Parameters
    ----------
    chain, index
        Robot and index.
    form
        C, with a header, or JavaScript.
    name
        What all names in the files begin with; one that tells variants apart by default.
    single
        Whether the C file computes in single precision.

    Raises
    ------
    ValueError
        If an index cannot be written in this form, or the name cannot be used in it.
    """
    derivation = dx.symbolic.derive(chain, index)
    if form is Language.C:
        return {**codegen.c_files(derivation, name, "float" if single else "double")}
    if form is Language.ONNX:
        raise ValueError("--form is onnx, which is for networks; an index is written as c or javascript")
    _require_double(single, form)
    stem = checks.identifier(name, "--name") if name else function_name(derivation.chain, index)
    return {f"{stem}.js": codegen.javascript_module(derivation)}


def network_files(network: Network, form: Language, name: str | None, single: bool) -> dict[str, str | bytes]:
    """Return a network as C with a header, JavaScript or ONNX, by file names.

    Parameters
    ----------
    network
        A network; its card gives the name where none is given, written with letters, digits and underscores.
    form, name, single
        As for :func:`index_files`; ONNX has single precision too.

    Raises
    ------
    ValueError
        If the name cannot be used.
    ImportError
        If the package onnx is missing.
    """
    # A file's own name for itself may be anything, a path included.
    stem = checks.identifier(name, "--name") if name else words(str(network.card.get("name", "network")))
    if form is Language.C:
        return {**network_export.c_files(network, stem, "float" if single else "double")}
    if form is Language.ONNX:
        model = dx.networks.onnx_models.onnx_model(network, "float" if single else "double")
        return {f"{stem}.onnx": model.SerializeToString(deterministic=True)}
    _require_double(single, form)
    return {f"{stem}.js": network_export.javascript_module(network)}


def _require_double(single: bool, form: Language) -> None:
    if single:
        raise ValueError(f"--single is for c and onnx; {form.value} has double precision alone")


def write(files: Mapping[str, str | bytes], folder: Path) -> Report:
    """Write files as one set, with a list of their checksums, and say what they are.

    Raises
    ------
    OSError
        If a file cannot be written.
    """
    stem = next(iter(files)).partition(".")[0]
    paths = store.write_set(folder, f"{stem}.sha256", files)
    return Report({"file": [str(path) for path in paths], "bytes": [path.stat().st_size for path in paths]})
