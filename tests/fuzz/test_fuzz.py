"""Bad arguments to public functions: an error that names the argument, or the answer to the good one.

By default one or two of the cases of each sample are tried; `DEXTERITY_FUZZ=1000` tries nearly all, and the
script `attack.py` tries all and lists what is wrong.
"""

import os
import re

import exceptions
import pytest
from attack import cases, fault, plain_answer
from entries import entries, is_record
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from samples import SAMPLES

TRIED = int(os.environ.get("DEXTERITY_FUZZ", "1"))
RECORDS = set(exceptions.RECORDS.split())
LEFT = {name for names in exceptions.ENTRIES.values() for name in names.split()}
SAMPLED = {sample.partition(" ")[0] for sample in SAMPLES}


@pytest.mark.usefixtures("annotations_unchecked")
@pytest.mark.parametrize("sample", SAMPLES)
def test_a_bad_argument_is_named_or_changes_nothing(sample: str) -> None:
    plain_answer(sample)

    @settings(max_examples=TRIED, suppress_health_check=list(HealthCheck))
    @given(case=st.sampled_from(list(cases(sample))))
    def trial(case) -> None:
        if not any(re.match(pattern, repr(case)) for pattern in exceptions.CASES):
            wrong = fault(case)
            assert not wrong, f"{case}: {wrong}"

    trial()


def test_every_entry_is_tried_or_left_with_a_reason() -> None:
    every = set(entries())
    assert every == SAMPLED | RECORDS | LEFT
    assert not SAMPLED & (RECORDS | LEFT)


def test_records_check_nothing() -> None:
    assert not [name for name in RECORDS if not is_record(entries()[name])]


def test_many_entries_are_tried() -> None:
    assert len(SAMPLED) > 400
    assert len({name.partition(".")[0] for name in SAMPLED}) >= 18
