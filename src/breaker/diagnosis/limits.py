"""Which limits are kept: every limit has a row with what is known of its quantities."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from breaker.common.numerals import in_digits
from breaker.common.plain_values import Plain
from breaker.common.randomness import generator
from breaker.diagnosis.estimate import MAY_SLIDE, NOTHING, WITH_CONTACT, Estimate
from breaker.model.limits import Limit
from breaker.model.quantities import EVENTS, QUANTITIES

VERDICTS = ("pass", "not shown", "fail")
"""Verdicts on a limit, the worst last."""

RESULTS = {
    "fail": ("FAIL", "bad"),
    "not shown": ("not shown", "doubt"),
    "pass": ("pass", "good"),
}
"""Text and tone of verdicts, the worst first."""

NORMAL = {90: 1.645, 95: 1.96}
"""Half of a central interval of a normal number, sds, by the percent that it holds."""

_TIMES = 20.0  # by which no limit is off what it is of,
_MAY_BE_SMALL = {"over_travel", "opening_over_travel", "bounce_time"}  # but of these
_MAY_BE_SMALL |= {
    "reaction_time",
    "spring_compression",
    "closing_wipe",
    "opening_wipe",
    "arcing_wipe",
}
_ENDS = 0.025, 0.975  # of a 95 % interval


class Told(NamedTuple):
    """What is known of a quantity.

    Attributes:
        value, sd: Measured, in its unit; nan if it is not.
        draws: Inferred, ``(d,)``; None if it is not.
        reason: Why it is neither; empty if it is one.
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


@dataclass(frozen=True)
class JudgedPart(Plain):
    """A quantity of a limit: its value, and least and largest that pass, None where all do; what
    these are a tolerance away from, if there is such a reference.
    """

    quantity: str
    unit: str
    value: float | None
    interval_95: Sequence[float | None]
    bounds: Sequence[float | None]
    reference: float | None = None


@dataclass(frozen=True)
class Verdict(Plain):
    """What is known of a limit: "pass" and "fail" where the 95 % interval is on one side of each
    bound, else "not shown" with a reason. Both sides of a reference are one part.
    """

    name: str
    motion: str
    words: str
    probability: float | None  # that it is exceeded
    verdict: str
    reason: str
    parts: Sequence[JudgedPart]


def judge(limits: Iterable[Limit], reader: object, *key: object) -> list[Verdict]:
    """Return a verdict for each limit, and one for both sides of a reference.

    Args:
        reader: Tells what is known of a quantity of a limit, as ``Told``.
        key: Of the generator of errors of what is measured, the seed first.
    """
    groups: dict[str, list[Limit]] = {}
    for limit in limits:
        groups.setdefault(limit.pair or limit.name, []).append(limit)
    return [_verdict(name, sides, reader, key) for name, sides in groups.items()]


def _verdict(name: str, sides: Sequence[Limit], reader: object, key: Sequence) -> Verdict:
    known = [[limit.read(reader, quantity) for quantity in limit.quantities] for limit in sides]
    reasons = dict.fromkeys(each.reason for some in known for each in some if each.reason)
    reasons |= dict.fromkeys(filter(None, map(_far, sides, known)))
    probability, verdict, reason = np.nan, "not shown", "; ".join(reasons)
    if not reasons:
        shares = [_exceedance(*both, key) for both in zip(sides, known, strict=True)]
        probability, most = min(sum(shares), 1.0), max(shares)
        verdict = VERDICTS[sum(most > each for each in _ENDS)]
        reason = "the bound is within the 95 % interval" if verdict == "not shown" else ""
    parts = [part for both in zip(sides, known, strict=True) for part in _parts(*both)]
    if sides[0].pair:  # both sides are of the same quantity
        ends = zip(*(part.bounds for part in parts), strict=True)
        bounds = [next((each for each in end if each is not None), None) for end in ends]
        parts = [replace(parts[0], bounds=bounds)]
    words = " or ".join(limit.words for limit in sides)
    return Verdict(name, sides[0].motion, words, probability, verdict, reason, parts)


