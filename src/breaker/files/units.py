"""Units as instruments spell them, bare, in brackets, or behind the name of a column.

Only what is sure is known: `grad` is a degree in German and a gon elsewhere, so it is not. A single
letter counts in its own case, and letters of phases are no units behind a name: `Travel (S)`.
"""

import re

__all__ = ["split_unit", "unit_of"]

_SPELLINGS = {
    "s": "s sec secs second seconds sek sekunden",
    "ms": "ms msec msecs msek millisec millisecs millisecond milliseconds millisekunden",
    "us": "us µs μs usec µsec μsec microsec microsecs microsecond microseconds",
    "mm": "mm millimeter millimeters millimetre millimetres",
    "cm": "cm centimeter centimeters centimetre centimetres",
    "m": "m meter meters metre metres",
    "um": "um µm μm micron microns micrometer micrometers micrometre micrometres",
    "inch": "in inch inches zoll \" '' ″",
    "deg": "deg degs degree degrees ° º ˚ °deg",
    "rad": "rad rads radian radians",
    "V": "V volt volts",
    "counts": "count counts cts digit digits inc incs incr increment increments pulse pulses lsb",
    "%": "% pct percent prozent",
}
# Known, but of no time or travel that the settings can have: they contradict any of these.
_OTHERS = (
    "ns min h dm km nm ft mil thou mrad gon A mA kA mV kV W N kN Pa bar Hz kHz Ω ohm °C "
    "m/s mm/s mm/ms cm/s ft/s in/s deg/s rad/s m/s² m/s2 g"
)
_KNOWN = {
    spelling: unit
    for unit, spellings in {**_SPELLINGS, **{other: other for other in _OTHERS.split()}}.items()
    for spelling in spellings.split()
}
_FOLDED = {spelling.casefold(): unit for spelling, unit in _KNOWN.items() if len(spelling) > 1}
_BEHIND = re.compile(r"(.*?)\s*(?:\[(.*)\]|\((.*)\)|/\s*(\S+)|\sin\s+(\S+)|[,_]\s*(\w{2,}))\s*")
_LONGEST = 200  # signs of a name
# Behind a name they rather are a phase, a pole or a direction.
_NAMES = {"A", "V", "W", "N", "h", "g", "in", "inc"}


def unit_of(text: str) -> str | None:
    """Return the unit that a text states, as the settings call it, or None if it is not known.

    >>> [unit_of(text) for text in ("[msec]", "Grad", "°", "(INCH)", "kA")]
    ['ms', None, 'deg', 'inch', 'kA']
    """
    bare = text.strip().strip("[](){}<>").strip().removesuffix(".")
    return _KNOWN.get(bare) or _FOLDED.get(bare.casefold())


def split_unit(name: str) -> tuple[str, str | None]:
    """Return the name of a column without its unit, and the unit; None where it has none.

    >>> [split_unit(name) for name in ("Travel [mm]", "t/ms", "Travel (A)")]
    [('Travel', 'mm'), ('t', 'ms'), ('Travel (A)', None)]
    """
    found = _BEHIND.fullmatch(name) if len(name) <= _LONGEST else None
    behind = next(filter(None, found.groups()[1:]), "") if found else ""
    unit = None if behind.strip() in _NAMES else unit_of(behind)
    return (found[1], unit) if unit else (name, None)
