"""Contents of the text above the samples: the rate, the breaker, the test, and its results.

Nothing is guessed. What is not stated is missing, and what contradicts itself is a doubt.
"""

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

from breaker.common.numerals import in_digits
from breaker.records.dates import clock_of, dates_of
from breaker.records.header_pairs import Pair, lines_of, numbers_of, pairs_of
from breaker.records.lexicon import WORDS
from breaker.records.printed import Printed, near_event, printed_in
from breaker.records.settings import RATES, TO_MS
from breaker.records.words import PHASE, any_of, by_words, phase_in, sequence_of, unit_of

_NAN = math.nan
_SHORTEST = 20.0  # ms, below which a length without a unit may be in seconds
_MOST = (400, 60, 300)  # lines, cells in a line and signs in a cell that are read: bounds the time
_AGREE = 0.01  # share between two statements of a length: one sample of the shortest record
_meant = by_words(WORDS["stated"])
_CHANNEL = re.compile(
    rf"^(?:phase(?: name)? (?:of )?)?{any_of(WORDS['labels']['stated channel'])}\W*(\d+)"
    r"(?:\W*(?:phase|name|label))*$"
)

_OF_BREAK = re.compile(rf"(?:{PHASE})-[0-9](?: \w+)?")  # a break of a phase: Y-1 CT, B-1

_PREFIXES = {None: 1e-3} | {
    prefix: size for size, prefixes in WORDS["rate_prefixes"].items() for prefix in prefixes.split()
}
_UNIT = re.compile(
    rf"({'|'.join(filter(None, _PREFIXES))})?(?:{WORDS['hertz']})"
    rf"|(?P<k>{WORDS['kilocycles']}|{WORDS['per_ms']})"
)
_PER_SAMPLE = re.compile(r"(?:\bper |\bsamples? ?/) ?(m?s)(?:ec(?:ond)?s?)?\b")  # in the name
_EACH_SAMPLE = re.compile(r"([µμu]?\w+) ?(?:/|per) ?samples?")
_rates_in = by_words(WORDS["rate_words"])
_NO_UNIT, _OF_WHAT = "has no unit", "does not say that it is of the samples"


@dataclass(frozen=True)
class Header:
    """Contents of the text above the samples; empty, NaN or None where nothing is stated.

    Attributes:
        pairs: All names and values, in the order of the file.
        rate: Sampling rate, kHz, NaN if it is not stated or doubtful.
        rate_doubt: Reason of a doubt; empty if there is a rate.
        length: Duration of the record or of its plot, ms.
        ratio: Ratio of the linkage. No file states whether the samples are multiplied by it.
        travel_unit: Unit as in the file.
        dates: Date of the test as ISO 8601, with its time if that is stated. Two dates, first that
            with the day before the month, where the order of day and month is not known.
        station, bay, type, serial: Names of the breaker.
        operation: Motions, such as ``"C-O"``.
        phases: Names of phases by number of the channel, from 1; by 0 that of all.
        speed_points: Points between which speeds are means.
        results: Results of the analyser.
        doubts: Contradictions, and statements that can be read in two ways, in words.
    """

    pairs: tuple[Pair, ...] = ()
    rate: float = _NAN
    rate_doubt: str = ""
    length: float = _NAN
    ratio: float = _NAN
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
    doubts: tuple[str, ...] = ()

    @property
    def date(self) -> str:
        """Date of the test as ISO 8601; empty if it is not stated, or its order is not known."""
        return self.dates[0] if len(self.dates) == 1 else ""


class _Rate(NamedTuple):
    """A stated rate, kHz, with its text and a doubt about it, empty where there is none."""

    kHz: float = _NAN
    text: str = ""
    doubt: str = ""


def header_of(rows: Sequence[Sequence[str]], decimal: str = ".", samples: int = 0) -> Header:
    """Return the contents of the lines above samples.

    Args:
        rows: Cells of each line, with blank cells.
        decimal: Decimal sign of numbers.
        samples: Number of samples below, 0 if it is not known. A length that contradicts it makes
            the rate doubtful.

    >>> rows = [["Sampling Speed (kC) :", "10", "", "Range :", "8000"], ["Serial No: 17"]]
    >>> found = header_of(rows)
    >>> found.rate, found.serial
    (10.0, '17')
    """
    rows = [[cell[: _MOST[2]] for cell in row[: _MOST[1]]] for row in rows[: _MOST[0]]]
    pairs = pairs_of(lines := lines_of(rows))
    named = {key: _named(pairs, key) for key in ("station", "bay", "type", "serial")}
    named["station"] = named["station"] or _named(pairs, "site")
    operations = {sequence_of(pair.text) for pair in _of(pairs, "operation")} - {""}
    length = _length(pairs, decimal, samples)
    rate, doubt = _checked(_rate_of(pairs, decimal), length, samples)
    ratio, unsure = _ratio(pairs, decimal)
    dates = _dates(pairs)
    if len(dates) > 1:
        unsure = (*unsure, f"the date of the test is {dates[0]} or {dates[1]}")
    return Header(
        pairs=tuple(pairs),
        rate=rate,
        rate_doubt=doubt,
        length=length,
        ratio=ratio,
        travel_unit=next((pair.text for pair in _of(pairs, "unit")), ""),
        dates=dates,
        operation=operations.pop() if len(operations) == 1 else "",
        phases=_phases(pairs),
        speed_points=tuple(_of(pairs, "point of speed")),
        results=printed_in(lines, decimal, _widths(pairs, decimal)),
        doubts=unsure,
        **named,
    )


