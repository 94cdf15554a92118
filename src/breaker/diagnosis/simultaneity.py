"""By how much poles of a breaker switch apart."""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from breaker.common.numerals import in_digits
from breaker.common.parts import Cell
from breaker.diagnosis.limits import NORMAL
from breaker.diagnosis.report_tables import RESULTS
from breaker.diagnosis.result import RecordResult
from breaker.model.quantities import EVENTS

_UNSEEN = (
    "simultaneity of the {event} is not told: recorded contacts alone tell it, and of {poles} "
    "there is none"
)
_UNCOUNTED = (
    "simultaneity of the {event} is not told: poles are in files of their own, and of {poles} no "
    "trigger is known from which to count; name the coil's current in "
    "endurance.format.trigger_column"
)


class Simultaneity(NamedTuple):
    """By how much poles switch apart.

    Attributes:
        said: In words, or why it is not told; empty of one pole.
        verdict: On the limit, as of ``limit_verdicts``; empty without one, or where nothing is
            told.
    """

    said: str = ""
    verdict: str = ""


def simultaneity_of(
    channels: Mapping[str, RecordResult], limits: Mapping[str, float | None] | None = None
) -> Simultaneity:
    """Say by how much poles switch apart, by their recorded contacts, or why that is not told.

    Times of one record are on one base; those of several each count from the trigger of theirs.

    Args:
        channels: Entry of a motion in the document, by pole.
        limits: Most that they may switch apart, by motion, ms; None for any.
    """
    entries, motion = channels.values(), next(iter(channels.values())).motion
    event, base = EVENTS[motion], "of one record"
    if len(channels) == 1:
        return Simultaneity()
    dumb = [name for name, each in channels.items() if each.fit.contact_time is None]
    times = [each.fit.switches for each in entries]
    if len({each.file for each in entries}) > 1:
        base = "each from the trigger of its file"
        triggers = np.array([each.fit.trigger for each in entries], float)  # None becomes nan
        times = [time - trigger for time, trigger in zip(times, triggers, strict=True)]
    if len(channels) - len(dumb) < 2:
        return Simultaneity(_UNSEEN.format(event=event, poles=", ".join(dumb)))
    known = {n: t for n, t in zip(channels, times, strict=True) if n not in dumb}
    if not np.isfinite([*known.values()]).all():
        where = ", ".join(name for name, time in known.items() if not np.isfinite(time))
        return Simultaneity(_UNCOUNTED.format(event=event, poles=where))
    first, last = (end(known, key=known.get) for end in (min, max))
    apart = known[last] - known[first]
    spread = f"{in_digits(apart, 3)} ms, {first} first, {last} last, {base}"
    said = f"simultaneity of the {event}: {spread}"
    if dumb:
        said += f"; not recorded of {', '.join(dumb)}"
    most = (limits or {}).get(motion)
    if most is None:
        return Simultaneity(said)
    sd = np.hypot(*(channels[each].fit.contact_sd or 0.0 for each in (first, last)))
    return _judged(said, apart, float(sd), most)


def _judged(said: str, apart: float, sd: float, most: float) -> Simultaneity:
    """By how much poles switch apart, with its sd, against the most that they may, ms."""
    surely = (apart - most) / max(NORMAL[95] * sd, 1e-9)
    verdict = "pass" if surely < -1.0 else "fail" if surely > 1.0 else "inconclusive"
    text, tone = RESULTS[verdict]
    said += f"; limit {in_digits(most, 3)} ms: {text}"
    return Simultaneity(Cell(said, tone), verdict)
