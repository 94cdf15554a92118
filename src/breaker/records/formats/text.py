"""Curve files that are text: CSV and the like, in any encoding, with any end of line."""

from __future__ import annotations

import codecs
from collections.abc import Iterator, Mapping
from functools import lru_cache
from itertools import repeat
from pathlib import Path

from breaker.common.lazy_numpy import np
from breaker.records.cells import Lines
from breaker.records.files import Opened, RejectedCurveError, check_lines
from breaker.records.sheet import Columns, columns_of

_BLOCK = 2**20  # characters that are split into cells at a time
_KEPT = 2**21  # bytes of a text whose cells are kept for a while, as of most exports
_LONGEST_LINE = 100_000  # characters


ENDINGS = dict.fromkeys((".csv", ".txt", ".tsv"), "a text")
SIGNATURES: tuple[bytes, ...] = ()
EXTRA = ""


def read(opened: Opened, settings: Mapping, channel: str = "") -> Columns:
    """Read the columns of a text: see ``formats``."""
    file, content = opened.file, opened.content
    check_lines(file, content)
    form = settings["encoding"], settings["delimiter"]
    blocks = (_kept_blocks if len(content) <= _KEPT else _blocks)(file, content, *form)
    return columns_of(file, blocks, settings, channel)


def look(_: Opened) -> None:
    """Return nothing: what a text is like is to be guessed."""


# Each channel and motion of a file is read, and what stands above, one after the other. Cells take
# twelve times the bytes of their text, and stay to the end of a job.
@lru_cache(maxsize=2)
def _kept_blocks(*text: str | Path | bytes) -> list[tuple[np.ndarray, Lines]]:
    return list(_blocks(*text))


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
    text = text.removeprefix("\ufeff").rstrip("\n\r\x1a")  # the old sign for the end of a file
    if "\r" in text:
        # Lines that were translated twice end with two returns.
        text = text.replace("\r\r\n", "\n").replace("\r\n", "\n").replace("\r", "\n")
    return text


def _blocks(
    file: str | Path, content: bytes, encoding: str, delimiter: str
) -> Iterator[tuple[np.ndarray, Lines]]:
    """Numbers and rows of all lines that are not blank, block after block of whole lines."""
    text = _decode(file, content, encoding)
    begin, line, blank = 0, 1, f'{delimiter}" \t\v\f'
    while begin < len(text):
        end = text.find("\n", begin + _BLOCK)
        end = len(text) if end < 0 else end
        every = text[begin:end].split("\n")
        if end - begin > _LONGEST_LINE and max(map(len, every)) > _LONGEST_LINE:
            long = next(i for i, one in enumerate(every) if len(one) > _LONGEST_LINE)
            reason = f"has {len(every[long])} signs; is it a table, endurance.format right?"
            raise RejectedCurveError(file, reason, line=line + long)
        filled = list(map(str.strip, every, repeat(blank)))
        kept = np.arange(len(every)) if all(filled) else np.flatnonzero(list(map(bool, filled)))
        yield line + kept, Lines(every, kept, delimiter)
        begin, line = end + 1, line + len(every)
