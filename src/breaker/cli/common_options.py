"""Common parts of commands: their configuration, and options of several commands."""

import argparse
from collections.abc import Mapping, Sequence

from breaker.configuration.loading import defaults, load, read
from breaker.model.parameters import MOTIONS

SEVERAL = {"nargs": "+", "action": "extend", "default": []}
"""Settings of an option that takes several values, and may occur several times."""


def settings_of(overlays: Sequence[str]) -> dict:
    """Return the configuration: overlays over the shipped defaults.

    Unchanged defaults are not checked: tests check them, and a check takes a tenth of a command.
    """
    return load(overlays, curves=False) if overlays else defaults()  # arguments name the records


def limits_of(config: Mapping, overlays: Sequence[str]) -> list:
    """Return the limits of the drive; the shipped limits, an example, count only if configured."""
    return config["limits"] if any("limits" in read(path) for path in overlays) else []


def add_choice(command: argparse.ArgumentParser) -> None:
    """Add the options that choose among the records of a command's files."""
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
    from breaker.records.named import Choice

    channels = [options.channel] if options.channel else []
    motions = [options.motion] if options.motion else MOTIONS
    return Choice(motions, channels, options.breaker, options.phase)