def _parts(limit: Limit, known: Sequence[Told]) -> Iterator[JudgedPart]:
    """The quantities of a limit, with what is known of each."""
    for (name, bound, is_upper), unit, each in zip(limit.parts, limit.units, known, strict=True):
        bounds = [None, bound] if is_upper else [bound, None]
        yield JudgedPart(name, unit, *each.interval, bounds, limit.reference)


def _far(limit: Limit, known: Sequence[Told]) -> str:
    """Why a limit cannot be in the unit that it stands for: far from what it is of; "" else."""
    for (name, bound, _), unit, each in zip(limit.parts, limit.units, known, strict=True):
        value = np.nan if each.reason else abs(each.interval[0])
        off = abs(bound) / value if value > 0.0 else np.nan
        small = name in _MAY_BE_SMALL or unit == "%"
        if not small and bound and (off > _TIMES or off < 1.0 / _TIMES):
            return (
                f"{limit.name}: {in_digits(bound, 4)} {unit} is {in_digits(max(off, 1 / off), 2)} "
                f"times off the {name} of {in_digits(value, 4)} {unit}: is the limit in {unit}?"
            )
    return ""


def _exceedance(limit: Limit, known: Sequence[Told], key: Sequence) -> float:
    """Probability that a limit is exceeded, of quantities that are known."""
    if limit.of == "record" and all(not up and bound <= 0.0 for _, bound, up in limit.parts):
        return 0.0  # a record shows no distance or time below 0
    values, sds = np.array([(each.value, each.sd) for each in known]).T
    drawn = [each.draws for each in known if each.draws is not None]
    if not drawn:
        return float(limit.measured_exceedance(values, sds))
    rng = generator(*key[:1], "limit", limit.name, *key[1:])
    draws = values + sds * rng.standard_normal((drawn[0].size, len(known)))
    for k, each in enumerate(known):
        if each.draws is not None:
            draws[:, k] = each.draws
    return float(limit.exceeded(draws).mean())


def judged(answer: Estimate, limits: Sequence[Limit], *, seed: int) -> list[Verdict]:
    """Return what ``judge`` does of the limits of a record's motion; none of a rejected record.

    Parameters and the time of touch or separation are judged by their draws; all else as measured,
    with normal errors. A limit ``of: record`` takes only what the record shows by itself; one
    ``of: change`` is of no single record.
    """
    record = answer.record
    if record.reason:
        return []
    limits = [each for each in limits if each.motion == record.motion and each.of != "change"]
    return judge(limits, _Single(answer), seed, record.operation.number)


@dataclass(frozen=True, eq=False)
class _Single:
    """What an answer of one record tells of a quantity of a limit, by the limit's source."""

    answer: Estimate

    def of_record(self, limit: Limit, name: str) -> Told:
        if not self.answer.alone(name):
            of_model = name not in QUANTITIES or "model" in QUANTITIES[name].of
            takes = ", and of: model takes the inferred one" * of_model
            event = EVENTS[limit.motion]
            return Told(reason=f"no contact channel: {event} was not measured{takes}")
        return self._withheld(name) or self._measured(name)

    def of_model(self, _limit: Limit, name: str) -> Told:
        if withheld := self._withheld(name):
            return withheld
        inferred = self.answer.is_inferred(name)
        if self.answer.draws is None and (inferred or not self.answer.alone(name)):
            return Told(reason=self.answer.why_not_inferred)
        return Told(draws=self.answer.inferred(name)) if inferred else self._measured(name)

    def of_change(self, _limit: Limit, _name: str) -> Told:
        return Told(reason="of no single record")

    def _withheld(self, name: str) -> Told | None:
        """Nothing of a contact that may slide."""
        withheld = self.answer.draws is not None and self.answer.may_slide
        return Told(reason=MAY_SLIDE) if withheld and name in WITH_CONTACT else None

    def _measured(self, name: str) -> Told:
        measured = self.answer.measured.get(name, NOTHING)
        return Told(measured.value, measured.sd, None, measured.reason)
