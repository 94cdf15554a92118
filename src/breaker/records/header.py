"""Read the text above the samples: the rate, the breaker, the test, the stroke.

The text consists of pairs of a name and values, separated by a sign or by cells. Values that are
not stated are missing, and contradictions are doubts.
"""

import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import NamedTuple

from breaker.common.numerals import in_digits
from breaker.model.quantities import EVENTS, Speed
from breaker.records import words
from breaker.records.dates import clock_of, dates_of, in_order
from breaker.records.settings import RATES, SAME_RATE, TO_MM, TO_MS
from breaker.records.words import WORDS, phase_in, unit_of

_MOST = (400, 60, 300)  # most lines, cells in a line and signs in a cell; bounds the time
_TEXTS = ("station", "bay", "type", "serial", "ratio")
_meant = words.by_words(WORDS["stated"])
_rates_in = words.by_words(WORDS["rate_words"])
_LABEL = words.any_of(WORDS["labels"]["stated channel"])
_CHANNEL = re.compile(rf"(?:phase (?:of )?)?{_LABEL}\W*(\d+)(?:\W*(?:phase|name))*")
_KHZ = {
    kind: {unit: size for size, units in WORDS[kind].items() for unit in units.split()}
    for kind in ("frequencies", "sample_rates")
}

_SIGN = r"(?:(?<!\d)[:=：]|[:=：](?!\d))"  # not within a time of day or a ratio
_SIGNED = re.compile(rf"([^\W\d_].*?)\s*{_SIGN}\s*(.*)")
_SPLIT = re.compile(rf"[\t;|]|\s{{2,}}|,(?=\s*[^\W\d_][^,:=]*{_SIGN})")
_NUMBER = r"[-+]?\d+(?:[.,]\d+)*(?:[eE][-+]?\d+)?"
_VALUE = re.compile(rf"({_NUMBER}|[-+]?[.,]\d+)[.,]?\s*([^\d\s:,;.]\S{{0,11}})?")
_TAG = re.compile(r"[A-Za-z]{1,3}[\W_]?\d{1,2}")  # channel in brackets next to the unit
_UNIT = re.compile(r"\s*[\[(]([^\[\]()]{1,12})[\])]\s*")


class Pair(NamedTuple):
    """Name without its unit, the unit, and the values after the name."""

    name: str
    unit: str
    values: tuple[str, ...]

    @property
    def text(self) -> str:
        """First value; empty without values."""
        return self.values[0] if self.values else ""

    def number(self) -> tuple[float, str]:
        """Return the first value as a number, NaN where it is not a number, and its unit."""
        number, unit = _number_of(self.text)
        second = self.values[1] if len(self.values) == 2 and not self.values[1][0].isdigit() else ""
        return number, unit or self.unit or second


@dataclass(frozen=True)
class Header:
    """Contents of the text above the samples; empty, NaN or None where nothing is stated.

    Attributes:
        rate, rate_doubt: Sampling rate, kHz; NaN where it is not clear, and the reason.
        dates: Date of the test as ISO 8601; two dates if the order of day and month is unknown.
        date_text: Date of the test as stated.
        ratio: Ratio of the linkage; files do not state whether their samples are multiplied by it.
        operation: Motions, such as ``"C-O"``.
        phases: Names of phases by number of the channel, from 1; 0 for a phase of all channels.
        strokes: Strokes that the analyser measured, mm, of any channel and motion.
        speeds: Speeds by motion, between two points that are stated in % of the stroke.
    """

    rate: float = math.nan
    rate_doubt: str = ""
    travel_unit: str = ""
    dates: tuple[str, ...] = ()
    date_text: str = ""
    station: str = ""
    bay: str = ""
    type: str = ""
    serial: str = ""
    ratio: str = ""
    operation: str = ""
    phases: Mapping[int, str] = field(default_factory=dict)
    strokes: tuple[float, ...] = ()
    speeds: Mapping[str, Speed] = field(default_factory=dict)

    def phase_of(self, column: str | int) -> str:
        """Return the phase of a travel column, by its name or as stated for its number, or ""."""
        stated = self.phases.get(words.channel_of(str(column)), self.phases.get(0, ""))
        return phase_in(str(column)) or stated


