"""When the samples of an unknown record were taken: by a column, or a rate that the text states.

Guessing, to propose settings: see ``layouts``.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from breaker.files import TO_MS
from breaker.inspection.layouts import Layout

__all__ = ["Clock", "find_clock", "stated_rates"]

_RATES = (0.95, 105.0)  # kHz, of recorders
_USUAL = 10.0  # kHz
_LOOKED_AT = (200, 300)  # lines, and signs of each, where rates are looked for
_NICE = 1e-3  # share by which a rate may be off a round number that it is then taken for

_TIME_NAMES = re.compile(r"(?i)\b(time|zeit|temps|tiempo|tempo|t|ms|sec)\b|时间|時間|время|czas")
_NUMBER = r"(\d+(?:[.,]\d+)*(?:e[-+]?\d+)?)"
_UNITS = r"(k?hz|mhz|k?s/s|k?sps|samples?/s(?:ec)?|1/s|m?s(?:ec)?|[uµμ]s(?:ec)?)"
_AFTER = re.compile(rf"{_NUMBER}[\s;,\t\"\[(]*{_UNITS}(?![a-z/])")
_BEFORE = re.compile(rf"{_UNITS}[\])]\"?[\s:=;,\t\"]*{_NUMBER}")
_BARE = re.compile(rf"[:=;,\t]\s*\"?{_NUMBER}\"?[\s;,\t]*$")
_RATE_WORDS = re.compile(r"sampl|rate|freq|abtast|takt|chantillon|muestr|采样|采樣")
_STEP_WORDS = re.compile(r"interv|increm|period|delta|\bdt\b|step|schritt|raster|resol|间隔|周期")
_FILTER_WORDS = re.compile(r"filter|bandw|cut.?off|grenz|low.?pass|tiefpass|滤波")
_CLOCK = re.compile(r"(\d{1,2}):(\d{2}):(\d{2}(?:[.,]\d+)?)(?!:)")


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
    found = [clock for i in range(len(layout.columns)) if (clock := _time_in(layout, i))]
    if found:
        return max(found, key=lambda clock: _likely_time(layout, clock))
    if clock := _wall_clock(layout):
        return clock
    rates = stated_rates(layout.preamble)
    if len(rates) == 1:
        return Clock(None, None, rates[0])
    listed = ", ".join(f"{rate:g} kHz" for rate in rates)
    remarks = (f"the text above the samples states several rates: {listed}",) if rates else ()
    return Clock(None, None, np.nan, remarks)


def _likely_time(layout: Layout, clock: Clock) -> tuple[bool, bool, bool]:
    if clock.place is None:
        return False, False, False
    named = _TIME_NAMES.search(layout.names[clock.place])
    return True, layout.units[clock.place] in TO_MS, named is not None


def _time_in(layout: Layout, place: int) -> Clock | None:
    """What a column says of the time, if it is one: it rises in even steps."""
    unit, name = layout.units[place], layout.names[place]
    values = layout.columns[place][np.isfinite(layout.columns[place])]
    if values.size < max(20, 0.5 * layout.columns[place].size) or (unit and unit not in TO_MS):
        return None
    steps = np.diff(values)
    step = float(np.median(steps))
    timely = unit is not None or _TIME_NAMES.search(name) is not None
    if values[-1] <= values[0] or (steps < 0).mean() > 0.01:
        return None
    if step > 0 and (np.abs(steps - step) <= 0.2 * step).mean() > 0.9:
        if step == 1 and not timely:
            return None  # it counts the samples
        units = [unit] if unit else _units_of(step)
        how = f"the time's unit is not stated; steps of {step:.4g} are those of {''.join(units)}"
        remarks = () if unit else (how,)
        return Clock(place, units[0], 1.0 / (step * TO_MS[units[0]]), remarks) if units else None
    digits = steps[steps > 0].min()
    mean, start = np.polyfit(np.arange(values.size), values, 1)
    even = start + mean * np.arange(values.size)
    units = [unit] if unit else _units_of(float(mean))
    if not (timely and units and np.abs(values - even).max() <= 1.5 * digits):
        return None
    rate = _nice(1.0 / (mean * TO_MS[units[0]]))
    how = f"the time is printed in steps of {digits:g} {units[0]}, too coarse to tell its samples "
    return Clock(None, None, rate, (how + f"apart; the rate on average is {rate:g} kHz",))


def _units_of(step: float) -> list[str]:
    """The unit of time in which a step is one of a recorder; one or none."""
    return [u for u, ms in TO_MS.items() if _RATES[0] <= 1.0 / (step * ms) <= _RATES[1]][:1]


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
        if not (lasts > 0 and _RATES[0] <= steps / lasts <= _RATES[1]):
            return Clock(None, None, np.nan, (what,))
        rate = _nice(steps / lasts)
        return Clock(None, None, rate, (f"{what}; their mean rate is {rate:g} kHz",))
    return None


def _seconds(time: re.Match) -> float:
    """Seconds of the day."""
    return 3600 * int(time[1]) + 60 * int(time[2]) + float(time[3].replace(",", "."))


def stated_rates(preamble: Sequence[str]) -> list[float]:
    """Return the rates, kHz, that lines of text state as such or as the time of a step.

    >>> stated_rates(["Sampling: 10000 Hz", "Mains 50 Hz"]), stated_rates(["dt;0,1;ms"])
    ([10.0], [10.0])
    >>> stated_rates(["Filter 2 kHz", "Sample rate [Hz],20,000"])
    [20.0]
    """
    named, other = set(), set()
    for line in (text[: _LOOKED_AT[1]].lower() for text in preamble[: _LOOKED_AT[0]]):
        of_rate, of_step = _RATE_WORDS.search(line), _STEP_WORDS.search(line)
        pairs = _AFTER.findall(line) + [(n, u) for u, n in _BEFORE.findall(line)]
        if not pairs and (of_rate or of_step):
            pairs = [(n, "") for n in _BARE.findall(line)]
        for number, unit in pairs:
            rates = {_rate(each, unit, bool(of_step)) for each in _readings(number)}
            rates = {r for r in rates if r and _RATES[0] <= r <= _RATES[1]}
            if of_rate or of_step:
                named |= rates
            elif "hz" in unit and not _FILTER_WORDS.search(line):
                other |= rates
    return sorted(named or other)


def _readings(number: str) -> set[float]:
    """What a number may mean whose comma or point separates decimals or thousands."""
    texts = {number.replace(",", ".")}
    if re.fullmatch(r"\d{1,3}(?:[.,]\d{3})+", number):
        texts.add(re.sub("[.,]", "", number))
    return {float(text) for text in texts if text.count(".") < 2}


def _rate(number: float, unit: str, of_step: bool) -> float | None:
    """The rate, kHz, of a number with a unit; None if it is none."""
    unit = unit.removesuffix("ec").replace("µ", "u").replace("μ", "u")
    if unit in TO_MS:
        return 1.0 / (number * TO_MS[unit]) if of_step and number > 0 else None
    if not unit:
        rates = [1.0 / (number * ms) for ms in TO_MS.values() if number > 0] if of_step else []
        return next((r for r in rates if _RATES[0] <= r <= _RATES[1]), 1e-3 * number)
    return number * {"k": 1.0, "m": 1e3}.get(unit[0], 1e-3)
