"""What a file states, which of its columns travel, and what goes with each; no record is read."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np

from breaker.files import TO_MM, Description, Part, Preamble, RejectedCurveError
from breaker.inspection.channels import Travel
from breaker.inspection.contents import look_into
from breaker.inspection.guesses import guess_direction
from breaker.inspection.layouts import Layout, LayoutError
from breaker.inspection.printed_results import phase_of
from breaker.inspection.proposals import InspectionError, chosen_travels, motions_of
from breaker.inspection.timing import Clock, find_clock
from breaker.inspection.wiring import Beside, columns_beside

__all__ = ["Channel", "describe_file", "stated_in", "travel_channels"]


class Channel(NamedTuple):
    """A column that travels.

    Attributes:
        name: Its phase, or else the column.
        beside: By motion, what goes with it: see ``columns_beside``.
    """

    name: str
    beside: Mapping[str, Beside]


class _Seen(NamedTuple):
    """Columns of travel of a file, with the phase of each and what goes with it by motion."""

    clock: Clock
    travels: list[Travel]
    sign: int
    phases: list[str]
    beside: list[dict[str, Beside]]


def stated_in(file: str | Path) -> Preamble:
    """Return what a file states above its samples; nothing of one that cannot be read."""
    try:
        return look_into(file).stated
    except (LayoutError, RejectedCurveError):
        return Preamble()


def travel_channels(file: str | Path) -> dict[str, Channel]:
    """Return the channels of a file by those columns that move as a drive does.

    A channel is called by its phase, where the file states it and no other channel has the same;
    else by its column. What moves by far less than the others is left out, as by cross-talk.

    Raises:
        InspectionError: If none moves.
        LayoutError: If there are no columns of numbers.
        RejectedCurveError: If the file cannot be read.
    """
    seen = _seen(Path(file), layout := look_into(file))
    columns = [str(layout.column(each.place)) for each in seen.travels]
    named = all(seen.phases) and len({*seen.phases}) == len(columns)
    channels = map(Channel, seen.phases if named else columns, seen.beside)
    return dict(zip(columns, channels, strict=True))


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


def _seen(file: Path, layout: Layout) -> _Seen:
    travels, _ = chosen_travels(file, layout, clock := find_clock(layout), "")
    sign = guess_direction(file, layout, travels).settings["sign"]
    phases = [phase_of(layout, each.place, k) for k, each in enumerate(travels, start=1)]
    return _Seen(clock, travels, sign, phases, columns_beside(layout, travels, sign))


def _parts(file: Path, layout: Layout) -> Iterator[Part]:
    """The motions of all channels; where they are only if the times of samples are known."""
    clock, travels, sign, phases, besides = _seen(file, layout)
    for travel, phase, beside in zip(travels, phases, besides, strict=True):
        ratio = np.nan if travel.unit in (None, *TO_MM) else layout.stated.ratio
        for each in motions_of(travel, file, layout, clock, sign):
            found = each.operation
            at = (np.nan, np.nan) if np.isnan(clock.rate) else (found.begin, found.end)
            yield Part(each.motion, str(each.column), phase, *at, ratio, *beside[each.motion])
