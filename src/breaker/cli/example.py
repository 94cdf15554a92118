"""`breaker example`: write the exports of a simulated breaker, to try all of this on."""

import argparse
import os

from breaker.cli.command_inputs import add_path, settings_of
from breaker.common.visible_text import say

_MOST = 100
_SEED = 1


def add(example: argparse.ArgumentParser) -> None:
    """Write exports of a simulated breaker of 150 mm stroke, as an analyser of high-voltage
    breakers writes them: always the same files. With --worn they are of the end of its life.
    """
    add_path(example, "folder", "FOLDER", "where to write; it must be empty, or not be there")
    what = "how many, each a close and an open (default: 3)"
    example.add_argument("--operations", type=int, default=3, metavar="N", help=what)
    example.add_argument("--worn", action="store_true", help="the last operations of its life")


def _run(options: argparse.Namespace) -> int:
    if not 1 <= options.operations <= _MOST:
        raise ValueError(f"--operations is {options.operations}; write from 1 to {_MOST}")
    if os.path.lexists(options.folder) and not (
        os.path.isdir(options.folder) and not os.listdir(options.folder)
    ):
        raise FileExistsError(f"{options.folder} is there, and is not replaced; name another")
    from breaker.drive.simulation.endurance_rig import Rig
    from breaker.drive.simulation.rack_exports import write_exports

    settings = settings_of(options.config)["rig"]
    rig, life = Rig.from_settings(settings, _SEED), settings["operations"]
    first = max(1, life - options.operations + 1) if options.worn else 1
    drive = rig.worn(life, scatter=False) if options.worn else rig.new
    write_exports(drive, _SEED, options.folder, range(first, first + options.operations))
    say(f"{options.operations} files written to {options.folder}")
    return 0
