"""Touch, separation and gap of long strokes, whose contact may slide: inconclusive without one."""

from dataclasses import replace

import numpy as np
import pytest

from breaker.diagnosis.limits import judged
from breaker.model.limits import Limit
from tests.diagnosis.conftest import result_of


def long(answer, **more):
    """The same answer, of a drive of 150 mm."""
    shape = answer.record.shape._replace(stroke=150.0)
    return replace(answer, record=replace(answer.record, shape=shape), **more)


def limit(name, bound):
    return Limit.from_settings({"name": name, "motion": "closing", "upper": {name: bound}})


def test_a_long_one_withholds_it_everywhere(answers):
    answer = long(answers[0])
    verdicts = judged(answer, [limit("touch_time", 50.0), limit("L", 500.0)], seed=1)
    assert [verdict["verdict"] for verdict in verdicts] == ["inconclusive"] * 2
    assert {verdict["reason"].code for verdict in verdicts} == {"contact-may-slide"}
    (entry,) = result_of([answer])["records"]
    for name in ("touch_time", "spring_compression", "closing_wipe"):
        assert entry["quantities"][name]["median"] is None
        assert entry["quantities"][name]["reason"].code == "contact-may-slide"
    assert "touch_from10" not in entry["quantities"]
    assert entry["parameters"]["L"]["reason"].code == "contact-may-slide"
    assert entry["parameters"]["f"]["median"] > 0.0


def test_a_known_value_or_a_used_contact_brings_it_back(answers, timed):
    assert long(answers[0]).contact_unknown
    assert not long(answers[0], contact_given=True).contact_unknown
    assert not long(answers[0], contact_used=True).contact_unknown
    assert long(answers[0]).contact.time == pytest.approx(np.nan, nan_ok=True)
    left_out = long(replace(answers[0], record=timed(20.0)))
    assert left_out.why_not("L").code == "contact-may-slide"
    assert left_out.why_not("touch_time") == ""
