"""What a file states, which of its columns travel, and what goes with each; no record is read."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np

from breaker.records.channels import (
    Clock,
    InspectionError,
    Travel,
    chosen_travels,
    find_clock,
)
from breaker.records.contact_columns import Beside, columns_beside
from breaker.records.file_facts import Description, Part
from breaker.records.files import Opened, RejectedCurveError, as_opened
from breaker.records.guesses import (
    guess_direction,
    guess_rest,
    guess_time,
    guess_unit,
)
from breaker.records.layout import Layout, LayoutError, look_into
from breaker.records.operations import FILL_IN
from breaker.records.settings import TO_MM


def travel_channels(file: str | Path | Opened) -> dict[str, tuple[str, Mapping[str, Beside]]]:
    """Return the channels of a file by those columns that move as a drive does: what each is
    called, and what goes with it by motion, as of ``columns_beside``.

    A channel is called by its phase, where the file states it and no other channel has the same;
    else by its column. What moves by far less than the others is left out, as by cross-talk.

    Raises:
        InspectionError: If none moves.
        LayoutError: If there are no columns of numbers.
        RejectedCurveError: If the file cannot be read.
    """
    opened = as_opened(file)
    return opened.once("channels", lambda: _travel_channels(look_into(opened)))


def _travel_channels(layout: Layout) -> dict[str, tuple[str, Mapping[str, Beside]]]:
    clock = find_clock(layout)
    _, travels, _ = chosen_travels(layout, clock, "")
    sign = guess_direction(layout, travels).settings["sign"]
    columns = [str(layout.column(each.place)) for each in travels]
    phases = [each.phase for each in travels]
    names = phases if all(phases) and len({*phases}) == len(phases) else columns
    beside = columns_beside(layout, travels, sign)
    return dict(zip(columns, zip(names, beside, strict=True), strict=True))


def describe_file(file: str | Path) -> Description:
    """Return what a file states above its samples, which motions its channels have, and how it is
    read; of one that cannot be read, or in which nothing moves, the reason.
    """
    try:
        clock = find_clock(layout := look_into(file))
    except (LayoutError, RejectedCurveError) as error:
        return Description(reason=str(error).removeprefix(f"{file}: "))
    seen = Description(layout.stated, (), clock.rate, clock.place is not None)
    try:
        _, travels, _ = chosen_travels(layout, clock, "")
    except InspectionError as error:
        return seen._replace(reason=str(error).removeprefix(f"{file}: "))
    direction = guess_direction(layout, travels)
    unit = guess_unit(layout, travels)
    settings = {**layout.settings, **guess_time(layout, clock).settings, **direction.settings}
    settings["travel_unit"] = unit.settings["travel_unit"]
    settings |= dict.fromkeys(unit.lacking, FILL_IN)
    if not unit.lacking:
        mm = TO_MM[settings["travel_unit"]]
        settings["zero"] = guess_rest(travels, mm, settings["sign"]).settings["zero"]
    parts = _parts(layout, clock, travels, settings["sign"])
    return seen._replace(parts=tuple(parts), settings=settings, sure=direction.sure)


def _parts(layout: Layout, clock: Clock, travels: Sequence[Travel], sign: int) -> Iterator[Part]:
    """The motions of all channels; where they are only if the times of samples are known."""
    # Here, as it loads xarray, and what goes with a travel is asked in every answer.
    from breaker.records.proposal import motions_of

    other = {layout.column(t.place) for t in travels if t.unit not in (None, *TO_MM)}
    for each in motions_of(layout, clock, travels, sign):
        found, column = each.operation, each.column
        at = (np.nan, np.nan) if np.isnan(clock.rate) else (found.begin, found.end)
        ratio = layout.stated.ratio if column in other else np.nan
        yield Part(each.motion, str(column), each.phase, *at, ratio, each.beside.settings)
