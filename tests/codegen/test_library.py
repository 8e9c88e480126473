"""Compiling on demand: what is kept, what is not done twice, and what is said when it cannot be done."""

import hashlib
import os
import re
import shutil
import stat
import subprocess
import textwrap
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
import torch
from torch.testing import assert_close

import dexterity as dx
from dexterity import store, symbolic
from dexterity.codegen import compiler as c_compiler
from dexterity.codegen import engine, library
from dexterity.indices import Index
from dexterity.symbolic import CompilationFailed
from warm_process import WarmProcess

PUMA = dx.robots.puma560()
W = Index("manipulability")
FLAGS = library.FLAGS  # as they are before tests compile without optimisation
SOURCE = "int twice(int x);\nint twice(int x) { return 2*x; }\n"


@pytest.fixture(autouse=True)
def cache(tmp_path, monkeypatch) -> Path:
    """Return a cache folder of this test's own, not there yet."""
    folder = tmp_path / "cache"
    monkeypatch.setenv("DEXTERITY_CACHE", str(folder))
    monkeypatch.delenv("CC", raising=False)
    return folder


@pytest.fixture
def compiler(tmp_path, monkeypatch) -> Callable[[str], None]:
    """Return what makes a shell script the compiler; ``real "$@"`` in it is the compiler of the system."""

    def use(script: str) -> None:
        path = tmp_path / "compiler"
        path.write_text(f'#!/bin/sh\nreal() {{ cc "$@"; }}\n{textwrap.dedent(script)}', encoding="utf-8")
        path.chmod(path.stat().st_mode | stat.S_IXUSR)
        monkeypatch.setenv("CC", str(path))

    return use


ONLY_DESCRIBES = 'case "$*" in *-E*) real "$@"; exit;; esac\n'  # what the compiler is asked for first


def kept(folder: Path) -> list[str]:
    """Endings of the entries of the cache folder; each has its sum beside it, and nothing else is there."""
    code = folder / "code"
    names = {path.name for path in code.rglob("*")}
    entries = {name for name in names if not name.endswith(".sha256")}
    assert names == entries | {f"{name}.sha256" for name in entries}
    assert all(re.fullmatch(r"[0-9a-f]{16}\.(c|so)", name) for name in entries)
    return sorted(Path(name).suffix for name in entries)


# ---- what is kept ----------------------------------------------------------------------------------


def test_a_source_is_compiled_loaded_and_kept(cache):
    assert library.compiled_library(SOURCE).twice(21) == 42
    assert kept(cache) == [".so"]


def test_nothing_is_compiled_twice(cache, compiler, tmp_path):
    log = tmp_path / "log"
    compiler(f'echo "$*" >> {log}\nreal "$@"')
    for _ in range(3):
        assert library.compiled_library(SOURCE).twice(21) == 42
    assert sum("index.so" in line for line in log.read_text().splitlines()) == 1
    assert library.compiled_library(SOURCE.replace("2*x", "3*x")).twice(2) == 6
    assert kept(cache) == [".so", ".so"]


def test_a_kept_index_is_neither_derived_nor_compiled_again(cache, compiler, monkeypatch, tmp_path):
    log = tmp_path / "log"
    compiler(f'echo "$*" >> {log}\nreal "$@"')
    first = symbolic.compile_index(PUMA, W, "c")

    def derive_again(*_: object) -> None:
        pytest.fail("the index was derived again")

    monkeypatch.setattr(engine, "derive", derive_again)
    second = symbolic.compile_index(dx.robots.puma560(), W, "c")
    assert sum("index.so" in line for line in log.read_text().splitlines()) == 1
    assert kept(cache) == [".c", ".so"]
    q = torch.ones(6, dtype=torch.float64)
    assert_close(second(q), first(q), rtol=0, atol=0)


def test_a_change_of_any_module_or_template_changes_the_key(tmp_path):
    copy = tmp_path / "package"
    shutil.copytree(store.PACKAGE, copy, ignore=shutil.ignore_patterns("__pycache__", "_data"))

    def key() -> str:
        return engine._generator_key.__wrapped__(copy)

    before = key()
    assert before == engine._generator_key.__wrapped__(store.PACKAGE)
    # One file of each kind in each folder; all files of a folder are read alike.
    files = {(path.parent, path.suffix): path for path in copy.rglob("*") if path.suffix in (".py", ".in")}
    assert {path.parent.name for path in files.values()} >= {"package", "codegen", "templates", "crane"}
    for path in files.values():
        content = path.read_bytes()
        path.write_bytes(content + b"\n")
        assert key() != before, path
        path.write_bytes(content)
    (copy / "moved.py").write_text("")
    assert key() != before


