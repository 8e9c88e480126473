"""Instructions counted by Callgrind: the same at every run, and as many as there are."""

import platform
import shutil

import pytest

from dexterity.timing import instructions
from dexterity.timing.instructions import instructions_per_configuration

SOURCE = """
#include <stddef.h>
enum { JOINTS = 2, SUM_JOINTS = JOINTS };
static int sum_batch(const double *q, size_t count, size_t joints, double *values)
{
  for (size_t i = 0; i < count; ++i) {
    volatile double sum = 0.0;
    for (int times = 0; times < TIMES; ++times)
      sum = sum + q[i*joints];
    values[i] = sum;
  }
  return 0;
}
"""
needs_callgrind = pytest.mark.skipif(
    platform.machine() != "x86_64" or not (shutil.which("valgrind") and shutil.which("cc")),
    reason="valgrind or a C compiler is not installed, or the processor is another",
)


@needs_callgrind
def test_work_that_is_done_more_often_takes_more_instructions_by_as_much():
    counts = [instructions_per_configuration(f"#define TIMES {n}{SOURCE}", "sum") for n in (50, 100)]
    assert counts[0] == instructions_per_configuration(f"#define TIMES 50{SOURCE}", "sum")
    # A step of the loop takes at least its load, addition and store.
    assert 3 * 50 <= counts[1] - counts[0] <= 8 * 50


@needs_callgrind
def test_a_file_that_does_not_compile_or_run_is_an_error():
    with pytest.raises(RuntimeError, match="cc failed with status 1"):
        instructions_per_configuration("nonsense", "sum")
    with pytest.raises(RuntimeError, match="valgrind failed with status 1"):
        instructions_per_configuration(f"#define TIMES 1{SOURCE.replace('return 0', 'return 1')}", "sum")


@pytest.mark.parametrize("missing", ["valgrind", "cc", "the processor"])
def test_where_nothing_can_be_counted_there_is_no_count(monkeypatch, missing):
    if missing == "the processor":
        monkeypatch.setattr(instructions.platform, "machine", lambda: "arm64")
    monkeypatch.setattr(instructions.shutil, "which", lambda name: None if name == missing else name)
    assert instructions_per_configuration("nonsense", "sum") is None
