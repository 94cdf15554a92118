"""Which columns of a file travel, what their channels are called, and what goes with each."""

from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

from breaker.inspection.contents import look_into
from breaker.inspection.guesses import guess_direction
from breaker.inspection.printed_results import phase_of
from breaker.inspection.proposals import chosen_travels
from breaker.inspection.timing import find_clock
from breaker.inspection.wiring import Beside, columns_beside

__all__ = ["Channel", "travel_channels"]


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
    layout = look_into(Path(file))
    travels, _ = chosen_travels(Path(file), layout, find_clock(layout), "")
    sign = guess_direction(Path(file), layout, travels).settings["sign"]
    columns = [str(layout.column(each.place)) for each in travels]
    phases = [phase_of(layout, each.place, k) for k, each in enumerate(travels, start=1)]
    names = phases if all(phases) and len({*phases}) == len(phases) else columns
    beside = columns_beside(layout, travels, sign)
    return dict(zip(columns, map(Channel, names, beside), strict=True))
