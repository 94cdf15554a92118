"""Formats of other distributions, by the entry points ``breaker.formats``.

What such an entry point names has ``ENDINGS``, ``read`` and ``look``, as ``formats`` describes. It
reads files of endings that no format here has. Messages name the distribution of a format that
fails, and other files are read as before.
"""

from __future__ import annotations

import logging
from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from typing import Any, ClassVar

from breaker.common.lazy_numpy import np
from breaker.reading.files.guards import Opened, RejectedCurveError
from breaker.reading.files.sample_table import Columns, Labelled, Tables

_FAULTS = (Exception, SystemExit)  # what a plugin may raise; an interrupt is the user's
_LONGEST = 200  # letters of what a plugin raised, in a message: such texts may be pages long
_log = logging.getLogger(__name__)


@dataclass(frozen=True, eq=False)
class PluginFormat:
    """A format of another distribution.

    Attributes:
        words: Name and distribution, as in "the format tdms of acme-breaker 1.2".
        module: What the entry point names.
        ENDINGS: What messages call a file of it, by ending in lower case.
        EXTRA: Empty: its distribution installs what it needs.
        SIGNATURES: Empty: its ending alone decides whether a file is of it.
    """

    words: str
    module: Any
    ENDINGS: Mapping[str, str]
    EXTRA: ClassVar[str] = ""
    SIGNATURES: ClassVar[tuple[bytes, ...]] = ()

    @property
    def __name__(self) -> str:
        """Its name where a module of this package has one."""
        return self.words

    def read(self, opened: Opened, settings: Mapping, channel: str = "") -> Columns:
        """Read the columns: see ``formats``.

        Raises:
            RejectedCurveError: If it raises anything, or returns no record.
        """
        with self._named(opened.file):
            found = self.module.read(opened, settings, channel)
            _check_columns(found)
        return found

    def look(self, opened: Opened) -> Labelled | Tables | None:
        """Return what a file shows: see ``formats``; raise as ``read``."""
        with self._named(opened.file):
            shown = self.module.look(opened)
            if isinstance(shown, Tables):  # lines may be made as they are asked for: now
                shown = shown._replace(lines=[list(each) for each in shown.lines])
            elif isinstance(shown, Labelled):
                sizes = {each.shape for each in shown.columns}
                if not len(shown.names) == len(shown.units) == len(shown.columns) or len(sizes) > 1:
                    raise ValueError("look shows columns of several lengths, or without names")
            elif shown is not None:
                raise ValueError(f"look returns {type(shown).__name__}")
        return shown

    @contextmanager
    def _named(self, file: str | Path) -> Iterator[None]:
        """Add the distribution to what is raised about a file."""
        try:
            yield
        except RejectedCurveError as error:
            reason = f"{error.reason} ({self.words})"
            raise RejectedCurveError(file, reason, line=error.line) from error
        except _FAULTS as error:
            kind = self.ENDINGS[Path(file).suffix.lower()]
            what = f"is {kind} that cannot be read: {self.words} fails {_raised(error)}"
            raise RejectedCurveError(file, what) from error


def plugin_formats(taken: Collection[str]) -> tuple[PluginFormat, ...]:
    """Return the formats of other distributions; the log names those that cannot be used.

    Args:
        taken: Endings that they may not have.
    """
    found: list[PluginFormat] = []
    taken = set(taken)
    for entry in entry_points(group="breaker.formats"):
        of = entry.dist
        words = f"the format {entry.name} of {f'{of.name} {of.version}' if of else 'nobody'}"
        try:
            format_ = _format_of(entry, words, taken)
        except _FAULTS as error:
            _log.error("%s cannot be used %s; its files are not read", words, _raised(error))
            continue
        taken |= format_.ENDINGS.keys()
        found.append(format_)
    return tuple(found)


def _format_of(entry: EntryPoint, words: str, taken: set[str]) -> PluginFormat:
    """Load a format; raise what its module raises, or ValueError."""
    module: Any = entry.load()
    lacks = [name for name in ("ENDINGS", "read", "look") if not hasattr(module, name)]
    if lacks:
        raise ValueError(f"it has no {' and no '.join(lacks)}")
    endings = dict(module.ENDINGS)
    if not all(each.startswith(".") and each == each.lower() for each in endings):
        raise ValueError("its ENDINGS must be lower case and begin with a dot, such as '.abc'")
    if common := sorted(endings.keys() & taken):
        raise ValueError(f"another format reads files of {', '.join(common)}")
    return PluginFormat(words, module, endings)


def _raised(error: BaseException) -> str:
    return f"({type(error).__name__}: {error})"[:_LONGEST]


def _check_columns(found: Any) -> None:
    """Raise ValueError if something is not a record's columns."""
    if not isinstance(found, Columns):
        raise ValueError(f"read returns {type(found).__name__}, not Columns")
    numbers = {"travel": found.travel, "time": found.time, **found.beside}
    for name, each in {**numbers, "lines": found.lines}.items():
        if name == "time" and each is None:
            continue
        if not isinstance(each, np.ndarray) or each.shape != (found.travel.size,):
            raise ValueError(f"{name} is not one array of as many samples as travel")
        if not np.issubdtype(each.dtype, np.integer if name == "lines" else np.floating):
            raise ValueError(f"{name} has no numbers of that kind")
