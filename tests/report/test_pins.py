import pytest
from scratch import write

from dexterity.report import pins
from dexterity.report.pins import counted_pins

LOCK = """\
# made by hand, alpha==9
Alpha.Beta==1.0
gamma==2.0
delta==3.0
epsilon==4.0
zeta==5.0
missing==6.0
"""

INSTALLED = {
    "alpha_beta": ("ab", ['Gamma[more]>=1; python_version >= "3"', 'epsilon; extra == "all"', "unpinned"]),
    "gamma": ("gamma", ["delta", 'zeta; python_version < "3"']),
    "delta": ("delta", ["gamma<9"]),
    "epsilon": ("epsilon", []),
    "zeta": ("zeta", ["missing"]),
    "more_zeta": ("gamma", []),
    "unpinned": ("unpinned", ["epsilon"]),
}


@pytest.fixture(autouse=True)
def installed(tmp_path, monkeypatch):
    for name, (module, required) in INSTALLED.items():
        lines = ["Metadata-Version: 2.4", f"Name: {name}", "Version: 0"]
        lines += [f"Requires-Dist: {requirement}" for requirement in required]
        write(tmp_path / f"{name}-0.dist-info" / "METADATA", "\n".join(lines))
        write(tmp_path / f"{name}-0.dist-info" / "top_level.txt", module)
    monkeypatch.syspath_prepend(tmp_path)
    caches = (pins._distributions, pins._requirements)
    for cache in caches:
        cache.cache_clear()
    yield
    for cache in caches:
        cache.cache_clear()


@pytest.mark.parametrize(
    ("imports", "counted"),
    [
        ([], []),
        (["epsilon"], ["epsilon"]),
        (["ab"], ["alpha-beta", "delta", "gamma"]),
        (["delta"], ["delta", "gamma"]),
        (["epsilon", "delta"], ["delta", "epsilon", "gamma"]),
    ],
)
def test_the_pins_of_imports_and_of_what_they_require_count(imports, counted):
    assert list(counted_pins(LOCK, imports)) == counted


@pytest.mark.parametrize("unknown", ["nowhere", "missing", "unpinned", "zeta"])
def test_all_pins_count_where_it_is_not_known_what_is_needed(unknown):
    every = {"alpha-beta", "gamma", "delta", "epsilon", "zeta", "missing"}
    assert counted_pins(LOCK, [unknown, "epsilon"]).keys() == every


def test_a_pin_is_its_line():
    assert counted_pins(LOCK, ["ab"])["alpha-beta"] == "Alpha.Beta==1.0"


def test_no_comment_counts():
    assert counted_pins(f"# another\n\n{LOCK}", ["nowhere"]) == counted_pins(LOCK, ["nowhere"])
