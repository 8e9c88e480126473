"""CONTRIBUTING.md shows the house as the imports have it."""

from house_map import house_map

from dexterity import store


def test_the_map_in_contributing_is_the_one_that_the_imports_draw():
    text = (store.repository() / "CONTRIBUTING.md").read_text(encoding="utf-8")
    assert house_map() in text, "renew it: python tests/study/house_map.py"
