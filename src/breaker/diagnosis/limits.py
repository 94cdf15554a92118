"""Verdicts on limits: of quantities of a record or a change, and of the simultaneity of poles."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence

import numpy as np

from breaker.common.plain_values import note_of
from breaker.common.randomness import generator
from breaker.diagnosis.estimate import NOTHING, Estimate
from breaker.diagnosis.sentences import say
from breaker.model.limits import Limit
from breaker.model.quantities import EVENTS, QUANTITIES
from breaker.records.measurements import Measured

VERDICTS = ("pass", "inconclusive", "fail")
"""Verdicts on a limit, the worst last."""

NORMAL = {90: 1.645, 95: 1.96}
"""Half-width of a central interval of a normal variable, sds, by its coverage in percent."""

Known = Measured | np.ndarray
"""Knowledge of a quantity: a measurement, or posterior draws, ``(d,)``."""

_ENDS = 0.025, 0.975  # ends of a 95 % interval
# Ratio of bound and value from which a limit is in another unit: no maker's limit is 20 times off a
# usual value, but a limit in m instead of mm, or s instead of ms, is 1000 times off.
_OTHER_UNIT = 20.0
_NEVER_SMALL = ("stroke", "speed", "closing_time", "opening_time", "travel_time")
_NEVER_SMALL += ("touch_time", "separation_time")

Verdict = Mapping[str, object]
"""The verdict on a limit, "pass" or "fail" where the 95 % interval lies on one side of each bound,
else "inconclusive" with a "reason"; and the value, interval and "bounds" of each of its "parts".
"""


def worst(verdicts: Iterable[str]) -> str:
    """Return the worst of verdicts; empty without any."""
    return max(verdicts, key=VERDICTS.index, default="")


def interval_of(known: Known) -> tuple[float, np.ndarray]:
    """Return the value of a quantity, and the ends of its 95 % interval."""
    if isinstance(known, np.ndarray):
        middle, *ends = np.quantile(known, [0.5, *_ENDS])
        return middle, np.array(ends)
    away = NORMAL[95] * known.sd
    low = max(known.value - away, min(known.value, 0.0))  # a distance or time is not negative
    return known.value, np.array([low, known.value + away])


def known_of(estimate: Estimate, name: str) -> Known:
    """Return the posterior draws or the measurement of a quantity, or the reason for no value."""
    if reason := estimate.why_not(name):
        return NOTHING._replace(reason=reason)
    return estimate.inferred(name) if estimate.is_inferred(name) else estimate.measured[name]


def judge(
    limits: Iterable[Limit], find: Callable[[Limit, str], Known], *key: object
) -> list[Verdict]:
    """Return a verdict for each limit, and one for both sides of a reference or range. ``find``
    returns the knowledge of a quantity; ``key`` seeds measurement errors, by the seed first.
    """
    groups: dict[str | int, list[Limit]] = {}
    for limit in limits:
        groups.setdefault(limit.pair or id(limit), []).append(limit)
    return [_verdict(sides, find, key) for sides in groups.values()]


def _verdict(sides: Sequence[Limit], find: Callable, key: Sequence) -> Verdict:
    first = sides[0]  # both sides limit the same quantity
    name = first.pair or first.name
    known = [find(first, quantity) for quantity in first.quantities]
    parts = [part for limit in sides for part in _parts(limit, known)]
    reasons = [value.reason for value in known if isinstance(value, Measured) and value.reason]
    reasons += [text for part in parts if (text := _other_unit(name, part))]
    probability, verdict = np.nan, "inconclusive"
    if not reasons:
        shares = [_exceedance(limit, known, key) for limit in sides]
        probability = sum(shares)  # the two sides exclude each other
        verdict = VERDICTS[sum(max(shares) > end for end in _ENDS)]
        reasons = [say("bound-inside-interval") if verdict == "inconclusive" else ""]
    if first.pair:
        bounds = {is_upper: bound for limit in sides for _, bound, is_upper in limit.parts}
        parts = [parts[0] | {"bounds": [bounds.get(False), bounds.get(True)]}]
    fields = {"name": name, "motion": first.motion, "words": " or ".join(e.words for e in sides)}
    fields |= {"p_exceeded": probability, "verdict": verdict, "reason": note_of(reasons[0])}
    return fields | {"parts": parts}


def _parts(limit: Limit, known: Sequence[Known]) -> Iterator[dict[str, object]]:
    every = zip(limit.parts, limit.units, known, strict=True)
    for (name, bound, is_upper), unit, quantity in every:
        value, ends = interval_of(quantity)
        bounds = [None, bound] if is_upper else [bound, None]
        part = {"quantity": name, "unit": unit, "value": value, "interval_95": ends}
        yield part | {"bounds": bounds}


def _other_unit(limit: str, part: Mapping) -> str:
    """Return a doubt about a bound that is so far from its value that its unit may be wrong."""
    (bound,), value = (abs(e) for e in part["bounds"] if e is not None), abs(part["value"])
    if not (bound and value > 0.0 and part["quantity"].endswith(_NEVER_SMALL)):
        return ""
    times = max(bound / value, value / bound)
    numbers = {**part, "value": value, "bound": bound, "times": times}
    return say("limit-in-other-unit", limit=limit, **numbers) if times > _OTHER_UNIT else ""


def _exceedance(limit: Limit, known: Sequence[Known], key: Sequence) -> float:
    """Return the probability that known quantities exceed a limit."""
    if limit.of == "record" and all(not up and bound <= 0.0 for _, bound, up in limit.parts):
        return 0.0  # no distance or time of a record is below 0
    drawn = [quantity.size for quantity in known if isinstance(quantity, np.ndarray)]
    if not drawn:
        values, sds = np.array([quantity[:2] for quantity in known]).T
        return float(limit.measured_exceedance(values, sds))
    seed, *more = key
    rng = generator(seed, "limit", limit.name, *more)
    draws = rng.standard_normal((drawn[0], len(known)))
    for k, quantity in enumerate(known):
        measured = isinstance(quantity, Measured)
        draws[:, k] = quantity.value + quantity.sd * draws[:, k] if measured else quantity
    return float(limit.exceeded(draws).mean())


def judged(estimate: Estimate, limits: Sequence[Limit], *, seed: int) -> list[Verdict]:
    """Return verdicts on the limits of a record's motion; none for a rejected record.

    Parameters and the time of contact touch or separation are judged by their draws, others by
    their measurement, with normal errors. A limit ``of: record`` uses only quantities that the
    record alone shows. A limit ``of: change`` does not apply to a single record.
    """
    record = estimate.record
    if record.reason:
        return []

    def find(limit: Limit, name: str) -> Known:
        if no_drive := record.raw.no_drive:
            return estimate.measured.get(name, NOTHING)._replace(reason=no_drive)
        if limit.of == "model":
            return known_of(estimate, name)
        if estimate.measured_directly(name):
            return estimate.measured.get(name, NOTHING)
        of_model = name in QUANTITIES and "model" not in QUANTITIES[name].of
        code = "no-contact-channel" if of_model else "no-contact-channel-try-model"
        return NOTHING._replace(reason=say(code, event=EVENTS[record.motion]))

    limits = [entry for entry in limits if entry.motion == record.motion and entry.of != "change"]
    return judge(limits, find, seed, record.operation.number)


def simultaneity_of(poles: Sequence[Mapping], limits: Mapping[str, float | None]) -> dict:
    """Return the simultaneity of poles, by their recorded contacts.

    Times count within a common "record", or from the "trigger" of each file: the "base". ``limits``
    are the largest allowed times by motion, ms; None allows any time.
    """
    motion = poles[0]["motion"]
    base = "record" if len({pole["file"] for pole in poles}) == 1 else "trigger"
    simultaneity = {"operation": poles[0]["operation"], "motion": motion, "base": base}
    if (limit := limits.get(motion)) is not None:
        simultaneity["limit"] = limit
    times, unknown = {}, []
    for pole in poles:
        fit, phase = pole["fit"], pole.get("phase", "")
        zero = fit.get("trigger") if base == "trigger" else 0.0
        if zero is None or "contact_time" not in fit:
            unknown.append(phase)
        else:
            time = fit["first_motion"] + fit["contact_time"] - zero
            times[phase] = time, fit.get("contact_sd", 0.0)
    if len(times) < 2:
        words = {"event": EVENTS[motion], "poles": ", ".join(unknown)}
        return simultaneity | {"reason": note_of(say(f"simultaneity-unknown-by-{base}", **words))}
    first, last = min(times, key=times.get), max(times, key=times.get)
    (early, sd), (late, other) = times[first], times[last]
    spread = Measured(late - early, float(np.hypot(sd, other)), "")
    simultaneity |= {"value": spread.value, "sd": spread.sd, "first": first, "last": last}
    if limit is not None:
        simultaneity["verdict"] = VERDICTS[int((interval_of(spread)[1] > limit).sum())]
    return simultaneity
