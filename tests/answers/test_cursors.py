"""Where numbers are read: what stands there gives the number again."""

from dataclasses import replace

import numpy as np
import pytest

from breaker.documents.terminal import text_of
from breaker.drive.answers.answer_document import document
from breaker.drive.answers.answer_words import words_of


@pytest.fixture(scope="module")
def document_of_all(answers):
    return document(answers, [[]] * len(answers), {"words": []}, {}, explain=True)


@pytest.fixture(scope="module")
def told(document_of_all):
    return [each for each in document_of_all.records if each.accepted]


def test_places_give_the_numbers_again(told):
    for record in told:
        known, places = record.quantities, record.places
        before, after = places["stroke"]
        way = abs(after.travel - before.travel)
        assert known["stroke"].median == pytest.approx(way, rel=1e-4)
        begin, end = places["travel_time"]
        lasts = end.time - begin.time
        assert known["travel_time"].median == pytest.approx(lasts, rel=1e-4)
        for name, (first, last) in places.items():
            if "_speed" in name:
                way = abs(last.travel - first.travel)
                speed = way / (last.time - first.time)
                assert known[name].median == pytest.approx(speed, rel=1e-3)


def test_only_what_is_measured_has_places(told):
    for record in told:
        shown = {n for n, each in record.quantities.items() if each.median is not None}
        assert record.places.keys() <= shown
        assert not any(record.quantities[n].source == "inferred" for n in record.places)


def test_samples_count_from_one_and_rests_have_an_end(told, document_of_all):
    before, after = told[0].places["stroke"]
    assert 1 <= before.sample < after.sample
    assert before.until > before.time
    assert np.diff([before.time, before.until, after.time, after.until]).min() > 0.0
    both = [replace(document_of_all, records=[e]) for e in (told[0], replace(told[0], places=None))]
    longer, shorter = (len(text_of(words_of(each)).splitlines()) for each in both)
    assert longer > shorter + len(told[0].places)
