"""The model and other detectors on made-up lives, whose series bend or do not."""

import numpy as np
import pytest
import xarray as xr

from breaker.mechanism.parameters import MOTIONS, NAMES
from breaker.model.randomness import generator
from breaker.synthetic.detectors import RATES, compare_detectors, score_alarms, watched

EVERY, SETTLE, LEVELS = 5, 30, (0.5, 0.9)


def life(number, *, bend, ratio=6.0, failure=800, model=(410,)):
    """A life that changes at 400: raw times rest, one parameter bends in the outputs of both."""
    operation = np.arange(EVERY, failure + 1, EVERY).astype(float)
    rng = generator(4, "test", "detectors", number)
    output = rng.standard_normal((len(operation), 2, len(NAMES) + 1))
    output[:, :, number % len(NAMES)] += bend * np.maximum(operation - 400, 0)[:, None]
    alarm_at = np.stack([np.isin(operation, model[:k]) for k in (None, 1)], axis=1)
    return xr.Dataset(
        {
            "operation": ("record", operation),
            "raw_time": (("record", "motion"), rng.standard_normal((len(operation), 2))),
            "output": (("record", "motion", "parameter"), output),
            "alarm_at": (("record", "level"), alarm_at.astype(float)),
            "change": 400,
            "failure": failure,
            "ratio": ratio,
        },
        {"motion": list(MOTIONS), "parameter": [*NAMES, "onset"], "level": list(LEVELS)},
    )


def together(rows):
    longest = max(row.sizes["record"] for row in rows)
    return xr.concat([row.pad(record=(0, longest - row.sizes["record"])) for row in rows], "life")


@pytest.fixture(scope="module")
def compared():
    lives = [life(k, bend=1.0 * (k % 3 > 0), ratio=(2, 4, 9)[k % 3]) for k in range(12)]
    return compare_detectors(
        together([*lives, life(12, bend=1.0, failure=700, ratio=30)]), settle=SETTLE
    )


def test_every_detector_at_every_rate(compared):
    names = compared.detector.unique().tolist()
    charts = [f"{kind}, {m}" for kind in ("threshold", "CUSUM", "EWMA") for m in MOTIONS]
    assert names == ["model", *charts, "multivariate EWMA", "slope test"]
    assert compared[compared.detector == "model"].level.tolist() == list(LEVELS)
    for name in names[1:]:
        mine = compared[compared.detector == name]
        assert len(mine) == len(RATES)
        assert np.all(mine.false_alarms.values <= np.array(RATES) + 1e-9)
        assert np.all(np.diff(mine.level) <= 0)


def test_what_bends_is_found_by_those_that_watch_it(compared):
    """Of eight and nine lives that bend by 5 sd a record nearly all, of the others and of raw
    times, which rest, next to none: at no false alarm at all."""
    strict = compared.drop_duplicates("detector").set_index("detector")
    for name in ("multivariate EWMA", "slope test"):
        assert strict.found_from_5[name] >= 0.8
        assert strict.found_3_to_5[name] >= 0.75
        assert strict["found_1.5_to_3"][name] == 0.0
        assert strict.delay_from_5[name] <= 20.0
    assert np.all(strict.found_from_5.filter(like=",") <= 0.2)
    assert np.all(np.isinf(strict.delay_from_5.filter(like=",")))
    assert strict.found_from_5["model"] == 1.0
    assert strict.delay_from_5["model"] == 10.0


def test_scores_of_alarms():
    """3 % of 800 operations are 24; false alarms count over 400 - 30 records of each of four."""
    lives = together([life(k, bend=0.0, ratio=ratio) for k, ratio in enumerate((2, 4, 6, 7))])
    assert watched(lives, SETTLE) == 4 * (400 - 30 * EVERY)
    scores = score_alarms(lives, [[200, 405], [430], [424], [795]], SETTLE)
    assert scores["false_alarms"] == pytest.approx(1e4 / 1000)
    assert (scores["found_from_5"], scores["delay_from_5"]) == (0.5, 395.0)
    assert (scores["found_3_to_5"], scores["delay_3_to_5"]) == (0.0, 30.0)
    assert (scores["found_1.5_to_3"], scores["delay_1.5_to_3"]) == (1.0, 5.0)
    assert np.isinf(score_alarms(lives, [[], [], [], [800]], SETTLE)["delay_from_5"])
