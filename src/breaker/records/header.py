"""What the text above the samples says: the rate, the breaker, the test, and its results.

Nothing is guessed: what is not stated is missing, and what contradicts itself is a doubt. Results
of the analyser stand in pairs, or in a table of quantities by channels.
"""

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

from breaker.common.numerals import in_digits
from breaker.records.dates import clock_of, dates_of
from breaker.records.header_pairs import Pair, numbers_of, pairs_of
from breaker.records.lexicon import WORDS
from breaker.records.settings import RATES, TO_MM, TO_MS
from breaker.records.words import (
    any_of,
    by_words,
    channel_in,
    channel_of,
    motion_of,
    phase_in,
    says,
    sequence_of,
    unit_of,
)

_NAN = math.nan
_SHORTEST = 20.0  # ms, of a record whose length has no unit
_MOST = (400, 60, 300)  # lines, cells of each, and signs of a cell that are looked at
_AGREE = 0.01  # share by which a length may differ from that of the samples: a trigger, a last one
_meant = by_words(WORDS["stated"])
_CHANNEL = re.compile(
    rf"^(?:phase(?: name)? (?:of )?)?{any_of(WORDS['labels']['stated channel'])}\W*(\d+)"
    r"(?:\W*(?:phase|name|label))*$"
)

_PREFIXES = {None: 1e-3} | {
    prefix: size for size, prefixes in WORDS["rate_prefixes"].items() for prefix in prefixes.split()
}
_PREFIX = "|".join(filter(None, _PREFIXES))
_UNIT = re.compile(
    rf"({_PREFIX})?(?:{WORDS['hertz']})|{WORDS['kilocycles']}|(?P<ms>{WORDS['per_ms']})"
)
_PER_SAMPLE = re.compile(r"(?:\bper |\bsamples? ?/) ?(m?s)(?:ec(?:ond)?s?)?\b")  # in the name
_EACH_SAMPLE = re.compile(r"([µμu]?\w+) ?(?:/|per) ?samples?")
_rates_in = by_words(WORDS["rate_words"])
_NO_UNIT, _OF_WHAT = "has no unit", "does not say that it is of the samples"

_results_in = by_words(WORDS["results"])
_UNIT_SIZES = {  # mm/ms, ms and mm, by the end of a quantity's name
    "speed": {"m/s": 1.0, "mm/ms": 1.0, "cm/s": 1e-2, "mm/s": 1e-3, "ft/s": 0.3048, "in/s": 0.0254}
    | {"rad/s": _NAN, "deg/s": _NAN},
    "time": TO_MS,
    "": TO_MM | {"deg": _NAN},
}


class Printed(NamedTuple):
    """A result of an analyser.

    Attributes:
        quantity: What it is, such as "stroke", "speed" or "closing_time". A travel of the contact
            is a stroke, that of the mechanism, before its linkage, is none.
        motion: "closing" or "opening"; empty where the text does not say.
        channel: As the text names it, such as "CH1", "R" or "2"; empty for one of all.
        value: In its unit.
        unit: As it stands in the text.
        name: As it stands in the text.
    """

    quantity: str
    motion: str
    channel: str
    value: float
    unit: str
    name: str

    @property
    def size(self) -> float | None:
        """Size of its unit, mm, ms or mm/ms; NaN of an angle, None where it may have no such."""
        sizes = next(each for end, each in _UNIT_SIZES.items() if self.quantity.endswith(end))
        return sizes.get(unit_of(self.unit) or self.unit.lower()) if self.unit else 1.0


