"""Settings with which no file can be read are refused before one is opened."""

import re

import pytest

from breaker.records.settings import FORMAT, complete, lacking

REFUSED = {
    "an unknown unit of time": ({"time_unit": "min"}, "time_unit is 'min', but must be one of s"),
    "a ratio and a table": ({"ratio": 2.0, "table": "a.csv"}, "ratio and endurance.format.table"),
    "a zero beside a table": ({"table": "a.csv", "zero": 0.5}, "zero must be 0 or rest"),
    "a wrong zero": ({"zero": "start"}, "zero is 'start', but must be a number or rest"),
    "no range of strokes": ({"stroke": [60.0, 4.0]}, "stroke is [60.0, 4.0]"),
    "an encoding": ({"encoding": "utf-9"}, "endurance.format.encoding: unknown encoding: utf-9"),
    **{
        name: ({"encoding": name}, f"endurance.format.encoding: {name} is no encoding of text")
        for name in ("base64", "punycode", "idna", "unicode-escape")
    },
    "a delimiter": ({"delimiter": "\\t"}, "delimiter is '\\\\t', but must be one sign"),
    "an unknown setting": ({"colour": "red"}, "endurance.format has no colour"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_settings_that_fit_no_file_are_refused(name):
    settings, reason = REFUSED[name]
    with pytest.raises(ValueError, match=re.escape(reason)):
        complete(settings)


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"travel_unit": "foot"}, "travel_unit is 'foot', not one of mm, cm"),
        ({"travel_unit": "deg"}, "ratio (mm for one of it) or table must be given"),
        ({"travel_unit": "V"}, "ratio (mm for one of it) or table must be given"),
        ({"time_column": None}, "rate is needed: the samples in a ms (kHz), or the column rate"),
        ({"travel_unit": "deg", "ratio": 1.5, "time_column": None, "rate": 10.0}, ""),
    ],
)
def test_what_a_row_of_the_table_may_still_state_is_lacking(settings, said):
    found = lacking(complete(settings))
    assert said in found
    assert bool(said) == bool(found)


def test_what_is_not_given_has_its_default():
    assert complete({}) == FORMAT
    assert complete({"travel_unit": "deg", "ratio": 1.5})["ratio"] == 1.5
