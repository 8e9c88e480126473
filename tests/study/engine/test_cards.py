"""A card names the versions of what a run imports, and of programs that it runs outside of Python."""

from dexterity_study.engine import card

MODULE = "dexterity_study.uvms.cost.experiment"


def test_a_card_names_the_programs_that_a_run_starts(tmp_path):
    made = card.made(MODULE, 1.0, {"GNU Octave": "7.3.0"})
    card.write(tmp_path / "card.toml", {"made": made})
    versions = card.read(tmp_path / "card.toml")["made"]["versions"]
    assert versions["GNU Octave"] == "7.3.0"
    assert versions["sympy"] == card.versions(MODULE)["sympy"]


def test_a_card_of_a_run_in_python_alone_names_no_programs():
    assert set(card.made(MODULE, 1.0)["versions"]) == {"python", *card.versions(MODULE)}
