"""Where numbers are read: what stands there gives the number again."""

import numpy as np
import pytest

from breaker.drive.answers.answer_document import document
from breaker.drive.answers.number_sources import explained, place_lines


@pytest.fixture(scope="module")
def told(answers):
    found = document(answers, [[]] * len(answers), {"words": []}, {})
    return [each for each in explained(found, answers)["records"] if each["accepted"]]


def test_places_give_the_numbers_again(told):
    for record in told:
        known, places = record["quantities"], record["places"]
        before, after = places["stroke"]
        way = abs(after["travel"] - before["travel"])
        assert known["stroke"]["median"] == pytest.approx(way, rel=1e-4)
        begin, end = places["travel_time"]
        lasts = end["time"] - begin["time"]
        assert known["travel_time"]["median"] == pytest.approx(lasts, rel=1e-4)
        for name, (first, last) in places.items():
            if "_speed" in name:
                way = abs(last["travel"] - first["travel"])
                speed = way / (last["time"] - first["time"])
                assert known[name]["median"] == pytest.approx(speed, rel=1e-3)


def test_only_what_is_measured_has_places(told):
    for record in told:
        shown = {n for n, each in record["quantities"].items() if each["median"] is not None}
        assert record["places"].keys() <= shown
        assert not any(record["quantities"][n]["source"] == "inferred" for n in record["places"])


def test_samples_count_from_one_and_rests_have_an_end(told):
    before, after = told[0]["places"]["stroke"]
    assert 1 <= before["sample"] < after["sample"]
    assert before["until"] > before["time"]
    assert np.diff([before["time"], before["until"], after["time"], after["until"]]).min() > 0.0
    lines = place_lines(told[0])
    assert lines[0].split()[:4] == ["where", "it", "is", "read"]
    assert any("stroke: rest after" in line for line in lines)
    assert place_lines({"quantities": {}}) == []
