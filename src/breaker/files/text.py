"""Curve files that are text: CSV and the like, in any encoding, with any end of line."""

import codecs
import csv
import re
from collections.abc import Iterator, Mapping
from pathlib import Path

from breaker.files.columns import Columns, columns_of
from breaker.files.guards import RejectedCurveError, read_bytes

__all__ = ["cells_of", "read_text"]

_BLOCK = 2**20  # characters that are split into cells at a time
_LONGEST_LINE = 100_000  # characters
# The blank before a unit in brackets that follows a name, where blanks separate.
_COMMENT = re.compile(r"^([#%!]|//)\s+")  # its sign is no cell of a line of names
_BEFORE_UNIT = re.compile(r"(?<=[^\s\])])\s+(?=[\[(])")


def read_text(file: str | Path, settings: Mapping, channel: str = "") -> Columns:
    """Read the columns of a text: see ``sources.read_columns``."""
    text = _decode(file, read_bytes(file), settings["encoding"])
    return columns_of(file, _blocks(file, text, settings["delimiter"]), settings, channel)


def _decode(file: str | Path, content: bytes, encoding: str) -> str:
    r"""The text of a file, without a byte order mark, its lines ended by ``\n``."""
    if codecs.lookup(encoding).name == "utf-16" and content[:1] == b"\0" != content[1:2]:
        encoding = "utf-16-be"  # without a mark; it begins with a sign of ASCII
    try:
        text = content.decode(encoding)
    except UnicodeError as error:
        line = content.count(b"\n", 0, getattr(error, "start", 0)) + 1
        reason = f"cannot be read: {error}; is it a text file, endurance.format.encoding right?"
        raise RejectedCurveError(file, reason, line=line) from error
    if "\0" in text:
        reason = "has zero bytes: it is damaged, or endurance.format.encoding is utf-16, say"
        raise RejectedCurveError(file, reason, line=text.count("\n", 0, text.index("\0")) + 1)
    text = text.removeprefix("\ufeff").rstrip("\x1a")  # the old sign for the end of a file
    if "\r" in text:
        # Lines that were translated twice end with two returns.
        text = text.replace("\r\r\n", "\n").replace("\r\n", "\n").replace("\r", "\n")
    return text


def _blocks(
    file: str | Path, text: str, delimiter: str
) -> Iterator[tuple[list[int], list[list[str]]]]:
    """Lines and cells of all that are not blank, block after block of whole lines."""
    begin, line, blank = 0, 1, f'{delimiter}" \t\v\f'
    while begin < len(text):
        end = text.find("\n", begin + _BLOCK)
        end = len(text) if end < 0 else end
        block = text[begin:end]
        every = block.split("\n")
        if max(map(len, every)) > _LONGEST_LINE:
            long = next(i for i, one in enumerate(every) if len(one) > _LONGEST_LINE)
            reason = f"has {len(every[long])} signs; is it a table, endurance.format right?"
            raise RejectedCurveError(file, reason, line=line + long)
        kept = [i for i, one in enumerate(every) if one.strip(blank)]
        there = every if len(kept) == len(every) else [every[i] for i in kept]
        plain = delimiter != " " and '"' not in block
        split = str.split if plain else cells_of
        yield [line + i for i in kept], [split(one, delimiter) for one in there]
        begin, line = end + 1, line + len(every)


def cells_of(line: str, delimiter: str) -> list[str]:
    """Return the cells of a line; where " " is the delimiter, any blanks are one.

    Each line is split for itself: an odd quotation mark, such as that of an inch, must not join
    lines, or their numbers shift.

    >>> cells_of('"1,5", 2', ","), cells_of("Travel (mm)  Time", " ")
    (['1,5', '2'], ['Travel(mm)', 'Time'])
    """
    line = line.strip() if delimiter == " " else line.rstrip("\n")
    if delimiter == " ":
        line = _COMMENT.sub(r"\1", line)
        line = _BEFORE_UNIT.sub("", line) if "(" in line or "[" in line else line
    cells = line.split(None if delimiter == " " else delimiter)
    if '"' in line and line.count('"') % 2 == 0:
        reader = csv.reader([line], delimiter=delimiter, skipinitialspace=True)
        cells = next(reader, [])
    return [cell.strip() for cell in cells]
