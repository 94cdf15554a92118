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
    check_unit,
    label_of,
    place_of,
    places_of,
    split_unit,
    unit_of,
    wanted_columns,
)


class LayoutError(RejectedCurveError):
    """A file in which no columns of numbers are found."""


class Table(Sequence):
    """Columns of numbers, each ``(t,)``, NaN where a sample is missing: as float64, whatever holds
    them.
    """

    odd_widths: Mapping[int, str] = {}
    """Why lines have too many cells, by line."""

    def __init__(self, columns: Sequence[np.ndarray]) -> None:
        self._columns = columns

    def __len__(self) -> int:
        return len(self._columns)

    def __getitem__(self, place: int | slice) -> np.ndarray | list[np.ndarray]:
        if isinstance(place, slice):
            return self.numbers(range(len(self))[place])
        return np.asarray(self._columns[place], dtype=float)

    @property
    def lines(self) -> np.ndarray:
        """Line of each sample in the file, or its number where it has no lines, ``(t,)``."""
        return np.arange(1, len(self._columns[0]) + 1)

    @property
    def nbytes(self) -> int:
        """Bytes that it takes."""
        return sum(column.nbytes for column in self._columns)

    def numbers(self, places: Iterable[int]) -> list[np.ndarray]:
        """Return some columns, also what is beyond any reading."""
        return [np.asarray(self._columns[place], dtype=float) for place in places]

    def wrong(self, place: int) -> Mapping[int, str]:
        """Return what is no number in a column, by its place among the samples."""
        return {}

    def present(self, place: int) -> np.ndarray:
        """Say whether a line is long enough to have a cell of a column, ``(t,)``."""
        return np.ones(len(self.lines), bool)


@dataclass(frozen=True, eq=False)
class Sheet:
    """A table of samples, with what stands above it.

    Attributes:
        file: The file.
        names: Name of each column, empty where it has none.
        columns: Numbers of each column, ``(t,)``, NaN where a cell is empty or no number: a
            ``Table``, or arrays. Those of a text are read from its cells when they are asked for.
        texts: Unit of each column as it stands in the file, apart from its name; empty where there
            is none.
        preamble: Cells of the lines above the samples, but for names and units.
        settings: What is known of ``endurance.format``, by key.
        clock: Place of the column that the format itself knows to be the time; it is the time where
            no column has the name that settings have for it.
        named: Line of the names, and that of the units; None where there is none.
        remarks: What is doubtful about the file, in words.
        notes: What is doubtful about a column, by its place.
        kind: What messages call the file.
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
        if not isinstance(self.columns, Table):
            object.__setattr__(self, "columns", Table(self.columns))

    @property
    def nbytes(self) -> int:
        """Bytes of its columns."""
        return self.columns.nbytes

    @cached_property
    def units(self) -> list[str | None]:
        """Unit of each column as the settings call it; None where none is known."""
        texts = [*self.texts, *[""] * len(self.names)]
        pairs = zip(self.names, texts, strict=False)
        return [unit_of(text) if text else split_unit(name)[1] for name, text in pairs]

    @cached_property
    def stated(self) -> Header:
        """What the lines above the samples say."""
        return header_of(self.preamble, self.settings.get("decimal", "."), self.columns[0].size)

    @cached_property
    def _bare(self) -> list[str]:
        return [split_unit(name)[0] for name in self.names]

    def column(self, place: int) -> str | int:
        """Return how settings name a column: without its unit if possible, or by its number."""
        for names in (self._bare, self.names):
            if names[place] and names.count(names[place]) == 1:
                return names[place]
        return place + 1

    def place_of(self, column: str | int) -> int | None:
        """Return the place of a column that settings name; None where it is not one."""
        words = (column, split_unit(column)[0]) if isinstance(column, str) else (column,)
        found = (places for word in words if (places := places_of(self.names, word)))
        number = [int(column) - 1] if str(column).isdecimal() else []
        return next((places[0] for places in (*found, number) if len(places) == 1), None)

    def text(self, place: int) -> str:
        """Return the unit of a column as it stands apart from the name; empty if it does not."""
        return self.texts[place] if place < len(self.texts) else ""


@dataclass(frozen=True, eq=False)
class Columns:
    """The columns of a record.

    Attributes:
        time: Times, ``(t,)``; None where the file has none.
        travel: Readings, ``(t,)``, NaN where one is missing.
        lines: Line of each in the file, ``(t,)``.
        remarks: What is doubtful about the file, in words.
        beside: Those of ``words.BESIDE`` that are wanted, by kind, ``(t,)``, NaN where missing.
        amperes: That one of the unit of these is; nan where it is no current.
        sheet: All that stands in the file.
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
        """What the lines above the samples say."""
        decimal = self.sheet.settings.get("decimal", ".")
        return header_of(self.sheet.preamble, decimal, self.travel.size)


