"""`breaker example`: write exports of a simulated breaker, to try the commands on."""

import argparse
import os
from pathlib import Path

from breaker.cli.inputs import add_path, settings_of
from breaker.common.text import say

_MOST, _USUAL, _SEED = 100, 3, 1  # operations, and of all files


def add(example: argparse.ArgumentParser) -> None:
    """Write exports of a simulated breaker of 150 mm stroke, in the layout of an analyser of
    high-voltage breakers. The files are always the same. With --inspections, the command writes the
    files that `breaker view --example` shows: two inspections of a medium-voltage breaker, and a
    file that does not state its rate.
    """
    add_path(example, "folder", "FOLDER", "an empty or new folder")
    what = f"number of operations, each a close and an open (default: {_USUAL})"
    example.add_argument("--operations", type=int, metavar="N", help=what)
    example.add_argument(
        "--worn", action="store_true", help="write the last operations of its life"
    )
    example.add_argument(
        "--inspections", action="store_true", help="write two inspections, from 2014 and 2026"
    )


def run(options: argparse.Namespace) -> int:
    """Write the files."""
    folder = Path(options.folder)
    count = _USUAL if options.operations is None else options.operations
    if not 1 <= count <= _MOST:
        raise ValueError(f"--operations is {count}. Give a number from 1 to {_MOST}")
    if options.inspections and (options.worn or options.operations is not None):
        raise ValueError(
            "--inspections always writes the same files. Leave --operations and --worn out"
        )
    if os.path.lexists(folder) and not (folder.is_dir() and not os.listdir(folder)):
        raise FileExistsError(f"{folder} exists, and is not replaced. Name another folder")
    from breaker.configuration.definitions import simulated_test
    from breaker.family.endurance import EnduranceTest
    from breaker.family.exports import write_close_opens, write_inspections

    config = settings_of(options.config)
    if options.inspections:
        folder.mkdir(parents=True, exist_ok=True)
        count = write_inspections(config, folder)
    else:
        test = EnduranceTest.from_settings(simulated_test(config), _SEED)
        first = max(1, test.operations - count + 1) if options.worn else 1
        drive = test.worn(test.operations, scatter=False) if options.worn else test.new
        write_close_opens(drive, _SEED, folder, range(first, first + count))
    say(f"{count} files written to {folder}")
    return 0
