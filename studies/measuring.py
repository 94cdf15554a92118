"""Quantities read from records of drives whose motion is known: how true they are.

    python -m studies.measuring        # writes docs/measuring.csv, in some minutes of one core

A drive's own quantities are those of its motion without noise, sampled densely until it rests.
They are compared with what is measured of a noisy record.
"""

from collections.abc import Sequence

import numpy as np
import pandas as pd
from scipy.stats import norm

from breaker.common.randomness import generator
from breaker.configuration.data_files import family_of
from breaker.configuration.loading import load
from breaker.family.drive_family import Family
from breaker.family.rich_drive import Drive
from breaker.model.parameters import MOTIONS, Size
from breaker.model.prior import Prior
from breaker.model.quantities import SPEEDS, Point, Speed, quantities_of, speeds_of
from breaker.records.contacts import ContactTimes
from breaker.records.measurements import measure_curve

_FINE = 0.01  # ms at size 1, between samples of a motion without noise
_LONG, _RESTS = 150.0, 1000.0  # ms at size 1, all of a motion, and when it is over
_LEAD, _LENGTH = 10.0, 80.0  # ms at size 1, of a record before and after the first motion
_CONTACT_SD = 0.1  # ms at size 1

_DRIVES = 200  # of the family, in each column of the table
_WIDE = norm.isf(0.025)  # half of a 95 % interval
_MEAN = ["10 % of stroke", "90 % of stroke"]
_SPEEDS = speeds_of({f"{motion}_speed_mean": _MEAN for motion in MOTIONS})
# Columns of the table: factors on lengths and times, and what differs from the first column.
_COLUMNS: dict[str, tuple[tuple[float, float], dict[str, float]]] = {
    "noise 0.7 %, 10 kHz": ((1.0, 1.0), {}),
    "noise 0.07 %": ((1.0, 1.0), {"noise": 0.0007}),
    "noise 2 %": ((1.0, 1.0), {"noise": 0.02}),
    "2.5 kHz": ((1.0, 1.0), {"rate": 2.5}),
    "counter, 1 % a step": ((1.0, 1.0), {"noise": 0.0, "quantum": 0.01}),
    "lengths x 0.43, times x 0.7": ((0.43, 0.7), {}),
    "lengths x 10, times x 4": ((10.0, 4.0), {}),
    "lengths x 14, times x 35": ((14.0, 35.0), {}),
}


def own_quantities(drive: Drive, motion: str, speeds: Sequence[Speed] = SPEEDS) -> dict[str, float]:
    """Return the quantities of a drive's motion without noise, nan where one does not exist."""
    sign = 1.0 if motion == "closing" else -1.0
    time = drive.size.times * np.append(np.arange(0.0, _LONG, _FINE), _RESTS)
    curve, switching = drive.operate(motion, time)
    way = sign * (curve - curve[0])
    stroke = way[-1]

    def place(point: Point) -> tuple[float, float]:
        if point.unit == "ms":
            at = switching + point.amount
            return at, float(np.interp(at, time, way))
        touch = np.interp(switching, time, way)
        level = point.amount / 100.0 * stroke if point.unit == "%" else touch + point.amount
        if point.amount < 0.0:
            below = np.flatnonzero((way <= level) & (time < switching))
            first = below[-1] + 1 if below.size else 0
        else:
            begin = 0.0 if point.unit == "%" else switching
            first = int(((way >= level) & (time >= begin)).argmax())
        if first == 0:
            return np.nan, level
        around = slice(first - 1, first + 1)
        return float(np.interp(level, way[around], time[around])), level

    def between(start: Point, end: Point) -> tuple[float, float]:
        (begin, low), (stop, high) = place(start), place(end)
        return (stop - begin, high - low) if stop > begin else (np.nan, np.nan)

    beyond = max(float(way.max() - stroke), 0.0)
    quantities = {
        **{"stroke": stroke, "travel_time": between(Point(10.0, "%"), Point(90.0, "%"))[0]},
        **dict.fromkeys(("touch_time", "separation_time"), switching),
        **dict.fromkeys(("over_travel", "opening_over_travel"), beyond),
    }
    for speed in speeds:
        duration, way_between = between(speed.start, speed.end)
        quantities[speed.name] = way_between / duration
    return {name: quantities.get(name, np.nan) for name in quantities_of(motion, speeds)}


def measure_drives(
    drives: Sequence[Drive],
    motion: str,
    rng: np.random.Generator,
    *,
    rate: float = 10.0,
    noise: float = 0.007,
    quantum: float = 0.0,
    speeds: Sequence[Speed] = SPEEDS,
) -> pd.DataFrame:
    """Record each drive once, with contact timing, and read what an instrument would print.

    Args:
        motion: "closing" or "opening".
        rate: Samples in a ms of a drive of size 1.
        noise: Standard deviation of the noise, in strokes.
        quantum: Step of the reading, in strokes.

    Returns:
        A row per drive and quantity: ``measured`` and ``measured_sd``, nan with a ``reason`` where
        it is not shown; ``own``, that of the drive's motion without noise.
    """
    rows = []
    for drive in drives:
        own = own_quantities(drive, motion, speeds)
        times, stroke = drive.size.times, own["stroke"]
        time = times * np.arange(-_LEAD - rng.uniform(0.0, 1.0 / rate), _LENGTH, 1.0 / rate)
        curve, switching = drive.operate(motion, time)
        curve = curve + noise * stroke * rng.standard_normal(time.size)
        if quantum:
            curve = quantum * stroke * np.round(curve / (quantum * stroke))
        sd = _CONTACT_SD * times
        contact = ContactTimes(switching + sd * rng.standard_normal(), sd)
        result = measure_curve(time, curve, motion, contact=contact, speeds=speeds)
        for name in own:
            if name in result:  # else of the model alone
                row = {"quantity": name, "own": own[name], "reason": result[name].reason}
                rows.append(row | {"measured": result[name].value, "measured_sd": result[name].sd})
    return pd.DataFrame(rows)


def main() -> None:
    """Write the table of docs/evidence.md: coverage of the stated intervals."""
    config = load()
    family = Family(Prior.from_settings(config["prior"]), family_of(config["family"]["name"]))
    rng = generator(1, "measuring")
    drives = [family.new(rng) for _ in range(_DRIVES)]
    rows = []
    for column, (size, settings) in _COLUMNS.items():
        for motion in MOTIONS:
            some = [drive.scaled(Size(*size)) for drive in drives]
            speeds = [speed.sized(Size(*size)) for speed in _SPEEDS]
            result = measure_drives(some, motion, rng, speeds=speeds, **settings)
            result["error"] = (result.measured - result.own) / result.measured_sd
            for name, both in result.dropna(subset="error").groupby("quantity", sort=False):
                row = {"column": column, "motion": motion, "quantity": name}
                row |= {"sd": both.measured_sd.median(), "records": len(both)}
                rows.append(row | {"covered": (both.error.abs() < _WIDE).mean()})
    pd.DataFrame(rows).to_csv("docs/measuring.csv", index=False, float_format="%.3g")


if __name__ == "__main__":
    main()
