"""Damage the text of a curve file by faults between the instrument and the reader.

Each kind is a function of the bytes of a good file and a generator, ``(content, rng) -> bytes``.
The extent of the damage is drawn. The text is split at the ends of lines, and at the delimiter of
most cells. Binary files are damaged in the same manner.
"""

import re
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from studies.faults.records import size

Damage = Callable[[bytes, np.random.Generator], bytes]
TEXT: dict[str, Damage] = {}
"""Kinds of damage by name."""
_CELL = re.compile(rb"-?\d+(?:[.,]\d+)?(?:[eE][+-]?\d+)?")
_ODD = [
    "1_000", "1e246", "-1e300", "1e-320", "٣٫١٤", "１２.５", "²", "nan", "inf", "-inf", "N/A",
    "#DIV/0!", "---", "OVER", "1.2.3", "1,234.5", "0x1F", "1e5000", "12 34", "+-1", "1.", ".", "on",
    "9" * 400, "=A1", "1d3", "\u221212.3", "1e3j", "", " ", '"', "''", "\x00", "\t", "\u200b",
]  # fmt: skip


def kind(damage: Damage) -> Damage:
    """Register a kind of damage by the name of its function."""
    TEXT[damage.__name__.replace("_", " ")] = damage
    return damage


def _lines(content: bytes) -> tuple[list[bytes], bytes]:
    """Return the lines and their end; byte order marks and zero bytes remain in the lines."""
    end = next((name for name in (b"\r\n", b"\n") if name in content), b"\r")
    return content.split(end), end


def _one(rng: np.random.Generator, options: Sequence[Any]) -> Any:
    return options[rng.integers(len(options))]


