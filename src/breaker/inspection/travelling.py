"""Which columns of a file travel, and what their channels are called: phases, poles, or columns."""

from pathlib import Path

from breaker.inspection.channels import find_travels
from breaker.inspection.contents import look_into
from breaker.inspection.timing import find_clock

__all__ = ["travel_channels"]

_HEARD = 0.25  # share of the largest stroke, up to which a column may hear another


def travel_channels(file: str | Path) -> dict[str, str]:
    """Return the names of channels by the columns of a file that move as a drive does; maybe none.

    Those that move by far less than the largest are left out: an unused input that hears another.

    Raises:
        LayoutError: If there are no columns of numbers.
        RejectedCurveError: If the file cannot be read.
    """
    layout = look_into(Path(file))
    travels = find_travels(layout, find_clock(layout))
    least = _HEARD * max((each.strokes.max() for each in travels), default=0.0)
    used = [str(layout.column(each.place)) for each in travels if each.strokes.max() > least]
    return dict(zip(used, used, strict=True))
