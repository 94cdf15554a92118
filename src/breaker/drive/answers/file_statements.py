"""What files state of their records: of which breaker they are, and the rate, which nothing else
shows.

The rate that a file states counts before the configuration, which may be that of another export;
the table of a folder, which names the file, counts before both.
"""

import re
from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import replace
from math import isfinite, isnan
from pathlib import Path

from breaker.common.numerals import in_digits
from breaker.reading.files.date_text import dates_of
from breaker.reading.files.format_settings import FORMAT, complete
from breaker.reading.files.formats import read_columns
from breaker.reading.files.guards import printable
from breaker.reading.files.motion_words import MOTION_OF
from breaker.reading.files.opened_file import Opened
from breaker.reading.files.operations_table import Operation
from breaker.reading.files.phases import channel_of, phase_in
from breaker.reading.files.preamble import Preamble
from breaker.reading.inspection.file_contents import look_into
from breaker.reading.records.raw_record import Raw

# Of ``endurance.format``, that go with a travel.
_WITH = {"contact_column", "trigger_column", "motor_column"}
_RATES, _LENGTHS = 0.01, 0.02  # shares, by which rates and lengths of a record may differ


def as_told(
    operation: Operation, motion: str, opened: Opened, stated: Preamble, settings: Mapping
) -> Operation:
    """Return an operation with settings that its file tells, and its row does not.

    The rate that the file states counts where nothing else gives times. The columns of a contact,
    a coil and a motor are those that go with the travel (``contact_columns``). Those of the
    configuration are of the configured travel, and of another travel of the file that has none of
    its own.
    """
    form = {**FORMAT, **settings, **operation.settings}
    told = _columns_with(operation, motion, opened, form)
    if form["rate"] is form["time_column"] is None and isfinite(stated.rate):
        told["rate"] = stated.rate
    return replace(operation, settings={**operation.settings, **told}) if told else operation


def _columns_with(operation: Operation, motion: str, opened: Opened, form: Mapping) -> dict:
    """The columns that go with a travel in a motion, where neither a row nor settings name them."""
    usual, open_keys = form["travel_column"], _WITH - operation.settings.keys()
    column = operation.channel or usual
    if column == usual:
        open_keys = {key for key in open_keys if form[key] is None}
    with suppress(ValueError):  # what cannot be read so is rejected, with the reason
        width = read_columns(opened, complete(form), operation.channel).width if open_keys else 1
        if 0 < width < 2 + (form["time_column"] is not None):
            return {}  # most files: nothing is beside the travel
        # Here, as most files need neither, and an answer comes in a third of a second.
        from breaker.reading.inspection.contact_columns import Beside
        from breaker.reading.inspection.file_description import columns_with

        layout = look_into(opened)
        place, own = layout.place_of(column), layout.place_of(usual)
        found = columns_with(opened, column).get(motion, Beside()).settings
        other = own is not None and place != own
        return {k: v for k, v in found.items() if k in open_keys and (other or form[k] is None)}
    return {}


def against_stated(raw: Raw, stated: Preamble) -> str:
    """Return a warning where a file states another rate or length than a record has; else nothing.

    Raises:
        ValueError: If the rate of the configuration is not the stated one, or the motion is not.
    """
    motions = {MOTION_OF[letter] for letter in stated.operation.split("-") if letter}
    if motions and raw.motion not in motions:
        (other,) = motions
        raise ValueError(
            f"the file states that it is a record of {other}, and it is read as {raw.motion}: "
            "check endurance.format.sign, and the motion that you named; if the file is wrong, "
            f"mend its {stated.operation!r} above the samples"
        )
    if isnan(stated.rate) and isnan(stated.length):
        return ""
    name, rate = printable(raw.operation.file), f"{in_digits(1.0 / raw.step, 4)} kHz"
    timed = raw.settings["time_column"] is not None
    if isfinite(stated.rate) and abs(stated.rate * raw.step - 1.0) > _RATES:
        states = f"states {in_digits(stated.rate, 4)} kHz"
        if not (timed or "rate" in raw.operation.settings):
            raise ValueError(
                f"the file {states}, and endurance.format.rate is {rate}: leave that out, and the "
                "stated one is taken. If the file is wrong, write the rate into the column rate of "
                f"operations.csv; breaker inspect {name} has both"
            )
        by = "its column of times says" if timed else "operations.csv says"
        return f"{name} {states}, and is read at {rate}, as {by}; see breaker inspect {name}"
    lasts = raw.time.size * raw.step
    if not timed and isfinite(stated.length) and abs(lasts / stated.length - 1.0) > _LENGTHS:
        return (
            f"{name} states a length of {in_digits(stated.length, 4)} ms, and lasts "
            f"{in_digits(lasts, 4)} ms at the {rate} of the settings: check endurance.format.rate; "
            f"see breaker inspect {name}"
        )
    return ""


def date_of(record) -> str:
    """Return the date of a record as ISO 8601: of its table, or what its file or name states;
    empty where none does, or day and month may be either.
    """
    named = {*_dates_in_name(record.operation.file)}
    return record.operation.date or record.stated.date or (named.pop() if len(named) == 1 else "")


def date_in(file: str | Path, stated: Preamble) -> str:
    """Return the date that a file states, or its name, as ISO 8601; of two readings, as of day and
    month, the first.
    """
    return next(iter([*stated.dates, *_dates_in_name(file)]), "")


def _dates_in_name(file: str | Path) -> Iterable[str]:
    return dates_of(Path(file).name).values()


def dates_in_words(records: Iterable) -> str:
    """Return the days of a visit, the first and the last; of day and month in either order both
    readings, where no other record is of either; empty where nothing states any.
    """
    days: set[str] = set()
    either: list[dict[str, None]] = []
    for each in records:
        if date := date_of(each):
            days.add(date[:10])
        else:
            either.append(dict.fromkeys(day[:10] for day in each.stated.dates))
    ends = dict.fromkeys([*sorted(days)[:1], *sorted(days)[-1:]])
    others = {" or ".join(each) for each in either if not days & each.keys()}
    return ", ".join(filter(None, [" to ".join(ends), *sorted(others)]))


def stated_of(records: Iterable) -> dict[str, float | str]:
    """Return what files state of a visit by what it is called: the ratio of the linkage, serial
    number, bay, phase and channel; what they do not, or differently, is left out.
    """
    found: dict[str, set] = {}
    for each in records:
        said = {"linkage ratio": each.stated.ratio, "serial number": each.stated.serial}
        said |= {"bay": each.stated.bay, "phase": _phase(each), "channel": _channel(each)}
        for name, value in said.items():
            if value and value == value:
                found.setdefault(name, set()).add(value)
    return {name: values.pop() for name, values in found.items() if len(values) == 1}


def _channel(record) -> str:
    """Number of a record's channel among those of the same name; empty where it has none."""
    column = record.operation.channel or (
        record.raw.settings["travel_column"] if record.raw else ""
    )
    number = re.fullmatch(r"(\D*[^\W\d_])[\W_]*(\d)\W*", str(column))
    return f"{number[1].casefold()} {number[2]}" if number else ""


def _phase(record) -> str:
    """Phase of a record's channel, by its name or its number."""
    phases, operation = record.stated.phases, record.operation
    column = operation.channel or str(record.raw.settings["travel_column"] if record.raw else "")
    return phase_in(column) or phases.get(channel_of(column), phases.get(0, ""))
