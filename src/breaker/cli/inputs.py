"""Common parts of commands: their configuration, and options of several commands."""

import argparse
from collections.abc import Mapping, Sequence
from pathlib import Path

from breaker.configuration.loading import defaults, load, read

# The workflow's configuration in a project's folder; the second file overrides the first.
ADVANCED, PROJECT = Path("config/advanced.yaml"), Path("config/config.yaml")

SEVERAL = {"nargs": "+", "action": "extend", "default": []}
"""Settings of an option that takes several values, and may occur several times."""


def settings_of(overlays: Sequence[str]) -> dict:
    """Return the configuration: overlays over the folder's files, or over the shipped defaults.

    Unchanged defaults are not checked: tests check them, and a check takes a tenth of a command.
    """
    own = [ADVANCED] * ADVANCED.exists() + [PROJECT] if PROJECT.exists() else []
    files = [*own, *overlays]
    return load(files, curves=False) if files else defaults()  # arguments name the records


def limits_of(config: Mapping, overlays: Sequence[str]) -> list:
    """Return the limits of the drive; the shipped limits, an example, count only if configured."""
    named = any("limits" in read(path) for path in overlays)
    return config["limits"] if named or config["limits"] != defaults()["limits"] else []


def add_choice(command: argparse.ArgumentParser) -> None:
    """Add the options that choose among the records of a command's files."""
    from breaker.model.parameters import MOTIONS  # loads numpy, after the number of threads is set

    command.add_argument("--motion", choices=MOTIONS, help="use only this motion")
    command.add_argument("--channel", default="", metavar="NAME", help="column of travel")
    add_type(command)
    command.add_argument(
        "--breaker", metavar="NAME", help="breaker, as the table of the folder states it"
    )
    command.add_argument("--phase", metavar="NAME", help="phase, as the table or a file states it")


def add_type(command: argparse.ArgumentParser) -> None:
    """Add the option that names the type of the breaker."""
    what = "type of the breaker (default: as the table or the file states it)"
    command.add_argument("--type", default="", metavar="NAME", help=what)


def choice_of(options: argparse.Namespace):
    """Return the ``Choice`` of the options of ``add_choice``."""
    from breaker.model.parameters import MOTIONS
    from breaker.records.named import Choice

    channels = [options.channel] if options.channel else []
    motions = [options.motion] if options.motion else MOTIONS
    return Choice(motions, channels, options.breaker, options.phase)
