"""What is in a file of any kind, before anything is known of it: the columns and their names.

Workbooks, COMTRADE and labelled arrays say themselves what texts leave to guess: their encoding,
delimiter and decimal sign.
"""

import io
import re
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from itertools import islice
from pathlib import Path

from breaker.reading.files.format_settings import FORMAT, complete
from breaker.reading.files.formats import format_of, is_text, kind_in, read_columns, understood
from breaker.reading.files.guards import Opened, RejectedCurveError, as_opened, check_lines
from breaker.reading.files.lexicon import TELLING
from breaker.reading.files.preamble import Preamble
from breaker.reading.files.sample_table import Labelled
from breaker.reading.files.text_cells import cells_of
from breaker.reading.files.word_meanings import any_of
from breaker.reading.inspection.table_layout import Kinds, Layout, LayoutError, layout_of_lines

_CODES = ("gb18030", "cp1252", "shift_jis", "euc_kr", "cp1251", "cp1250")
_WORDS = re.compile(any_of(TELLING))
_FOREIGN = re.compile(r"[^\x00-\x7f°µ²³±·½×ßäöüÄÖÜéèêëàâçîïôûñáíóúãõÉÀ–’]|[^\x00-\x7f]{2}")
_PADDED = re.compile(r"0\d+")
_DELIMITERS = (";", "\t", "|", ",", " ")  # in case of doubt, the first that fits
_LOOKED_AT = (200, 100_000)  # lines, and signs, from which the delimiter is guessed
_TELLING = (1_000, 2**14)  # lines, and bytes, from which an encoding is guessed
_LONGEST_LINE = 100_000  # signs; reading takes no longer ones


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
    from charset_normalizer import from_bytes  # here, as it is rarely needed

    best = from_bytes(telling, cp_isolation=_CODES).best()
    alike = best.could_be_from_charset if best else []
    return next((code for code in _CODES if code in alike), "latin-1")


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
