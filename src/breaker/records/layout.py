"""What is in a file of any kind, before anything is known of it: columns, their names and units.

Guessing belongs here, to propose settings that are then shown and confirmed by reading. Records are
read with explicit settings only. Workbooks, COMTRADE and labelled arrays say themselves what texts
leave to guess: their encoding, delimiter and decimal sign. The size of a table is bounded before
its cells are built, and the head is guessed from the first lines and some of the others: a file may
hold anything.
"""

import io
import re
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cache, cached_property
from itertools import islice, pairwise, zip_longest
from pathlib import Path

import numpy as np

from breaker.records.cells import (
    LARGEST_NUMBER,
    MISSING,
    Lines,
    cells_of,
    is_number,
    strict_numbers,
)
from breaker.records.files import (
    MOST_COLUMNS,
    Opened,
    RejectedCurveError,
    as_opened,
    check_lines,
    check_size,
)
from breaker.records.formats.registry import format_of, is_text, kind_in, read_columns, understood
from breaker.records.header import Preamble, preamble_of
from breaker.records.lexicon import WORDS
from breaker.records.settings import FORMAT, complete
from breaker.records.sheet import Labelled
from breaker.records.words import any_of, places_of, split_unit, unit_of

_SAMPLE = 1_000  # lines from which the kinds of columns are guessed
_ABOVE = (10_000, 2**20)  # first lines, and signs, among which samples begin; reading looks there
_FIRST = 200  # lines, among which samples begin in most files
_BLOCK = 2_000  # lines, of which cells are built at a time
_TOGETHER = 5  # lines in a row that look like samples: there samples begin
_LONGEST_NAME = 60  # signs; no number is longer either
_VALUE = re.compile(r"[-+]?\d+(?:[.,]\d+)?\s*\S{0,5}|.*[:=]")  # "10 kHz", "Rate:": of no column

_CODES = ("gb18030", "cp1252", "shift_jis", "euc_kr", "cp1251", "cp1250")
_WORDS = re.compile(any_of(WORDS["telling"]))
_FOREIGN = re.compile(r"[^\x00-\x7f°µ²³±·½×ßäöüÄÖÜéèêëàâçîïôûñáíóúãõÉÀ–’]|[^\x00-\x7f]{2}")
_PADDED = re.compile(r"0\d+")
_DELIMITERS = (";", "\t", "|", ",", " ")  # in case of doubt, the first that fits
_LOOKED_AT = (200, 100_000)  # lines, and signs, from which the delimiter is guessed
_TELLING = (1_000, 2**14)  # lines, and bytes, from which an encoding is guessed
_LONGEST_LINE = 100_000  # signs; reading takes no longer ones


class LayoutError(ValueError):
    """A file in which no columns of numbers are found."""


@dataclass(frozen=True)
class Layout:
    """What is in a file.

    Attributes:
        settings: What was guessed of ``endurance.format``, by key.
        preamble: Cells of the lines before the samples, but for names and units.
        names: Name of each column, empty where it has none.
        units: Unit of each column as the settings call it; None where none is known.
        columns: Numbers of each column, ``(t,)``, NaN where a cell is empty or no number.
        kind: What kind of file it is.
        file: The file.
    """

    settings: dict
    preamble: list[list[str]]
    names: list[str]
    units: list[str | None]
    columns: list[np.ndarray]
    kind: str = "a text"
    file: Path = Path()

    @property
    def nbytes(self) -> int:
        """Bytes of its columns."""
        return sum(each.nbytes for each in self.columns)

    @cached_property
    def stated(self) -> Preamble:
        """What the lines before the samples say."""
        decimal = self.settings.get("decimal", ".")
        return preamble_of(self.preamble, decimal, self.columns[0].size)

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
        found = (places for each in words if (places := places_of(self.names, each)))
        number = [int(column) - 1] if str(column).isdecimal() else []
        return next((places[0] for places in (*found, number) if len(places) == 1), None)


