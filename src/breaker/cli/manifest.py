"""`breaker manifest`: propose the table of the operations in a folder."""

import argparse
import sys

from breaker.cli.settings import settings_of

__all__ = ["add"]


def add(commands) -> argparse.ArgumentParser:
    manifest = commands.add_parser(
        "manifest",
        help="propose a table of the operations in a folder",
        description="Propose the table operations.csv of a folder: which file is which operation. "
        "What to check in it is printed beside it.",
    )
    manifest.set_defaults(run=_run)
    manifest.add_argument("folder", metavar="FOLDER", help="folder of the curve files")
    manifest.add_argument("--output", metavar="CSV", help="write the table there, if nothing is")
    manifest.add_argument(
        "--channels", nargs="+", default=[], metavar="NAME", help="columns of travel in each file"
    )
    return manifest


def _run(options: argparse.Namespace) -> int:
    from breaker.files import propose_manifest

    motions = settings_of(options.config)["motions"]
    text, remarks = propose_manifest(options.folder, options.channels, motions)
    if options.output:
        try:
            with open(options.output, "x", encoding="utf-8", newline="") as stream:
                stream.write(text)
        except FileExistsError:
            raise FileExistsError(
                f"{options.output} is there already, and is not overwritten; name another file"
            ) from None
    else:
        print(text, end="")
    for remark in remarks:
        print(f"check: {remark}", file=sys.stderr)
    return 0
