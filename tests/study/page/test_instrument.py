"""Instruments: what they refuse, and what their page holds."""

import base64
import json
import zlib
from dataclasses import replace

import pytest

from dexterity_study.page.instrument import Choice, Drawing, Instrument, Readout, Slider

INSTRUMENT = Instrument(
    title='A <square> & its "root"',
    controls=[Slider("side", "side", "mm", 0.0, 2.0, 0.01, 1.0), Choice("sign", "sign", ["+", "−"])],
    readouts={"Area": [Readout("area", "area", "m²")]},
    drawings=[Drawing("plan", "The square", (-1.0, 1.0, -1.0, 1.0))],
    modules={"square": "export const area = (side) => side * side; // </script>"},
    script="export function values() { return {}; }",
    presets={"unit": {"side": 1.0}},
    data={"names": ["ä", "</script>"]},
)


def settings(page: str) -> dict:
    packed = page.split('<script id="settings" type="text/plain">', 1)[1].split("</script>", 1)[0]
    return json.loads(zlib.decompress(base64.b64decode(packed)))


def test_the_page_holds_all_that_it_was_given():
    held = settings(INSTRUMENT.page())
    assert held["modules"] == INSTRUMENT.modules
    assert held["data"] == INSTRUMENT.data
    assert held["presets"] == INSTRUMENT.presets
    assert [control["kind"] for control in held["controls"]] == ["slider", "choice"]
    assert held["readouts"]["Area"][0]["unit"] == "m²"


def test_titles_are_escaped_and_the_same_instrument_has_the_same_bytes():
    shown = INSTRUMENT._repr_html_()
    assert "<h2>A &lt;square&gt; &amp; its &quot;root&quot;</h2>" in INSTRUMENT.page()
    assert shown.count("<") == 2  # the frame opens and closes; all else is inside an attribute
    assert shown == replace(INSTRUMENT)._repr_html_()


def test_the_page_names_no_address():
    page = INSTRUMENT.page().replace("http://www.w3.org/2000/svg", "")
    assert "://" not in page


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"presets": {"far": {"side": 3.0}}}, "preset 'far' sets side to 3.0; its limits are 0.0 to 2.0"),
        (
            {"presets": {"odd": {"edge": 1.0}}},
            r"preset 'odd' sets 'edge'; the controls are \['side', 'sign'\]",
        ),
        (
            {"presets": {"odd": {"sign": "?"}}},
            "preset 'odd' sets sign to '\\?', which is none of its options",
        ),
        ({"readouts": {"": [Readout("area", "area", "acre")]}}, "area is in 'acre'; "),
        ({"drawings": [INSTRUMENT.drawings[0]] * 2}, r"drawings are \['plan', 'plan'\]; each needs a name"),
        ({"controls": [Slider("side", "side", "m", 0.0, 1.0, 0.1, 2.0)]}, "preset 'start' sets side to 2.0"),
    ],
)
def test_what_does_not_fit_is_refused(changes, message):
    with pytest.raises(ValueError, match=message):
        replace(INSTRUMENT, **changes)