def _some(rng: np.random.Generator, total: int) -> np.ndarray:
    """Return between one and half of ``total`` places, in order."""
    count = min(total, round(size(rng, 1, max(2, total // 2))))
    return np.sort(rng.choice(total, count, replace=False))


def _delimiter(content: bytes) -> bytes:
    """Return the sign between the cells of the last lines."""
    return next(
        (sign for sign in (b";", b"\t", b"|", b",") if content[-600:].count(sign) > 5), b" "
    )


def _in_cells(change: Callable[[bytes, np.random.Generator], bytes]) -> Damage:
    """Return a damage to numbers of the file, from the change of one number."""

    def damage(content: bytes, rng: np.random.Generator) -> bytes:
        result = list(_CELL.finditer(content))
        parts, end = [], 0
        for i in _some(rng, len(result)) if rng.random() < 0.3 else [rng.integers(len(result))]:
            parts += [content[end : result[i].start()], change(result[i].group(), rng)]
            end = result[i].end()
        return b"".join([*parts, content[end:]])

    damage.__name__, damage.__doc__ = change.__name__, change.__doc__
    return damage


@kind
@_in_cells
def odd_numbers(number: bytes, rng: np.random.Generator) -> bytes:
    """Cells contain texts that Python, a spreadsheet or an instrument may write for a number."""
    suffixes = [b" mm", b"mm", b"V", b" s", b"*", b"!", b"?", b"%", b"e"]
    return _one(rng, _ODD).encode() if rng.random() < 0.8 else number + _one(rng, suffixes)


@kind
@_in_cells
def digits_changed(number: bytes, rng: np.random.Generator) -> bytes:
    """A digit of a number is changed, or two digits are swapped."""
    digits = [i for i, item in enumerate(number) if chr(item).isdigit()]
    i, j = rng.choice(digits, 2)
    changed = bytearray(number)
    changed[i], changed[j] = changed[j], changed[i]
    if i == j:
        changed[i] = ord(str(rng.integers(10)))
    return bytes(changed)


@kind
@_in_cells
def cells_lost(number: bytes, rng: np.random.Generator) -> bytes:
    """Cells are blank."""
    return b""


@kind
def bytes_flipped(content: bytes, rng: np.random.Generator) -> bytes:
    """Single bits are flipped, in 1 byte to 10 % of the bytes."""
    changed = np.frombuffer(content, dtype=np.uint8).copy()
    where = rng.choice(changed.size, round(size(rng, 1, max(2, changed.size // 10))), replace=False)
    changed[where] ^= (1 << rng.integers(0, 8, where.size)).astype(np.uint8)
    return changed.tobytes()


@kind
def lines_deleted(content: bytes, rng: np.random.Generator) -> bytes:
    """Lines of the head or of the samples are missing."""
    lines, end = _lines(content)
    gone = set(_some(rng, len(lines)).tolist())
    return end.join(line for i, line in enumerate(lines) if i not in gone)


@kind
def lines_repeated(content: bytes, rng: np.random.Generator) -> bytes:
    """Lines are repeated, or the file is appended to itself."""
    lines, end = _lines(content)
    if rng.random() < 0.1:
        return content * 2
    twice = set(_some(rng, len(lines)).tolist())
    return end.join(line for i, line in enumerate(lines) for _ in range(1 + (i in twice)))


@kind
def truncated(content: bytes, rng: np.random.Generator) -> bytes:
    """The file ends early or begins late, in mid-line."""
    lost = round(size(rng, 1, len(content)))
    return content[lost:] if rng.random() < 0.3 else content[: len(content) - lost]


@kind
def other_delimiter(content: bytes, rng: np.random.Generator) -> bytes:
    """Another sign separates the columns, in the entire file or from a line on."""
    new = _one(rng, [b";", b"\t", b"|", b",", b" ", b"::", b", "])
    lines, end = _lines(content)
    first = 0 if rng.random() < 0.5 else int(rng.integers(len(lines)))
    sign = _delimiter(content)
    return end.join(lines[:first] + [line.replace(sign, new) for line in lines[first:]])


@kind
def other_decimal(content: bytes, rng: np.random.Generator) -> bytes:
    """Decimal points become commas, or are swapped with them, in the file or from a line on."""
    lines, end = _lines(content)
    first = 0 if rng.random() < 0.5 else int(rng.integers(len(lines)))
    swap = bytes.maketrans(b".,", b",.") if rng.random() < 0.5 else bytes.maketrans(b".", b",")
    return end.join(lines[:first] + [line.translate(swap) for line in lines[first:]])


@kind
def other_encoding(content: bytes, rng: np.random.Generator) -> bytes:
    """The text has another encoding, or begins with a right or wrong byte order mark."""
    if rng.random() < 0.5:
        return _one(rng, [b"\xef\xbb\xbf", b"\xff\xfe", b"\xfe\xff"]) * rng.integers(1, 3) + content
    new = _one(rng, ["utf-16", "utf-16-le", "utf-16-be", "utf-32", "utf-8-sig", "cp037"])
    return content.decode("latin-1").encode(new, errors="replace")


@kind
def junk_lines(content: bytes, rng: np.random.Generator) -> bytes:
    """Other lines are inserted: page heads, remarks, blanks, or the head again."""
    (lines, end), sign = _lines(content), _delimiter(content)
    junk = [b"", b"   ", b"# remark", b"Page 2", b"-----", sign * 3, lines[0], lines[-1][:5]]
    for i in _some(rng, len(lines))[:20][::-1]:
        lines.insert(int(i), _one(rng, junk))
    return end.join(lines)


@kind
def binary(content: bytes, rng: np.random.Generator) -> bytes:
    """The file, or a block in it, consists of random bytes; or it is a picture or an archive."""
    junk = rng.bytes(round(size(rng, 1, 20_000)))
    first = int(rng.integers(len(content)))
    whole = [b"PK\x03\x04" + junk, b"\x89PNG\r\n\x1a\n" + junk, b"%PDF-1.7\n" + junk, junk]
    inside = content[:first] + junk + content[first + len(junk) :]
    return inside if rng.random() < 0.5 else _one(rng, whole)


@kind
def empty(content: bytes, rng: np.random.Generator) -> bytes:
    """The file is empty, blank, or contains only the head."""
    return _one(rng, [b"", b"\n", b"\n" * 5000, b" " * 5000, b"\0" * 5000, content[:100]])
