"""Flow charts and drawings of networks: what is drawn, and what cannot be."""

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pytest

from dexterity_study.page.diagrams import Arrow, Box, flow_chart, layers

BOXES = {
    "start": Box("begin", (1.5, 2.0)),
    "ask": Box("enough?", (1.5, 1.2), asks=True),
    "stop": Box("give up", (1.5, 0.4)),
}
ARROWS = (Arrow([(1.5, 1.75), (1.5, 1.45)]), Arrow([(1.5, 0.95), (1.5, 0.65)], "no", (1.2, 0.8)))


@pytest.fixture(autouse=True)
def _no_window():
    with mpl.rc_context({"backend": "agg"}):
        yield
    plt.close("all")


def words(figure):
    return [text.get_text() for text in figure.axes[0].texts]


def test_a_flow_chart_says_how_often_each_box_was_passed_and_where_the_run_ended():
    figure = flow_chart(BOXES, ARROWS, {"start": 1, "ask": 1200}, last="ask", height=2.4)
    assert {"begin", "enough?", "give up", "no", "1 ×", "1,200 ×"} <= set(words(figure))
    widths = {patch.get_linewidth() for patch in figure.axes[0].patches}
    by_style = [patch.get_linestyle() for patch in figure.axes[0].patches]
    assert max(widths) == 3
    # The box that was never reached is dashed, and it alone.
    assert sum(style in ("--", "dashed") for style in by_style) == 1


@pytest.mark.parametrize(
    ("passed", "last"),
    [({"start": 1, "nowhere": 1}, "start"), ({"start": 1}, "nowhere"), ({"start": 1}, "stop")],
)
def test_a_run_that_does_not_fit_its_chart_is_refused(passed, last):
    with pytest.raises(ValueError, match=r"nowhere|stop"):
        flow_chart(BOXES, ARROWS, passed, last, height=2.4)


@pytest.mark.parametrize(("inputs", "hidden", "circles"), [(3, 2, 3 + 2 + 1), (7, 8, 3 + 3 + 1)])
def test_of_many_neurons_a_few_are_drawn_and_all_are_counted(inputs, hidden, circles):
    figure = layers([f"θ{n}" for n in range(inputs)], hidden, np.tanh, "w", "sigmoids")
    assert len(figure.axes[0].patches) == circles
    assert {f"{inputs} inputs", f"{hidden} sigmoids", "output", "w"} <= set(words(figure))


def test_a_network_without_neurons_is_refused():
    with pytest.raises(ValueError, match="neurons"):
        layers(["θ5"], 0, np.tanh, "w")
