"""Contents of the text above the samples: the rate, the breaker, the test, and its results.

Nothing is guessed: what is not stated is missing, and what contradicts itself is a doubt.
"""

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

from breaker.common.numerals import in_digits
from breaker.records.dates import clock_of, dates_of, day_order, in_order
from breaker.records.header_pairs import Pair, line_of, number_of, pairs_of
from breaker.records.printed import Printed, printed_in
from breaker.records.settings import RATES, SAME_RATE, TO_MS
from breaker.records.words import (
    PHASE,
    WORDS,
    any_of,
    by_words,
    channel_of,
    phase_in,
    sequence_of,
    unit_of,
)

_MOST = (400, 60, 300)  # lines, cells in a line and signs in a cell that are read: bounds the time
_meant = by_words(WORDS["stated"])
_rates_in = by_words(WORDS["rate_words"])
_LABEL = any_of(WORDS["labels"]["stated channel"])
_CHANNEL = re.compile(rf"(?:phase (?:of )?)?{_LABEL}\W*(\d+)(?:\W*(?:phase|name))*")
_OF_BREAK = re.compile(rf"\b(?:{PHASE})-[0-9](?: \w{{2,}}(?!-))?")  # such as Y-1 CT
_KHZ = {
    kind: {unit: size for size, units in WORDS[kind].items() for unit in units.split()}
    for kind in ("frequencies", "sample_rates")
}


@dataclass(frozen=True)
class Header:
    """Contents of the text above the samples; empty, NaN or None where nothing is stated.

    Attributes:
        rate, rate_doubt: Sampling rate, kHz; NaN where it is not clear, and why.
        length: Duration of the record, ms; NaN without a unit, as it may be in samples, ms or s.
        ratio: Ratio of the linkage; whether samples are multiplied by it no file states.
        dates: Date of the test as ISO 8601; two where the order of day and month is not known.
        operation: Motions, such as ``"C-O"``.
        phases: Names of phases by number of the channel, from 1; by 0 that of all.
        speed_points: Statements of points between which speeds are means.
    """

    pairs: tuple[Pair, ...] = ()
    rate: float = math.nan
    rate_doubt: str = ""
    length: float = math.nan
    ratio: float = math.nan
    travel_unit: str = ""
    dates: tuple[str, ...] = ()
    station: str = ""
    bay: str = ""
    type: str = ""
    serial: str = ""
    operation: str = ""
    phases: Mapping[int, str] = field(default_factory=dict)
    speed_points: tuple[Pair, ...] = ()
    results: tuple[Printed, ...] = ()

    def phase_of(self, column: str | int) -> str:
        """Return the phase of a column of travel by its name or what is stated of it, or ""."""
        stated = self.phases.get(channel_of(str(column)), self.phases.get(0, ""))
        return phase_in(str(column)) or stated


def header_of(rows: Sequence[Sequence[str]], decimal: str = ".", samples: int = 0) -> Header:
    """Return the contents of the lines above samples.

    Args:
        rows: Cells of each line, with blank cells.
        decimal: Decimal sign of numbers.
        samples: Number of samples below, 0 if it is not known. A length that contradicts it makes
            the rate doubtful.

    >>> rows = [["Sampling Speed (kC) :", "10", "", "Range :", "8000"], ["Serial No: 17"]]
    >>> header_of(rows).rate, header_of(rows).serial
    (10.0, '17')
    """
    lines = [line_of([cell[: _MOST[2]] for cell in row[: _MOST[1]]]) for row in rows[: _MOST[0]]]
    pairs = pairs_of(lines)
    operations = {sequence_of(pair.text) for pair in stated_as(pairs, "operation")} - {""}
    length, unit = next((p.number(decimal) for p in stated_as(pairs, "length")), (math.nan, ""))
    length *= TO_MS.get(unit_of(unit) or "", math.nan)
    rate, doubt = _rate(pairs, decimal, samples / length if samples and length > 0 else math.nan)
    return Header(
        pairs=tuple(pairs),
        rate=rate,
        rate_doubt=doubt,
        length=length,
        ratio=_ratio(pairs, decimal),
        travel_unit=next((pair.text for pair in stated_as(pairs, "unit")), ""),
        dates=_dates(pairs),
        operation=operations.pop() if len(operations) == 1 else "",
        phases=_phases(pairs),
        speed_points=tuple(stated_as(pairs, "point of speed")),
        results=printed_in(lines, decimal),
        **{key: _first_of(pairs, key) for key in ("station", "bay", "type", "serial")},
    )


