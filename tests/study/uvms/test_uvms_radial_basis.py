"""The chapter on radial-basis networks: where a run of its loop was, and what its units cost."""

from types import SimpleNamespace

from dexterity.networks.design import RadialBasisOptions
from dexterity_study.engine.evidence import Evidence
from dexterity_study.uvms.radial_basis import show

OPTIONS = RadialBasisOptions(error_threshold=1e-2)


def design_of(*growths):
    made = [SimpleNamespace(success=success, mean_square_errors=errors) for success, errors in growths]
    return SimpleNamespace(success=any(one.success for one in made), growths=made)


def test_a_run_that_passes_at_its_second_spread():
    design = design_of((False, (0.5, 0.02, 0.005)), (True, (0.4, 0.008)))
    passed, last = show.passages(design, OPTIONS)
    assert last == "pass"
    # Tests begin below the threshold: one at the first spread, one at the second.
    counts = {"add": 5, "ready": 5, "test": 2, "more": 4, "full": 1, "raise": 1}
    assert passed == {"start": 1, **counts, "pass": 1}


def test_a_run_that_never_passes_ends_at_the_last_spread():
    passed, last = show.passages(design_of((False, (0.5,)), (False, (0.4,))), OPTIONS)
    assert last == "stop"
    assert passed == {"start": 1, "add": 2, "ready": 2, "more": 2, "full": 2, "raise": 1, "stop": 1}


def test_operations_of_the_exact_index_in_units():
    counts = Evidence("uvms.cost")["counts"].where().set_index(["what", "form"])["operations"]
    assert counts["w", "closed form"] / 26 - 0.5 <= int(show.units_for_exact(Evidence("uvms.cost")))
    assert int(show.units_for_exact(Evidence("uvms.cost"))) <= counts["w", "closed form"] / 26 + 0.5
