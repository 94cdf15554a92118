"""Verdicts on limits: of quantities of a record or a change, and of the simultaneity of poles."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from breaker.common.numerals import in_digits
from breaker.common.plain_values import Note, Plain, note_of
from breaker.common.randomness import generator
from breaker.diagnosis.estimate import NOTHING, Estimate
from breaker.diagnosis.words import say
from breaker.model.limits import Limit
from breaker.model.quantities import EVENTS, QUANTITIES

if TYPE_CHECKING:
    from breaker.diagnosis.result import RecordResult

VERDICTS = ("pass", "inconclusive", "fail")
"""Verdicts on a limit, the worst last."""

NORMAL = {90: 1.645, 95: 1.96}
"""Half of a central interval of a normal number in sds, by its coverage in percent."""

_ENDS = 0.025, 0.975  # ends of a 95 % interval
# No maker's limit is 20 times off a usual value; a limit in m instead of mm, or s instead of ms, is
# 1000 times off.
_OTHER_UNIT = 20.0
_NEVER_SMALL = ("stroke", "speed", "closing_time", "opening_time", "travel_time")
_NEVER_SMALL += ("touch_time", "separation_time")


class Evidence(NamedTuple):
    """What is known of a quantity.

    Attributes:
        value, sd: Measured value and its standard deviation; nan without one.
        draws: Posterior draws, ``(d,)``; None without them.
        reason: Why neither is known; empty if one is.
    """

    value: float = np.nan
    sd: float = np.nan
    draws: np.ndarray | None = None
    reason: str = ""

    @property
    def interval(self) -> tuple[float, np.ndarray]:
        """Value, and the ends of its 95 % interval."""
        if self.draws is None:
            return self.value, self.value + NORMAL[95] * self.sd * np.array([-1.0, 1.0])
        middle, *ends = np.quantile(self.draws, [0.5, *_ENDS])
        return middle, np.array(ends)

    @property
    def known(self) -> dict:
        """Median, and the ends of the 95 % interval, by name."""
        middle, ends = self.interval
        return {"median": middle, "interval_95": ends}


@dataclass(frozen=True)
class JudgedPart(Plain):
    """A quantity of a limit: its value, the least and largest that pass (None where all do), and
    the reference from which these are a tolerance away, if there is one.
    """

    quantity: str
    unit: str
    value: float | None
    interval_95: Sequence[float | None]
    bounds: Sequence[float | None]
    reference: float | None = None


@dataclass(frozen=True)
class Verdict(Plain):
    """The verdict on a limit: "pass" or "fail" where the 95 % interval lies on one side of each
    bound, else "inconclusive" with a reason. Both sides of a reference are one part.
    """

    name: str
    motion: str
    words: str
    p_exceeded: float | None
    verdict: str
    reason: Note | None
    parts: Sequence[JudgedPart]


def judge(
    limits: Iterable[Limit], evidence: Callable[[Limit, str], Evidence], *key: object
) -> list[Verdict]:
    """Return a verdict for each limit, and one for both sides of a reference.

    Args:
        limits: The limits.
        evidence: Returns what is known of a quantity of a limit.
        key: Key of the generator of measurement errors, the seed first.
    """
    groups: dict[str, list[Limit]] = {}
    for limit in limits:
        groups.setdefault(limit.pair or limit.name, []).append(limit)
    return [_verdict(name, sides, evidence, key) for name, sides in groups.items()]


def _verdict(name: str, sides: Sequence[Limit], evidence: Callable, key: Sequence) -> Verdict:
    known = [[evidence(limit, quantity) for quantity in limit.quantities] for limit in sides]
    parts = [part for both in zip(sides, known, strict=True) for part in _parts(*both)]
    reasons = [each.reason for some in known for each in some if each.reason]
    reasons += [text for part in parts if (text := _other_unit(name, part))]
    probability, verdict = np.nan, "inconclusive"
    if not reasons:
        shares = [_exceedance(*both, key) for both in zip(sides, known, strict=True)]
        probability = min(sum(shares), 1.0)
        verdict = VERDICTS[sum(max(shares) > end for end in _ENDS)]
        reasons = [say("bound-inside-interval")] if verdict == "inconclusive" else [""]
    if sides[0].pair:  # both sides are of the same quantity
        ends = zip(*(part.bounds for part in parts), strict=True)
        bounds = [next((bound for bound in end if bound is not None), None) for end in ends]
        parts = [replace(parts[0], bounds=bounds)]
    words = " or ".join(limit.words for limit in sides)
    reason = note_of(reasons[0])
    return Verdict(name, sides[0].motion, words, probability, verdict, reason, parts)


def _parts(limit: Limit, known: Sequence[Evidence]) -> Iterator[JudgedPart]:
    for (name, bound, is_upper), unit, some in zip(limit.parts, limit.units, known, strict=True):
        bounds = [None, bound] if is_upper else [bound, None]
        yield JudgedPart(name, unit, *some.interval, bounds, limit.reference)


def _other_unit(limit: str, part: JudgedPart) -> str:
    """Return a doubt on a bound that is far from its quantity, as one in another unit is."""
    (bound,), value = (abs(each) for each in part.bounds if each is not None), abs(part.value)
    if not (bound and value > 0.0 and part.quantity.endswith(_NEVER_SMALL)):
        return ""
    times = max(bound / value, value / bound)
    if times <= _OTHER_UNIT:
        return ""
    numbers = {"bound": in_digits(bound, 4), "value": in_digits(value, 4)}
    about = {"quantity": part.quantity, "unit": part.unit, "times": in_digits(times, 2)}
    return say("limit-in-other-unit", limit=limit, **about, **numbers)


def _exceedance(limit: Limit, known: Sequence[Evidence], key: Sequence) -> float:
    """Return the probability that a limit is exceeded by quantities that are known."""
    if limit.of == "record" and all(not up and bound <= 0.0 for _, bound, up in limit.parts):
        return 0.0  # no distance or time of a record is below 0
    values, sds = np.array([(some.value, some.sd) for some in known]).T
    drawn = [some.draws for some in known if some.draws is not None]
    if not drawn:
        return float(limit.measured_exceedance(values, sds))
    rng = generator(*key[:1], "limit", limit.name, *key[1:])
    draws = values + sds * rng.standard_normal((drawn[0].size, len(known)))
    for k, some in enumerate(known):
        if some.draws is not None:
            draws[:, k] = some.draws
    return float(limit.exceeded(draws).mean())


def judged(estimate: Estimate, limits: Sequence[Limit], *, seed: int) -> list[Verdict]:
    """Return verdicts on the limits of a record's motion; none of a rejected record.

    Parameters and the time of contact touch or separation are judged by their draws, all else as
    measured, with normal errors. A limit ``of: record`` takes only what the record alone shows. A
    limit ``of: change`` does not apply to a single record.
    """
    record = estimate.record
    if record.reason:
        return []
    limits = [each for each in limits if each.motion == record.motion and each.of != "change"]
    find = lambda limit, name: _evidence(estimate, limit, name)  # noqa: E731
    return judge(limits, find, seed, record.operation.number)


def _evidence(estimate: Estimate, limit: Limit, name: str) -> Evidence:
    """Return posterior draws for the model where there are any, else what was measured."""
    if limit.of == "record" and not estimate.measured_directly(name):
        of_model = name in QUANTITIES and "model" not in QUANTITIES[name].of
        code = "no-contact-channel" if of_model else "no-contact-channel-try-model"
        return Evidence(reason=say(code, event=EVENTS[estimate.record.motion]))
    if limit.of == "model" and (reason := estimate.why_not(name)):
        return Evidence(reason=reason)
    if limit.of == "model" and estimate.is_inferred(name):
        return Evidence(draws=estimate.inferred(name))
    measured = estimate.measured.get(name, NOTHING)
    return Evidence(measured.value, measured.sd, None, measured.reason)


# ---- simultaneity --------------------------------------------------------------------------------


@dataclass(frozen=True, kw_only=True)
class Simultaneity(Plain):
    """Time between the first and the last pole of an operation, by their recorded contacts.

    Attributes:
        operation, motion: Operation and motion of the poles.
        value, sd: The time and its standard deviation, ms; None if unknown, with a reason.
        first, last: The poles.
        base: Whether times count within one "record", or each from the "trigger" of its file.
        limit: Largest allowed time, ms; None without one.
        verdict: Verdict on the limit, if there are a value and a limit.
    """

    operation: int
    motion: str
    value: float | None = None
    sd: float | None = None
    first: str | None = None
    last: str | None = None
    base: str
    limit: float | None = None
    verdict: str | None = None
    reason: Note | None = None


def simultaneity_of(
    poles: Sequence["RecordResult"], limits: Mapping[str, float | None]
) -> Simultaneity:
    """Return how simultaneously poles switch.

    Args:
        poles: Accepted records of one motion of an operation, two poles or more.
        limits: Largest allowed time by motion, ms; None for any.
    """
    motion = poles[0].motion
    timed = [each for each in poles if each.fit.contact_time is not None]
    base = "record" if len({each.file for each in poles}) == 1 else "trigger"
    about = {"operation": poles[0].operation, "motion": motion, "base": base}
    about["limit"] = limits.get(motion)
    untimed = [each.phase for each in poles if each not in timed]
    no_trigger = [each.phase for each in timed if base == "trigger" and each.fit.trigger is None]
    if len(timed) < 2 or no_trigger:
        code, names = ("unseen", untimed) if len(timed) < 2 else ("no-trigger", no_trigger)
        reason = say(f"simultaneity-{code}", event=EVENTS[motion], poles=", ".join(names))
        return Simultaneity(**about, reason=note_of(reason))
    zeros = [each.fit.trigger if base == "trigger" else 0.0 for each in timed]
    times = [each.fit.switches - zero for each, zero in zip(timed, zeros, strict=True)]
    first, last = timed[int(np.argmin(times))], timed[int(np.argmax(times))]
    value = max(times) - min(times)
    sd = float(np.hypot(first.fit.contact_sd or 0.0, last.fit.contact_sd or 0.0))
    about |= {"value": value, "sd": sd, "first": first.phase, "last": last.phase}
    if about["limit"] is not None:
        ends = value + NORMAL[95] * sd * np.array([-1.0, 1.0])
        about["verdict"] = VERDICTS[int((ends > about["limit"]).sum())]
    return Simultaneity(**about)
