"""A table of samples as it stands in a file of any format, and the columns of a record in it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

import numpy as np

from breaker.records import words
from breaker.records.cells import LARGEST_NUMBER
from breaker.records.files import RejectedCurveError
from breaker.records.header import Header, header_of

EVERY = -1  # place in ``Sheet.wrong`` of an error in every column


@dataclass(frozen=True, eq=False)
class Sheet:
    """Table of samples, with the lines above it.

    Attributes:
        file: Name of the file.
        names: Name of each column, empty for a column without a name.
        columns: Numbers of each column, ``(t,)``, NaN where a sample is missing.
        texts: Unit of each column as stated in the file separately from its name, or "".
        preamble: Cells of the lines above the samples, without names and units.
        settings: Known settings of ``endurance.format``, by key.
        clock: Place of the column that the format itself states as the time; used if no column has
            the name in the settings.
        remarks: Doubts about the file, in words.
        kind: Name of this kind of file in messages.
        lines: Line of each sample in the file, ``(t,)``; its number if the file has no lines.
        wrong: Line and text of the first cell of a column that is not a number, by place.
        header: Contents of the preamble, where they are known.
    """

    file: Path
    names: Sequence[str]
    columns: Sequence[np.ndarray]
    texts: Sequence[str] = ()
    preamble: Sequence[Sequence[str]] = ()
    settings: Mapping = field(default_factory=dict)
    clock: int | None = None
    remarks: tuple[str, ...] = ()
    kind: str = "a text"
    lines: np.ndarray | None = None
    wrong: Mapping[int, tuple[int, str]] = field(default_factory=dict)
    header: Header | None = None

    def __post_init__(self) -> None:
        columns = [np.asarray(column, dtype=float) for column in self.columns]
        object.__setattr__(self, "file", Path(self.file))
        object.__setattr__(self, "columns", columns)
        texts = [*self.texts, *[""] * len(self.names)][: len(self.names)]
        object.__setattr__(self, "texts", texts)
        if self.lines is None and columns:
            object.__setattr__(self, "lines", np.arange(1, columns[0].size + 1))

    @cached_property
    def units(self) -> list[str | None]:
        """Unit of each column as the settings name it; None if unknown."""
        pairs = zip(self.names, self.texts, strict=True)
        return [words.unit_of(text) if text else words.split_unit(name)[1] for name, text in pairs]

    @cached_property
    def stated(self) -> Header:
        """Contents of the lines above the samples."""
        return self.header or header_of(self.preamble, self.lines.size)

    def column(self, place: int) -> str | int:
        """Return the name of a column, if possible without its unit, or else its number."""
        for names in ([words.split_unit(name)[0] for name in self.names], self.names):
            if names[place] and names.count(names[place]) == 1:
                return names[place]
        return place + 1

    def place_of(self, column: str | int) -> int | None:
        """Return the place of a column that settings name; None if it is not unique."""
        places = words.places_of(self.names, column)
        if not places and isinstance(column, str):
            places = words.places_of(self.names, words.split_unit(column)[0])
        if len(places) != 1 and str(column).isdecimal():
            places = [int(column) - 1]
        return places[0] if len(places) == 1 else None


@dataclass(frozen=True, eq=False)
class Columns:
    """Columns of a record.

    Attributes:
        time: Times, ``(t,)``; None if the file has no times.
        travel: Readings, ``(t,)``, NaN where a sample is missing.
        lines: Line of each sample in the file, ``(t,)``.
        remarks: Doubts about the file, in words.
        paired: Wanted columns of ``words.BESIDE``, by kind, ``(t,)``, NaN where missing.
        sizes: Amperes (microohms for a contact) of one unit of a paired column; nan for other
            units.
        sheet: Entire table of the file.
    """

    time: np.ndarray | None
    travel: np.ndarray
    lines: np.ndarray
    remarks: tuple[str, ...]
    paired: Mapping[str, np.ndarray]
    sizes: Mapping[str, float]
    sheet: Sheet


def columns_of(sheet: Sheet, settings: Mapping) -> Columns:
    """Return the columns of a record in a sheet.

    Args:
        settings: The section ``endurance.format``, complete.

    Raises:
        RejectedCurveError: If a column does not exist, states another unit, or has an impossible
            number; without a time column also if a line between its samples is blank.
    """
    wanted = words.wanted_columns(sheet.names, settings)
    places, remarks = _places(sheet, wanted), ()
    used = [*places.items(), ("", EVERY)]
    if wrong := [(*sheet.wrong[place], kind) for kind, place in used if place in sheet.wrong]:
        line, reason, kind = min(wrong)
        label = words.label_of(wanted.get(kind, "the time"))
        raise RejectedCurveError(sheet.file, f"{label} {reason}" if kind else reason, line=line)
    columns = {}
    for kind, place in places.items():
        label, values = words.label_of(wanted.get(kind, "the time")), sheet.columns[place]
        if kind not in words.BESIDE:
            remarks += _unit_remarks(sheet, kind, place, label, settings)
        if (beyond := np.flatnonzero(np.abs(values) > LARGEST_NUMBER[kind])).size:
            reason = f"{label} is {values[beyond[0]]:.6g}, which is not a reading; export it again"
            raise RejectedCurveError(sheet.file, reason, line=int(sheet.lines[beyond[0]]))
        columns[kind] = values
    travel, time = columns.pop("travel"), columns.pop("time", None)
    there = np.flatnonzero(~np.isnan(travel))
    if there.size == 0:
        raise RejectedCurveError(sheet.file, f"{words.label_of(wanted['travel'])} has no samples")
    # Channels may differ in length: blanks at the end are not missing samples.
    kept = np.arange(there[-1] + 1)
    if time is not None:
        kept = np.flatnonzero(~np.isnan(time[: kept.size]))
    elif (gaps := np.flatnonzero(np.diff(sheet.lines[kept]) > 1)).size:
        reason = (
            "stands before a line that is blank, a remark or too short; without a time column "
            "it is unknown whether this line is a sample: delete or correct the line"
        )
        raise RejectedCurveError(sheet.file, reason, line=int(sheet.lines[gaps[0]]))
    labels = {kind: (sheet.names[places[kind]], sheet.texts[places[kind]]) for kind in columns}
    size_of = {kind: words.amperes_of for kind in columns} | {"contact": words.microohms_of}
    sizes = {kind: size_of[kind](*label) for kind, label in labels.items()}
    return Columns(
        time=None if time is None else time[kept],
        travel=travel[kept],
        lines=sheet.lines[kept],
        remarks=(*sheet.remarks, *remarks),
        paired={kind: values[kept] for kind, values in columns.items()},
        sizes=sizes,
        sheet=sheet,
    )


def _places(sheet: Sheet, wanted: Mapping[str, str | int]) -> dict[str, int]:
    """Return the places of the wanted columns by kind; the format itself may state the clock."""
    places = {} if sheet.clock is None else {"time": sheet.clock}
    for kind, column in wanted.items():
        named = words.places_of(sheet.names, column)
        if len(named) == 1:
            places[kind] = named[0]
        elif named or kind not in places or isinstance(column, int):
            names = ", ".join(repr(name.strip()[:40]) for name in sheet.names[:40] if name)
            many = "more than one" if named else "no"
            reason = f"{many} column {column!r} among {names}; give its number, from 1, instead"
            null = ", or null and a rate" if kind == "time" else ""
            raise RejectedCurveError(sheet.file, f"{reason}{null}")
    return places


def _unit_remarks(
    sheet: Sheet, kind: str, place: int, label: str, settings: Mapping
) -> tuple[str, ...]:
    """Reject a unit that differs from the settings; return a remark on an unknown unit."""
    text = sheet.texts[place] or words.split_unit(sheet.names[place])[1] or ""
    unit, stated = settings[f"{kind}_unit"], words.unit_of(text)
    reason = f"the unit of {label} is {text!r}, but endurance.format.{kind}_unit is {unit!r}"
    if stated and stated != unit:
        raise RejectedCurveError(sheet.file, reason)
    return (f"{reason}: that of the file is not known",) if text and not stated else ()
