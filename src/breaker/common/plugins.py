"""Formats that other installed distributions add, by their entry points.

A plugin is named with its distribution in whatever is said of it, and one that fails takes nothing
else with it.
"""

import logging
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from typing import Any

FORMATS = "breaker.formats"
"""Group of the entry points; docs/library.md has an example."""

FAULTS = (Exception, SystemExit)
"""What a plugin may raise and is named for; an interrupt is the user's."""

_LONGEST = 200  # signs of what a plugin raised, in a message
_log = logging.getLogger(__name__)


class PluginError(ValueError):
    """A plugin that fails; the message names it, its distribution and what it raised."""


@dataclass(frozen=True)
class Plugin:
    """One entry point of a distribution.

    Attributes:
        entry: The entry point.
    """

    entry: EntryPoint

    @property
    def words(self) -> str:
        """What it is, and whose: "the format tdms of acme-breaker 1.2"."""
        of = self.entry.dist
        whose = f"{of.name} {of.version}" if of else "nobody"
        return f"the format {self.entry.name} of {whose}"

    def load(self) -> Any:
        """Return what the entry point names.

        Raises:
            PluginError: If it raises anything.
        """
        try:
            return self.entry.load()
        except FAULTS as error:
            raise self.failed("cannot be loaded", error) from error

    def failed(self, what: str, error: BaseException | None = None) -> PluginError:
        """Return the error that says what is wrong with the plugin."""
        said = f" ({type(error).__name__}: {error})"[:_LONGEST] if error else ""
        return PluginError(f"{self.words} {what}{said}")


@cache
def plugins() -> Mapping[str, Plugin]:
    """Return the plugins by name; of two of one name none, and the log says so."""
    found: dict[str, list[Plugin]] = {}
    for entry in entry_points(group=FORMATS):
        found.setdefault(entry.name, []).append(Plugin(entry))
    for several in found.values():
        if len(several) > 1:
            named = " and ".join(each.words for each in several)
            _log.error("%s have one name; neither is used. Uninstall one", named)
    return {name: each for name, (each, *more) in found.items() if not more}
