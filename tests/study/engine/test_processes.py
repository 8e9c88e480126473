"""Processes that hold a folder, and that end with the one that started them."""

import subprocess
import sys
import time
from pathlib import Path

import psutil
import pytest

from dexterity_study.engine.processes import InUse, alone_in

HOLDS = """
import sys, time
from pathlib import Path
from dexterity_study.engine.processes import alone_in
with alone_in(Path(sys.argv[1])):
    print("holds", flush=True)
    time.sleep(600)
"""

STARTS = """
import subprocess, sys
child = "import time; from dexterity_study.engine.processes import *; end_with_parent(0.1); time.sleep(99)"
print(subprocess.Popen([sys.executable, "-c", child]).pid, flush=True)
sys.stdin.read()
"""


def test_a_folder_is_held_by_one_process_and_free_when_it_was_killed(tmp_path: Path) -> None:
    folder = tmp_path / "a" / "b"
    holder = subprocess.Popen([sys.executable, "-c", HOLDS, str(folder)], stdout=subprocess.PIPE, text=True)
    assert holder.stdout
    assert holder.stdout.readline() == "holds\n"
    with pytest.raises(InUse, match=r"another process works in .*b: wait"), alone_in(folder):
        pytest.fail("two hold one folder")
    holder.kill()
    holder.wait()
    holder.stdout.close()
    for _ in range(2):
        with alone_in(folder):
            assert folder.is_dir()


def test_a_process_ends_with_the_one_that_started_it() -> None:
    parent = subprocess.Popen(
        [sys.executable, "-c", STARTS], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    assert parent.stdout
    assert parent.stdin
    child = psutil.Process(int(parent.stdout.readline()))
    time.sleep(1)
    assert child.is_running()
    parent.kill()
    parent.wait()
    parent.stdout.close()
    parent.stdin.close()
    assert gone(child)


def gone(process: psutil.Process, seconds: float = 30) -> bool:
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if not process.is_running() or process.status() == psutil.STATUS_ZOMBIE:
            return True
        time.sleep(0.1)
    return False