def test_another_chain_index_or_limit_is_another_entry(cache):
    moved = PUMA.home
    moved[0, 3] += 1e-9
    q = torch.ones(6, dtype=torch.float64)
    values = [
        symbolic.compile_index(chain, index, "c")(q).item()
        for chain, index in [
            (PUMA, W),
            (dx.Chain(PUMA.screws, PUMA.home, name="another name"), W),
            (dx.Chain(PUMA.screws, moved, name=PUMA.name), W),
            (dx.Chain(PUMA.screws, PUMA.home, name=PUMA.name, rates=[1, 2, 1, 1, 1, 1]), W),
            (PUMA, Index("manipulability", "body")),
            (PUMA, Index("manipulability", joint_rates=(1, 1, 3, 1, 1, 1))),
            (PUMA, Index("manipulability", tool_rates=(1, 1, 1, 1, 1, 0.5))),
        ]
    ]
    assert kept(cache) == [".c"] * 7 + [".so"] * 7
    w = values[0]
    assert values == pytest.approx([w, w, w, 2 * w, w, 3 * w, 2 * w], rel=1e-12)


def test_flags_and_compilers_have_entries_of_their_own(cache, monkeypatch):
    library.compiled_library(SOURCE)
    monkeypatch.setenv("CC", "cc -DANOTHER")
    assert library.compiled_library(SOURCE).twice(21) == 42
    monkeypatch.setattr(library, "FLAGS", (*library.FLAGS, "-DONE_MORE"))
    library.compiled_library(SOURCE)
    assert kept(cache) == [".so"] * 3


def test_many_may_compile_the_same_at_once(cache):
    with ThreadPoolExecutor(4) as threads:
        libraries = list(threads.map(library.compiled_library, [SOURCE] * 8))
    assert [loaded.twice(21) for loaded in libraries] == [42] * 8
    assert kept(cache) == [".so"]


def test_a_kept_index_is_ready_within_a_second(cache, monkeypatch):
    monkeypatch.setattr(library, "FLAGS", FLAGS)  # the other process has them too
    value = symbolic.compile_index(PUMA, W, "c")([1.0] * 6).item()
    script = textwrap.dedent("""
        import time
        import dexterity as dx
        from dexterity import store, symbolic
        from dexterity.indices import Index

        puma, index = dx.robots.puma560(), Index("manipulability")
        start = time.process_time()  # of this process alone, whatever else the machine does
        value = symbolic.compile_index(puma, index, "c")([1.0] * 6).item()
        print(time.process_time() - start, value)
    """)
    ended, printed = WarmProcess(script).end()
    assert ended == 0, printed
    seconds, again = map(float, printed.split())
    assert again == value
    assert seconds < 1
    assert kept(cache) == [".c", ".so"]


def test_the_cache_folder_is_the_named_one_or_in_the_users_cache(monkeypatch, tmp_path):
    monkeypatch.setenv("DEXTERITY_CACHE", str(tmp_path / "named"))
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "xdg"))
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    assert library.cache_folder() == tmp_path / "named"
    monkeypatch.setenv("DEXTERITY_CACHE", "")
    assert library.cache_folder() == tmp_path / "xdg" / "dexterity"
    monkeypatch.delenv("DEXTERITY_CACHE")
    monkeypatch.delenv("XDG_CACHE_HOME")
    assert library.cache_folder() == tmp_path / "home" / ".cache" / "dexterity"


# ---- compilers -------------------------------------------------------------------------------------


def test_a_compiler_may_be_named_with_arguments(monkeypatch):
    monkeypatch.setenv("CC", "cc -DX=1")
    source = SOURCE.replace("2*x", "X*x")
    assert library.compiled_library(source).twice(21) == 21


def test_flags_that_the_compiler_refuses_are_left_out(compiler, tmp_path):
    log = tmp_path / "log"
    compiler(f"""
        echo "$*" >> {log}
        case "$*" in *-march=native*) echo "no such flag" >&2; exit 1;; esac
        real "$@"
    """)
    assert library.compiled_library(SOURCE).twice(21) == 42
    assert "-march" not in log.read_text().splitlines()[-1]


@pytest.mark.parametrize("path", ["/nonexistent/cc", "no-such-compiler -O2"])
def test_a_compiler_that_is_not_there_is_named_and_torch_goes_on(cache, monkeypatch, path):
    monkeypatch.setenv("CC", path)
    with pytest.raises(
        CompilationFailed, match=rf"^there is no C compiler \(CC is '{path}'\).*backend=\"torch\""
    ):
        symbolic.compile_index(PUMA, W, "c")
    assert symbolic.compile_index(PUMA, W)([1.0] * 6) > 0
    assert ".so" not in kept(cache)


