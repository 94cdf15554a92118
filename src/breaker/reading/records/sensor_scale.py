"""From the reading of a sensor to travel: mm towards closed.

A length needs its unit alone. Degrees, volts or counts need the mm of one of them, ``ratio``, or a
table of readings and mm, between whose points a smooth curve is laid that never turns back. Beyond
the ends of a table there is no travel.
"""

import csv
from collections.abc import Mapping
from dataclasses import dataclass
from io import StringIO
from pathlib import Path

import numpy as np

from breaker.reading.files.format_settings import TO_MM
from breaker.reading.files.guards import RejectedCurveError, read_bytes
from breaker.reading.records.rejections import UnusableError

_BEYOND = 0.02  # of its width, by which noise may leave a table; there it goes on straight
_OUTSIDE = 0.05  # share of samples further out from which it is the wrong table

# Of readings that are rounded coarsely, this share at least is as the one before.
_TIES = 0.05
_TRIED = 12  # of the smallest steps: damaged samples make odd ones
_COUNTS = 10.5  # quanta, of a small step
_FEWEST = 10  # small steps,
_OFTEN = 3  # and the quantum itself among them
_NEARLY = 0.9  # share of them that are multiples
_PRINTED = 0.02  # share by which equal steps differ in print


@dataclass(frozen=True)
class Scale:
    """How a reading becomes travel.

    Attributes:
        factor: mm towards closed for one unit of the reading, or for a mm of the table.
        zero: Reading of the open breaker; 0 where it is found in each record.
        table: Readings and mm, ``(2, n)``; None where the factor is all.

    Example:
        >>> scale = Scale.from_settings(
        ...     {"travel_unit": "deg", "ratio": 1.5, "table": None, "zero": 10.0, "sign": -1})
        >>> scale.travel(np.array([10.0, 0.0]))
        array([-0., 15.])
    """

    factor: float
    zero: float
    table: np.ndarray | None = None

    @classmethod
    def from_settings(cls, settings: Mapping) -> "Scale":
        """Build from the section ``endurance.format`` of the configuration.

        Raises:
            ValueError: If the table cannot be read, or is not one of readings and mm.
        """
        zero = 0.0 if settings["zero"] == "rest" else settings["zero"]
        if settings["table"] is not None:
            return cls(float(settings["sign"]), zero, _read_table(settings["table"]))
        factor = TO_MM[settings["travel_unit"]] if settings["ratio"] is None else settings["ratio"]
        return cls(settings["sign"] * factor, zero)

    def travel(self, reading: np.ndarray) -> np.ndarray:
        """Return travel for readings, ``(t,) -> (t,)``, mm; NaN for NaN, infinite beyond a table.

        Raises:
            UnusableError: If more than a few readings are beyond the table.
        """
        with np.errstate(over="ignore"):  # what is too large is no travel, and said to be so later
            if self.table is None:
                return self.factor * (reading - self.zero)
        from scipy.interpolate import PchipInterpolator  # slow to import, and few need it

        low, high = self.table[0, [0, -1]]
        margin = _BEYOND * (high - low)
        outside = (reading < low - margin) | (reading > high + margin)
        if outside.sum() > _OUTSIDE * np.isfinite(reading).sum():
            raise UnusableError(
                f"reads {np.nanmin(reading):.4g} to {np.nanmax(reading):.4g}, but "
                f"endurance.format.table goes from {low:.4g} to {high:.4g}"
            )
        curve = PchipInterpolator(*self.table)
        inside = np.clip(reading, low, high)
        slope = np.where(reading < low, curve(low, 1), curve(high, 1))
        travel = self.factor * (curve(inside) + slope * (reading - inside))
        return np.where(outside, np.inf, travel)


def _read_table(file: str | Path) -> np.ndarray:
    """Readings, increasing, and mm, ``(2, n)``, of a CSV file with commas and decimal points."""
    name = f"endurance.format.table, {file}"
    try:
        lines = StringIO(read_bytes(file).decode("utf-8-sig"), newline="")
        rows = [row for row in csv.reader(lines) if any(cell.strip() for cell in row)]
    except RejectedCurveError as error:
        raise ValueError(f"endurance.format.table, {error}") from error
    except (UnicodeError, csv.Error) as error:
        raise ValueError(f"{name}: cannot be read: {error}") from error
    try:
        float(rows[0][0])
    except (IndexError, ValueError):
        rows = rows[1:]  # the names of the columns
    try:
        table = np.array([(float(reading), float(mm)) for reading, mm in rows]).reshape(-1, 2).T
    except ValueError as error:
        raise ValueError(
            f"{name}: has lines that are not two numbers, reading and mm, with a comma between "
            "them and decimal points"
        ) from error
    table = table[:, np.argsort(table[0], kind="stable")]
    rises = np.diff(table, axis=1)
    steady = (rises[0] > 0).all() and ((rises[1] > 0).all() or (rises[1] < 0).all())
    if not (rises.size and steady and np.isfinite(table).all()):
        raise ValueError(
            f"{name}: needs two points or more, each reading once, and mm that only rise or only "
            "fall with it"
        )
    return table


def seen_quantum(travel: np.ndarray) -> float:
    """Return the step to which a record is rounded, mm; 0 where it is fine beside the noise.

    It is the smallest of the steps between neighbouring samples of which nearly all small steps
    are multiples.

    Args:
        travel: Travel, ``(t,)``, mm; NaN where a sample is missing.
    """
    steps = np.abs(np.diff(travel[np.isfinite(travel)]))
    fine = 1e-9 * max(1.0, float(steps.max(initial=0.0)))
    if steps.size == 0 or (steps <= fine).mean() < _TIES:
        return 0.0
    steps = np.sort(steps[steps > fine])
    others = np.flatnonzero(steps[1:] > (1.0 + _PRINTED) * steps[:-1]) + 1
    for quantum in steps[[0, *others[: _TRIED - 1]]] if steps.size >= _FEWEST else []:
        counts = steps[: np.searchsorted(steps, _COUNTS * quantum)] / quantum
        whole = np.rint(counts)
        multiples = (whole > 0.0) & (np.abs(counts - whole) < 0.2)
        if counts.size >= _FEWEST and (whole == 1.0).sum() >= _OFTEN and multiples.mean() > _NEARLY:
            return float(np.median(counts[multiples] / whole[multiples]) * quantum)
    return 0.0
