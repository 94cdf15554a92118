"""What commands have in common: their configuration, and options that several of them have."""

import argparse
from collections.abc import Mapping, Sequence
from pathlib import Path

from breaker.configuration.loading import defaults, load, read
from breaker.model.parameters import MOTIONS

# The workflow's configuration in a project's folder; the second is laid over the first.
ADVANCED, PROJECT = Path("config/advanced.yaml"), Path("config/config.yaml")

SEVERAL = {"nargs": "+", "action": "extend", "default": []}
"""Settings of an option that takes several values, and may be given several times."""


def settings_of(overlays: Sequence[str]) -> dict:
    """Return the configuration: overlays over that of the folder, or over the shipped defaults.

    The defaults alone are not checked: tests do that, and it takes a tenth of the first answer.
    """
    own = [ADVANCED] * ADVANCED.exists() + [PROJECT] if PROJECT.exists() else []
    files = [*own, *overlays]
    return load(files, curves=False) if files else defaults()  # commands name records themselves


def limits_of(config: Mapping, overlays: Sequence[str]) -> list:
    """Return the limits of the drive: the shipped ones are an example, and count only by name."""
    named = any("limits" in read(path) for path in overlays)
    return config["limits"] if named or config["limits"] != defaults()["limits"] else []


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
