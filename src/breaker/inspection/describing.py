"""What is seen in a file for the table of its folder, without reading it as a record."""

from pathlib import Path

import numpy as np

from breaker.files import TO_MM, Description, Part, RejectedCurveError
from breaker.inspection.contents import look_into
from breaker.inspection.guesses import guess_direction
from breaker.inspection.layouts import Layout, LayoutError
from breaker.inspection.printed_results import phase_of
from breaker.inspection.proposals import InspectionError, chosen_travels, motions_of
from breaker.inspection.timing import find_clock
from breaker.inspection.wiring import columns_beside

__all__ = ["describe_file"]


def describe_file(file: str | Path) -> Description:
    """Return what a file states above its samples, and which motions its channels have.

    Motions are looked for where the text names the breaker or its bay, as an analyser does. Of a
    file that cannot be read nothing is seen.
    """
    try:
        layout = look_into(file)
    except (LayoutError, RejectedCurveError):
        return Description()
    stated = layout.stated
    if not (stated.serial or stated.bay):
        return Description(stated)
    try:
        return Description(stated, tuple(_parts(Path(file), layout)))
    except InspectionError:
        return Description(stated)


def _parts(file: Path, layout: Layout) -> list[Part]:
    """The motions of all channels; where they are only if the times of samples are known."""
    clock = find_clock(layout)
    travels, _ = chosen_travels(file, layout, clock, "")
    sign = guess_direction(file, layout, travels).settings["sign"]
    parts = []
    beside = columns_beside(layout, travels, sign)
    for order, travel in enumerate(travels, start=1):
        phase = phase_of(layout, travel.place, order)
        ratio = np.nan if travel.unit in (None, *TO_MM) else layout.stated.ratio
        for each in motions_of(travel, file, layout, clock, sign):
            found = each.operation
            at = (np.nan, np.nan) if np.isnan(clock.rate) else (found.begin, found.end)
            own = beside[order - 1][each.motion]
            parts.append(Part(each.motion, str(each.column), phase, *at, ratio, *own))
    return parts
