"""Contents of the text above the samples: the rate, the breaker, the test, and its results.

Nothing is guessed: what is not stated is missing, and what contradicts itself is a doubt.
"""

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

from breaker.common.numerals import in_digits
from breaker.records.dates import clock_of, dates_of, day_order, in_order
from breaker.records.header_pairs import Pair, lines_of, number_of, pairs_of
from breaker.records.lexicon import WORDS
from breaker.records.printed import Printed, printed_in
from breaker.records.settings import RATES, TO_MS
from breaker.records.words import PHASE, any_of, by_words, phase_in, sequence_of, unit_of

_MOST = (400, 60, 300)  # lines, cells in a line and signs in a cell that are read: bounds the time
_AGREE = 0.01  # share between two statements of a length: one sample of the shortest record
_meant = by_words(WORDS["stated"])
_rates_in = by_words(WORDS["rate_words"])
_CHANNEL = re.compile(
    rf"^(?:phase(?: name)? (?:of )?)?{any_of(WORDS['labels']['stated channel'])}\W*(\d+)"
    r"(?:\W*(?:phase|name|label))*$"
)
_OF_BREAK = re.compile(rf"(?:{PHASE})-[0-9](?: \w+)?")  # such as Y-1 CT
_KHZ = {
    kind: {unit: size for size, units in WORDS[kind].items() for unit in units.split()}
    for kind in ("frequencies", "sample_rates")
}
_PER_SAMPLE = re.compile(r"(?:\bper |\bsamples? ?/) ?(m?s)(?:ec(?:ond)?s?)?\b")  # in the name
_EACH_SAMPLE = re.compile(r"([µμu]?\w+) ?(?:/|per) ?samples?")


