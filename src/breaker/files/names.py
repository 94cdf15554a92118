"""Columns by their names or numbers, and the units that they state.

A name is found in these words, or else without regard to capitals and to a unit behind it. A unit
is bare, in brackets, or behind a name, in the usual languages. `Grad` is a degree, as no transducer
reads gons. A single letter counts in its own case, and letters of phases are no units behind a
name: `Travel (S)`.
"""

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import lru_cache
from pathlib import Path

from breaker.files.guards import RejectedCurveError

BESIDE = ("contact", "trigger")
"""Columns that a record may have beside time and travel, in any unit."""

_SPELLINGS = {
    "s": "s с sec secs second seconds sek sekunden сек segundos seconde secondes secondi 秒",
    "ms": "ms мс msec msecs msek millisec millisecs millisecond milliseconds millisekunden мсек "
    "milisegundos millisecondes millisecondi 毫秒",
    "us": "us мкс µs μs usec µsec μsec microsec microsecs microsecond microseconds",
    "mm": "mm мм millimeter millimeters millimetre millimetres milímetros milimetros millimètres "
    "millimetri миллиметр 毫米",
    "cm": "cm centimeter centimeters centimetre centimetres",
    "m": "m meter meters metre metres",
    "um": "um µm μm micron microns micrometer micrometers micrometre micrometres",
    "inch": "in inch inches zoll \" '' ″ pulgada pulgadas pulg pouce pouces pollice pollici "
    "polegada polegadas дюйм дюймы 英寸",
    "deg": "deg degs degree degrees ° º ˚ °deg grad grade grads winkelgrad grado grados gradi "
    "grau graus degré degrés degre degres graden grader stopnie град градус градусы 度",
    "rad": "rad rads radian radians",
    "V": "V volt volts",
    "counts": "count counts cts digit digits inc incs incr increment increments pulse pulses lsb",
    "%": "% pct percent prozent",
}
# Known, but of no time or travel that the settings can have: they contradict any of these.
_OTHERS = (
    "ns min h dm km nm ft mil thou mrad gon A mA kA mV kV W N kN Pa bar Hz kHz кГц Ω ohm °C "
    "uOhm µOhm μOhm mOhm kOhm uΩ µΩ μΩ mΩ kΩ "
    "m/s mm/s mm/ms cm/s ft/s in/s deg/s rad/s m/s² m/s2 g"
)
_KNOWN = {each: unit for unit, spelt in _SPELLINGS.items() for each in spelt.split()}
_KNOWN |= {other: other for other in _OTHERS.split()}
_FOLDED = {spelling.casefold(): unit for spelling, unit in _KNOWN.items() if len(spelling) > 1}
_BEHIND = re.compile(
    r"(.*?)\s*(?:\[(.*)\]|\((.*)\)|/\s*(\S+)|\sin\s+(\S+)|[,_]\s*(\w{2,}|m|°)|([°º˚]))\s*"
)
_TRAVEL = re.compile(
    r"travel|stroke|\bweg|hub|posi[tcz]|displac|course|carrera|transduc|angle|winkel|[aá]ngulo"
    r"|motion|corsa|curso|recorrido|desplaz|verplaats|\bход|перемещ|положен|行程|位移|^trv?\W*\d",
    re.I,
)
_LONGEST = 200  # signs of a name
# Behind a name they rather are a phase, a pole or a direction.
_NAMES = {"A", "V", "W", "N", "h", "g", "in", "inc"}


def wanted_columns(
    rows: Iterable[Sequence[str]], settings: Mapping, channel: str
) -> dict[str, str | int]:
    """Return the columns that are wanted, by kind: ``"time"``, if there is one, ``"travel"``, and
    those of ``BESIDE`` that the settings name. A channel that is a number in words is a number,
    unless one of the rows has it for a name.
    """
    if channel.isdecimal() and not any(places_of(row, channel) for row in rows):
        channel = int(channel)
    wanted = {"time": settings["time_column"], "travel": channel or settings["travel_column"]}
    # A trigger at time 0 has no column.
    wanted |= {kind: settings[f"{kind}_column"] or None for kind in BESIDE}
    return {kind: column for kind, column in wanted.items() if column is not None}


def label_of(column: str | int) -> str:
    """Return what messages call a column."""
    return f"column {column}" if isinstance(column, int) else repr(column)


