"""By how much poles of a breaker switch apart."""

from collections.abc import Mapping

import numpy as np

from breaker.common.numerals import in_digits
from breaker.documents.parts import Text
from breaker.drive.answers.answer_document import RecordAnswer
from breaker.quantities.speeds import EVENTS


def simultaneity_of(channels: Mapping[str, RecordAnswer]) -> str:
    """Say by how much poles switch apart, by their recorded contacts, or why that is not told.

    Times of one record are on one base; those of several each count from the trigger of theirs.

    Args:
        channels: Entry of a motion in the document, by pole; "" of one.
    """
    entries, motion = channels.values(), next(iter(channels.values())).motion
    event, base = EVENTS[motion], "of one record"
    if len(channels) == 1:
        return ""
    dumb = [name for name, each in channels.items() if each.fit.contact_time is None]
    times = [each.fit.switches for each in entries]
    if len({each.file for each in entries}) > 1:
        base = "each from the trigger of its file"
        triggers = np.array([each.fit.trigger for each in entries], float)  # None becomes nan
        times = [time - trigger for time, trigger in zip(times, triggers, strict=True)]
    if len(channels) - len(dumb) < 2:
        return Text(
            "simultaneity of the {event} is not told: recorded contacts alone tell it, and of "
            "{poles} there is none",
            event=Text(event),
            poles=", ".join(dumb),
        )
    known = {n: t for n, t in zip(channels, times, strict=True) if n not in dumb}
    if not np.isfinite([*known.values()]).all():
        where = ", ".join(name for name, time in known.items() if not np.isfinite(time))
        return Text(
            "simultaneity of the {event} is not told: poles are in files of their own, and of "
            "{poles} no trigger is known from which to count; name the coil's current in "
            "endurance.format.trigger_column",
            event=Text(event),
            poles=where,
        )
    first, last = (end(known, key=known.get) for end in (min, max))
    spread = in_digits(known[last] - known[first], 3)
    said = Text(
        "simultaneity of the {event}: {spread} ms, {first} first, {last} last, {base}",
        event=Text(event),
        spread=spread,
        first=first,
        last=last,
        base=Text(base),
    )
    return Text("{said}; not recorded of {dumb}", said=said, dumb=", ".join(dumb)) if dumb else said