@dataclass(frozen=True)
class Preamble:
    """What the text above the samples says; empty, NaN or None where it says nothing.

    Attributes:
        pairs: All names and values, in the order of the file.
        rate: kHz, NaN if it is not stated or doubtful.
        rate_doubt: Why it is; empty if there is a rate.
        length: Of the record or its plot, ms.
        ratio: Of the linkage, as stated: whether the samples are multiplied by it, no file says.
        travel_unit: As it stands in the file.
        dates: Date of the test, with its time if that is stated, as ISO 8601; two dates, first that
            with the day before the month, where day and month may be either.
        station, bay, type, serial: Of the breaker.
        operation: Its motions, such as ``"C-O"``.
        phases: Names of phases by number of the channel, from 1; by 0 that of all.
        speed_points: The points between which speeds are taken.
        results: What the analyser found.
        doubts: What contradicts itself or can be read in two ways, in words.
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
        """Date of the test as ISO 8601; empty if none is stated, or day and month may be either."""
        return self.dates[0] if len(self.dates) == 1 else ""


class _StatedRate(NamedTuple):
    """A rate, and what is doubtful about it.

    Attributes:
        rate: kHz, NaN if none is stated, or not for sure.
        doubt: Why not, empty where there is a rate or nothing is stated.
        likely: What it may be, kHz, if something else confirms it; NaN if there is none.
        text: As it is stated.
    """

    rate: float = math.nan
    doubt: str = ""
    likely: float = math.nan
    text: str = ""


def preamble_of(rows: Sequence[Sequence[str]], decimal: str = ".", samples: int = 0) -> Preamble:
    """Return what lines above samples say.

    Args:
        rows: Cells of each line; blank cells are kept.
        decimal: Sign of numbers.
        samples: Number of samples below, 0 if it is not known: a length that contradicts it with
            the rate makes that doubtful.

    >>> rows = [["Sampling Speed (kC) :", "10", "", "Range :", "8000"], ["Serial No: 17"]]
    >>> found = preamble_of(rows)
    >>> found.rate, found.serial
    (10.0, '17')
    """
    rows = [[cell[: _MOST[2]] for cell in row[: _MOST[1]]] for row in rows[: _MOST[0]]]
    pairs = pairs_of(rows)
    named = {key: _named(pairs, key) for key in ("station", "bay", "type", "serial")}
    named["station"] = named["station"] or _named(pairs, "site")
    operations = filter(None, (sequence_of(pair.text) for pair in _of(pairs, "operation")))
    stated, length = _rate_of(pairs, decimal), _length(pairs, decimal, samples)
    rate, doubt = _checked(stated, length, samples)
    ratio, unsure = _ratio(pairs, decimal)
    dates = _dates(pairs)
    if len(dates) > 1:
        unsure = (*unsure, f"the date of the test is {dates[0]} or {dates[1]}")
    return Preamble(
        pairs=tuple(pairs),
        rate=rate,
        rate_doubt=doubt,
        length=length,
        ratio=ratio,
        travel_unit=next((pair.text for pair in _of(pairs, "unit")), ""),
        dates=dates,
        operation=next(operations, ""),
        phases=_phases(pairs),
        speed_points=tuple(_of(pairs, "point of speed")),
        results=_printed_of(rows, pairs, decimal),
        doubts=unsure,
        **named,
    )


def _of(pairs: Sequence[Pair], meaning: str) -> list[Pair]:
    """Those with a value whose name has a meaning."""
    return [pair for pair in pairs if pair.values and meaning in _meant(pair.name)]


def _named(pairs: Sequence[Pair], meaning: str) -> str:
    """The first value of a name; not of the analyser, or a part of the breaker."""
    own = (p.text for p in _of(pairs, meaning) if "of another thing" not in _meant(p.name))
    return next(own, "")


def _length(pairs: Sequence[Pair], decimal: str, samples: int) -> float:
    """Length of the record or its plot, ms; a number without a unit may be that of samples."""
    for pair in _of(pairs, "length"):
        number, unit = pair.number(decimal)
        if number > 0:
            bare = "ms" if number >= _SHORTEST and abs(number - samples) > 1 else ""
            return number * TO_MS.get(unit_of(unit) if unit else bare, _NAN)
    return _NAN


def _checked(stated: _StatedRate, length: float, samples: int) -> tuple[float, str]:
    """The rate, kHz, and why there is none."""
    by_length = samples / length if samples and length > 0 else _NAN
    if math.isnan(by_length):
        return stated.rate, stated.doubt
    likely = stated.likely if math.isnan(stated.rate) else stated.rate
    if abs(likely / by_length - 1.0) <= _AGREE:
        return likely, ""
    lasting = f"{samples} samples in a length of {in_digits(length, 6)} ms are "
    lasting += f"{in_digits(by_length, 4)} kHz"
    if math.isnan(stated.rate):
        return _NAN, f"{stated.doubt or 'not stated'}; {lasting}"
    return _NAN, f"{stated.text!r} is {in_digits(likely, 6)} kHz, but {lasting}"


def _ratio(pairs: Sequence[Pair], decimal: str) -> tuple[float, tuple[str, ...]]:
    """The ratio of the linkage, and a doubt where channels differ in it."""
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
    """The date of the test in either order of day and month, or in the order of all dates."""
    every = [(pair, dates_of(pair.text)) for pair in _of(pairs, "date")]
    own = [each for each in every if each[1] and "of another day" not in _meant(each[0].name)]
    own.sort(key=lambda each: "of the test" not in _meant(each[0].name))
    if not own:
        return ()
    pair, found = own[0]
    # A 14th month decides for the other dates, too.
    orders = {first for _, each in every if len(each) == 1 for first in each}
    if len(orders) == 1 and orders <= {*found}:
        found = {first: found[first] for first in orders}
    clocks = (clock_of(each.text) for each in _of(pairs, "time"))
    clock = clock_of(" ".join(pair.values)) or next(filter(None, clocks), "")
    return tuple(dict.fromkeys(found[first] + clock for first in sorted(found, reverse=True)))


def _phases(pairs: Sequence[Pair]) -> dict[int, str]:
    """Names of phases by number of the channel, from 1; by 0 that of all."""
    found: dict[int, str] = {}
    for pair in pairs:
        channel = _CHANNEL.fullmatch(pair.name.lower())
        if channel and (phase := phase_in(pair.text)):
            found.setdefault(int(channel[1]), phase)
        elif pair.values and "phases" in _meant(pair.name):
            values = pair.values if len(pair.values) > 1 else re.split(r"[\s,/]+", pair.text)
            phases = list(filter(None, map(phase_in, values)))
            named = {0: phases[0]} if len(phases) == 1 else dict(enumerate(phases, start=1))
            found = named | found
    return found


def _rate_of(pairs: Iterable[Pair], decimal: str = ".") -> _StatedRate:
    """Return the rate that pairs state.

    >>> _rate_of([Pair("Sampling Speed", "kC", ("10",), 0)]).rate
    10.0
    >>> _rate_of([Pair("dt", "", ("0,05", "ms"), 0)], ",").rate
    20.0
    >>> _rate_of([Pair("Sampling rate", "", ("10",), 0)]).doubt
    "'Sampling rate: 10' has no unit"
    """
    sure, unsure = {}, {}
    for pair in pairs:
        for rate, doubt in _rates(pair, decimal):
            unit = f" ({pair.unit})" if pair.unit else ""
            text = f"{pair.name}{unit}: {' '.join(pair.values[:2])}"
            found = unsure if doubt else sure
            found.setdefault(float(f"{rate:.9g}"), (text, doubt))
    if len(sure) == 1:
        ((rate, (text, _)),) = sure.items()
        return _StatedRate(rate, text=text)
    if sure:
        several = " and ".join(
            f"{text!r} ({in_digits(rate, 6)} kHz)" for rate, (text, _) in sure.items()
        )
        return _StatedRate(doubt=f"several rates are stated: {several}")
    if unsure:
        rate, (text, doubt) = next(iter(unsure.items()))
        return _StatedRate(doubt=f"{text!r} {doubt}", likely=rate, text=text)
    return _StatedRate()


def _per_ms(unit: str) -> float:
    """Samples in a ms that one of a unit is; NaN if it is none of rates."""
    if not (found := _UNIT.fullmatch(unit.lower().replace(" ", "").strip("[]()."))):
        return math.nan
    return (
        1.0 if found["ms"] or found[0] == "k" or found[0].startswith("kc") else _PREFIXES[found[1]]
    )


def _rates(pair: Pair, decimal: str) -> list[tuple[float, str]]:
    """Rates of a recorder, kHz, that a pair states, and what is doubtful about each."""
    number, unit = pair.number(decimal)
    if not number > 0:
        return []
    meant = _rates_in(pair.name)
    named = "samples" in meant
    if named and (per := _PER_SAMPLE.search(f"{pair.name} {unit}".lower())):
        return _of_recorders([number / TO_MS[per[1]]])
    if "other" in meant:
        return []
    each = _EACH_SAMPLE.fullmatch(unit.lower())
    if (ms := TO_MS.get(unit_of(each[1] if each else unit))) is not None:
        return _of_recorders([1.0 / (number * ms)]) if "step" in meant or each else []
    if (per_ms := _per_ms(unit)) > 0:
        sure = named or "frequency" in meant or not re.search("hz|hertz|гц|k$", unit.lower())
        if found := _of_recorders([number * per_ms], "" if sure else _OF_WHAT):
            return found
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


def _quantity_of(name: str) -> str:
    """Return the quantity that a name means, empty where it means none of an operation."""
    return next(iter(_results_in(name)), "")


def _printed_of(
    rows: Sequence[Sequence[str]], pairs: Sequence[Pair], decimal: str
) -> tuple[Printed, ...]:
    """Return the results that lines state, by their cells, their pairs and the sign of numbers.

    >>> rows = [["Parameter", "CH1", "CH2"], ["Stroke (mm)", "178.1", "178.4"]]
    >>> [each[:5] for each in _printed_of(rows, (), ".")]
    [('stroke', '', 'CH1', 178.1, 'mm'), ('stroke', '', 'CH2', 178.4, 'mm')]
    """
    tables, taken = _results_in_tables(rows, decimal)
    found = list(tables)
    for pair in pairs:
        if pair.row in taken or not (quantity := _quantity_of(pair.name)):
            continue
        numbers, unit = numbers_of(pair.values, decimal)
        channel = channel_in(pair.name)
        label = channel[0] if channel else phase_in(pair.name)
        several = sum(map(math.isfinite, numbers)) > 1
        texts = (v for v, n in zip(pair.values, numbers, strict=True) if math.isnan(n))
        unit, motion = pair.unit or unit or next(texts, ""), motion_of(pair.name)
        for place, number in enumerate(numbers, start=1):
            channel = str(place) if several else label
            found.append(Printed(quantity, motion, channel, number, unit, pair.name))
    fit = (each for each in found if math.isfinite(each.value) and each.size is not None)
    return tuple(dict.fromkeys(fit))


def _results_in_tables(
    rows: Sequence[Sequence[str]], decimal: str
) -> tuple[list[Printed], set[int]]:
    """Results in tables, by quantities or by channels, and the lines that they take."""
    found, taken, head, title = [], set(), None, ""
    for place, row in enumerate(rows):
        cells = [cell.strip() for cell in row]
        while cells and not cells[-1]:
            cells.pop()
        if len(list(filter(None, cells))) == 1:
            title, head = motion_of(cells[0]) if cells[0] else "", None
        elif not cells or any(cell.endswith((":", "=")) for cell in cells):
            head = None
        elif not any(map(math.isfinite, numbers := numbers_of(cells[1:], decimal)[0])):
            head = cells if _is_head_of_results(cells) else None
            taken |= {place} if head else set()
        elif head:
            # The names of channels may stand alone, with none of the column of quantities.
            head = ["", *head] if len(head) == len(cells) - 1 else head
            each = _results_of_row(head, cells, numbers, title)
            found += each
            taken |= {place} if each else set()
    return found, taken


def _is_head_of_results(cells: Sequence[str]) -> bool:
    """Whether a line has names of channels, or of quantities, side by side."""
    channels = [bool(channel_of(cell) or phase_in(cell)) for cell in cells]
    quantities = [bool(_quantity_of(cell)) for cell in cells[1:]]
    named = says(cells[0], WORDS["result_heads"]) and (any(channels[1:]) or any(quantities))
    return bool(named) or all(channels)


def _results_of_row(
    head: Sequence[str], cells: Sequence[str], numbers: Sequence[float], title: str
) -> list[Printed]:
    """Results in a line of a table."""
    found, columns = [], list(zip(head[1:], cells[1:], numbers, strict=False))
    unit = next((cell for label, cell, _ in columns if label.lower().startswith("unit")), "")
    for label, _, number in columns:
        heads = _quantity_of(label) and not channel_of(label)
        name, channel = (label, cells[0]) if heads else (cells[0], label)
        if (quantity := _quantity_of(name)) and not label.lower().startswith("unit"):
            inner = re.search(r"[\[(]\s*([^\[\]()]+?)\s*[\])]", name)
            own = inner[1] if inner else unit
            found.append(Printed(quantity, motion_of(name) or title, channel, number, own, name))
    return found
