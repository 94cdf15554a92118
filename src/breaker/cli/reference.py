"""A good record that others are laid over."""

import argparse
from collections.abc import Sequence

from breaker.cli.operations_named import add_path, percent


def add_reference(command: argparse.ArgumentParser) -> None:
    """Add the options that name a good record, and how far others may depart from it."""
    add_path(
        command, "--reference", "GOOD", "a good record: draw the others over it, with differences"
    )
    command.add_argument(
        "--tolerance",
        type=percent,
        metavar="PERCENT",
        help="of the stroke, half of the band about the good record (default: 5)",
    )


def overlays_of(records: Sequence, good: Sequence, options: argparse.Namespace) -> list:
    """Lay records over good ones; none where none is named.

    Args:
        records, good: What was read of the files of the command, and of the good one.
        options: Those of ``add_reference``.

    Raises:
        ValueError: If the good record cannot be read, or has no motion of the others; or if a
            tolerance is given without it.
    """
    from breaker.drive.answers.reference_curve import TOLERANCE, overlaid

    if options.reference is None:
        if options.tolerance is not None:
            raise ValueError("--tolerance is of a --reference, which is not given; name a record")
        return []
    if good and all(each.reason for each in good):
        raise ValueError(f"--reference: {good[0].reason}")
    if not (found := overlaid(records, good, options.tolerance or TOLERANCE)):
        motions = " or ".join({each.motion: "" for each in records})
        raise ValueError(
            f"--reference {options.reference} has no usable {motions}; name one that has"
        )
    return found
