"""Values and uncertainties of some records, so that a rule changes them on purpose only.

After such a change, ``python -m tests.records.test_readings`` writes ``readings.csv`` anew. Other
tests compare readings with the truth.
"""

from pathlib import Path

import numpy as np
import pandas as pd

from breaker.model.quantities import speeds_of
from breaker.records.contacts import ContactTimes
from breaker.records.first_motion import start_interval
from breaker.records.measurements import measure_curve
from tests.raws import swinging
from tests.records.test_first_motion import closing

TABLE = Path(__file__).with_name("readings.csv")
POINTS = {
    "closing_speed": ["6 mm before touch", "touch"],
    "closing_speed_first": ["0 % of stroke", "50 % of stroke"],
    "closing_speed_zone": ["0.5 mm from open", "3 mm from closed"],
    "opening_speed": ["separation", "6 mm after separation"],
    "opening_speed_zone": ["3 mm from closed", "4 ms after 50 % of stroke"],
}


def records():
    """Yield the name, times, travel and motion of each record, and its contact's times."""
    rng = np.random.default_rng(31)
    for number in (0, 1, 3, 4):
        time, travel, start = closing(number, slow=number != 4, strokes=(60.0, 150.0))
        contact = ContactTimes(start + 50.0, 0.1, trigger=5.0)
        yield f"slow {number}", time, travel, "closing", contact
    time = np.arange(0.0, 200.0, 0.2)
    noise = 0.05 * rng.standard_normal(time.size)
    drive = 13.5, 12.0, 0.12, 1.2
    for name, ends in (("swings", 70.0), ("ends early", 44.0), ("rests", 200.0)):
        travel = (swinging(time - 20.0, *drive) + noise)[time < ends]
        contact = ContactTimes(27.5, 0.1, trigger=5.0, bounce_time=1.5)
        yield name, time[time < ends], travel, "closing", contact
    way = 160.0 * swinging(time - 60.0, 1.0, 30.0, 0.05)
    fast = np.gradient(way) / np.gradient(way).max()
    contact = ContactTimes(70.0, 0.1, main=66.0, main_sd=0.2, arcing=70.0, arcing_sd=0.1)
    creep = 3.0 * np.exp(-np.maximum(time - 80.0, 0.0) / 60.0) * (way / 160.0)
    for name, more in (
        ("ripples", 3.0 * fast * np.sin(time)),
        ("drifts", 0.02 * time),
        ("slips", 2.0 * (time > 75.0)),
        ("creeps back", creep),
        ("creeps on", -3.0 * creep),
        ("gap", np.where(np.abs(time - 75.0) < 1.0, np.nan, 0.0)),
    ):
        yield name, time, 170.0 - way - more + noise, "opening", contact
    for name, sd in (("counter", 0.0), ("noisy counter", 0.15)):
        noisy = 170.0 - way + sd * rng.standard_normal(time.size)
        yield name, time, 0.4 * np.round(noisy / 0.4), "opening", contact
    for name, low, high in (("clipped", 9, 999), ("ends late", 10, 999), ("ends first", 0, 170)):
        yield name, time, np.clip(170.0 - way + noise, low, high), "opening", contact
    seldom = slice(None, None, 5)
    yield "1 kHz", time[seldom], (170.0 - way + noise)[seldom], "opening", contact


def readings():
    """Return value and sd of each quantity that a record shows, by its name."""
    rows = []
    for name, time, travel, motion, contact in records():
        speeds = speeds_of({key: ends for key, ends in POINTS.items() if motion in key})
        measured = measure_curve(time, travel, motion, contact=contact, speeds=speeds)
        shown = {key: item for key, item in measured.items() if not item.reason}
        rows += [(name, quantity, value, sd) for quantity, (value, sd, _) in shown.items()]
        rows.append((name, "start", *start_interval(time, travel, motion)))
    return pd.DataFrame(rows, columns=["record", "quantity", "value", "sd"])


def test_readings_are_those_of_the_table():
    expected = pd.read_csv(TABLE)
    pd.testing.assert_frame_equal(readings(), expected, rtol=1e-3, atol=1e-5)


if __name__ == "__main__":
    readings().to_csv(TABLE, index=False, float_format="%.6g")
