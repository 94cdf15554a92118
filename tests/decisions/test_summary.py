"""The first page: on small tables made up for it."""

from dataclasses import replace

import numpy as np

from breaker.decisions.trust import trust_table
from breaker.mechanism.parameters import MOTIONS
from tests.decisions import made_up
from tests.decisions.made_up import INF, NAN, NUMBERS, QUIET, curves_of, page_of, trend_of
from tests.decisions.test_trust import trust_of


def test_way_is_from_the_baseline_to_the_limit():
    """Of a limit of two parts, the part that is farthest; below a limit as above it."""
    trend = trend_of(MOTIONS, NUMBERS)
    trend["value"][:2] = np.array([[9.0] * 3, [9.0] * 3, [0.8] * 3, [10.0] * 3])
    trend["value"][2:] = np.array(
        [[9.1, 9.25, 9.5], [9.4, 9.6, 9.8], [0.77, 0.78, 0.79], [9.8, 9.9, 10.5]]
    )
    trend["value"][3, 0] = NAN  # no record of closing: as last known
    page = page_of(QUIET, trend).verdict
    assert page.limit.values.tolist() == ["slow", "tired", "wide"]
    np.testing.assert_allclose(
        page.way.values, [[10, 25, 50], [10, 20, 30], [-20, -10, 50]], atol=1e-9
    )
    page = page_of(QUIET, trend, baseline=100).verdict
    np.testing.assert_allclose(page.way.sel(quantile=0.5)[1:], 0, atol=1e-9)


def test_way_of_a_limit_exceeded_from_the_start():
    trend = trend_of(MOTIONS, NUMBERS, beyond={"wide": 1.0})
    trend["value"][:2, 3] = 11.2
    trend["value"][2:, 3] = 11.4
    assert page_of(QUIET, trend).verdict.way.sel(limit="wide", quantile=0.5) >= 100


def test_names_of_limits_with_words_of_the_sentences(monkeypatch):
    odd = [replace(each, name=f"{each.name} (A) since 2019") for each in made_up.LIMITS]
    monkeypatch.setattr(made_up, "LIMITS", odd)
    monkeypatch.setattr(made_up, "PARTS", [each.name for each in odd for _ in each.parts])
    page = page_of(QUIET, trend_of(MOTIONS, NUMBERS, beyond={odd[0].name: 0.3})).verdict
    assert "Cannot tell" not in page.headline  # the limit that the action is about
    page = page_of(np.full((4, 3), 0.99), trend_of(MOTIONS, NUMBERS)).verdict
    assert "slow (A) since 2019 exceeded since operation 2, tired (A) since 2019 since 2" in (
        page.headline
    )
    assert page.attrs["left"] == "Left, operations (90 %): nothing to the limits exceeded."


def test_what_is_left_and_what_cannot_be_told():
    trend = trend_of(
        MOTIONS,
        NUMBERS,
        toward={"slow": 0.99, "wide": 0.99},
        remaining={"slow": [250, 300, 350], "wide": [1234, 4321, INF]},
        beyond={"tired": 0.2},
    )
    dates = ["2024-01-01", "", "", "2024-01-31"]
    page = page_of(QUIET, trend, curves={"closing": curves_of(NUMBERS, date=dates)}).verdict
    assert page.headline == (
        "Plan service by operation 251 (2030-11-05), before slow (250 to 350 operations left). "
        "Cannot tell tired (20 %). As of operation 4."
    )
    assert page.attrs["left"] == (
        "Left, operations (90 %): slow 300 (250 to 350), wide 4,320 (1,230 to beyond the horizon). "
        "At the recent rate slow in 3,000 days (2,500 to 3,500)."
    )


def test_days_beyond_a_century_are_not_told():
    curves = {"closing": curves_of(NUMBERS, date=["2020-01-01", "", "", "2023-01-01"])}
    trend = trend_of(MOTIONS, NUMBERS, toward={"slow": 0.99}, remaining={"slow": [250, 300, 350]})
    page = page_of(QUIET, trend, curves=curves).verdict
    assert page.attrs["left"] == "Left, operations (90 %): slow 300 (250 to 350)."


def test_a_drive_beyond_the_family_is_named_in_the_headline():
    unlike = trust_table([trust_of(MOTIONS, drive=9.0)])
    page = page_of(QUIET, trend_of(MOTIONS, NUMBERS), trust=unlike)
    assert "Intervals cannot be relied on" in page.verdict.headline
    assert "unlike the family: closing start" in page.last.trust
