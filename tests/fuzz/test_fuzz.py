"""Bad arguments to public functions: an error that names the argument, or the answer to the good one.

By default some hundreds of several thousand cases are tried; `DEXTERITY_FUZZ=100000` tries all of them, and
the script `attack.py` lists what is wrong.
"""

import os
import re

import pytest
from attack import Case, cases, fault, plain_answer
from hypothesis import given, settings
from hypothesis import strategies as st
from samples import EXAMPLES

pytestmark = pytest.mark.usefixtures("annotations_unchecked")

TRIED = int(os.environ.get("DEXTERITY_FUZZ", "600"))
CASES = tuple(cases())

ACCEPTED = {
    r"spatial\.compose\(T: huge": "the parameter is called poses",
    r"spatial\.wrap_to_pi\(angle: with nan": "a NaN is documented to stay one",
    r"inverse_kinematics\.null_space_step\(objective: a class": "a class can be called",
    r"sampling\.uvms_space\(index_name": "it is the name of an index, as the error says",
    r"sampling\.uvms_space\(half_range_deg: 1e\+300": "the number of steps is named",
    r"symbolic\.compile_index\(index: text": "the text is the name of an index, which the error names",
}
"""Cases by patterns of what they print, with the reason why they may end otherwise."""


@settings(max_examples=min(TRIED, len(CASES)), derandomize=True)
@given(case=st.sampled_from(CASES))
def test_a_bad_argument_is_named_or_changes_nothing(case: Case) -> None:
    if not any(re.match(pattern, repr(case)) for pattern in ACCEPTED):
        wrong = fault(case)
        assert not wrong, f"{case}: {wrong}"


@pytest.mark.parametrize("name", [name for name, _, _ in EXAMPLES])
def test_the_good_arguments_are_taken(name: str) -> None:
    plain_answer(name)


def test_many_functions_of_every_package_are_tried() -> None:
    names = {name for name, _, _ in EXAMPLES}
    assert len(names) == len(EXAMPLES) > 110
    assert len({name.partition(".")[0] for name in names}) >= 14
