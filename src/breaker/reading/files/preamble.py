"""What the text above the samples says: the rate, the breaker, the test, and its results.

Nothing is guessed: what is not stated is missing, and what contradicts itself is a doubt.
"""

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

from breaker.common.numerals import in_digits
from breaker.reading.files.column_names import unit_of
from breaker.reading.files.date_text import clock_of, dates_of
from breaker.reading.files.format_settings import TO_MS
from breaker.reading.files.lexicon import LABELS, STATED
from breaker.reading.files.motion_words import sequence_of
from breaker.reading.files.name_value_pairs import Pair, numbers_of, pairs_of
from breaker.reading.files.phases import phase_in
from breaker.reading.files.printed_results import Printed, printed_of
from breaker.reading.files.sampling_rate import StatedRate, rate_of
from breaker.reading.files.word_lookup import any_of, by_words

_NAN = math.nan
_SHORTEST = 20.0  # ms, of a record whose length has no unit
_MOST = (400, 60, 300)  # lines, cells of each, and signs of a cell that are looked at
_AGREE = 0.01  # share by which a length may differ from that of the samples: a trigger, a last one
_meant = by_words(STATED)
_CHANNEL = re.compile(
    rf"^(?:phase(?: name)? (?:of )?)?{any_of(LABELS['stated channel'])}\W*(\d+)"
    r"(?:\W*(?:phase|name|label))*$"
)


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
        dates: Of the test, with its time if that is stated, as ISO 8601: with the day before the
            month, and after it. They are alike where nothing is open.
        day_first: Whether dates of the text have the day before the month; None if that is open.
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
    day_first: bool | None = None
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
        return self.dates[0] if len({*self.dates}) == 1 else ""

    def with_days(self, *, first: bool) -> "Preamble":
        """Return the same with the day before the month, or after it, as other files have it."""
        return replace(self, dates=self.dates[:1] if first else self.dates[-1:])


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
    stated, length = rate_of(pairs, decimal), _length(pairs, decimal, samples)
    rate, doubt = _checked(stated, length, samples)
    ratio, unsure = _ratio(pairs, decimal)
    dates, day_first = _dates(pairs)
    if len({*dates}) > 1:
        unsure = (*unsure, f"the date of the test is {dates[0]} or {dates[1]}")
    return Preamble(
        pairs=tuple(pairs),
        rate=rate,
        rate_doubt=doubt,
        length=length,
        ratio=ratio,
        travel_unit=next((pair.text for pair in _of(pairs, "unit")), ""),
        dates=dates,
        day_first=day_first,
        operation=next(operations, ""),
        phases=_phases(pairs),
        speed_points=tuple(_of(pairs, "point of speed")),
        results=printed_of(rows, pairs, decimal),
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


def _checked(stated: StatedRate, length: float, samples: int) -> tuple[float, str]:
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


def _dates(pairs: Sequence[Pair]) -> tuple[tuple[str, ...], bool | None]:
    """The date of the test in both orders of day and month, or in that of all dates if any tells,
    and which that is.
    """
    every = [(pair, dates_of(pair.text)) for pair in _of(pairs, "date")]
    own = [each for each in every if each[1] and "of another day" not in _meant(each[0].name)]
    own.sort(key=lambda each: "of the test" not in _meant(each[0].name))
    if not own:
        return (), None
    pair, found = own[0]
    # A 14th month decides for the other dates, too.
    orders = {first for _, each in every if len(each) == 1 for first in each}
    if len(orders) == 1 and orders <= {*found}:
        found = {first: found[first] for first in orders}
    clocks = (clock_of(each.text) for each in _of(pairs, "time"))
    clock = clock_of(" ".join(pair.values)) or next(filter(None, clocks), "")
    dates = tuple(dict.fromkeys(found[first] + clock for first in sorted(found, reverse=True)))
    return dates, orders.pop() if len(orders) == 1 else None


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
