"""Scenes of reach maps and placements: what is drawn, and what is refused."""

import pytest

import dexterity as dx
from dexterity import reach
from dexterity.scenes.reach import map_scene, placement_scene

PUMA = dx.robots.puma560()
GRID = reach.box([0.2, -0.4, -0.4], [0.6, 0.4, 0.4], spacing=0.2)
MAP = reach.survey(PUMA, GRID, reach.rotations(24), index="w")
SEAM = reach.seam([-0.1, 0, 0], [0.1, 0, 0], 3, reach.pointing([0, 0, -1]))


def test_a_map_is_drawn_with_a_colour_for_each_range_of_shares():
    scene = map_scene(MAP)
    html = scene._repr_html_()
    drawn = GRID[MAP.reached.any(1)].numpy()
    assert (scene.region.min(axis=0) <= drawn.min(axis=0)).all()
    assert (scene.region.max(axis=0) >= drawn.max(axis=0)).all()
    assert "of the rotations" in html
    assert map_scene(MAP.slice("z", 0.0)).title.startswith("Reach of puma560")


def test_a_placement_is_drawn_with_its_bases_and_the_arm_on_the_best():
    placed = reach.place(PUMA, SEAM, [[0.0, -0.5, 0.0], [0.0, -3.0, 0.0]], "w", refine=False)
    html = placement_scene(placed)._repr_html_()
    for words in ("bases that reach all poses", "bases that do not", "poses of the tool"):
        assert words in html


def test_nothing_to_draw_is_refused():
    nothing = reach.survey(PUMA, [[5.0, 0.0, 0.0]], reach.rotations(24)[:2])
    with pytest.raises(ValueError, match="reaches something is needed"):
        map_scene(nothing)
    placed = reach.place(PUMA, SEAM, [[0.0, -3.0, 0.0]], "w")
    with pytest.raises(ValueError, match="reaches all poses is needed"):
        placement_scene(placed)
