import io
import itertools
from collections.abc import Iterator

import matplotlib as mpl
import nbclient
import nbformat
import numpy as np
import pytest
from matplotlib import colors
from matplotlib.figure import Figure

from dexterity_study.page import figures

PHONE = 360  # CSS pixels


@pytest.fixture(autouse=True)
def _style_left_at_the_end() -> Iterator[None]:
    with mpl.rc_context():
        figures.style()
        yield


def svg(figure: Figure) -> bytes:
    picture = io.BytesIO()
    figure.savefig(picture, format="svg", metadata={"Date": None})
    return picture.getvalue()


def drawn() -> Figure:
    figure = Figure()
    axes = figure.add_subplot(xlabel="θ [rad]", ylabel="w [1]")
    axes.plot(np.linspace(0, 1, 20), np.linspace(0, 1, 20) ** 2, label="exact")
    axes.legend()
    return figure


def test_the_same_figure_gives_the_same_bytes() -> None:
    assert svg(drawn()) == svg(drawn())


def test_letters_are_legible_on_a_phone() -> None:
    width = Figure().get_figwidth() * 96
    smallest = min(mpl.font_manager.font_scalings[mpl.rcParams[f"{axis}tick.labelsize"]] for axis in "xy")
    letters = smallest * mpl.rcParams["font.size"] * 96 / 72
    assert letters * min(1, PHONE / width) > 10


def test_figures_stand_on_white_for_light_and_dark_pages() -> None:
    assert colors.to_hex(drawn().get_facecolor()) == "#ffffff"
    assert mpl.rcParams["savefig.facecolor"] == "white"


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
