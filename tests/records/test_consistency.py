"""What only a whole record shows: each kind of damage is found, and good records have no remark."""

import numpy as np
import pytest

from breaker.common.randomness import generator
from breaker.model.curves import travel
from breaker.model.parameters import MOTIONS
from breaker.records.checks import inconsistencies
from breaker.records.first_motion import first_motion

NOISE = 0.1
RECORDS = 150


@pytest.fixture(scope="module", params=MOTIONS)
def records(request, prior):
    """Times, records and their first motions."""
    rng, time = generator(6, "test consistency", request.param), np.arange(0.0, 76.0, 0.1)
    moves = 8.0 + 4.0 * rng.random(RECORDS)
    exact = travel(prior.sample(RECORDS, rng), time, request.param, onset=moves).travel
    measured = exact + NOISE * rng.standard_normal(exact.shape)
    return time, measured, [first_motion(time, each, request.param)[0] for each in measured]


def found(records, change=lambda x: x, rows=slice(None), shift=0.0):
    time, measured, moves = records
    pairs = zip(measured[rows], moves[rows], strict=True)
    return [inconsistencies(time, change(x), m + shift, NOISE) for x, m in pairs]


def test_good_records_have_no_remark(records):
    # Fewer than one in 1,000 has one: of 150, more than two have a probability below 1e-3.
    assert sum(bool(words) for words in found(records)) <= 2
    missing = generator(6, "missing").random(records[0].size) < 0.1
    assert sum(map(bool, found(records, lambda x: np.where(missing, np.nan, x)))) <= 2
    rounded = found(records, lambda x: 0.08 * np.rint(x / 0.08))
    assert sum(bool(words) for words in rounded) <= 2


@pytest.mark.parametrize(
    ("words", "change"),
    [
        ("come again", lambda x: np.insert(x, 170, x[150:170])[: x.size]),
        ("come again", lambda x: np.r_[x[:400], x[:360]]),
        ("far more than elsewhere", lambda x: x + 0.5 * np.sin(2.0 * np.arange(x.size)) * BURST),
    ],
)
def test_damage_is_found(records, words, change):
    for remarks in found(records, change, slice(10)):
        assert any(words in each for each in remarks)


BURST = (np.arange(760) // 20) == 10  # two ms


def test_an_excursion_at_rest_is_found_and_a_swing_that_decays_is_none(records):
    bump = np.zeros(760)
    bump[690:750] = np.hanning(60)
    words = found(records, lambda x: x + 4.0 * bump, slice(20))
    assert sum("off its rest" in " ".join(remarks) for remarks in words) >= 15
    time = np.arange(0.0, 600.0, 0.1)
    swing = np.exp(-(time - 100.0) / 60.0) * np.cos((time - 100.0) / 20.0)
    noise = 0.1 * np.random.default_rng(2).standard_normal(time.size)
    record = 150.0 * np.where(
        time < 100.0, np.clip((time - 50.0) / 50.0, 0.0, 1.0), 1.0 + 0.1 * swing
    )
    assert "off its rest" not in " ".join(inconsistencies(time, record + noise, 50.0, 0.1))


def test_what_is_steady_at_rest_is_no_repetition():
    time = np.arange(0.0, 60.0, 0.1)
    counted = 0.32 * np.floor(0.3 * np.clip(time - 25.0, 0.0, 7.0) ** 2 / 0.32)
    assert inconsistencies(time, counted, first_motion(time, counted, "closing")[0], 0.1) == []


def test_a_stop_and_a_flicker_of_the_last_digit_are_no_noise():
    time = np.arange(0.0, 300.0, 0.1)
    way = 170.0 * np.clip((time - 60.0) / 20.0, 0.0, 1.0) ** 2
    noise = 0.03 * np.random.default_rng(1).standard_normal(time.size)
    record = 0.1 * np.rint((way + noise) / 0.1)
    assert "noise" not in " ".join(inconsistencies(time, record, 60.0, 0.0, 0.1))


@pytest.mark.parametrize("share", [0.7, 0.8, 0.9])
def test_a_range_that_ends_below_the_stroke_is_seen_through_noise(prior, share):
    """Of 100 closings that are cut so at least 80 are named, and of 100 whole ones none."""
    rng, time = generator(7, "range"), np.arange(0.0, 76.0, 0.1)
    exact = travel(prior.sample(100, rng), time, "closing", onset=10.0).travel
    noise = 0.01 * rng.standard_normal(exact.shape)
    cut = np.minimum(exact, share * exact[:, -1:])
    named = [
        sum("range" in " ".join(inconsistencies(time, x, 10.0, 0.01)) for x in each + noise)
        for each in (cut, exact)
    ]
    assert named[0] >= 80
    assert named[1] == 0


@pytest.mark.parametrize("noise", [0.02, 0.1])
@pytest.mark.parametrize("motion", MOTIONS)
def test_a_flat_end_of_the_range_is_seen_where_noise_lies_on_it(prior, motion, noise):
    """Noise of the transducer is cut off there and that of the recorder is not: of 100 records that
    are cut at least 95 are named, and of 100 whole ones none, which noise hides as well.
    """
    rng, time = generator(8, "range", motion), np.arange(0.0, 76.0, 0.1)
    exact = travel(prior.sample(100, rng), time, motion, onset=20.0).travel
    measured = exact + noise * rng.standard_normal(exact.shape)
    low, high = measured.min(axis=1, keepdims=True), measured.max(axis=1, keepdims=True)
    cut = np.minimum(measured, low + 0.8 * (high - low))
    named = [
        sum("flat" in " ".join(inconsistencies(time, x, 20.0, 0.01)) for x in each)
        for each in (cut + 0.5 * noise * rng.standard_normal(exact.shape), measured)
    ]
    assert named[0] >= 95
    assert named[1] == 0