def columns_of(sheet: Sheet, settings: Mapping) -> Columns:
    """Return the columns of a record in a sheet.

    Args:
        settings: The section ``endurance.format``, complete.

    Raises:
        RejectedCurveError: If a column is not there, states another unit, or has a cell that is no
            number or beyond any reading; without a time column also if a line between its samples
            is blank.
    """
    file = sheet.file
    wanted = wanted_columns([sheet.names], settings)
    places, remarks = _places(sheet, wanted, settings)
    labels = {kind: label_of(wanted.get(kind, "the time")) for kind in places}
    for kind in [kind for kind in places if kind not in BESIDE]:
        text, at = sheet.text(places[kind]), 1
        if not text:
            text, at = split_unit(sheet.names[places[kind]])[1] or "", 0
        remarks += check_unit(file, (kind, labels[kind]), text, settings, sheet.named[at])
    remarks += tuple(sheet.notes[place] for place in places.values() if place in sheet.notes)
    columns = _numbers(sheet, places, labels)
    lines, travel = sheet.columns.lines, columns["travel"]
    check_size(file, travel.size, len(places))
    there = np.flatnonzero(~np.isnan(travel))
    if there.size == 0:
        raise RejectedCurveError(file, f"{labels['travel']} has no samples")
    # Channels may differ in length: blanks at the end are its end, no missing samples.
    kept = np.arange(there[-1] + 1)
    if "time" in columns:
        kept = np.flatnonzero(~np.isnan(columns["time"][: kept.size]))
    else:
        kept = kept[sheet.columns.present(places["travel"])[: kept.size]]
        if (gaps := np.flatnonzero(np.diff(lines[kept]) > 1)).size:
            reason = (
                "stands before a line that is blank, a remark or too short; without a time column "
                "nobody knows whether it stands for a sample: delete or mend it"
            )
            raise RejectedCurveError(file, reason, line=int(lines[kept][gaps[0]]))
    return Columns(
        time=columns["time"][kept] if "time" in columns else None,
        travel=travel[kept],
        lines=lines[kept],
        remarks=(*sheet.remarks, *remarks),
        beside={kind: columns[kind][kept] for kind in BESIDE if kind in columns},
        amperes={
            kind: amperes_of(sheet.names[place], sheet.text(place))
            for kind, place in places.items()
            if kind in BESIDE
        },
        sheet=sheet,
    )


def _places(
    sheet: Sheet, wanted: Mapping[str, str | int], settings: Mapping
) -> tuple[dict[str, int], tuple[str, ...]]:
    """The places of the columns, and a remark where a rate stands for that of the time."""
    places, names, remarks = {}, sheet.names, ()
    for kind, column in wanted.items():
        missing = kind == "time" and isinstance(column, str) and not places_of(names, column)
        if missing and sheet.clock is not None:
            continue
        if missing and settings["rate"]:
            rate = in_digits(settings["rate"], 6)
            remarks = (f"there is no column {column!r}: times are those of the rate, {rate} kHz",)
            continue
        places[kind] = place_of(sheet.file, names, column, line=sheet.named[0])
    if sheet.clock is not None:
        places.setdefault("time", sheet.clock)
    return places, remarks


def _numbers(
    sheet: Sheet, places: Mapping[str, int], labels: Mapping[str, str]
) -> dict[str, np.ndarray]:
    """The columns by kind, ``(t,)``.

    Raises:
        RejectedCurveError: Of the first line, or sample, with what is no number or no reading.
    """
    table = sheet.columns
    columns = dict(zip(places, table.numbers(places.values()), strict=True))
    wrong = dict(table.odd_widths)
    for kind, values in columns.items():
        faults, most = dict(table.wrong(places[kind])), LARGEST_NUMBER[kind]
        if (beyond := np.flatnonzero(np.abs(values) > most)).size:
            shown = f"{values[beyond[0]]:.6g}, which is no reading: it is beyond {most:.0e}"
            faults.setdefault(int(beyond[0]), shown)
        if faults:
            row = min(faults)
            wrong.setdefault(int(table.lines[row]), f"{labels[kind]} is {faults[row]}")
    if wrong:
        line = min(wrong)
        raise RejectedCurveError(sheet.file, wrong[line], line=line)
    return columns