def test_without_any_compiler_torch_goes_on(cache, monkeypatch, tmp_path):
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(CompilationFailed, match=r"^there is no C compiler \(cc, gcc and clang were tried\)"):
        symbolic.compile_index(PUMA, W, "c")
    assert symbolic.compile_index(PUMA, W)([1.0] * 6) > 0
    assert ".so" not in kept(cache)


FAILING = {
    "at once": ("echo out of order >&2\nexit 1", "failed with status 1: out of order"),
    "silently": ("exit 1", "failed with status 1: it printed nothing"),
    "at the source": (
        ONLY_DESCRIBES + "echo out of memory >&2\nexit 4",
        "failed with status 4: out of memory",
    ),
    "half way": (
        ONLY_DESCRIBES + 'while [ "$1" != -o ]; do shift; done\necho half > "$2"\necho disk full >&2\nexit 1',
        "failed with status 1: disk full",
    ),
    "without a result": (ONLY_DESCRIBES + "exit 0", "ended without an error, and without a library"),
    "by a signal": (ONLY_DESCRIBES + "kill -9 $$", "failed with status -9"),
}


@pytest.mark.parametrize(("script", "message"), FAILING.values(), ids=FAILING)
def test_a_compiler_that_fails_is_quoted_and_leaves_nothing(cache, compiler, monkeypatch, script, message):
    compiler(script)
    with pytest.raises(CompilationFailed, match=f"^{re.escape(os.environ['CC'])} {message}"):
        library.compiled_library(SOURCE)
    assert not cache.exists() or kept(cache) == []
    monkeypatch.delenv("CC")
    assert library.compiled_library(SOURCE).twice(21) == 42


def test_a_source_that_is_no_c_is_refused_with_the_compilers_words(cache):
    with pytest.raises(CompilationFailed, match=r"failed with status 1: (.|\n)*error"):
        library.compiled_library("this is no C\n")
    assert kept(cache) == []


def test_of_a_long_message_the_end_is_quoted(compiler):
    compiler(ONLY_DESCRIBES + "for i in $(seq 1000); do echo line $i >&2; done\nexit 1")
    with pytest.raises(CompilationFailed) as caught:
        library.compiled_library(SOURCE)
    assert "line 1000" in str(caught.value)
    assert "line 900" not in str(caught.value)


def test_a_compiler_that_is_no_program_is_named(monkeypatch, tmp_path):
    path = tmp_path / "compiler"
    path.write_bytes(b"\x00\x01no program")
    path.chmod(0o755)
    monkeypatch.setenv("CC", str(path))
    with pytest.raises(CompilationFailed, match=rf"^{re.escape(str(path))} cannot be run: "):
        library.compiled_library(SOURCE)


# ---- folders that cannot be written ----------------------------------------------------------------


def test_a_cache_folder_that_cannot_be_written_is_named(monkeypatch, tmp_path):
    """Below a regular file, where not even the administrator writes."""
    (tmp_path / "file").write_text("no folder")
    folder = tmp_path / "file" / "cache"
    monkeypatch.setenv("DEXTERITY_CACHE", str(folder))
    message = (
        rf"^the cache folder {re.escape(str(folder))} cannot be written \(.*DEXTERITY_CACHE names another"
    )
    with pytest.raises(OSError, match=message):
        symbolic.compile_index(PUMA, W, "c")
    with pytest.raises(OSError, match=message):
        library.compiled_library(SOURCE)
    with pytest.raises(OSError, match=message):
        library.cached_source("key", lambda: SOURCE)
    assert symbolic.compile_index(PUMA, W)([1.0] * 6) > 0


def test_a_cache_folder_that_is_a_file_is_named(monkeypatch, tmp_path):
    file = tmp_path / "file"
    file.write_text("no folder")
    monkeypatch.setenv("DEXTERITY_CACHE", str(file))
    with pytest.raises(OSError, match=rf"^the cache folder {re.escape(str(file))} cannot be written"):
        library.compiled_library(SOURCE)
    assert file.read_text() == "no folder"


def test_a_source_is_made_once(cache):
    made = []

    def make() -> str:
        made.append(1)
        return SOURCE

    assert library.cached_source("key", make) == library.cached_source("key", make) == SOURCE
    assert len(made) == 1