def header_of(rows: Sequence[Sequence[str]], samples: int = 0) -> Header:
    """Return the contents of the lines above samples.

    Args:
        rows: Cells of each line, with blank cells.
        samples: Number of samples below, 0 if unknown. If a stated length contradicts this number,
            the rate is doubtful.

    >>> rows = [["Sampling Speed (kC) :", "10", "", "Range :", "8000"], ["Serial No: 17"]]
    >>> header_of(rows).rate, header_of(rows).serial
    (10.0, '17')
    """
    kept = ([cell[: _MOST[2]] for cell in row[: _MOST[1]]] for row in rows[: _MOST[0]])
    pairs = [pair for row in kept for pair in pairs_in(row)]
    operations = {words.sequence_of(pair.text) for pair in stated_as(pairs, "operation")} - {""}
    length, unit = next((p.number() for p in stated_as(pairs, "length")), (math.nan, ""))
    length *= TO_MS.get(unit_of(unit) or "", math.nan)
    rate, doubt = _rate(pairs, samples / length if samples and length > 0 else math.nan)
    date_text, dates = _dates(pairs)
    return Header(
        rate=rate,
        rate_doubt=doubt,
        travel_unit=next((pair.text for pair in stated_as(pairs, "unit")), ""),
        dates=dates,
        date_text=date_text,
        operation=operations.pop() if len(operations) == 1 else "",
        phases=_phases(pairs),
        strokes=_strokes(pairs),
        speeds=_speeds(stated_as(pairs, "point of speed")),
        **{key: _first_of(pairs, key) for key in _TEXTS},
    )


def stated_as(pairs: Iterable[Pair], meaning: str) -> list[Pair]:
    """Return the pairs that have a value and a meaning of ``stated`` of the lexicon."""
    return [pair for pair in pairs if pair.values and meaning in _meant(pair.name)]


def _first_of(pairs: Iterable[Pair], meaning: str) -> str:
    """Return the first value that does not describe the analyser or a part of the breaker."""
    texts = (p.text for p in stated_as(pairs, meaning) if "of another thing" not in _meant(p.name))
    return next(texts, "")


def _dates(pairs: Iterable[Pair]) -> tuple[str, tuple[str, ...]]:
    """Return the date of the test as stated, and as dates: in both orders of day and month if the
    order is unknown.
    """
    dated = [pair for pair in stated_as(pairs, "date") if "of another day" not in _meant(pair.name)]
    dated.sort(key=lambda pair: "of the test" not in _meant(pair.name))
    pair = next((pair for pair in dated if dates_of(pair.text)), [*dated, Pair("", "", ())][0])
    texts = [" ".join(pair.values), *(clock.text for clock in stated_as(pairs, "time"))]
    clock = next(filter(None, map(clock_of, texts)), "")
    return pair.text, tuple(day + clock for day in in_order(dates_of(pair.text)))


def _phases(pairs: Iterable[Pair]) -> dict[int, str]:
    """Return names of phases by number of the channel, from 1; 0 for a phase of all channels."""
    meanings: dict[int, set[str]] = {}
    for pair in pairs:
        if channel := _CHANNEL.fullmatch(pair.name.lower()):
            phases = {int(channel[1]): phase_in(pair.text)}
        elif pair.values and "phases" in _meant(pair.name):
            values = pair.values if len(pair.values) > 1 else re.split(r"[\s,/]+", pair.text)
            named = [*filter(None, map(phase_in, values))]
            phases = dict(enumerate(named, start=len(named) > 1))
        else:
            continue
        for number, phase in phases.items():
            meanings.setdefault(number, set()).update({phase} - {""})
    return {number: phases.pop() for number, phases in meanings.items() if len(phases) == 1}


def _rate(pairs: Iterable[Pair], by_length: float) -> tuple[float, str]:
    """Return the rate, kHz, or NaN and the reason; the rate by the length may contradict it."""
    rates = {}
    for pair in pairs:
        if RATES[0] <= (rate := _rate_in(pair)) <= RATES[1]:
            rates[float(f"{rate:.9g}")] = f"'{pair.name}: {pair.text}'"
    rate, doubt = next(iter(rates.items()), (math.nan, "no usual rate is stated with its unit"))
    if len(rates) > 1:
        doubt = f"several rates are stated: {' and '.join(rates.values())}"
    elif not abs(rate / by_length - 1.0) > SAME_RATE and rates:
        return rate, ""
    if by_length > 0:
        doubt += f"; by the length {in_digits(by_length, 4)} kHz"
    return math.nan, doubt


def _rate_in(pair: Pair) -> float:
    """Return the rate that a pair states, kHz; NaN where it states none."""
    number, unit = pair.number()
    meant, bare = _rates_in(pair.name), unit.lower().replace(" ", "").strip("[]().")
    if not number > 0 or "other" in meant:
        return math.nan
    if ms := TO_MS.get(unit_of(unit) or ""):
        return 1.0 / (number * ms) if "step" in meant else math.nan
    if not unit and {"samples", "tempo"} <= {*meant} and number > RATES[1]:
        return 1e-3 * number  # Hz, as no recorder takes as many samples in a ms
    of_samples = "samples" in meant or ("tempo" in meant and bare == "khz")  # mains are in Hz
    sizes = _KHZ["sample_rates"] | (_KHZ["frequencies"] if of_samples else {})
    return number * sizes.get(bare, math.nan)


