"""`breaker inspect`: propose how to read a file or a folder, or check a folder."""

import argparse
import os
from collections.abc import Mapping
from pathlib import Path

from breaker.cli.common_options import settings_of
from breaker.cli.outputs import check_outputs, say_written, write_lines
from breaker.common.clean_text import print_text


def add(inspect: argparse.ArgumentParser) -> None:
    """Show how a file is written: its columns of time and travel, and the motions in it. The
    command prints the lines of configuration that read the file. For a folder without a table
    operations.csv, the command proposes the table, which assigns files to operations. For a folder
    with the table, the command reads all records and prints which are accepted, and why others are
    not. The exit status is 1 if no record of a motion is accepted.
    """
    inspect.add_argument("file", metavar="FILE|FOLDER", help="a record, or a folder of records")
    inspect.add_argument("--channel", default="", metavar="NAME", help="column of travel")
    inspect.add_argument("--output", metavar="YAML|CSV", help="write the proposal to this new file")


def run(options: argparse.Namespace) -> int:
    """Inspect a file, or check or propose the table of a folder."""
    from breaker.records.operations import MANIFEST

    check_outputs([(options.output, "lines")])
    config = settings_of(options.config)
    if not os.path.isdir(options.file):
        return _look_into(options, config)
    if options.channel:
        raise ValueError("--channel is for a file. Leave it out, or name a file of the folder")
    if not os.path.lexists(Path(options.file, MANIFEST)):
        return _propose(options, config)
    if options.output:
        raise ValueError(f"{options.file} has a table {MANIFEST}. Leave --output out to check it")
    return _check(options.file, config)


def _look_into(options: argparse.Namespace, config: Mapping) -> int:
    """Propose how to read a file; return the status, 1 if no motion can be read."""
    from breaker.common.document import text_of
    from breaker.records.proposal import inspect_file, overlay_of, words_of

    proposal = inspect_file(options.file, config["sensor"], options.channel)
    overlay = overlay_of(proposal)
    output = options.output if proposal.is_read else None
    written = [write_lines(output, overlay)] if output else []
    print_text(text_of(words_of(proposal)))
    if proposal.is_read:
        print_text(f"\nProposed settings, for a file after --config:\n\n{overlay}")
    else:
        print_text(f"\nNothing is proposed: these settings read no motion:\n\n{overlay}")
    say_written(written)
    return 0 if any(motion.record for motion in proposal.motions) else 1


def _check(folder: str, config: Mapping) -> int:
    """Read the records of a folder as in the workflow, and print which are accepted."""
    from breaker.common.document import text_of
    from breaker.records.acceptance import check_folder, document_of

    motions = config["motions"]
    checked = check_folder(folder, config["endurance"], config["sensor"], motions)
    accepted = {group.motion for group in checked if group.accepted}
    print_text(text_of(document_of(checked)))
    remedy = f"set endurance.curves: {folder} in the configuration to use what is accepted"
    if lacking := " and no ".join(motion for motion in motions if motion not in accepted):
        remedy = f"no {lacking} is accepted: correct this, and run the command again"
    print_text(f"\nRead the listed records of {folder}; {remedy}.")
    return 1 if lacking else 0


def _propose(options: argparse.Namespace, config: Mapping) -> int:
    """Propose the table of a folder, and print remarks on entries to check."""
    from breaker.records.settings import FORMAT
    from breaker.records.table_proposal import propose_manifest

    # The configuration overrides settings that are found in the files.
    configured = config["endurance"]["format"] != FORMAT
    text, remarks = propose_manifest(options.file, config["motions"], configured=configured)
    if options.output:
        print_text(write_lines(options.output, text))
        step = "complete it"
    else:
        print_text(text, end="")
        step = f"write it with --output {Path(options.file, 'operations.csv')}, complete it"
    for remark in remarks:
        print_text(f"check: {remark}", on_stderr=True)
    step += f" as operations.csv in the folder, and run breaker inspect {options.file} again"
    print_text(f"Proposed a table of the operations in {options.file}: {step}.", on_stderr=True)
    return 0
