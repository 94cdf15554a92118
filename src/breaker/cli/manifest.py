"""`breaker manifest`: propose a table of the operations in a folder."""

import argparse
from collections.abc import Sequence

from breaker.cli.command_inputs import SEVERAL, add_path, settings_of
from breaker.cli.outputs import check_outputs, say_written, write_lines
from breaker.common.visible_text import say


def add(manifest: argparse.ArgumentParser) -> None:
    """Propose the table operations.csv of a folder: which file is which operation. What to check
    in it is printed beside it.
    """
    add_path(manifest, "folder", "FOLDER", "folder of the curve files")
    add_path(manifest, "--output", "CSV", "write the table there, if nothing is")
    what = "columns of travel in each file"
    manifest.add_argument("--channels", metavar="NAME", help=what, **SEVERAL)


def _run(options: argparse.Namespace) -> int:
    check_outputs([(options.output, "lines")], [options.folder, *options.config])
    from breaker.common.visible_text import visible_text

    text, remarks = table_of(options.folder, options.config, options.channels)
    written = [write_lines(options.output, text)] if options.output else []
    if not written:
        say(text, end="")
        if visible_text(text) != text:
            remarks.append(
                "signs that a terminal obeys or does not show stand there as escapes: write the "
                "table with --output, and it has the signs themselves"
            )
    for remark in remarks:
        say(f"check: {remark}", beside=True)
    say_written(written)
    return 0


def table_of(
    folder: str, overlays: Sequence[str], channels: Sequence[str] = ()
) -> tuple[str, list[str]]:
    """Return the proposed table of a folder, and what to check in it; nothing is written."""
    from breaker.reading.files.format_settings import FORMAT
    from breaker.reading.files.table_proposal import propose_manifest
    from breaker.reading.inspection.file_description import describe_file

    config = settings_of(overlays)
    own = {"configured": config["endurance"]["format"] != FORMAT}
    return propose_manifest(folder, channels, config["motions"], describe_file, **own)
