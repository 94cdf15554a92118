"""The rate that a text states, as such or as the time from one sample to the next."""

import math
import re
from collections.abc import Iterable
from typing import NamedTuple

from breaker.common.numerals import in_digits
from breaker.reading.files.column_names import unit_of
from breaker.reading.files.format_settings import TO_MS
from breaker.reading.files.lexicon import HERTZ, KILOCYCLES, PER_MS, RATE_PREFIXES, RATE_WORDS
from breaker.reading.files.name_value_pairs import Pair
from breaker.reading.files.word_lookup import by_words

RATES = (0.95, 105.0)
"""The least and the largest rate, kHz, of recorders: what is stated or guessed is within."""

READABLE = (RATES[0], 1000.0)
"""The same of records that are read, whether times or settings give it."""

_SIZES = {None: 1e-3} | {
    prefix: size for size, prefixes in RATE_PREFIXES.items() for prefix in prefixes.split()
}
_PREFIX = "|".join(filter(None, _SIZES))
_UNIT = re.compile(rf"({_PREFIX})?(?:{HERTZ})|{KILOCYCLES}|(?P<ms>{PER_MS})")
_PER = re.compile(r"(?:\bper |\bsamples? ?/) ?(m?s)(?:ec(?:ond)?s?)?\b")  # in the name
_EACH = re.compile(r"([µμu]?\w+) ?(?:/|per) ?samples?")
_meant = by_words(RATE_WORDS)
_NO_UNIT, _OF_WHAT = "has no unit", "does not say that it is of the samples"


class StatedRate(NamedTuple):
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


def rate_of(pairs: Iterable[Pair], decimal: str = ".") -> StatedRate:
    """Return the rate that pairs state.

    >>> rate_of([Pair("Sampling Speed", "kC", ("10",), 0)]).rate
    10.0
    >>> rate_of([Pair("dt", "", ("0,05", "ms"), 0)], ",").rate
    20.0
    >>> rate_of([Pair("Sampling rate", "", ("10",), 0)]).doubt
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
        return StatedRate(rate, text=text)
    if sure:
        several = " and ".join(
            f"{text!r} ({in_digits(rate, 6)} kHz)" for rate, (text, _) in sure.items()
        )
        return StatedRate(doubt=f"several rates are stated: {several}")
    if unsure:
        rate, (text, doubt) = next(iter(unsure.items()))
        return StatedRate(doubt=f"{text!r} {doubt}", likely=rate, text=text)
    return StatedRate()


def _per_ms(unit: str) -> float:
    """Samples in a ms that one of a unit is; NaN if it is none of rates."""
    if not (found := _UNIT.fullmatch(unit.lower().replace(" ", "").strip("[]()."))):
        return math.nan
    return 1.0 if found["ms"] or found[0] == "k" or found[0].startswith("kc") else _SIZES[found[1]]


def _rates(pair: Pair, decimal: str) -> list[tuple[float, str]]:
    """Rates of a recorder, kHz, that a pair states, and what is doubtful about each."""
    number, unit = pair.number(decimal)
    if not number > 0:
        return []
    meant = _meant(pair.name)
    named = "samples" in meant
    if named and (per := _PER.search(f"{pair.name} {unit}".lower())):
        return _fit([number / TO_MS[per[1]]])
    if "other" in meant:
        return []
    each = _EACH.fullmatch(unit.lower())
    if (ms := TO_MS.get(unit_of(each[1] if each else unit))) is not None:
        return _fit([1.0 / (number * ms)]) if "step" in meant or each else []
    if (per_ms := _per_ms(unit)) > 0:
        sure = named or "frequency" in meant or not re.search("hz|hertz|гц|k$", unit.lower())
        if found := _fit([number * per_ms], "" if sure else _OF_WHAT):
            return found
        both = f"is {in_digits(number * per_ms, 6)} kHz, which no recorder has, "
        both += f"or {in_digits(1e-3 * number, 6)} kHz, if it is samples a second"
        return _fit([1e-3 * number], both) if named and per_ms >= 1.0 else []
    if unit:
        return []
    if "step" in meant and (named or "dt" in meant):
        return _fit([1.0 / (number * ms) for ms in TO_MS.values()], _NO_UNIT)
    if not (named and "tempo" in meant):
        return []
    # Thousands without a unit are Hz: no recorder takes as many in a ms.
    return _fit([1e-3 * number]) or _fit([number], _NO_UNIT)


def _fit(rates: Iterable[float], doubt: str = "") -> list[tuple[float, str]]:
    return [(rate, doubt) for rate in rates if RATES[0] <= rate <= RATES[1]]