def _strokes(pairs: Iterable[Pair]) -> tuple[float, ...]:
    """Return the measured strokes, mm, that are stated with a unit."""
    strokes = []
    for pair in stated_as(pairs, "stroke"):
        if "other stroke" in _meant(pair.name):
            continue
        numbers = [_number_of(value) for value in pair.values]
        units = [pair.unit, *pair.values, *(unit for _, unit in numbers)]
        size = next((TO_MM[unit] for unit in map(unit_of, units) if unit in TO_MM), math.nan)
        strokes += [size * number for number, _ in numbers if size * number > 0]
    return tuple(strokes)


def _speeds(points: Sequence[Pair]) -> dict[str, Speed]:
    """Return the speeds whose two points are shares of the stroke."""
    speeds, shares_of = {}, {*WORDS["share_of_stroke"]}
    usual = "%" if any({p.text.strip(), p.unit} & shares_of for p in points) else ""
    for motion in EVENTS:
        numbers = [p.number() for p in points if words.motion_of(p.name) in (motion, "")]
        shares = [number for number, unit in numbers if number > 0 and (unit or usual) == "%"]
        if len(shares) == 2 and shares[0] < shares[1] < 100:
            ends = [f"{share:g} % of stroke" for share in shares]
            speeds[motion] = Speed.read(f"{motion}_speed", ends)
    return speeds


# ---- names and values ----------------------------------------------------------------------------


def pairs_in(row: Sequence[str]) -> list[Pair]:
    """Return the pairs of a line by its cells; values before the first name are dropped."""
    pairs: list[tuple[str, list[str]]] = []
    for text, named in _tokens([part for cell in row for part in _parts(cell)]):
        if named:
            pairs.append((text, []))
        elif text and pairs:
            pairs[-1][1].append(text)
    return [Pair(*_name_of(name), tuple(values)) for name, values in pairs]


def _tokens(cells: Sequence[str]) -> Iterable[tuple[str, bool]]:
    """Return the parts of a line, and whether they are names. Without a sign, a name is the first
    cell or follows a blank cell, or names and values alternate.
    """
    if any(map(_SIGNED.match, cells)):
        return [token for cell in cells for token in _signed(cell)]
    if len(cells) % 2 == 0 and all(cells) and all(cell[0].isalpha() for cell in cells[::2]):
        return [(cell, place % 2 == 0) for place, cell in enumerate(cells)]
    around = zip(["", *cells], cells, [*cells[1:], ""], strict=False)
    return [(cell, not before and after and cell[:1].isalpha()) for before, cell, after in around]


def _signed(cell: str) -> Iterator[tuple[str, bool]]:
    """Split a cell at its signs into names and a value; a cell without a sign is a value."""
    while match := _SIGNED.match(cell):
        yield match[1], True
        cell = match[2].lstrip(" ,")
    yield cell, False


@lru_cache(maxsize=4096)
def _parts(cell: str) -> list[str]:
    """Split a cell that is a line with another delimiter."""
    cell = cell.replace('"', "").strip(" \t,")
    cell = re.sub(r"\s*([:=：])(?=\s|$)\s*", r"\1 ", cell.lstrip("#%! ") or cell)
    return [part.strip(" ,") for part in _SPLIT.split(cell)]


@lru_cache(maxsize=4096)  # files of a folder have the same names
def _name_of(text: str) -> tuple[str, str]:
    """Return a name without its unit, and the unit; a channel in brackets belongs to the name."""
    brackets = [match[1].strip() for match in _UNIT.finditer(text)]
    if not brackets:
        bare, unit = (text, "") if "/" in text else words.split_unit(text)
        return (bare, unit or "") if bare else (text, "")
    label = next(filter(_TAG.fullmatch, brackets), "") if len(brackets) > 1 else ""
    unit = next((bracket for bracket in brackets if bracket != label), "")
    return f"{_UNIT.sub(' ', text).strip()} {label}".strip(), unit


def _number_of(text: str) -> tuple[float, str]:
    """Return a text as a number, NaN where it is not a number, and the unit after it."""
    match = _VALUE.fullmatch(text.strip())
    if match is None:
        return math.nan, ""
    digits, unit = match[1], (match[2] or "").strip("[]()")
    digits = digits.replace(",", ".")
    return (float(digits) if digits.count(".") < 2 else math.nan), unit
