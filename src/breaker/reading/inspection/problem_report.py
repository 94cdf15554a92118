"""What a report of a misread file needs, without names, serial numbers, dates and travel.

The head of the file keeps its signs, quotes and empty cells. Of its words, those stay that makers
use (``files.lexicon``). Letters of all others become x, and digits
become 0, but for single ones and numbers before a unit. So nothing has to be known of names to hide
them. What ``breaker inspect`` says is told with the same words hidden.
"""

import platform
import re
import sys
import traceback
from collections.abc import Iterable, Iterator, Mapping
from functools import lru_cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from breaker import __version__
from breaker.common.visible_text import visible_text
from breaker.documents.terminal import text_of
from breaker.reading.files.format_settings import FORMAT
from breaker.reading.files.formats import FORMATS, format_of
from breaker.reading.files.guards import Opened
from breaker.reading.files.lexicon import (
    COLOURS,
    COLUMNS,
    LABELS,
    MOTION_WORDS,
    OTHER_UNITS,
    RATE_WORDS,
    RESULT_HEADS,
    RESULTS,
    STATED,
    UNITS,
)
from breaker.reading.files.sample_table import Labelled
from breaker.reading.inspection.file_contents import encoding_of
from breaker.reading.inspection.proposal_words import overlay_of, words_of
from breaker.reading.inspection.setting_proposal import inspect_file

_MOST_LINES, _LONGEST_LINE = 80, 400  # of a head
_LONG = 4  # signs of what may be somebody's
_SAMPLES = 3  # lines of them that end a head
_REMEMBERED = 5000  # words and signs: a file has the same again and again
_PACKAGES = ("numpy", "scipy", "openpyxl", "comtrade", "h5netcdf", "h5py", "zarr")
_PACKED = (b"PK\x03\x04", b"\x89HDF", b"CDF", b"\xd0\xcf\x11\xe0")  # begins of what is no text

_TOKEN = re.compile(r"\d+|[^\W\d_]+")
_DATE = re.compile(r"\d{4}-\d\d-\d\d(?:[T ]\d\d:\d\d(?::\d\d)?)?")
_UNIT_WORDS = frozenset(
    unit.lower()
    for units in (*UNITS.values(), OTHER_UNITS)
    for unit in units.split()
    if len(unit) > 1
)
_UNIT = re.compile(rf"(?i)\s?({'|'.join(sorted(map(re.escape, _UNIT_WORDS), key=len))})\b")
_KNOWN = [
    re.compile(words)
    for table in (COLUMNS, MOTION_WORDS, LABELS, STATED, RATE_WORDS, RESULTS)
    for languages in (*table.values(), RESULT_HEADS)
    for words in languages.values()
]


class Hidden:
    """Hides words and numbers of texts, and remembers which.

    Example:
        >>> hidden = Hidden()
        >>> hidden.text("Station: Musterfeld 4711; Rate: 10 kHz")
        'Station: Xxxxxxxxxx 0000; Rate: 10 kHz'
        >>> hidden.again("of Musterfeld, 2026-01-31, 4711 and 10")
        'of Xxxxxxxxxx, 0000-00-00, 0000 and 10'
        >>> hidden.words
        ['musterfeld']
    """

    def __init__(self) -> None:
        self._found: set[str] = set()

    @property
    def words(self) -> list[str]:
        """Words that were hidden, in lower case."""
        return sorted(each for each in self._found if not each[0].isdigit())

    def text(self, text: str) -> str:
        """Return a text of the file with what is not known hidden."""
        pieces, end = [], 0
        for match in _TOKEN.finditer(text):
            token = match[0]
            stays = self._stays(token, text[match.start() - 1 : match.start()], text[match.end() :])
            if not stays:
                self._found.add(token.lower())
            pieces += [_shape(text[end : match.start()]), token if stays else _shape(token)]
            end = match.end()
        return "".join([*pieces, _shape(text[end:])])

    def again(self, text: str) -> str:
        """Return a text about the file with all hidden that was hidden before, and dates.

        Short words in lower case stay, and numbers of up to three digits: of a text about the file,
        most are not of the file.
        """
        return _TOKEN.sub(self._seen, _DATE.sub(lambda match: _shape(match[0]), text))

    def _seen(self, match: re.Match) -> str:
        token = match[0]
        plain = len(token) < _LONG and (token.isdigit() or (token.isascii() and token.islower()))
        return _shape(token) if token.lower() in self._found and not plain else token

    def _stays(self, token: str, before: str, after: str) -> bool:
        if len(token) == 1:
            return True
        if not token[0].isdigit():
            return _is_known(token.lower())
        return not re.match(r"[\w./:-]", before) and bool(_UNIT.match(after))


