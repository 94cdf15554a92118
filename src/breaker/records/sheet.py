"""A table of samples as it stands in a file of any format, and the columns of a record in it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

from breaker.common.lazy_numpy import np
from breaker.common.numerals import in_digits
from breaker.records.cells import LARGEST_NUMBER
from breaker.records.files import RejectedCurveError, check_size
from breaker.records.header import Header, header_of
from breaker.records.words import (
    BESIDE,
    amperes_of,
    label_of,
    listed,
    places_of,
    split_unit,
    unit_of,
    wanted_columns,
)


class LayoutError(RejectedCurveError):
    """A file in which no columns of numbers are found."""


class Table(Sequence):
    """Columns of numbers, each ``(t,)``, NaN where a sample is missing."""

    odd_widths: Mapping[int, str] = {}
    """Why lines have too many cells, by line."""

    def __init__(self, columns: Sequence[np.ndarray], lines: np.ndarray | None = None) -> None:
        self._columns, self._lines = columns, lines

    def __len__(self) -> int:
        return len(self._columns)

    def __getitem__(self, place: int | slice) -> np.ndarray | list[np.ndarray]:
        if isinstance(place, slice):
            return [self[i] for i in range(len(self))[place]]
        return self.numbers([range(len(self))[place]])[0]

    @property
    def lines(self) -> np.ndarray:
        """Line of each sample in the file, or its number where it has no lines, ``(t,)``."""
        count = len(self._columns[0])
        return np.arange(1, count + 1) if self._lines is None else self._lines

    @property
    def nbytes(self) -> int:
        """Bytes of the columns."""
        return sum(column.nbytes for column in self._columns)

    def numbers(self, places: Iterable[int]) -> list[np.ndarray]:
        """Return columns, however large their numbers are."""
        return [np.asarray(self._columns[place], dtype=float) for place in places]

    def wrong(self, place: int) -> Mapping[int, str]:
        """Return what is not a number in a column, by its place among the samples."""
        return {}

    def present(self, place: int) -> np.ndarray:
        """Return whether lines have a cell of a column, ``(t,)``."""
        return np.ones(len(self.lines), bool)


@dataclass(frozen=True, eq=False)
class Sheet:
    """A table of samples, with what stands above it.

    Attributes:
        file: Name of the file.
        names: Name of each column, empty where it has none.
        columns: Numbers of each column, ``(t,)``, NaN where a cell is empty or not a number: arrays
            or a ``Table``.
        texts: Unit of each column as it stands in the file, apart from its name, or "".
        preamble: Cells of the lines above the samples, without names and units.
        settings: Known settings of ``endurance.format``, by key.
        clock: Place of the column that the format itself knows to be the time; it is the time where
            no column has the name that settings have for it.
        named: Line of the names, and that of the units; None where there is none.
        remarks: Doubts about the file, in words.
        notes: Doubts about a column, by its place.
        kind: Name of this kind of file in messages.
    """

    file: Path
    names: Sequence[str]
    columns: Sequence[np.ndarray]
    texts: Sequence[str] = ()
    preamble: Sequence[Sequence[str]] = ()
    settings: Mapping = field(default_factory=dict)
    clock: int | None = None
    named: tuple[int | None, int | None] = (None, None)
    remarks: tuple[str, ...] = ()
    notes: Mapping[int, str] = field(default_factory=dict)
    kind: str = "a text"

    def __post_init__(self) -> None:
        object.__setattr__(self, "file", Path(self.file))
        texts = [*self.texts, *[""] * len(self.names)][: len(self.names)]
        object.__setattr__(self, "texts", texts)
        if not isinstance(self.columns, Table):
            object.__setattr__(self, "columns", Table(self.columns))

    @property
    def nbytes(self) -> int:
        """Bytes of its columns."""
        return self.columns.nbytes

    @cached_property
    def units(self) -> list[str | None]:
        """Unit of each column as the settings call it; None where none is known."""
        pairs = zip(self.names, self.texts, strict=True)
        return [unit_of(text) if text else split_unit(name)[1] for name, text in pairs]

    @cached_property
    def stated(self) -> Header:
        """Contents of the lines above the samples."""
        return header_of(self.preamble, self.settings.get("decimal", "."), self.columns[0].size)

    def column(self, place: int) -> str | int:
        """Return the name of a column, if possible without its unit, or its number."""
        for names in ([split_unit(name)[0] for name in self.names], self.names):
            if names[place] and names.count(names[place]) == 1:
                return names[place]
        return place + 1

    def place_of(self, column: str | int) -> int | None:
        """Return the place of a column that settings name; None where it is not one."""
        places = places_of(self.names, column)
        if not places and isinstance(column, str):
            places = places_of(self.names, split_unit(column)[0])
        if len(places) != 1 and str(column).isdecimal():
            places = [int(column) - 1]
        return places[0] if len(places) == 1 else None


@dataclass(frozen=True, eq=False)
class Columns:
    """The columns of a record.

    Attributes:
        time: Times, ``(t,)``; None where the file has none.
        travel: Readings, ``(t,)``, NaN where one is missing.
        lines: Line of each in the file, ``(t,)``.
        remarks: Doubts about the file, in words.
        beside: Columns of ``words.BESIDE`` that are wanted, by kind, ``(t,)``, NaN where missing.
        amperes: Amperes of the unit of each of these; nan where it is not a current.
        sheet: Everything in the file.
    """

    time: np.ndarray | None
    travel: np.ndarray
    lines: np.ndarray
    remarks: tuple[str, ...]
    beside: Mapping[str, np.ndarray]
    amperes: Mapping[str, float]
    sheet: Sheet

    @property
    def nbytes(self) -> int:
        """Bytes of its arrays, and of the sheet."""
        arrays = (self.time, self.travel, self.lines, *self.beside.values())
        return self.sheet.nbytes + sum(array.nbytes for array in arrays if array is not None)

    @cached_property
    def stated(self) -> Header:
        """Contents of the lines above the samples."""
        decimal = self.sheet.settings.get("decimal", ".")
        return header_of(self.sheet.preamble, decimal, self.travel.size)


def columns_of(sheet: Sheet, settings: Mapping) -> Columns:
    """Return the columns of a record in a sheet.

    Args:
        settings: The section ``endurance.format``, complete.

    Raises:
        RejectedCurveError: If a column is not there, states another unit, or has a cell that is not
            a number or not a reading; without a time column also if a line between its samples is
            blank.
    """
    wanted = wanted_columns([sheet.names], settings)
    places, remarks = _places(sheet, wanted, settings)
    labels = {kind: label_of(wanted.get(kind, "the time")) for kind in places}
    for kind, place in places.items():
        remarks += () if kind in BESIDE else _unit_remarks(sheet, kind, place, labels, settings)
        remarks += (sheet.notes[place],) if place in sheet.notes else ()
    columns = _numbers(sheet, places, labels)
    travel = columns.pop("travel")
    check_size(sheet.file, travel.size, len(places))
    there = np.flatnonzero(~np.isnan(travel))
    if there.size == 0:
        raise RejectedCurveError(sheet.file, f"{labels['travel']} has no samples")
    # Channels may differ in length: blanks at the end are its end, not missing samples.
    lines, kept, time = sheet.columns.lines, np.arange(there[-1] + 1), columns.pop("time", None)
    if time is not None:
        kept = np.flatnonzero(~np.isnan(time[: kept.size]))
    else:
        kept = kept[sheet.columns.present(places["travel"])[: kept.size]]
        if (gaps := np.flatnonzero(np.diff(lines[kept]) > 1)).size:
            reason = (
                "stands before a line that is blank, a remark or too short; without a time column "
                "nobody knows whether it stands for a sample: delete or mend it"
            )
            raise RejectedCurveError(sheet.file, reason, line=int(lines[kept][gaps[0]]))
    return Columns(
        time=None if time is None else time[kept],
        travel=travel[kept],
        lines=lines[kept],
        remarks=(*sheet.remarks, *remarks),
        beside={kind: values[kept] for kind, values in columns.items()},
        amperes={k: amperes_of(sheet.names[places[k]], sheet.texts[places[k]]) for k in columns},
        sheet=sheet,
    )


def _places(
    sheet: Sheet, wanted: Mapping[str, str | int], settings: Mapping
) -> tuple[dict[str, int], tuple[str, ...]]:
    """The places of the columns, and a remark where a rate stands for that of the time."""
    places, remarks = {}, ()
    for kind, column in wanted.items():
        found = places_of(sheet.names, column)
        if not found and kind == "time" and isinstance(column, str):
            if sheet.clock is not None:
                continue
            if settings["rate"]:
                rate = in_digits(settings["rate"], 6)
                said = f"there is no column {column!r}: times are those of the rate, {rate} kHz"
                remarks = (said,)
                continue
        if len(found) != 1:
            numbers = " or ".join(str(place + 1) for place in found)
            reason = f"no column {column!r} among {listed(sheet.names)}; see endurance.format"
            if found:
                reason = f"more than one column {column!r}; give its number, {numbers}, instead"
            raise RejectedCurveError(sheet.file, reason, line=sheet.named[0])
        places[kind] = found[0]
    if sheet.clock is not None:
        places.setdefault("time", sheet.clock)
    return places, remarks


def _unit_remarks(
    sheet: Sheet, kind: str, place: int, labels: Mapping[str, str], settings: Mapping
) -> tuple[str, ...]:
    """Refuse another unit than that of the settings; remark on one that is not known."""
    text, line = sheet.texts[place], sheet.named[1]
    if not text:
        text, line = split_unit(sheet.names[place])[1] or "", sheet.named[0]
    known, stated = f"the unit of {labels[kind]} is {text!r}", unit_of(text)
    but = f"endurance.format.{kind}_unit is {settings[f'{kind}_unit']!r}"
    if stated and stated != settings[f"{kind}_unit"]:
        raise RejectedCurveError(sheet.file, f"{known}, but {but}", line=line)
    return (f"{known}, which is not known; {but}",) if text and not stated else ()


def _numbers(
    sheet: Sheet, places: Mapping[str, int], labels: Mapping[str, str]
) -> dict[str, np.ndarray]:
    """The columns by kind, ``(t,)``; the first line that has a false cell is refused."""
    table = sheet.columns
    columns = dict(zip(places, table.numbers(places.values()), strict=True))
    wrong = dict(table.odd_widths)
    for kind, values in columns.items():
        faults, most = dict(table.wrong(places[kind])), LARGEST_NUMBER[kind]
        if (beyond := np.flatnonzero(np.abs(values) > most)).size:
            shown = f"{values[beyond[0]]:.6g}, which is not a reading: it is beyond {most:.0e}"
            faults.setdefault(int(beyond[0]), shown)
        if faults:
            row = min(faults)
            wrong.setdefault(int(table.lines[row]), f"{labels[kind]} is {faults[row]}")
    if wrong:
        raise RejectedCurveError(sheet.file, wrong[min(wrong)], line=min(wrong))
    return columns
