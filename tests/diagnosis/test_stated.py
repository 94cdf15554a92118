"""What files state of a visit."""

from types import SimpleNamespace

import pytest

from breaker.diagnosis.identity import dates_in_words
from breaker.records.header import Header
from breaker.records.operations import Operation

MARCH, APRIL, LATER = "2021-03-04", "2021-04-03", "2021-04-14"


@pytest.mark.parametrize(
    ("stated", "words"),
    [
        ([(LATER,), (MARCH,)], f"{MARCH} to {LATER}"),
        ([(MARCH, APRIL)], f"{MARCH} or {APRIL}"),
        ([(MARCH, APRIL), (LATER,)], f"{MARCH} or {APRIL} to {LATER}"),
        ([()], ""),
    ],
)
def test_no_day_of_a_visit_is_left_out(stated, words):
    """Planted fault: a day that may be either was left out beside one that is told."""
    records = [
        SimpleNamespace(operation=Operation(1, "a.csv"), stated=Header(dates=dates))
        for dates in stated
    ]
    assert dates_in_words(records) == words