def places_of(row: Sequence[str], column: str | int) -> list[int]:
    """Return the places, from 0, of a column in a row of names: at best in these words.

    >>> places_of(["# Time [s]", "Travel 1 (mm)", "travel 2"], "travel 1")
    [1]
    """
    if isinstance(column, int):
        return [column - 1] if column <= len(row) else []
    if column.casefold() not in "\n".join(row).casefold():
        return []
    names = [cell.strip() for cell in row]
    names[0] = names[0].lstrip("#%! ") or names[0]
    if column not in names:
        names = [split_unit(name)[0] for name in names]
    if column not in names:
        names, column = [name.casefold() for name in names], column.casefold()
    return [i for i, name in enumerate(names) if name == column]


def place_of(
    file: str | Path, row: Sequence[str], column: str | int, *, line: int | None = None
) -> int:
    """Return the one place of a column in a row of names.

    Raises:
        RejectedCurveError: If it is not there, or more than once.
    """
    found = places_of(row, column)
    if len(found) == 1:
        return found[0]
    reason = f"no column {column!r} among {listed(row)}; see endurance.format, also its skip_rows"
    if found:
        numbers = " or ".join(str(place + 1) for place in found)
        reason = f"more than one column {column!r}; give its number, {numbers}, for its name"
    raise RejectedCurveError(file, reason, line=line)


def listed(row: Sequence[str]) -> str:
    """Return what a message shows of a row of names."""
    return ", ".join(repr(cell.strip()[:40]) for cell in filter(str.strip, row[:40]))


def check_unit(
    file: str | Path,
    column: tuple[str, str],
    text: str,
    settings: Mapping,
    line: int | None = None,
) -> tuple[str, ...]:
    """Return what is to be remarked on the unit of a column: that it is not known.

    Args:
        file, line: Named in messages.
        column: Its kind, "time" or "travel", and what messages call it.
        text: The unit as it stands in the file, empty where none is stated.
        settings: The section ``endurance.format``, complete.

    Raises:
        RejectedCurveError: If it is another than that of the settings.
    """
    kind, label = column
    wanted, stated = settings[f"{kind}_unit"], unit_of(text)
    known = f"the unit of {label} is {text!r}"
    but = f"endurance.format.{kind}_unit is {wanted!r}"
    if stated and stated != wanted:
        raise RejectedCurveError(file, f"{known}, but {but}", line=line)
    return (f"{known}, which is not known; {but}",) if text and not stated else ()


def unit_of(text: str) -> str | None:
    """Return the unit that a text states, as the settings call it, or None if it is not known.

    >>> [unit_of(text) for text in ("[msec]", "Grad", "°", "(INCH)", "kA")]
    ['ms', 'deg', 'deg', 'inch', 'kA']
    """
    bare = text.strip().strip("[](){}<>").strip().removesuffix(".")
    return _KNOWN.get(bare) or _FOLDED.get(bare.casefold())


def split_unit(name: str) -> tuple[str, str | None]:
    """Return the name of a column without its unit, and the unit; None where it has none.

    >>> [split_unit(name) for name in ("Travel [mm]", "t/ms", "Travel (A)", "Travel A(in)")]
    [('Travel', 'mm'), ('t', 'ms'), ('Travel (A)', None), ('Travel A', 'inch')]
    """
    found = _BEHIND.fullmatch(name) if len(name) <= _LONGEST else None
    behind = next(filter(None, found.groups()[1:]), "") if found else ""
    inches = found and "in" in found.groups()[1:3] and is_travel_name(found[1])
    unit = None if behind.strip() in _NAMES and not inches else unit_of(behind)
    return (found[1], unit) if unit else (name, None)


def by_words(table: Mapping[str, str]) -> Callable[[str], tuple[str, ...]]:
    r"""Return a function that says which keys of a table a text means, by regular expressions for
    lower-case text. Files of a folder have the same names, so that it remembers them.

    >>> by_words({"station": r"\bstation", "date": r"\bdat[ea]\b"})("Test Date")
    ('date',)
    """
    compiled = {key: re.compile(words) for key, words in table.items()}

    @lru_cache(maxsize=2048)
    def meant(text: str) -> tuple[str, ...]:
        low = text.lower()
        return tuple(key for key, words in compiled.items() if words.search(low))

    return lambda text: (meant if len(text) <= _LONGEST else meant.__wrapped__)(text)


def is_travel_name(name: str) -> bool:
    """Say whether the name of a column is that of a travel, in the usual languages."""
    return _TRAVEL.search(name) is not None
