"""Settings with which no file can be read are refused before one is opened."""

import pytest

from breaker.records.settings import complete, lacking

REFUSED = [
    ("time_unit", {"time_unit": "min"}),
    ("ratio", {"ratio": 2.0, "table": "a.csv"}),
    ("table", {"table": "a.csv", "zero": 0.5}),
    ("zero", {"zero": "start"}),
    ("stroke", {"stroke": [60.0, 4.0]}),
    ("delimiter", {"delimiter": "\\t"}),
    ("colour", {"colour": "red"}),
    ("encoding", {"encoding": "base64"}),
]


@pytest.mark.parametrize(("key", "settings"), REFUSED)
def test_settings_that_fit_no_file_are_refused(key, settings):
    with pytest.raises(ValueError, match=key):
        complete(settings)


@pytest.mark.parametrize(
    ("key", "settings"),
    [
        ("travel_unit", {"travel_unit": "foot"}),
        ("ratio", {"travel_unit": "deg"}),
        ("rate", {"time_column": None}),
        ("", {"travel_unit": "deg", "ratio": 1.5, "time_column": None, "rate": 10.0}),
    ],
)
def test_what_a_row_of_the_table_may_still_state_is_lacking(key, settings):
    result = lacking(complete(settings))
    assert key in result
    assert bool(key) == bool(result)
