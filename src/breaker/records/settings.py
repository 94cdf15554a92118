"""The section ``endurance.format`` of the configuration, which describes curve files."""

import codecs
from collections.abc import Mapping
from contextlib import suppress

TO_MS = {"s": 1e3, "ms": 1.0, "us": 1e-3}
TO_MM = {"mm": 1.0, "cm": 10.0, "m": 1e3, "um": 1e-3, "inch": 25.4}

RATES = (0.95, 105.0)
"""Smallest and largest rate of recorders, kHz; limits for stated and estimated rates."""

READABLE = (RATES[0], 1000.0)
"""Smallest and largest rate, kHz, of records that can be read."""

SAME_RATE = 0.01
"""Share by which two statements of a rate may differ by rounding; clocks of recorders agree far
better."""

FORMAT = {
    "encoding": "utf-8",
    "delimiter": ",",
    "decimal": ".",
    "time_column": "time",
    "time_unit": "s",
    "rate": None,
    "travel_column": "travel",
    "travel_unit": "mm",
    "ratio": None,
    "zero": 0.0,
    "sign": 1,
    "quantum": None,
    "stroke": None,
    "contact_column": None,
    "current_column": None,
    "timing_sd": 0.1,
    "trigger_column": None,
    "missing": 0.5,
}
"""Default of every setting, as in ``endurance.format`` of config/config.yaml."""


def lacking(settings: Mapping) -> str:
    """Return a message if complete settings lack a unit or rate that the table does not state."""
    unit = settings["travel_unit"]
    if unit not in TO_MM and not settings["ratio"]:
        return (
            f"endurance.format.travel_unit is {unit!r}, not one of {', '.join(TO_MM)}, so "
            "endurance.format.ratio (mm for one of it) is needed, or the column ratio of "
            "operations.csv"
        )
    if settings["time_column"] is None and settings["rate"] is None:
        return (
            "endurance.format.time_column is null, so endurance.format.rate is needed: the samples "
            "in a ms (kHz), or the column rate of operations.csv"
        )
    return ""


def complete(settings: Mapping) -> dict:
    """Return settings, completed by defaults; ``configuration`` checks most values.

    Raises:
        ValueError: If a setting is unknown, or the encoding.
    """
    if unknown := [key for key in settings if key not in FORMAT]:
        raise ValueError(f"endurance.format has no {', '.join(unknown)}; see config/config.yaml")
    settings = {**FORMAT, **settings}
    with suppress(LookupError, ValueError):
        if codecs.lookup(settings["encoding"])._is_text_encoding:
            return settings
    what = "an encoding of text, such as utf-8"
    raise ValueError(f"endurance.format.encoding is {settings['encoding']!r}, but must be {what}")
