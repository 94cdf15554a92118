"""A text file of unknown origin: its encoding, delimiter and decimal sign, guessed.

Guessing, to propose settings: see ``layouts``.
"""

import io
import re
from collections.abc import Sequence
from itertools import islice
from pathlib import Path

from charset_normalizer import from_bytes

from breaker.files import RejectedCurveError, read_bytes
from breaker.inspection.layouts import Layout, cells_of, kind_of, layout_of_lines

__all__ = ["guess_layout"]

_CODES = ("gb18030", "cp1252", "shift_jis", "euc_kr", "cp1251", "cp1250")
_WORDS = re.compile("行程|位移|时间|時間|电流|速度|采样|変位|время|ход|путь")
_DELIMITERS = (";", "\t", "|", ",", " ")  # in case of doubt, the first that fits
_LOOKED_AT = (200, 100_000)  # lines, and signs, from which the delimiter is guessed
_TELLING = (1_000, 2**14)  # lines, and bytes, from which an encoding is guessed
_LONGEST_LINE = 100_000  # signs; reading takes no longer ones
_MOST_LINES = 2_000_000


def guess_layout(file: str | Path) -> Layout:
    """Guess the layout of a text file.

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
        (['Rig 3'], ['Zeit', 'Weg'], ['ms', 'mm'])
    """
    content = read_bytes(file)
    encoding = _encoding(content)
    # Damaged signs do not hide the rest; reading says where they are.
    stream = io.TextIOWrapper(io.BytesIO(content), encoding, errors="replace")
    lines = list(islice(stream, _MOST_LINES + 1))
    if len(lines) > _MOST_LINES:
        reason = f"has more than {_MOST_LINES:,} lines; export a shorter part of the record"
        raise RejectedCurveError(file, reason)
    lines[:1] = [line.removeprefix("\ufeff") for line in lines[:1]]
    if max(map(len, lines), default=0) > _LONGEST_LINE:
        long = next(i for i, line in enumerate(lines) if len(line) > _LONGEST_LINE)
        reason = f"has {len(lines[long]):,} signs; export a table with one line per sample"
        raise RejectedCurveError(file, reason, line=long + 1)
    delimiter, decimal = _signs(lines)
    settings = {"encoding": encoding, "delimiter": delimiter, "decimal": decimal}
    return layout_of_lines(file, lines, settings, delimiter)


def _encoding(content: bytes) -> str:
    """Encoding of a text: by its mark, UTF-8 where it is that, else by what it would say."""
    if content[:2] in (b"\xff\xfe", b"\xfe\xff"):
        return "utf-16"
    try:
        content.decode("utf-8")
    except UnicodeDecodeError:
        pass
    else:
        return "utf-8"
    if (zeros := content[:2000].count(0)) > len(content[:2000]) / 4:
        return "utf-16-le" if content[1:2000:2].count(0) > zeros / 2 else "utf-16-be"
    # Lines of numbers tell nothing.
    lines = (line for line in io.BytesIO(content.replace(b"\r", b"\n")) if not line.isascii())
    telling = b"".join(islice(lines, _TELLING[0]))[: _TELLING[1]]
    for code in _CODES:  # so few signs leave doubts, but words do not
        if _WORDS.search(telling.decode(code, errors="ignore")):
            return code
    best = from_bytes(telling, cp_isolation=_CODES).best()
    alike = best.could_be_from_charset if best else []
    return next((code for code in _CODES if code in alike), "latin-1")


def _signs(lines: Sequence[str]) -> tuple[str, str]:
    """Delimiter and decimal sign with which most cells, and the fewest others, are numbers."""
    filled = [line for line in lines[len(lines) // 5 :] if line.strip()]
    signs = sum(map(len, filled))
    some = filled[:: max(1, len(filled) // _LOOKED_AT[0], signs // _LOOKED_AT[1])]
    quoted = any('"' in line for line in some)
    pairs = [(d, sign) for d in _DELIMITERS for sign in ".," if d != sign or quoted]

    def fit(pair: tuple[str, str]) -> tuple[bool, int]:
        rows = [cells_of(line, pair[0]) for line in some]
        # 12,045 is one number: no column has zeros before whole numbers, but perhaps the first.
        padded = any(re.fullmatch(r"0\d+", cell) for row in rows for cell in row[1:])
        return not padded, sum(kind_of(cell, pair[1]) for row in rows for cell in row)

    return max(pairs, key=fit)
