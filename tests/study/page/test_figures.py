import itertools
import re
from collections.abc import Iterator

import matplotlib as mpl
import nbclient
import nbformat
import numpy as np
import pytest
from matplotlib import colors
from matplotlib.figure import Figure

from dexterity_study.page import figures

PHONE, MARGINS = 360, 32  # CSS pixels


@pytest.fixture(autouse=True)
def _style_left_at_the_end() -> Iterator[None]:
    with mpl.rc_context():
        figures.style()
        yield


def svg(figure: Figure) -> str:
    return figures.themed_svg(figure)


def drawn() -> Figure:
    figure = Figure()
    axes = figure.add_subplot(xlabel="θ [rad]", ylabel="w [1]")
    axes.plot(np.linspace(0, 1, 20), np.linspace(0, 1, 20) ** 2, label="exact")
    axes.legend()
    return figure


def test_the_same_figure_gives_the_same_bytes() -> None:
    assert svg(drawn()) == svg(drawn())


def test_letters_are_legible_on_a_phone() -> None:
    drawn_at = [float(size) for size in re.findall(r"scale\(([\d.]+) -", svg(drawn()))]
    smallest = min(drawn_at) * 100 * 96 / 72  # outlines are drawn in hundredths of a letter's size [px]
    assert smallest * (PHONE - MARGINS) / (Figure().get_figwidth() * 96) >= 11


def test_figures_have_no_ground_and_their_ink_follows_the_page() -> None:
    assert colors.to_rgba(drawn().get_facecolor())[3] == 0
    picture = svg(drawn())
    ink = mpl.rcParams["text.color"].lower()
    assert f"fill: {ink}" in picture
    assert f'[style*="fill: {ink}"]' in picture[: picture.index("</style>")]


def test_lines_are_told_apart_and_stand_out_from_white() -> None:
    cycle = [np.array(colors.to_rgb(color)) for color in mpl.rcParams["axes.prop_cycle"].by_key()["color"]]
    assert all(np.linalg.norm(a - b) > 0.25 for a, b in itertools.combinations(cycle, 2))
    assert {colors.to_hex(color) for color in cycle} < {color.lower() for color in figures.COLORS.values()}
    assert all(color @ [0.2126, 0.7152, 0.0722] < 0.7 for color in cycle)


def test_a_notebook_shows_vectors_with_the_same_bytes_each_time() -> None:
    draw = "import matplotlib.pyplot as plt\nplt.plot([0, 1]);"
    cells = ["from dexterity_study.page import figures; figures.style()", draw, draw]
    notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(cell) for cell in cells])
    nbclient.NotebookClient(notebook, kernel_name="python3").execute()
    first, second = (
        output.data["image/svg+xml"]
        for cell in notebook.cells
        for output in cell.outputs
        if output.output_type == "display_data"
    )
    assert first == second
