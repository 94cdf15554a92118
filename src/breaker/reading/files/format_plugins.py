"""Formats of other distributions, by entry points, behind the formats here.

What such an entry point names has ``ENDINGS``, ``read`` and ``look``, as ``formats`` describes. It
reads files of endings that no format here has. Whatever it raises or returns that is no record is
said of the file, with the name of the distribution.
"""

from __future__ import annotations

import logging
from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from breaker.common.lazy_numpy import np
from breaker.common.plugins import FAULTS, Plugin, PluginError, plugins
from breaker.reading.files.guards import Opened, RejectedCurveError
from breaker.reading.files.sample_table import Columns, Labelled, Tables

_log = logging.getLogger(__name__)


@dataclass(frozen=True, eq=False)
class PluginFormat:
    """A format of another distribution.

    Attributes:
        plugin: Its entry point.
        ENDINGS: What messages call a file of it, by ending in lower case.
        EXTRA: Empty: what it needs is its distribution's.
        SIGNATURES: Empty: its own code says whether a file is of it, by its ending alone, as the
            first bytes of others may be alike.
    """

    plugin: Plugin
    ENDINGS: Mapping[str, str]
    EXTRA: str = field(default="", init=False)
    SIGNATURES: tuple[bytes, ...] = field(default=(), init=False)

    @property
    def __name__(self) -> str:
        """What it is called where a module of this package has its name."""
        return self.plugin.words

    def read(self, opened: Opened, settings: Mapping, channel: str = "") -> Columns:
        """Read the columns: see ``formats``.

        Raises:
            RejectedCurveError: If it raises anything, or returns no record.
        """
        with self._named(opened.file):
            found = self.plugin.load().read(opened, settings, channel)
            if why := _no_record(found):
                raise ValueError(why)
        return found

    def look(self, opened: Opened) -> Labelled | Tables | None:
        """Return what a file shows: see ``formats``; raise as ``read``."""
        with self._named(opened.file):
            shown = self.plugin.load().look(opened)
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
        """Put the plugin's name into what is said of a file."""
        try:
            yield
        except RejectedCurveError as error:
            reason = f"{error.reason} ({self.plugin.words})"
            raise RejectedCurveError(file, reason, line=error.line) from error
        except FAULTS as error:
            kind = self.ENDINGS[Path(file).suffix.lower()]
            what = f"is {kind} that cannot be read: {self.plugin.failed('fails', error)}"
            raise RejectedCurveError(file, what) from error


def plugin_formats(taken: Collection[str]) -> tuple[PluginFormat, ...]:
    """Return the formats of other distributions; the log names those that cannot be used.

    Args:
        taken: Endings that they may not have.
    """
    found: list[PluginFormat] = []
    taken = set(taken)
    for plugin in plugins().values():
        try:
            format_ = _format_of(plugin, taken)
        except PluginError as error:
            _log.error("%s; its files are not read", error)
            continue
        taken |= format_.ENDINGS.keys()
        found.append(format_)
    return tuple(found)


def _format_of(plugin: Plugin, taken: Collection[str]) -> PluginFormat:
    """The format of a plugin.

    Raises:
        PluginError: If it is none, or wants an ending that another format has.
    """
    loaded: Any = plugin.load()
    lacks = [n for n in ("ENDINGS", "read", "look") if not hasattr(loaded, n)]
    if lacks:
        raise plugin.failed(f"has no {' and no '.join(lacks)}")
    endings = loaded.ENDINGS
    if not isinstance(endings, Mapping) or not all(
        isinstance(e, str) and isinstance(k, str) and e[:1] == "." and e == e.lower()
        for e, k in endings.items()
    ):
        raise plugin.failed("has ENDINGS that are no names by endings such as '.abc'")
    if common := sorted(endings.keys() & set(taken)):
        raise plugin.failed(f"wants files of {', '.join(common)}, which another format reads")
    return PluginFormat(plugin, dict(endings))


def _no_record(found: Any) -> str:
    """Why something is no record's columns; nothing where it is."""
    if not isinstance(found, Columns):
        return f"read returns {type(found).__name__}, not Columns"
    numbers = {"travel": found.travel, **found.beside}
    numbers |= {} if found.time is None else {"time": found.time}
    for name, each in {**numbers, "lines": found.lines}.items():
        if not isinstance(each, np.ndarray) or each.ndim != 1 or each.size != found.travel.size:
            return f"{name} is not one array of as many samples as travel"
        if not np.issubdtype(each.dtype, np.integer if name == "lines" else np.floating):
            return f"{name} has no numbers of that kind"
    return ""
