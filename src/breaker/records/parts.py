"""Every motion that a record holds: an O-C-O has three, of which two are openings."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from breaker.files import Operation, RejectedCurveError, complete, read_columns
from breaker.records.clock import even_times
from breaker.records.errors import UnusableError
from breaker.records.scale import Scale
from breaker.records.segments import Course

__all__ = ["motions_in"]


def motions_in(operation: Operation, settings: Mapping) -> list[tuple[str, Operation]]:
    """Return the motions of a record in their order, each "closing" or "opening".

    One that is there more than once has the part of the record in which it is; the numbers of such
    operations count on from that of ``operation``.

    Args:
        operation: The whole record.
        settings: The section ``endurance.format``; what it lacks has its default.

    Raises:
        RejectedCurveError: If the record cannot be read, or nothing moves.
    """
    settings = complete(settings)
    columns = read_columns(operation.file, settings, operation.channel)
    try:
        time, place, _ = even_times(columns.time, columns.lines, settings)
    except UnusableError as error:
        raise RejectedCurveError(operation.file, str(error), line=error.line) from error
    travel = np.full(time.size, np.nan)
    travel[place] = Scale.from_settings(settings).travel(columns.travel)
    course = Course(time, travel)
    if np.isfinite(travel).sum() < time.size / 2 or not course.moves:
        raise RejectedCurveError(operation.file, "nothing moves; is it the right column?")
    closing = course.crossings[2]
    found = []
    for k, part in enumerate(course.motions):
        motion, same = "closing" if closing[k] else "opening", closing == closing[k]
        part_of = {"begin": float(time[part.begin]), "end": float(time[part.end - 1])}
        number = operation.number + int(same[:k].sum())
        several = part_of if same.sum() > 1 else {}
        found.append((motion, replace(operation, number=number, **several)))
    return found
