"""The study of the feed-forward design loop: its settings, and what its tables make of a result."""

import numpy as np
import pytest

from dexterity.report.claims import load_paper
from dexterity.studies.uvms import feed_forward as study

PAPER = load_paper("sotiropoulos2016")


def printed(claim):
    return PAPER.claim(f"feed-forward-{claim}").value


@pytest.mark.parametrize("scale", ["book", "full"])
def test_settings_are_the_printed_ones(scale):
    config = study.CONFIGS[scale]
    assert config.neurons == (printed("w-neurons"), printed("kci-neurons"))
    assert config.goals == printed("training-error-goals")
    assert {config.testing_error} == set(printed("testing-error-limit"))
    assert {config.neuron_limit} == set(printed("neuron-limit"))
    assert {config.epochs} == set(printed("epoch-limit"))
    # Curves of w must hold the sizes that claims name.
    assert config.largest[0] >= 8
    assert config.step[0] == 1


def test_full_has_ten_seeds_and_the_whole_grid():
    config = study.CONFIGS["full"]
    assert min(len(config.seeds), len(config.few_seeds), len(config.grid_seeds)) >= 10


def test_the_smallest_network_is_the_first_that_passes():
    errors = np.array([[0.05, 0.01, 0.03], [0.05, 0.04, 0.03]])
    curve = study.Curve((1, 2, 3), errors, errors)
    assert study._smallest(curve, 0.02) == [2.0, np.inf]
    assert study._range_of([2.0, np.inf]) == "none (2–none)"
    assert study._range_of([3, 3]) == "3"