def _of(pairs: Sequence[Pair], meaning: str) -> list[Pair]:
    """Return the pairs with a value whose name has a meaning."""
    return [pair for pair in pairs if pair.values and meaning in _meant(pair.name)]


def _named(pairs: Sequence[Pair], meaning: str) -> str:
    """Return the first value of a name that is not one of the analyser or a part of the breaker."""
    own = (p.text for p in _of(pairs, meaning) if "of another thing" not in _meant(p.name))
    return next(own, "")


def _widths(pairs: Sequence[Pair], decimal: str) -> dict[str, tuple[str, ...]]:
    """Return the points between which speeds above the columns of contacts are means, by motion.

    The width is in ms where it has no unit: on public exports with a width of 10, means over the
    10 ms after parting repeat the printed opening speeds within 3 % in 92 % of 152 breaks.
    """
    found = {}
    for pair in _of(pairs, "width of speed"):
        number, unit = pair.number(decimal)
        motion = "closing" if "clos" in pair.name.lower() else "opening"
        if number > 0 and (unit or "ms") in ("ms", "mm"):
            found[motion] = near_event(motion, f"{number:g}", unit or "ms")
    return found


def _length(pairs: Sequence[Pair], decimal: str, samples: int) -> float:
    """Return the length of the record or its plot, ms. A number without a unit that is the number
    of samples may be that.
    """
    for pair in _of(pairs, "length"):
        number, unit = pair.number(decimal)
        if number > 0:
            bare = "ms" if number >= _SHORTEST and abs(number - samples) > 1 else ""
            return number * TO_MS.get(unit_of(unit) if unit else bare, _NAN)
    return _NAN


def _ratio(pairs: Sequence[Pair], decimal: str) -> tuple[float, tuple[str, ...]]:
    """Return the ratio of the linkage, and a doubt where channels differ in it."""
    for pair in _of(pairs, "ratio"):
        texts = [re.sub(r"^\s*1\s*:\s*|\s*:\s*1\s*$", "", value) for value in pair.values]
        numbers = [n for n in numbers_of(texts, decimal)[0] if n > 0]
        several = [in_digits(n, 6) for n in dict.fromkeys(numbers)]
        if len(several) > 1:
            return _NAN, (f"channels differ in {pair.name!r}: {' and '.join(several)}",)
        if numbers:
            return numbers[0], ()
    return _NAN, ()


def _dates(pairs: Sequence[Pair]) -> tuple[str, ...]:
    """Return the date of the test in both orders of day and month, or in the order of all dates."""
    every = [(pair, dates_of(pair.text)) for pair in _of(pairs, "date")]
    own = [each for each in every if each[1] and "of another day" not in _meant(each[0].name)]
    own.sort(key=lambda each: "of the test" not in _meant(each[0].name))
    if not own:
        return ()
    pair, found = own[0]
    # A 14th month decides the order of the other dates, too.
    orders = {first for _, each in every if len(each) == 1 for first in each}
    if len(orders) == 1 and orders <= {*found}:
        found = {first: found[first] for first in orders}
    clocks = (clock_of(each.text) for each in _of(pairs, "time"))
    clock = clock_of(" ".join(pair.values)) or next(filter(None, clocks), "")
    return tuple(dict.fromkeys(found[first] + clock for first in sorted(found, reverse=True)))


