"""Operations are counted as the paper counts them, and the place of axes and point decides on those of w."""

import pytest

from dexterity import operations
from dexterity_study.claims.ledger import load_paper
from dexterity_study.engine.evidence import Evidence
from dexterity_study.uvms.cost import experiment, show

PAPER = load_paper("sotiropoulos2016")


@pytest.mark.parametrize("inputs", [3, 11])
def test_the_norm_without_its_sum_takes_d_plus_1_additions_and_d_plus_5_multiplications(inputs):
    counted = experiment.without_sum_of_norm(inputs, 1)
    assert (counted.additions, counted.multiplications) == (inputs + 1, inputs + 5)
    whole = operations.radial_basis(inputs, 1, "norm")
    assert whole.additions - counted.additions == inputs - 1


@pytest.mark.parametrize("index", ["w", "kci"])
def test_eleven_inputs_give_the_printed_split_of_both_radial_basis_networks(index):
    neurons = {"w": 149, "kci": 142}[index]
    counted = experiment.without_sum_of_norm(experiment.EVERY_INPUT, neurons)
    split = counted.additions, counted.multiplications
    assert split == tuple(PAPER.printed(f"radial-basis-{index}-split"))
    assert counted.total == PAPER.printed(f"radial-basis-{index}-operations")


def test_the_printed_count_of_the_jacobian_lies_between_those_with_and_without_l1():
    rows = Evidence("uvms.cost")["counts"].where().set_index(["what", "form"])["operations"]
    printed = PAPER.printed("jacobian-operations")
    assert rows["Jacobian", "written out, l1 = 0"] < printed < rows["Jacobian", "written out"]
    assert printed < rows["Jacobian", "written out, as printed in Eq. 6, l1 = 0"]


def test_axes_in_the_middle_and_a_point_on_the_wrist_shorten_the_entries():
    rows = experiment.places(links=(0, 7), points=(0, 10)).rows.set_index(["link", "point"])
    world, best = rows.loc[(0, 0)], rows.loc[(7, 10)]
    assert best["taken"]
    assert not world["taken"]
    assert best["zeros"] > world["zeros"]
    assert best["joints"] < world["joints"]
    assert 2 * best["operations"] < world["operations"]


def test_the_sentence_on_places_has_the_numbers_of_the_rows():
    stored = Evidence("uvms.cost")
    (best,) = stored["places"].where(link=7, point=10).itertuples()
    assert f"*w* takes {best.operations} operations" in show.moved(stored)