def stated_as(pairs: Iterable[Pair], meaning: str) -> list[Pair]:
    """Return the pairs that have a value and a meaning of ``stated`` of the lexicon."""
    return [pair for pair in pairs if pair.values and meaning in _meant(pair.name)]


def _first_of(pairs: Iterable[Pair], meaning: str) -> str:
    """Return the first value that is not of the analyser or a part of the breaker."""
    own = (p.text for p in stated_as(pairs, meaning) if "of another thing" not in _meant(p.name))
    return next(own, "")


def _ratio(pairs: Iterable[Pair], decimal: str) -> float:
    """Return the ratio; NaN where channels differ in it."""
    texts = [value for pair in stated_as(pairs, "ratio") for value in pair.values]
    texts = [re.sub(r"^1\s*:\s*|\s*:\s*1$", "", text) for text in texts]
    ratios = {number for number, _ in (number_of(text, decimal) for text in texts) if number > 0}
    return ratios.pop() if len(ratios) == 1 else math.nan


def _dates(pairs: Iterable[Pair]) -> tuple[str, ...]:
    """Return the date of the test in both orders of day and month, or in that of another date."""
    every = [(pair, dates_of(pair.text)) for pair in stated_as(pairs, "date")]
    own = [each for each in every if each[1] and "of another day" not in _meant(each[0].name)]
    own.sort(key=lambda each: "of the test" not in _meant(each[0].name))
    pair, readings = own[0] if own else (Pair("", "", ()), {})
    texts = [" ".join(pair.values), *(each.text for each in stated_as(pairs, "time"))]
    clock = next(filter(None, map(clock_of, texts)), "")
    return tuple(day + clock for day in in_order(readings, day_order(each for _, each in every)))


def _phases(pairs: Iterable[Pair]) -> dict[int, str]:
    """Return names of phases by number of the channel, from 1; by 0 that of all."""
    found: dict[int, set[str]] = {}
    for pair in pairs:
        if channel := _CHANNEL.fullmatch(pair.name.lower()):
            own = _OF_BREAK.fullmatch(pair.text.strip())  # named as it stands there
            phases = {int(channel[1]): own[0] if own else phase_in(pair.text)}
        elif pair.values and "phases" in _meant(pair.name):
            values = pair.values if len(pair.values) > 1 else re.split(r"[\s,/]+", pair.text)
            own = _OF_BREAK.findall(" / ".join(pair.values))
            named = own or [*filter(None, map(phase_in, values))]
            phases = dict(enumerate(named, start=len(named) > 1))
        else:
            continue
        for number, phase in phases.items():
            found.setdefault(number, set()).update({phase} - {""})
    return {number: phases.pop() for number, phases in found.items() if len(phases) == 1}


def _rate(pairs: Iterable[Pair], decimal: str, by_length: float) -> tuple[float, str]:
    """Return the rate, kHz, or NaN and why: that by the length confirms or contradicts it."""
    sure, unsure = {}, {}
    for pair in pairs:
        rate, certain = _rate_in(pair, decimal)
        if RATES[0] <= rate <= RATES[1]:
            known = sure if certain else unsure
            known[float(f"{rate:.9g}")] = f"'{pair.name}: {pair.text}'"
    rate, text = next(iter((sure or unsure).items()), (math.nan, "no usual rate is stated"))
    if len(sure) > 1:
        return math.nan, f"several rates are stated: {' and '.join(sure.values())}"
    if abs(rate / by_length - 1.0) <= SAME_RATE or (rate in sure and math.isnan(by_length)):
        return rate, ""
    if by_length > 0:
        return math.nan, f"{text}, but by the length {in_digits(by_length, 4)} kHz are right"
    return math.nan, f"{text} has no unit" if unsure else text


def _rate_in(pair: Pair, decimal: str) -> tuple[float, bool]:
    """Return the rate that a pair may state, kHz, NaN where it states none; and whether it does."""
    number, unit = pair.number(decimal)
    meant, bare = _rates_in(pair.name), unit.lower().replace(" ", "").strip("[]().")
    if not number > 0 or "other" in meant:
        return math.nan, True
    if ms := TO_MS.get(unit_of(unit) or ""):
        return 1.0 / (number * ms) if "step" in meant else math.nan, True
    if unit or not {"samples", "tempo"} <= {*meant}:
        of_samples = "samples" in meant or ("tempo" in meant and bare == "khz")  # mains are in Hz
        sizes = _KHZ["sample_rates"] | (_KHZ["frequencies"] if of_samples else {})
        return number * sizes.get(bare, math.nan), True
    # Thousands without a unit are Hz: no recorder takes as many in a ms.
    return (number, False) if number <= RATES[1] else (1e-3 * number, True)