def test_a_source_that_cannot_be_made_is_not_kept(cache):
    def make() -> str:
        raise ValueError("no such chain")

    with pytest.raises(ValueError, match="no such chain"):
        library.cached_source("key", make)
    assert kept(cache) == []


# ---- foreign and damaged code ----------------------------------------------------------------------


def entry(cache: Path, suffix: str) -> Path:
    (path,) = (cache / "code").glob(f"*{suffix}")
    return path


FOREIGN = """
#include <stdlib.h>
__attribute__((constructor)) static void start(void) { abort(); }
int twice(int x) { return x; }
"""


def foreign_library(folder: Path) -> bytes:
    (folder / "foreign.c").write_text(FOREIGN)
    subprocess.run(["cc", "-shared", "-fPIC", folder / "foreign.c", "-o", folder / "foreign.so"], check=True)
    return (folder / "foreign.so").read_bytes()


def pipe(path: Path, _: bytes) -> None:
    path.unlink()
    os.mkfifo(path)


def link(path: Path, content: bytes) -> None:
    other = path.with_name("other")
    other.write_bytes(content)
    path.unlink()
    path.symlink_to(other)


def folder(path: Path, _: bytes) -> None:
    path.unlink()
    path.mkdir()


DAMAGES = {
    "truncated": lambda path, content: path.write_bytes(content[: len(content) // 2]),
    "second half zeroed": lambda path, content: path.write_bytes(
        content[: len(content) // 2] + bytes(len(content) - len(content) // 2)
    ),
    "empty": lambda path, content: path.write_bytes(b""),
    "text": lambda path, content: path.write_text("no library"),
    "not UTF-8": lambda path, content: path.write_bytes(b"\xff\xfe int x;"),
    "appended": lambda path, content: path.write_bytes(content + b" "),
    "pipe": pipe,
    "link": link,
    "folder": folder,
    "unreadable": lambda path, content: path.unlink(),
    "sum removed": lambda path, content: path.with_name(f"{path.name}.sha256").unlink(),
    "sum of something else": lambda path, content: path.with_name(f"{path.name}.sha256").write_text("0" * 64),
}


@pytest.mark.parametrize("damage", DAMAGES.values(), ids=DAMAGES)
def test_damaged_entries_are_made_again(cache, damage):
    """faults.md, 5: each of these killed Python, hung, or stayed broken for ever."""
    assert library.compiled_library(SOURCE).twice(21) == 42
    library.cached_source("0" * 16, lambda: SOURCE)
    for suffix in (".so", ".c"):
        path = entry(cache, suffix)
        damage(path, path.read_bytes())
    library._loaded.cache_clear()
    assert library.compiled_library(SOURCE).twice(21) == 42
    assert library.cached_source("0" * 16, lambda: SOURCE) == SOURCE
    (cache / "code" / "other").unlink(missing_ok=True)
    assert kept(cache) == [".c", ".so"]


def test_foreign_code_beside_the_wrong_sum_is_not_loaded(cache, tmp_path):
    """faults.md, 3: a constructor ran. Here it would end this process."""
    library.compiled_library(SOURCE)
    entry(cache, ".so").write_bytes(foreign_library(tmp_path))
    library._loaded.cache_clear()
    assert library.compiled_library(SOURCE).twice(21) == 42


def test_an_edited_source_is_not_compiled(cache):
    q = torch.ones(6, dtype=torch.float64)
    w = symbolic.compile_index(PUMA, W, "c")(q)
    path = entry(cache, ".c")
    path.write_text(path.read_text().replace("results[l] = out", "results[l] = 2*out"))
    assert_close(symbolic.compile_index(PUMA, W, "c")(q), w, rtol=0, atol=0)


def test_what_others_could_write_is_discarded_and_the_folder_closed(cache, tmp_path):
    library.compiled_library(SOURCE)
    path, foreign = entry(cache, ".so"), foreign_library(tmp_path)
    path.write_bytes(foreign)
    path.with_name(f"{path.name}.sha256").write_text(hashlib.sha256(foreign).hexdigest())
    path.parent.chmod(0o777)
    library._loaded.cache_clear()
    assert library.compiled_library(SOURCE).twice(21) == 42
    assert stat.S_IMODE(path.parent.stat().st_mode) == 0o700


def test_a_folder_that_others_may_read_is_closed(cache):
    library.compiled_library(SOURCE)
    (cache / "code").chmod(0o755)
    library.compiled_library(SOURCE)
    assert stat.S_IMODE((cache / "code").stat().st_mode) == 0o700


@pytest.mark.skipif(os.geteuid() != 0, reason="only root can give a folder away")
def test_a_folder_of_another_user_is_refused_and_named(cache):
    (cache / "code").mkdir(parents=True)
    os.chown(cache / "code", 12345, 12345)
    with pytest.raises(PermissionError, match=rf"^the cache folder {cache}/code is a link or belongs to an"):
        library.compiled_library(SOURCE)


def test_a_folder_that_is_a_link_is_refused(cache, tmp_path):
    cache.mkdir()
    (tmp_path / "elsewhere").mkdir()
    (cache / "code").symlink_to(tmp_path / "elsewhere")
    with pytest.raises(PermissionError, match="is a link"):
        library.compiled_library(SOURCE)


def test_what_the_compiler_made_is_compared_with_the_derivation(cache, compiler):
    """faults.md, 4: a wrong library was stored and used."""
    compiler("""
        for last in "$@"; do
            case "$last" in *.c) sed -i 's/results\\[l\\] = out/results[l] = 1.0001*out/' "$last";; esac
        done
        real "$@"
    """)
    with pytest.raises(CompilationFailed, match=r"-O0 .*does not compute what it was derived from"):
        symbolic.compile_index(PUMA, W, "c")
    assert kept(cache) == [".c"]


@pytest.mark.parametrize("flags", ["-ffast-math", "-Ofast", "-funsafe-math-optimizations -O2"])
def test_fast_math_in_the_compilers_name_changes_nothing(monkeypatch, flags):
    monkeypatch.setenv("CC", f"cc {flags}")
    value = symbolic.compile_index(PUMA, W, "c")([0.3, -0.5, 0.7, 0.2, 0.9, -0.4])
    assert float(value) == pytest.approx(0.036354607016, rel=1e-10)  # as faults.md, 4 has it


# ---- compilers again -------------------------------------------------------------------------------


def test_a_compiler_that_hangs_is_stopped_with_all_that_it_started(cache, compiler, monkeypatch):
    monkeypatch.setattr(c_compiler, "PATIENCE", 1.0)
    compiler(ONLY_DESCRIBES + "sleep 1000 &\nsleep 1000")
    with pytest.raises(CompilationFailed, match=r"was stopped after 1 s without an end"):
        library.compiled_library(SOURCE)
    assert kept(cache) == []


@pytest.mark.parametrize(
    "script", ["printf 'warning: \\351\\n' >&2\nreal \"$@\"", "printf '\\377\\n'\nexit 1"]
)
def test_words_of_a_compiler_may_be_in_any_encoding(compiler, script):
    compiler(script)
    if "exit 1" in script:
        with pytest.raises(CompilationFailed, match="failed with status 1: \ufffd"):
            library.compiled_library(SOURCE)
    else:
        assert library.compiled_library(SOURCE).twice(21) == 42


def test_a_compilers_path_may_hold_spaces(tmp_path, monkeypatch):
    path = tmp_path / "my compilers" / "cc"
    path.parent.mkdir()
    path.symlink_to(shutil.which("cc"))
    for named in (str(path), f"'{path}' -DX=1", "   "):
        monkeypatch.setenv("CC", named)
        assert library.compiled_library(SOURCE).twice(21) == 42


def test_what_is_stored_needs_no_compiler(monkeypatch, tmp_path):
    assert library.compiled_library(SOURCE).twice(21) == 42
    library._loaded.cache_clear()
    monkeypatch.setenv("PATH", str(tmp_path))
    assert library.compiled_library(SOURCE).twice(21) == 42


def test_the_folder_may_be_relative_or_in_the_home_folder(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    for named, there in ((".", tmp_path), ("~/x", tmp_path / "home" / "x")):
        monkeypatch.setenv("DEXTERITY_CACHE", named)
        assert library.cache_folder() == there
        assert library.compiled_library(SOURCE).twice(21) == 42
        assert kept(there) == [".so"]
    monkeypatch.delenv("DEXTERITY_CACHE")
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    monkeypatch.setenv("HOME", "")
    assert library.cache_folder().is_absolute()


def test_what_interrupted_processes_left_is_swept_after_a_day(cache):
    code = cache / "code"
    code.mkdir(parents=True, mode=0o700)
    for name in (".compiling-a", ".loading-b"):
        (code / name).mkdir()
    (code / ".0123456789abcdef.tmp").write_text("half")
    library.compiled_library(SOURCE)
    assert len([path for path in code.iterdir() if path.name.startswith(".")]) == 3  # they may be at work
    for path in code.iterdir():
        os.utime(path, (0, 0))
    library.compiled_library(SOURCE.replace("2*x", "3*x"))
    assert kept(cache) == [".so", ".so"]