def layout_of_lines(
    file: str | Path, lines: Sequence[str], settings: Mapping, delimiter: str
) -> Layout:
    """Guess the head and the columns of a table from its lines, the sign between their cells, and
    settings: ``decimal``, and what else of them is known.

    Raises:
        LayoutError: If there are no columns of numbers.
        RejectedCurveError: If there are more columns or samples than a record has.
    """
    for number, line in enumerate(lines, start=1):
        if line.count(delimiter) >= MOST_COLUMNS:
            check_size(file, 1, len(cells_of(line, delimiter)), line=number)
    first, numeric = _first_sample(file, lines, delimiter, settings["decimal"])
    width = len(numeric)
    above = [cells_of(line, delimiter) for line in lines[:first]]
    samples = _filled(lines[first:], delimiter)
    check_size(file, len(samples), width)
    columns = _numbers(samples, delimiter, settings["decimal"], numeric)
    named, units_at = _head(above, width)
    names = [] if named is None else [above[named][0].lstrip("#%! "), *above[named][1:]]
    units = [split_unit(name)[1] for name in names]
    if units_at is not None:
        units = list(map(unit_of, above[units_at]))
    # Blanks that separate columns are those between the words of a text, too.
    texts = [[line.strip()] for line in lines[:first]] if delimiter == " " else above
    rest = [row for i, row in enumerate(texts) if i not in (named, units_at)]
    return Layout(
        settings=dict(settings),
        preamble=rest,
        names=[*names, *[""] * width][:width],
        units=[*units, *[None] * width][:width],
        columns=columns,
        file=Path(file),
    )


def _numbers(
    lines: Sequence[str], delimiter: str, decimal: str, numeric: Sequence[bool]
) -> list[np.ndarray]:
    """Numbers of each column, ``(t,)``, NaN where a cell is empty or no number, and in all of a
    column that is not numeric.
    """
    columns = np.full((len(numeric), len(lines)), np.nan)
    for begin in range(0, len(lines), _BLOCK):
        block = lines[begin : begin + _BLOCK]
        rows = Lines(block, range(len(block)), delimiter)
        alike = rows.columns(0, len(numeric))  # in a third of the time, where lines are
        cells_in = rows[:] if alike is None else []
        for place in np.flatnonzero(numeric):
            odd = (row[place] if place < len(row) else "" for row in cells_in)
            cells = list(odd) if alike is None else alike[place]
            values, _ = strict_numbers(cells, decimal, LARGEST_NUMBER["time"])
            columns[place, begin : begin + len(block)] = values
    return list(columns)


def _filled(lines: Iterable[str], delimiter: str) -> list[str]:
    """Lines with a cell that is not empty."""
    blank = f'{delimiter}" \t\v\f\n'
    return [line for line in lines if line.strip(blank)]


