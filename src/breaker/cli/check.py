"""`breaker check`: say which records of a folder will be accepted."""

import argparse

from breaker.cli.command_inputs import add_path, settings_of
from breaker.common.visible_text import say


def add(check: argparse.ArgumentParser) -> None:
    """Read all records of a folder as the workflow will, and print what is accepted, what is
    doubtful, and why the rest is rejected. The status is 1 if nothing of a motion is accepted.
    """
    add_path(check, "folder", "FOLDER", "folder of the curve files")


def _run(options: argparse.Namespace) -> int:
    from breaker.documents.terminal import text_of
    from breaker.reading.inspection.acceptance import check_folder, words_of_checked

    config = settings_of(options.config)
    motions = config["motions"]
    checked = check_folder(options.folder, config["endurance"], config["sensor"], motions)
    say(text_of(words_of_checked(checked)))
    accepted = {each.motion for each in checked if each.accepted}
    return 0 if accepted == set(motions) else 1
