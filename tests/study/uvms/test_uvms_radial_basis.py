"""The chapter on radial-basis networks: where a run of its loop was, and what its units cost."""

from types import SimpleNamespace

import matplotlib.pyplot as plt
import numpy as np

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


def test_growth_is_drawn_for_the_spreads_of_both_indices():
    stored = Evidence("uvms.radial_basis")
    figure = show.growth_by_spread(stored)
    for ax, index in zip(figure.axes, ("w", "KCI"), strict=True):
        rows = stored["growth"].where(index=index).query("spread == 8.9")
        (line,) = [line for line in ax.lines if line.get_label() == "8.9"]
        # The last size is the one to which every network was grown.
        smallest = 100 * rows["smallest"].median()
        assert smallest <= np.asarray(line.get_ydata())[-1] * (1 + 1e-6)
        shared = {line.get_label() for line in ax.lines if not line.get_label().startswith("_")}
        assert {"0.5", "1", "8.9"} <= shared
        assert "0.1" not in shared
    plt.close(figure)
