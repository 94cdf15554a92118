"""The document of an answer, and its words."""

import json

import numpy as np
import pytest

from breaker.answers.plain import document
from breaker.answers.words import in_words

DRIVE = {"words": ["of size 1"], "noise_sd": 0.1}
SETTINGS = {"discrepancy": 1.0}


def test_a_document_has_every_record_and_no_number_that_json_lacks(answers):
    found = document(answers, DRIVE, SETTINGS)
    text = json.dumps(found, allow_nan=False)
    assert json.loads(text) == found
    assert [each["accepted"] for each in found["records"]] == [True, True, False] * 2
    first, rejected = found["records"][0], found["records"][2]
    assert first["phase"] == "L1"
    assert rejected["reason"] == "b.csv: is empty"
    assert "parameters" not in rejected
    median = answers["closing"]["median"].sel(output="L")[0]
    assert first["parameters"]["L"]["median"] == pytest.approx(float(median), rel=1e-5)
    assert first["quantities"]["touch_time"]["unit"] == "ms"
    assert first["fit"]["resolved"] is True
    assert [each["verdict"] for each in first["limits"]] == ["not healthy", "healthy"]
    assert first["verdict"] == "not healthy"


def test_records_together_have_their_spread(answers):
    together = document(answers, DRIVE, SETTINGS)["together"]
    assert set(together) == {"closing", "opening"}
    closing = together["closing"]
    medians = answers["closing"]["median"].sel(output="mu").values[:2]
    assert closing["records"] == 2
    assert closing["parameters"]["mu"]["sd"] == pytest.approx(np.std(medians, ddof=1), rel=1e-4)
    assert closing["limits"]["slow"]["not healthy"] == 2
    alone = {"closing": answers["closing"].isel(operation=[0, 2])}
    assert document(alone, DRIVE, SETTINGS)["together"] == {}


def test_a_quantity_that_does_not_exist_is_none_and_said_to_be(answers):
    answer = answers["closing"].isel(operation=[0]).copy(deep=True)
    answer["quantity_median"][:, 0] = np.nan
    answer["quantity_interval"][:, 0] = np.nan
    found = document({"closing": answer}, DRIVE, SETTINGS)
    assert found["records"][0]["quantities"]["wipe"]["median"] is None
    assert "does not exist" in in_words(found)


def test_words_of_an_unresolved_misfit_name_the_remedies(answers):
    answer = answers["closing"].isel(operation=[0]).copy(deep=True)
    answer["resolved"][:] = False
    answer["misfit"][:] = True
    text = in_words(document({"closing": answer}, DRIVE, SETTINGS))
    assert "does NOT fit the model" in text
    assert "NOT resolved" in text
    assert "--model FILE" in text
    assert "endurance.discrepancy" in text
    assert max(map(len, text.splitlines())) <= 100
