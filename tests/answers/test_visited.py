"""The comparison of two visits as a document and in words."""

import numpy as np
import pytest
import xarray as xr

from breaker.answers.changed import changes
from breaker.answers.visited import measured_changes, visits_document, visits_in_words
from breaker.mechanism.parameters import NAMES
from breaker.posterior.comparing import Compared
from breaker.posterior.weights import importance

TODAY = {"closing": np.array([False, True, True])}
SETTINGS = {"share": 0.05, "seed": 1, "discrepancy": 1.0, "misfit_p_value": 0.001}


def compared(prior, factor, *, sd=0.005, motions=("closing",), **more):
    """Draws of both visits about parameters that changed by factors ``(7,)``."""
    rng = np.random.default_rng(4)
    before = prior.medians * np.exp(0.01 * rng.standard_normal((400, 7)))
    today = before * factor * np.exp(sd * rng.standard_normal((400, 7)))
    about = {"resolved": True, "reason": "", "p_value": 0.4, "agreement": 1.0} | more
    return Compared(motions, before, today, importance=importance(*np.zeros((2, 400))), **about)


def curves(strokes):
    """What is measured of closings: their strokes, mm."""
    names = ["stroke", "over_travel"]
    values = np.column_stack([strokes, np.full(len(strokes), np.nan)])
    over = ("operation", "quantity")
    found = xr.Dataset(
        {"measured": (over, values), "measured_sd": (over, np.full(values.shape, 0.01))},
        coords={"quantity": names},
    )
    return {"closing": found}


def document(found, *, strokes=(14.0, 13.9, 13.9), rejected=(), beyond=0.05):
    settings = SETTINGS | {"share": beyond}
    part = [(found, changes(found, beyond=beyond))]
    return visits_document(
        part, curves(strokes), TODAY, rejected, {"words": ["noise read"]}, settings
    )


def factors(**changed):
    return np.array([changed.get(name, 1.0) for name in NAMES])


def test_what_changed_is_in_the_headline(prior):
    found = document(compared(prior, factors(f=0.9)))
    assert found["headline"].startswith("Changed: f -9.9 % (-11 to -9")
    assert "not beyond 5 %: all others" in found["headline"]
    assert "touch_time" in found["headline"]
    rows = {row["name"]: row for row in found["comparisons"][0]["changes"]}
    assert rows["f"]["change"][1] == pytest.approx(-10.0, abs=0.3)
    assert rows["f"]["beyond"] == rows["f"]["worse"] == rows["f"]["less"] == 1.0
    assert rows["f"]["difference"][1] == pytest.approx(-0.075, rel=0.03)
    assert rows["mu"]["worse"] is None
    assert rows["mu"]["verdict"] == "did not change"


def test_a_strong_force_is_no_wear(prior):
    rows = document(compared(prior, factors(f=1.1)))["comparisons"][0]["changes"]
    assert [row["worse"] for row in rows if row["name"] == "f"] == [0.0]


def test_nothing_is_sure_where_nothing_is_known(prior):
    found = document(compared(prior, factors(), sd=0.1))
    assert found["headline"].startswith("No parameter changed for sure beyond 5 %; cannot be told")
    assert "not beyond" not in found["headline"]


def test_another_share_is_that_of_the_answer(prior):
    found = document(compared(prior, factors(f=0.9)), beyond=0.2)
    assert found["headline"].startswith("No parameter changed for sure beyond 20 %; not beyond")
    assert found["settings"]["prior_beyond"] == pytest.approx(0.06, abs=0.01)
    assert "P>20 %" in visits_in_words(found)


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ({"p_value": 1e-6}, "do NOT fit"),
        ({"resolved": False, "reason": "effective size 9, 400 are needed"}, "NOT resolved"),
        ({"agreement": 1e-5}, "compared apart"),
    ],
)
def test_what_limits_the_trust_is_said(prior, more, words):
    found = document(compared(prior, factors(), **more))
    assert any(words in each for each in found["trust"])
    assert words in visits_in_words(found).replace("\n  ", " ")


def test_another_drive_is_suspected(prior):
    found = document(compared(prior, factors()), strokes=(14.0, 20.0, 20.0))
    assert "same drive" in found["trust"][0]
    assert "WARNING" not in " ".join(document(compared(prior, factors()))["trust"])


def test_measured_changes_are_means_of_what_is_there():
    found = measured_changes(curves([14.0, 13.8, 13.9]), TODAY)["closing"]
    assert set(found) == {"stroke"}
    stroke = found["stroke"]
    assert stroke["difference"] == pytest.approx(-0.15)
    # One reading before, and two today that scatter by more than they are read.
    assert stroke["sd"] == pytest.approx(np.hypot(0.01, 0.05), rel=1e-3)
    assert stroke["change"][1] == pytest.approx(-1.07, abs=0.01)


def test_the_text_has_a_row_for_each_and_what_was_rejected(prior):
    rejected = [{"file": "x.csv", "motion": "closing", "visit": "today", "reason": "no rise"}]
    text = visits_in_words(document(compared(prior, factors(f=0.9)), rejected=rejected))
    assert "rejected: x.csv: no rise" in text
    assert "closing 1 before, 2 today" in text
    assert "-0.1 ±0.0" in text
    for name in (*NAMES, "wipe", "stroke", "closing_speed"):
        assert f"\n  {name}" in text
    assert max(map(len, text.splitlines())) <= 100


def test_quantities_that_do_not_exist_are_said_to_be_so(prior):
    found = document(compared(prior, factors(f=0.5)))
    rows = {row["name"]: row for row in found["comparisons"][0]["changes"]}
    assert rows["stroke"]["undefined"] == 1.0
    assert rows["stroke"]["change"] == [None] * 3
    assert "does not exist" in visits_in_words(found)