@dataclass(frozen=True)
class Header:
    """Contents of the text above the samples; empty, NaN or None where nothing is stated.

    Attributes:
        rate, length: Sampling rate, kHz, NaN if it is doubtful; duration of the record, ms.
        ratio: Ratio of the linkage. No file states whether the samples are multiplied by it.
        dates: Date of the test as ISO 8601, with its time if that is stated; two dates, first that
            with the day before the month, where their order is not known.
        operation: Motions, such as ``"C-O"``.
        phases: Names of phases by number of the channel, from 1; by 0 that of all.
        speed_points: Statements of points between which speeds are means.
        doubts: Contradictions, and statements that can be read in two ways, in words.
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
    doubts: tuple[str, ...] = ()

    @property
    def date(self) -> str:
        """Date of the test as ISO 8601; empty if it is not stated, or its order is not known."""
        return self.dates[0] if len(self.dates) == 1 else ""


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
    rows = [[cell[: _MOST[2]] for cell in row[: _MOST[1]]] for row in rows[: _MOST[0]]]
    pairs = pairs_of(lines := lines_of(rows))
    named = {key: _named(pairs, key) for key in ("station", "bay", "type", "serial")}
    named["station"] = named["station"] or _named(pairs, "site")
    operations = {sequence_of(pair.text) for pair in _of(pairs, "operation")} - {""}
    length = _length(pairs, decimal, samples)
    rate, rate_doubt = _checked(*_stated_rate(pairs, decimal), length, samples)
    ratios, dates = _ratios(pairs, decimal), _dates(pairs)
    several = " and ".join(in_digits(ratio, 6) for ratio in ratios)
    doubts = [f"channels differ in the ratio: {several}"] if len(ratios) > 1 else []
    doubts += [f"the date of the test is {dates[0]} or {dates[1]}"] if len(dates) > 1 else []
    return Header(
        pairs=tuple(pairs),
        rate=rate,
        rate_doubt=rate_doubt,
        length=length,
        ratio=ratios[0] if len(ratios) == 1 else math.nan,
        travel_unit=next((pair.text for pair in _of(pairs, "unit")), ""),
        dates=dates,
        operation=operations.pop() if len(operations) == 1 else "",
        phases=_phases(pairs),
        speed_points=(*_of(pairs, "point of speed"), *_of(pairs, "width of speed")),
        results=printed_in(lines, decimal),
        doubts=tuple(doubts),
        **named,
    )


def _of(pairs: Iterable[Pair], meaning: str) -> list[Pair]:
    return [pair for pair in pairs if pair.values and meaning in _meant(pair.name)]


def _named(pairs: Iterable[Pair], meaning: str) -> str:
    """Return the first value of a name that is not one of the analyser or a part of the breaker."""
    own = (p.text for p in _of(pairs, meaning) if "of another thing" not in _meant(p.name))
    return next(own, "")


def _length(pairs: Iterable[Pair], decimal: str, samples: int) -> float:
    """Return the length, ms; NaN without a unit, as it may be in samples, ms or s."""
    for pair in _of(pairs, "length"):
        number, unit = pair.number(decimal)
        if number > 0:
            return number * TO_MS.get(unit_of(unit) or "", math.nan)
    return math.nan


def _ratios(pairs: Iterable[Pair], decimal: str) -> list[float]:
    """Return the different ratios of the first name that has any."""
    for pair in _of(pairs, "ratio"):
        texts = [re.sub(r"^\s*1\s*:\s*|\s*:\s*1\s*$", "", value) for value in pair.values]
        numbers = [number_of(text, decimal)[0] for text in texts]
        if found := [*dict.fromkeys(number for number in numbers if number > 0)]:
            return found
    return []


def _dates(pairs: Iterable[Pair]) -> tuple[str, ...]:
    """Return the date of the test in both orders of day and month, or in that of another date."""
    every = [(pair, dates_of(pair.text)) for pair in _of(pairs, "date")]
    own = [each for each in every if each[1] and "of another day" not in _meant(each[0].name)]
    own.sort(key=lambda each: "of the test" not in _meant(each[0].name))
    if not own:
        return ()
    pair, readings = own[0]
    texts = [" ".join(pair.values), *(each.text for each in _of(pairs, "time"))]
    clock = next(filter(None, map(clock_of, texts)), "")
    order = day_order(each for _, each in every)
    return tuple(day + clock for day in in_order(readings, order))


def _phases(pairs: Iterable[Pair]) -> dict[int, str]:
    """Return names of phases by number of the channel, from 1; by 0 that of all."""
    found: dict[int, set[str]] = {}
    for pair in pairs:
        if channel := _CHANNEL.fullmatch(pair.name.lower()):
            own = _OF_BREAK.fullmatch(pair.text.strip())  # named as it stands there
            phase = own[0] if own else phase_in(pair.text)
            found.setdefault(int(channel[1]), set()).add(phase)
        elif pair.values and "phases" in _meant(pair.name):
            values = pair.values if len(pair.values) > 1 else re.split(r"[\s,/]+", pair.text)
            phases = list(filter(None, map(phase_in, values)))
            for number, phase in enumerate(phases, start=len(phases) > 1):
                found.setdefault(number, set()).add(phase)
    named = {number: phases - {""} for number, phases in found.items()}
    return {number: phases.pop() for number, phases in named.items() if len(phases) == 1}


# ---- the rate ------------------------------------------------------------------------------------


def _checked(rate: float, doubt: str, length: float, samples: int) -> tuple[float, str]:
    """Return the rate, kHz, or why there is none: a length confirms it or contradicts it."""
    by_length = samples / length if samples and length > 0 else math.nan
    if math.isnan(by_length):
        return (math.nan if doubt else rate), doubt
    if abs(rate / by_length - 1.0) <= _AGREE:
        return rate, ""
    stated = doubt or ("not stated" if math.isnan(rate) else f"{in_digits(rate, 6)} kHz is stated")
    lasting = f"{samples} samples in a length of {in_digits(length, 6)} ms are "
    return math.nan, f"{stated}, but {lasting}{in_digits(by_length, 4)} kHz"


def _stated_rate(pairs: Iterable[Pair], decimal: str = ".") -> tuple[float, str]:
    """Return the rate that pairs state, kHz, NaN without one, and a doubt about it.

    >>> _stated_rate([Pair("dt", "", ("0,05", "ms"))], ",")
    (20.0, '')
    >>> _stated_rate([Pair("Sampling rate", "", ("10",))])
    (10.0, "'Sampling rate: 10' has no unit")
    """
    sure, unsure = {}, {}
    for pair in pairs:
        rate, doubt = _rate_in(pair, decimal)
        text = f"{pair.name}{f' ({pair.unit})' if pair.unit else ''}: {' '.join(pair.values[:2])}"
        if RATES[0] <= rate <= RATES[1]:
            (unsure if doubt else sure)[float(f"{rate:.9g}")] = text, doubt
        elif math.isfinite(rate) and "samples" in _rates_in(pair.name):
            unsure[math.nan] = text, "is a rate that no recorder has"
    if len(sure) > 1:
        several = (f"{text!r} ({in_digits(rate, 6)} kHz)" for rate, (text, _) in sure.items())
        return math.nan, f"several rates are stated: {' and '.join(several)}"
    rate, (text, doubt) = next(iter((sure or unsure).items()), (math.nan, ("", "")))
    return rate, f"{text!r} {doubt}" if doubt else ""


def _rate_in(pair: Pair, decimal: str) -> tuple[float, str]:
    """Return the rate that a pair may state, kHz, NaN where it states none, and a doubt."""
    number, unit = pair.number(decimal)
    meant, bare = _rates_in(pair.name), unit.lower().replace(" ", "").strip("[]().")
    named = "samples" in meant
    if not number > 0:
        return math.nan, ""
    if named and (per := _PER_SAMPLE.search(f"{pair.name} {unit}".lower())):
        return number / TO_MS[per[1]], ""
    each = _EACH_SAMPLE.fullmatch(unit.lower())
    if ms := TO_MS.get(unit_of(each[1] if each else unit) or ""):
        is_step = each or ("step" in meant and "other" not in meant)
        return (1.0 / (number * ms) if is_step else math.nan), ""
    if "other" in meant:
        return math.nan, ""
    if size := _KHZ["sample_rates"].get(bare):
        return number * size, ""
    if size := _KHZ["frequencies"].get(bare):
        sure = named or "frequency" in meant
        return number * size, "" if sure else "does not say that it is of the samples"
    if unit or not (named and "tempo" in meant):
        return math.nan, ""
    # Thousands without a unit are Hz: no recorder takes as many in a ms.
    return (number, "has no unit") if number <= RATES[1] else (1e-3 * number, "")
