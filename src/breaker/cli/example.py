"""`breaker example`: write exports of a simulated breaker, to try the commands on."""

import argparse
import os
from pathlib import Path

from breaker.cli.common_options import settings_of
from breaker.common.clean_text import print_text

_OPERATIONS, _SEED = 3, 1


def add(example: argparse.ArgumentParser) -> None:
    """Write exports of a simulated breaker of 150 mm stroke, in the layout of an analyser of
    high-voltage breakers. The files are always the same. With --inspections, the command writes the
    files that `breaker view --example` shows: two inspections of a medium-voltage breaker, and a
    file that does not state its rate.
    """
    example.add_argument("folder", metavar="FOLDER", help="an empty or new folder")
    example.add_argument(
        "--inspections", action="store_true", help="write two inspections, from 2014 and 2026"
    )


def run(options: argparse.Namespace) -> int:
    """Write the files."""
    folder = Path(options.folder)
    if os.path.lexists(folder) and not (folder.is_dir() and not os.listdir(folder)):
        raise FileExistsError(f"{folder} exists, and is not replaced. Name another folder")
    from breaker.configuration.data_files import simulated_test
    from breaker.family.endurance import EnduranceTest
    from breaker.family.exports import write_close_opens, write_inspections

    config, count = settings_of(options.config), _OPERATIONS
    if options.inspections:
        folder.mkdir(parents=True, exist_ok=True)
        count = write_inspections(config, folder)
    else:
        test = EnduranceTest.from_settings(simulated_test(config), _SEED)
        write_close_opens(test.new, _SEED, folder, range(1, count + 1))
    print_text(f"{count} files written to {folder}")
    return 0