def _phases(pairs: Sequence[Pair]) -> dict[int, str]:
    """Return names of phases by number of the channel, from 1; by 0 that of all."""
    found: dict[int, str] = {}
    for pair in pairs:
        channel = _CHANNEL.fullmatch(pair.name.lower())
        own = _OF_BREAK.fullmatch(pair.text.strip())  # named as it stands there
        if channel and (phase := own[0] if own else phase_in(pair.text)):
            found.setdefault(int(channel[1]), phase)
        elif pair.values and "phases" in _meant(pair.name):
            values = pair.values if len(pair.values) > 1 else re.split(r"[\s,/]+", pair.text)
            phases = list(filter(None, map(phase_in, values)))
            named = {0: phases[0]} if len(phases) == 1 else dict(enumerate(phases, start=1))
            alike = found.get(0, "") in ("", *phases[:1]) or len(named) > 1
            found = named | found if alike else {**found, 0: ""}
    return {number: phase for number, phase in found.items() if phase}


# ---- the rate ------------------------------------------------------------------------------------


def _checked(stated: _Rate, length: float, samples: int) -> tuple[float, str]:
    """Return the rate, kHz, or why there is none: a length confirms it or contradicts it."""
    by_length = samples / length if samples and length > 0 else _NAN
    if math.isnan(by_length):
        return (_NAN if stated.doubt else stated.kHz), stated.doubt
    if abs(stated.kHz / by_length - 1.0) <= _AGREE:
        return stated.kHz, ""
    lasting = f"{samples} samples in a length of {in_digits(length, 6)} ms are "
    lasting += f"{in_digits(by_length, 4)} kHz"
    if math.isnan(stated.kHz) or stated.doubt:
        return _NAN, f"{stated.doubt or 'not stated'}; {lasting}"
    return _NAN, f"{stated.text!r} is {in_digits(stated.kHz, 6)} kHz, but {lasting}"


def _rate_of(pairs: Iterable[Pair], decimal: str = ".") -> _Rate:
    """Return the rate that pairs state.

    >>> _rate_of([Pair("Sampling Speed", "kC", ("10",))]).kHz
    10.0
    >>> _rate_of([Pair("dt", "", ("0,05", "ms"))], ",").kHz
    20.0
    >>> _rate_of([Pair("Sampling rate", "", ("10",))]).doubt
    "'Sampling rate: 10' has no unit"
    """
    sure, unsure = {}, {}
    for pair in pairs:
        for rate, doubt in _rates(pair, decimal):
            unit = f" ({pair.unit})" if pair.unit else ""
            text = f"{pair.name}{unit}: {' '.join(pair.values[:2])}"
            said = f"{text!r} {doubt}" if doubt else ""
            (unsure if doubt else sure).setdefault(float(f"{rate:.9g}"), _Rate(rate, text, said))
    if len(sure) > 1:
        several = (f"{each.text!r} ({in_digits(each.kHz, 6)} kHz)" for each in sure.values())
        return _Rate(doubt=f"several rates are stated: {' and '.join(several)}")
    return next(iter((sure or unsure).values()), _Rate())


def _rates(pair: Pair, decimal: str) -> list[tuple[float, str]]:
    """Return the rates of a recorder, kHz, that a pair may state, and a doubt about each."""
    number, unit = pair.number(decimal)
    meant = _rates_in(pair.name)
    named = "samples" in meant
    if not number > 0:
        return []
    if named and (per := _PER_SAMPLE.search(f"{pair.name} {unit}".lower())):
        return _of_recorders([number / TO_MS[per[1]]])
    if "other" in meant:
        return []
    each = _EACH_SAMPLE.fullmatch(unit.lower())
    if (ms := TO_MS.get(unit_of(each[1] if each else unit))) is not None:
        return _of_recorders([1.0 / (number * ms)]) if "step" in meant or each else []
    if found := _UNIT.fullmatch(unit.lower().replace(" ", "").strip("[]().")):
        per_ms = 1.0 if found["k"] else _PREFIXES[found[1]]
        sure = named or "frequency" in meant or not re.search("hz|hertz|гц|k$", unit.lower())
        if rates := _of_recorders([number * per_ms], "" if sure else _OF_WHAT):
            return rates
        both = f"is {in_digits(number * per_ms, 6)} kHz, which no recorder has, "
        both += f"or {in_digits(1e-3 * number, 6)} kHz, if it is samples a second"
        return _of_recorders([1e-3 * number], both) if named and per_ms >= 1.0 else []
    if unit:
        return []
    if "step" in meant and (named or "dt" in meant):
        return _of_recorders([1.0 / (number * ms) for ms in TO_MS.values()], _NO_UNIT)
    if not (named and "tempo" in meant):
        return []
    # Thousands without a unit are Hz: no recorder takes as many in a ms.
    return _of_recorders([1e-3 * number]) or _of_recorders([number], _NO_UNIT)


def _of_recorders(rates: Iterable[float], doubt: str = "") -> list[tuple[float, str]]:
    return [(rate, doubt) for rate in rates if RATES[0] <= rate <= RATES[1]]


Preamble, preamble_of = Header, header_of