@lru_cache(_REMEMBERED)
def _is_known(word: str) -> bool:
    """Whether makers use a word, in lower case: at least half of it is in the lexicon."""
    if word in _UNIT_WORDS or word in COLOURS:
        return True
    spans = (match.end() - match.start() for each in _KNOWN if (match := each.search(word)))
    return max(spans, default=0) > max(1, len(word) // 2)


@lru_cache(_REMEMBERED)
def _shape(text: str) -> str:
    """A text with its letters as x and X and its digits as 0; signs of no alphabet stay."""
    return "".join(map(_sign, text))


@lru_cache(_REMEMBERED)
def _sign(sign: str) -> str:
    if sign.isdigit() or sign.isnumeric():
        return "0"
    if sign.isalpha():
        return "X" if sign.isupper() else "x"
    plain = sign.isascii() or sign.isspace() or sign in "°µ±²³·–’″Ω"
    return sign if plain else "?"


def problem_report(
    file: str | Path,
    sensor: Mapping,
    channel: str = "",
    *,
    format_settings: Mapping = FORMAT,
) -> tuple[str, list[str]]:
    """Return the report, and the words that are hidden in it.

    Args:
        file, sensor, channel: As of ``setting_proposal.inspect_file``, which is run.
        format_settings: The section ``endurance.format`` of the user's configuration.
    """
    hidden = Hidden()
    head = [*_head(Opened(file), hidden)]
    own = {key: value for key, value in format_settings.items() if value != FORMAT[key]}
    parts = {
        "versions": _versions(),
        "head of the file": head,
        "settings of the configuration": [hidden.again(f"{k}: {v!r}") for k, v in own.items()],
        "breaker inspect": [hidden.again(each) for each in _inspected(file, sensor, channel)],
    }
    lines = (line for title, each in parts.items() for line in (f"== {title} ==", *each, ""))
    return visible_text("\n".join(lines)), hidden.words


def _versions() -> list[str]:
    """Versions of all that reads files, and formats of other distributions."""
    found = [f"breaker {__version__}, Python {platform.python_version()}, {sys.platform}"]
    for name in _PACKAGES:
        try:
            found.append(f"{name} {version(name)}")
        except PackageNotFoundError:
            found.append(f"{name}: not installed")
    return [", ".join(found), "formats: " + ", ".join(each.__name__ for each in FORMATS)]


def _head(opened: Opened, hidden: Hidden) -> Iterator[str]:
    """Lines of the head, each as Python writes a text, so that its signs are seen."""
    try:
        content = opened.content
    except ValueError:  # a folder, or what cannot be read at all: inspect says so
        content = b""
    try:
        if content and not content.startswith(_PACKED) and _is_text(content):
            encoding = encoding_of(content)
            text = content.decode(encoding, errors="replace")
            yield f"{Path(opened.file).suffix}, {len(content)} bytes, {encoding}"
            lines: Iterable[str] = text.splitlines(keepends=True)
        else:
            yield f"{Path(opened.file).suffix}, {len(content)} bytes, no text"
            lines = _shown(opened)
    except Exception as error:  # of a file that cannot be read: whatever its format raises
        yield f"not shown: {type(error).__name__}"
        return
    yield from _of_lines(lines, hidden)


def _is_text(content: bytes) -> bool:
    zeros = content[:4000].count(0)
    return zeros == 0 or content[:2] in (b"\xff\xfe", b"\xfe\xff") or zeros > 1000


def _shown(opened: Opened) -> list[str]:
    """What a file of another kind shows, as lines with tabs between cells."""
    shown = format_of(opened).look(opened)
    if shown is None:
        return []
    if isinstance(shown, Labelled):
        rows = [*shown.preamble, shown.names, [unit or "" for unit in shown.units]]
        rows += [[str(column[i]) for column in shown.columns] for i in range(_SAMPLES)]
        return ["\t".join(row) for row in rows]
    return [line for table in shown.lines for line in table]


def _of_lines(lines: Iterable[str], hidden: Hidden) -> Iterator[str]:
    samples = 0
    for number, line in enumerate(lines):
        line = line[:_LONGEST_LINE]
        numbers = not any(sign.isalpha() for sign in line) and any(map(str.isdigit, line))
        samples = samples + 1 if numbers else 0
        if samples > _SAMPLES or number == _MOST_LINES:
            yield "..."
            return
        yield repr(_shape(line) if numbers else hidden.text(line))


def _inspected(file: str | Path, sensor: Mapping, channel: str) -> list[str]:
    """What ``breaker inspect`` says, or why it says nothing."""
    try:
        proposal = inspect_file(file, sensor, channel)
        said = [text_of(words_of(proposal, named=False)), "", overlay_of(proposal)]
    except ValueError as error:
        said = [f"{type(error).__name__}: {error}"]
    except Exception as error:
        frames = traceback.extract_tb(error.__traceback__)
        places = (f"  {Path(each.filename).name}, line {each.lineno}" for each in frames)
        said = [f"{type(error).__name__}: {error}", *places]
    text, path = "\n".join(said), Path(file)
    for name in (path, path.resolve(), path.name):
        text = text.replace(str(name), f"FILE{path.suffix}")
    for name in (path.stem, *path.resolve().parts[:0:-1]):
        text = text.replace(name, "FOLDER") if len(name) >= _LONG else text
    return text.splitlines()
