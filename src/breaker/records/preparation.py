"""How a record is prepared, whoever asks: read with what its file states, and checked against it.

The rate that a file states counts before the configuration, which may be that of another export;
the table of a folder, which names the file, counts before both. The columns of a contact, a coil
and a motor are those that go with the travel (``contact_columns``). Those of the configuration are
of the configured travel, and of another travel of the file that has none of its own.
"""

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from math import isfinite, isnan
from pathlib import Path

from breaker.common.numerals import in_digits
from breaker.records.dates import one_date
from breaker.records.files import Files, Opened, printable
from breaker.records.formats.registry import read_columns
from breaker.records.header import Preamble
from breaker.records.layout import look_into, stated_in
from breaker.records.operations import Operation
from breaker.records.record import Raw
from breaker.records.rejections import UnusableError
from breaker.records.settings import FORMAT, complete
from breaker.records.words import MOTION_OF, holds

# Of ``endurance.format``, that go with a travel.
_WITH = {"contact_column", "current_column", "trigger_column", "motor_column"}
_RATES, _LENGTHS = 0.01, 0.02  # shares, by which rates and lengths of a record may differ


@dataclass(frozen=True, eq=False)
class Prepared:
    """The preparation of records: see ``raw_record.Preparation``.

    Attributes:
        settings: The section ``endurance.format`` of the configuration; what it lacks has its
            default.
        files: In which the files are opened.
    """

    settings: Mapping
    files: Files = field(default_factory=Files)
    _stated: dict[str | Path, Preamble] = field(default_factory=dict)

    def stated(self, operation: Operation) -> Preamble:
        """Return what stands above the samples of an operation's file."""
        file = operation.file
        if file not in self._stated:
            settings = {**self.settings, **operation.settings}
            self._stated[file] = stated_in(self.files[file], settings, operation.channel)
        return self._stated[file]

    def told(self, operation: Operation, motion: str) -> Operation:
        """Return an operation with its one date, and settings that its file has and its row not."""
        form = {**FORMAT, **self.settings, **operation.settings}
        stated = self.stated(operation)
        told = _columns_with(operation, motion, self.files[operation.file], form)
        if form["rate"] is form["time_column"] is None and isfinite(stated.rate):
            told["rate"] = stated.rate
        when = one_date(operation.date, stated.dates, operation.file)
        if not told and when == operation.date:
            return operation
        return replace(operation, date=when, settings={**operation.settings, **told})

    def checked(self, raw: Raw, row: Operation) -> Raw:
        """Return a record with what is to be said of it.

        Args:
            row: The operation, without what its file tells.

        Raises:
            UnusableError: If its file states another rate than that of the configuration, or
                another motion.
        """
        told, said = raw.operation.settings.keys() - row.settings.keys(), []
        if "rate" in told:
            rate = in_digits(1.0 / raw.step, 4)
            said = [f"the rate, {rate} kHz, is the one that the file states"]
        if "contact_column" in told:
            said += ["the contact is in the column that goes with the travel: see breaker inspect"]
        warning = _against(raw, self.stated(row))
        return replace(raw, said=(*raw.said, *said), warning=warning)


def _columns_with(operation: Operation, motion: str, opened: Opened, form: Mapping) -> dict:
    """The columns that go with a travel in a motion, where neither a row nor settings name them."""
    usual, open_keys = form["travel_column"], _WITH - operation.settings.keys()
    column = operation.channel or usual
    if column == usual:
        open_keys = {key for key in open_keys if form[key] is None}
    with suppress(ValueError):  # what cannot be read so is rejected, with the reason
        if not open_keys:
            return {}
        columns = read_columns(opened, complete(form), operation.channel)
        names = columns.sheet.names
        if len(names) < 2 + (form["time_column"] is not None):
            return {}  # most files: nothing is beside the travel
        kinds = "motor", "current"
        named = not any(names) or any(holds(each, kind) for each in names for kind in kinds)
        if open_keys <= {"current_column", "motor_column"} and not named:
            return {}  # contact and coil are named, and there is no other current
        # Here, as most files need neither, and an answer comes in a third of a second.
        from breaker.records.contact_columns import Beside, current_of
        from breaker.records.description import travel_channels

        layout = look_into(opened)
        place, own = layout.place_of(column), layout.place_of(usual)
        if place is None:
            return {}
        _, beside = travel_channels(opened).get(str(layout.column(place)), ("", {}))
        found = beside.get(motion, Beside()).settings
        other = own is not None and place != own
        if not other and form["contact_column"] is not None:
            contact = layout.place_of(form["contact_column"])
            current = [] if contact is None else current_of(layout, contact)
            found = {k: v for k, v in found.items() if k != "current_column"}
            found |= {"current_column": layout.column(current[0])} if current else {}
        return {k: v for k, v in found.items() if k in open_keys and (other or form[k] is None)}
    return {}


def _against(raw: Raw, stated: Preamble) -> str:
    """Return a warning where a file states another rate or length than a record has; else nothing.

    Raises:
        UnusableError: If the rate of the configuration is not the stated one, or the motion is not.
    """
    motions = {MOTION_OF[letter] for letter in stated.operation.split("-") if letter}
    if motions and raw.motion not in motions:
        (other,) = motions
        raise UnusableError(
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
            raise UnusableError(
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
