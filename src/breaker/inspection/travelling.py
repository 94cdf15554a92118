"""Which columns of a file travel, and what their channels are called: phases, poles, or columns."""

from pathlib import Path

from breaker.inspection.contents import look_into
from breaker.inspection.printed_results import phase_of
from breaker.inspection.proposals import chosen_travels
from breaker.inspection.timing import find_clock

__all__ = ["travel_channels"]


def travel_channels(file: str | Path) -> dict[str, str]:
    """Return the names of channels by the columns of a file that move as a drive does.

    A channel is called by its phase, where the file states it and no other channel has the same;
    else by its column. What moves by far less than the others is left out, as by cross-talk.

    Raises:
        InspectionError: If none moves.
        LayoutError: If there are no columns of numbers.
        RejectedCurveError: If the file cannot be read.
    """
    layout = look_into(Path(file))
    travels, _ = chosen_travels(Path(file), layout, find_clock(layout), "")
    columns = [str(layout.column(each.place)) for each in travels]
    phases = [phase_of(layout, each.place, k) for k, each in enumerate(travels, start=1)]
    told = all(phases) and len({*phases}) == len(phases)
    return dict(zip(columns, phases if told else columns, strict=True))
