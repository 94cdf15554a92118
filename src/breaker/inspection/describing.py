"""What a file states, which of its columns travel, and what goes with each; no record is read."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

import numpy as np

from breaker.files import TO_MM, Description, Part, RejectedCurveError
from breaker.inspection.channels import InspectionError, Travel, chosen_travels
from breaker.inspection.contents import look_into
from breaker.inspection.guesses import guess_direction
from breaker.inspection.layouts import Layout, LayoutError
from breaker.inspection.printed_results import phase_of
from breaker.inspection.proposals import motions_of
from breaker.inspection.timing import Clock, find_clock
from breaker.inspection.wiring import Beside, columns_beside

__all__ = ["Channel", "describe_file", "travel_channels"]


class Channel(NamedTuple):
    """A column that travels.

    Attributes:
        name: Its phase, or else the column.
        beside: By motion, what goes with it: see ``columns_beside``.
    """

    name: str
    beside: Mapping[str, Beside]


def travel_channels(file: str | Path) -> dict[str, Channel]:
    """Return the channels of a file by those columns that move as a drive does.

    A channel is called by its phase, where the file states it and no other channel has the same;
    else by its column. What moves by far less than the others is left out, as by cross-talk.

    Raises:
        InspectionError: If none moves.
        LayoutError: If there are no columns of numbers.
        RejectedCurveError: If the file cannot be read.
    """
    layout = look_into(file)
    travels, _, beside = _travels(Path(file), layout, find_clock(layout))
    columns = [str(layout.column(each.place)) for each in travels]
    phases = _phases(layout, travels)
    names = phases if all(phases) and len({*phases}) == len(phases) else columns
    return dict(zip(columns, map(Channel, names, beside), strict=True))


def describe_file(file: str | Path) -> Description:
    """Return what a file states above its samples, and which motions its channels have.

    Motions are looked for where the text names the breaker or its bay, as an analyser does. Of a
    file that cannot be read nothing is seen.
    """
    seen = Description()
    with suppress(LayoutError, RejectedCurveError, InspectionError):
        clock = find_clock(layout := look_into(file))
        seen = Description(layout.stated, (), clock.rate, clock.place is not None)
        if seen.preamble.serial or seen.preamble.bay:
            return seen._replace(parts=tuple(_parts(Path(file), layout)))
    return seen


def _travels(
    file: Path, layout: Layout, clock: Clock
) -> tuple[list[Travel], int, list[dict[str, Beside]]]:
    """Columns of travel, the sign of their reading, and what goes with each by motion."""
    _, travels, _ = chosen_travels(file, layout, clock, "")
    sign = guess_direction(file, layout, travels).settings["sign"]
    return travels, sign, columns_beside(layout, travels, sign)


def _phases(layout: Layout, travels: Sequence[Travel]) -> list[str]:
    return [phase_of(layout, each.place, k) for k, each in enumerate(travels, start=1)]


def _parts(file: Path, layout: Layout) -> Iterator[Part]:
    """The motions of all channels; where they are only if the times of samples are known."""
    travels, sign, besides = _travels(file, layout, clock := find_clock(layout))
    for travel, phase, beside in zip(travels, _phases(layout, travels), besides, strict=True):
        ratio = np.nan if travel.unit in (None, *TO_MM) else layout.stated.ratio
        for each in motions_of(travel, file, layout, clock, sign):
            found = each.operation
            at = (np.nan, np.nan) if np.isnan(clock.rate) else (found.begin, found.end)
            yield Part(each.motion, str(each.column), phase, *at, ratio, *beside[each.motion])