def _first_sample(
    file: str | Path, lines: Sequence[str], delimiter: str, decimal: str
) -> tuple[int, list[bool]]:
    """Line, from 0, of the first sample, and for each column whether it has numbers.

    Raises:
        LayoutError: If no column has numbers.
    """

    kinds = Kinds(decimal)

    @cache  # of a short file, all lines are looked at twice
    def kinds_in(line: str) -> list[int]:
        return [kinds[cell] for cell in cells_of(line, delimiter)]

    body = _filled(lines[len(lines) // 5 :], delimiter)
    body = list(filter(any, map(kinds_in, body[:: max(1, len(body) // _SAMPLE)])))
    columns = list(zip_longest(*body, fillvalue=0))
    numeric = [i for i, kind in enumerate(columns) if kind.count(1) > 3 * kind.count(-1)]
    usual = np.median([row.count(1) for row in body]) if body else 0
    top = lines[: _ABOVE[0]]
    most = 1 + int(np.searchsorted(np.cumsum(list(map(len, top))), _ABOVE[1]))
    for count in (min(_FIRST, most), most):  # most files have few lines above their samples
        rows = list(map(kinds_in, top[:count]))
        filled = [i for i, row in enumerate(rows) if any(row)]
        fits = [
            0 < 2 * rows[i].count(1) >= usual
            and not (-1 in rows[i] and any(rows[i][k] < 0 for k in numeric if k < len(rows[i])))
            for i in filled
        ]
        runs = np.convolve([*fits, *[False] * _TOGETHER], np.ones(_TOGETHER), "valid")
        starts = np.flatnonzero((runs[: len(fits)] >= _TOGETHER - 1) & np.array(fits, bool))
        if numeric and starts.size and starts[0] + _TOGETHER <= len(fits):
            break
    if not numeric or starts.size == 0:
        place = "" if len(rows) == len(lines) else f" in the first {len(rows):,} lines"
        reason = f"no columns of numbers are found{place}; is it a text file of measurements?"
        raise LayoutError(f"{file}: {reason}")
    return filled[starts[0]], [1 in kind for kind in columns]


class Kinds(dict):
    """What cells are by a decimal sign: 1 a number, 0 a missing sample, -1 anything else. Each cell
    is looked at once: samples of an instrument repeat themselves.

    >>> kinds = Kinds(",")
    >>> [kinds[cell] for cell in ("1,5", "nan", "1.5")]
    [1, 0, -1]
    """

    def __init__(self, decimal: str) -> None:
        super().__init__()
        self._decimal = decimal

    def __missing__(self, cell: str) -> int:
        """Look at a cell for the first time."""
        kind = 1 if len(cell) <= _LONGEST_NAME and is_number(cell, self._decimal) else -1
        self[cell] = found = 0 if cell.lower() in MISSING else kind
        return found


def _head(above: Sequence[Sequence[str]], width: int) -> tuple[int | None, int | None]:
    """Lines, from 0, of names and of units among those above the samples; None where none is."""
    filled = [i for i, row in enumerate(above) if any(row)]
    units = filled[-1] if filled and _are_units(above[filled[-1]]) else None
    candidates = filled[:-1] if units is not None else filled
    if candidates and _are_names(above[candidates[-1]], width):
        return candidates[-1], units
    for names, below in pairwise(filled) if units is None else ():  # other text is in between
        if _are_names(above[names], width) and _are_units(above[below]):
            return names, below
    return units, None  # a line of short names, such as "t;s", may look like one of units


def _are_units(row: Iterable[str]) -> bool:
    cells = [cell for cell in row if cell.strip("[]()-1")]
    return bool(cells) and sum(unit_of(cell) is not None for cell in cells) >= 2 / 3 * len(cells)


def _are_names(row: Sequence[str], columns: int) -> bool:
    cells = list(filter(None, row))
    short = all(len(cell) <= _LONGEST_NAME and not _VALUE.fullmatch(cell) for cell in cells)
    return short and columns / 2 <= len(cells) <= columns


def look_into(file: str | Path | Opened) -> Layout:
    """Return the layout of a file: guessed of a text, as it is said of other kinds.

    Args:
        file: The file, or one that is opened: then it is looked into once.

    Raises:
        LayoutError: If there are no columns of numbers.
        RejectedCurveError: If the file cannot be read.
    """
    opened = as_opened(file)
    return opened.once("layout", lambda: _layout_of(opened))


def _layout_of(opened: Opened) -> Layout:
    format_, kind = format_of(opened), kind_in(opened)
    with understood(opened):
        shown = format_.look(opened)
        if shown is None:
            return guess_layout(opened)
        if isinstance(shown, Labelled):
            return Layout(**shown._asdict(), kind=kind, file=Path(opened.file))
        for lines in shown.lines:
            with suppress(LayoutError):
                layout = layout_of_lines(opened.file, lines, {"decimal": "."}, "\t")
                return replace(layout, kind=kind)
    raise RejectedCurveError(opened.file, shown.reason)


def stated_in(file: str | Path | Opened, settings: Mapping = FORMAT, channel: str = "") -> Preamble:
    """Return what a file states above its samples; nothing of one that cannot be read.

    Args:
        file: The file, or one that is opened.
        settings: The section ``endurance.format``; where a text cannot be read by it, its layout
            is guessed.
        channel: Column of the travel, where it is not that of the settings.
    """
    opened = as_opened(file)
    with suppress(LayoutError, RejectedCurveError):
        with suppress(ValueError):
            if is_text(opened):
                return read_columns(opened, complete(settings), channel).stated
        return look_into(opened).stated
    return Preamble()


# ---- texts ---------------------------------------------------------------------------------------


def guess_layout(file: str | Path | Opened) -> Layout:
    """Guess the layout of a text file, or one that is opened.

    Raises:
        LayoutError: If there are no columns of numbers.
        RejectedCurveError: If the file cannot be read, or is larger than any record.

    Example:
        >>> import tempfile
        >>> rows = [f"{i / 10:.1f};{i / 7:.3f}".replace(".", ",") for i in range(50)]
        >>> with tempfile.NamedTemporaryFile("w") as file:
        ...     print("Rig 3", "Zeit;Weg", "[msec];mm", *rows, sep="\\n", file=file, flush=True)
        ...     layout = guess_layout(file.name)
        >>> layout.settings
        {'encoding': 'utf-8', 'delimiter': ';', 'decimal': ','}
        >>> layout.preamble, layout.names, layout.units
        ([['Rig 3']], ['Zeit', 'Weg'], ['ms', 'mm'])
    """
    opened = as_opened(file)
    file, content = opened.file, opened.content
    check_lines(file, content)
    encoding = encoding_of(content)
    # Damaged signs do not hide the rest; reading says where they are.
    stream = io.TextIOWrapper(io.BytesIO(content), encoding, errors="replace")
    lines = list(stream)
    lines[:1] = [line.removeprefix("\ufeff") for line in lines[:1]]
    if max(map(len, lines), default=0) > _LONGEST_LINE:
        long = next(i for i, line in enumerate(lines) if len(line) > _LONGEST_LINE)
        reason = f"has {len(lines[long]):,} signs; export a table with one line per sample"
        raise RejectedCurveError(file, reason, line=long + 1)
    delimiter, decimal = _signs(lines)
    settings = {"encoding": encoding, "delimiter": delimiter, "decimal": decimal}
    return layout_of_lines(file, lines, settings, delimiter)


def encoding_of(content: bytes) -> str:
    """Encoding of a text: by its mark, UTF-8 where it is that, else by what it would say."""
    if content[:2] in (b"\xff\xfe", b"\xfe\xff"):
        return "utf-16"
    with suppress(UnicodeDecodeError):
        content.decode("utf-8")
        return "utf-8"
    if (zeros := content[:2000].count(0)) > len(content[:2000]) / 4:
        return "utf-16-le" if content[1:2000:2].count(0) > zeros / 2 else "utf-16-be"
    # Lines of numbers tell nothing.
    lines = (line for line in io.BytesIO(content.replace(b"\r", b"\n")) if not line.isascii())
    telling = b"".join(islice(lines, _TELLING[0]))[: _TELLING[1]]
    for code in _CODES:  # so few signs leave doubts, but words do not
        if _WORDS.search(telling.decode(code, errors="ignore")):
            return code
    western = telling.decode("cp1252", errors="replace")
    if not _FOREIGN.search(western):  # else letters stand in pairs or words of their own
        return "cp1252"
    return "latin-1"


def _signs(lines: Sequence[str]) -> tuple[str, str]:
    """Delimiter and decimal sign with which most cells, and the fewest others, are numbers."""
    filled = [line for line in lines[len(lines) // 5 :] if line.strip()]
    every = max(1, len(filled) // _LOOKED_AT[0], sum(map(len, filled)) // _LOOKED_AT[1])
    some = filled[::every]
    signs = set().union(*some)
    there = [d for d in _DELIMITERS if d in signs]
    absent = [d for d in _DELIMITERS if d not in signs]  # one is like the other
    either = sorted([*there, *absent[:1]], key=_DELIMITERS.index)
    pairs = [(d, sign) for d in either for sign in ".," if d != sign or '"' in signs]

    def fit(pair: tuple[str, str]) -> tuple[bool, int]:
        rows, kinds = [cells_of(line, pair[0]) for line in some], Kinds(pair[1])
        # 12,045 is one number: no column has zeros before whole numbers, but perhaps the first.
        padded = any(_PADDED.fullmatch(cell) for cell in {c for row in rows for c in row[1:]})
        return not padded, sum(kinds[cell] for row in rows for cell in row)

    return max(pairs, key=fit)
