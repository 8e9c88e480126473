"""`make book` on copies: it fails when it should, says why, and executes again what an edit has touched."""

import ast
import re
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path

import pytest
from book_copy import Build, add_source, make_book, make_copy

SOUND = """# A sound chapter

An equation,

$$
a^2 = b^2 + c^2, {#eq-sides}
$$

a drawing,

![Two links and an ellipse](assets/favicon.svg)

and a cell.

```{code-cell} python3
print(6 * 7)
```
"""

CLOCK_AND_HAT = """# A chapter that uses the package

```{code-cell} python3
import time
from dexterity import spatial

print("hat", spatial.hat([1.0, 2.0, 3.0])[1, 0].item(), "at", time.time_ns())
```
"""

FAULTS = {
    "failing cell": ("```{code-cell} python3\n1 / 0\n```\n", "ZeroDivisionError"),
    "cell that warns": ("```{code-cell} python3\nimport sys\nprint('odd', file=sys.stderr)\n```\n", "stderr"),
    "broken cross-reference": ("See {ref}`no-such-label`.\n", "no-such-label"),
    "broken link to a page": ("See [there](no-such-page.md).\n", "no-such-page"),
    "missing image": ("![Something](no-such-picture.png)\n", "no-such-picture.png"),
    "unknown citation": ("As {cite:t}`nobody1900` says.\n", "nobody1900"),
}


@pytest.fixture(scope="module")
def builds(tmp_path_factory: pytest.TempPathFactory) -> Iterator[dict[str, Future[list[Build]]]]:
    """Every build of this file, by its name; two run at a time, and each test waits for its own."""
    root = tmp_path_factory.mktemp("books")
    jobs: dict[str, Callable[[], list[Build]]] = {
        "edits": lambda: _build_after_edits(root / "edits"),
        "sound": lambda: [make_book(make_copy(root / "sound", SOUND))],
    }
    for fault, (text, _) in FAULTS.items():
        jobs[fault] = lambda fault=fault, text=text: _build_twice(root / fault.replace(" ", "-"), text)
    with ThreadPoolExecutor(max_workers=2) as pool:
        yield {name: pool.submit(job) for name, job in jobs.items()}
        pool.shutdown(cancel_futures=True)


def _build_twice(folder: Path, text: str) -> list[Build]:
    make_copy(folder, f"# A faulty chapter\n\n{text}")
    return [make_book(folder) for _ in range(2)]


def _build_after_edits(folder: Path) -> list[Build]:
    """Build a copy, edit a function that its chapter uses, build again, and again without an edit."""
    add_source(make_copy(folder, CLOCK_AND_HAT))
    first = make_book(folder)
    _double_argument(folder / "src" / "dexterity" / "spatial" / "poses.py", "hat")
    return [first, make_book(folder), make_book(folder)]


def _double_argument(module: Path, function: str) -> None:
    """Make the first statement of a function double its first argument."""
    lines = module.read_text(encoding="utf-8").splitlines()
    tree = ast.parse("\n".join(lines))
    found = next(node for node in tree.body if isinstance(node, ast.FunctionDef) and node.name == function)
    argument, docstring = found.args.args[0].arg, found.body[0]
    lines.insert(docstring.end_lineno or 0, f"    {argument} = [2 * x for x in {argument}]")
    module.write_text("\n".join(lines) + "\n", encoding="utf-8")


def test_sound_book_builds(builds: dict[str, Future[list[Build]]]) -> None:
    (build,) = builds["sound"].result()
    assert build.exit_code == 0, build.output
    assert "42" in build.page
    assert "index.html" in build.output.splitlines()[-1]


@pytest.mark.parametrize("fault", FAULTS)
def test_faulty_book_does_not_build(builds: dict[str, Future[list[Build]]], fault: str) -> None:
    _, named = FAULTS[fault]
    for build in builds[fault].result():
        assert build.exit_code != 0, f"a {fault} passed:\n{build.output}"
        assert "The book was not built" in build.output.splitlines()[-1] or "make: ***" in build.output
        assert named in build.output, f"{named} is not named:\n{build.output}"
        assert "index.md" in build.output, f"the page is not named:\n{build.output}"


def test_chapter_runs_again_after_an_edit_and_only_then(builds: dict[str, Future[list[Build]]]) -> None:
    shown = []
    for build in builds["edits"].result():
        assert build.exit_code == 0, build.output
        shown.append(re.findall(r"hat (\S+) at (\d+)", build.page))
    (((before, first_time),), ((after, second_time),), ((same, third_time),)) = shown
    assert (float(before), float(after), float(same)) == (3.0, 6.0, 6.0)
    assert first_time != second_time == third_time
