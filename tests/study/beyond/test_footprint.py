"""Memory of generated C files, as the chapter on indices measures it."""

import shutil

import pytest

import dexterity as dx
from dexterity_study.beyond.indices.footprint import bytes_of


def test_a_file_writes_no_data_and_needs_less_stack_for_one_configuration():
    if not all(map(shutil.which, ("cc", "size"))):
        pytest.skip("a C compiler and size are needed")
    texts = dx.codegen.c_files(dx.Chain.from_dh([{"a": 0.5}, {"a": 0.4}]), "f")
    (code, data, stack), (_, none, alone) = (bytes_of(texts, lanes) for lanes in (16, 1))
    assert 1000 < code < 50_000
    assert data == none == 0
    assert 100 < alone < stack
