"""What other installed distributions add: formats, limits and families, by their entry points.

A plugin is named with its distribution in whatever is said of it, and one that fails takes nothing
else with it.
"""

import logging
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from typing import Any

FORMATS, LIMITS, FAMILIES = GROUPS = ("breaker.formats", "breaker.limits", "breaker.families")
"""Groups of the entry points; docs/library.md has an example of each."""

FAULTS = (Exception, SystemExit)
"""What a plugin may raise and is named for; an interrupt is the user's."""

_KINDS = dict(zip(GROUPS, ("format", "limits", "simulator"), strict=True))
_LONGEST = 200  # signs of what a plugin raised, in a message
_log = logging.getLogger(__name__)


class PluginError(ValueError):
    """A plugin that fails; the message names it, its distribution and what it raised."""


@dataclass(frozen=True)
class Plugin:
    """One entry point of a distribution.

    Attributes:
        group: Of the entry point, one of ``GROUPS``.
        entry: The entry point.
    """

    group: str
    entry: EntryPoint

    @property
    def words(self) -> str:
        """What it is, and whose: "the format tdms of acme-breaker 1.2"."""
        of = self.entry.dist
        whose = f"{of.name} {of.version}" if of else "nobody"
        return f"the {_KINDS[self.group]} {self.entry.name} of {whose}"

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
def plugins(group: str) -> Mapping[str, Plugin]:
    """Return the plugins of a group by name; of two of one name none, and the log says so."""
    found: dict[str, list[Plugin]] = {}
    for entry in entry_points(group=group):
        found.setdefault(entry.name, []).append(Plugin(group, entry))
    for several in found.values():
        if len(several) > 1:
            named = " and ".join(each.words for each in several)
            _log.error("%s have one name; neither is used. Uninstall one", named)
    return {name: each for name, (each, *more) in found.items() if not more}


def plugin_words(group: str, name: str) -> str:
    """Return what a plugin is, and whose, in which version; empty if nothing has the name."""
    return plugins(group)[name].words if name in plugins(group) else ""


def plugin_of(group: str, name: str) -> Plugin:
    """Return a plugin by its name.

    Raises:
        PluginError: If nothing that is installed has it.

    Example:
        >>> try:
        ...     plugin_of(FAMILIES, "acme")
        ... except PluginError as error:
        ...     print(str(error)[:61])
        no distribution that is installed has the simulator acme (bre
    """
    if name in (known := plugins(group)):
        return known[name]
    raise PluginError(
        f"no distribution that is installed has the {_KINDS[group]} {name} ({group}); there are: "
        f"{', '.join(known) or 'none'}"
    )
