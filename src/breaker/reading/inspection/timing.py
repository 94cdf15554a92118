"""When the samples of an unknown record were taken: by a column, or a rate that the text states.

Guessing, to propose settings: see ``table_layout``.
"""

import re
from dataclasses import dataclass, replace

import numpy as np

from breaker.common.numerals import in_digits
from breaker.reading.files.format_settings import RATES, TO_MS
from breaker.reading.files.word_meanings import holds
from breaker.reading.inspection.file_contents import Layout

_USUAL = 10.0  # kHz
_OFF = 0.02  # share by which a stated rate may differ from that of the times
_NICE = 1e-3  # share by which a rate may be off a round number that it is then taken for

_CLOCK = re.compile(r"(?<![\d:])(?:(\d{1,2}):)?(\d{1,2}):(\d{2}(?:[.,]\d+)?)(?!:)")


@dataclass(frozen=True)
class Clock:
    """When the samples of a record were taken.

    Attributes:
        place: Column of the time; None where there is none that can be read.
        unit: Of that column.
        rate: kHz; nan where neither a column nor the preamble states it.
        remarks: What has to be looked at, in words.
    """

    place: int | None
    unit: str | None
    rate: float
    remarks: tuple[str, ...] = ()

    @property
    def likely_rate(self) -> float:
        """The rate, kHz, or where there is none a usual one in its stead."""
        return _USUAL if np.isnan(self.rate) else self.rate


def find_clock(layout: Layout) -> Clock:
    """Find the column of the time, or the rate that stands for it."""
    stated = layout.stated
    found = [clock for i in range(len(layout.columns)) if (clock := _time_in(layout, i))]
    if found:
        clock = max(found, key=lambda clock: _likely_time(layout, clock))
    elif not (clock := _wall_clock(layout)):
        doubt = f"the rate is doubtful: {stated.rate_doubt}"
        return Clock(None, None, stated.rate, (doubt,) if stated.rate_doubt else ())
    off = abs(stated.rate / clock.rate - 1.0)
    if not off > _OFF:
        # A mean of times that are not read is no better than what the text says.
        exact = clock.place is not None or np.isnan(stated.rate)
        return clock if exact else Clock(None, None, stated.rate, clock.remarks)
    said, seen = (in_digits(rate, 6) for rate in (stated.rate, clock.rate))
    both = f"the text states {said} kHz, but the times are those of {seen} kHz"
    rate = np.nan if clock.place is None else clock.rate
    return replace(clock, rate=rate, remarks=(*clock.remarks, both))


def _likely_time(layout: Layout, clock: Clock) -> tuple[bool, bool, bool]:
    """Whether a clock is a column, has a unit, and has a name of the time: the more, the better."""
    at = clock.place or 0
    there, named = clock.place is not None, holds(layout.names[at], "time")
    return there, there and layout.units[at] in TO_MS, there and named


def _time_in(layout: Layout, place: int) -> Clock | None:
    """What a column says of the time, if it is one: it rises in even steps."""
    unit, name = layout.units[place], layout.names[place]
    values = layout.columns[place][np.isfinite(layout.columns[place])]
    if values.size < max(20, 0.5 * layout.columns[place].size) or (unit and unit not in TO_MS):
        return None
    steps = np.diff(values)
    step = float(np.median(steps))
    timely = unit is not None or holds(name, "time")
    if values[-1] <= values[0] or (steps < 0).mean() > 0.01:
        return None
    if step > 0 and (np.abs(steps - step) <= 0.2 * step).mean() > 0.9:
        if step == 1 and not timely:
            return None  # it counts the samples
        units = [unit] if unit else _units_of(step)
        if not units:
            return None
        how = (
            f"the time's unit is not stated; steps of {in_digits(step, 4)} are those of {units[0]}"
        )
        return Clock(place, units[0], 1.0 / (step * TO_MS[units[0]]), () if unit else (how,))
    digits = steps[steps > 0].min()
    mean, start = np.polyfit(np.arange(values.size), values, 1)
    even = start + mean * np.arange(values.size)
    units = [unit] if unit else _units_of(float(mean))
    if not (timely and units and np.abs(values - even).max() <= 1.5 * digits):
        return None
    rate = _nice(1.0 / (mean * TO_MS[units[0]]))
    how = f"the time is printed in steps of {in_digits(digits, 6)} {units[0]}, too coarse to tell "
    how += f"its samples apart; the rate on average is {in_digits(rate, 6)} kHz"
    return Clock(None, None, rate, (how,))


def falling_times(layout: Layout) -> str | int | None:
    """Return the column whose times fall from line to line; None if there is none."""
    back = replace(layout, columns=[each[::-1] for each in layout.columns])
    fall = (i for i in range(len(back.columns)) if _time_in(back, i))
    return next(map(layout.column, fall), None)


def _units_of(step: float) -> list[str]:
    """The unit of time in which a step is one of a recorder; one or none."""
    return [u for u, ms in TO_MS.items() if RATES[0] <= 1.0 / (step * ms) <= RATES[1]][:1]


def _nice(rate: float) -> float:
    """A rate, rounded to two digits if it is nearly that."""
    rounded = float(f"{rate:.2g}")
    return rounded if abs(rounded - rate) <= _NICE * rate else float(f"{rate:.6g}")


def _wall_clock(layout: Layout) -> Clock | None:
    """The rate by a column of times of the day, which settings cannot name."""
    for place, cells in layout.texts.items():
        found = [(i, match) for i, cell in enumerate(cells) if (match := _CLOCK.search(cell))]
        if len(found) < max(20, 0.9 * len(cells)):
            continue
        (begin, first), (end, last) = found[0], found[-1]
        steps, lasts = layout.every * (end - begin), 1e3 * (_seconds(last) - _seconds(first))
        lasts %= 86_400_000
        what = f"column {layout.column(place)!r} has times of the day, which are not read"
        if not (lasts > 0 and RATES[0] <= steps / lasts <= RATES[1]):
            return Clock(None, None, np.nan, (what,))
        rate = _nice(steps / lasts)
        return Clock(None, None, rate, (f"{what}; their mean rate is {in_digits(rate, 6)} kHz",))
    return None


def _seconds(time: re.Match) -> float:
    """Seconds of the day."""
    return 3600 * int(time[1] or 0) + 60 * int(time[2]) + float(time[3].replace(",", "."))
