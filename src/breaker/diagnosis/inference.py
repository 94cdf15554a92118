"""Posterior draws of the records of a drive, by the state networks of a family.

The records of both motions of an operation give one posterior, unless they contradict each other.
Recorded contacts, known values and a user's prior weight its draws. A recorded contact that
disagrees with the travel is left out, so that it never prevents an estimate; measured times and
speeds still use it. Other quantities are measured, at the inferred contact if none is recorded.
"""

from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from operator import itemgetter
from typing import NamedTuple

import numpy as np

from breaker.common.numerals import in_digits
from breaker.common.randomness import generator, systematic
from breaker.diagnosis.estimate import DriveRecord, Estimate, Given
from breaker.diagnosis.sentences import say
from breaker.family.membership import choose_family
from breaker.family.networks import StateNetwork
from breaker.family.shape import SHAPE_TIMES
from breaker.model.parameters import NAMES
from breaker.model.quantities import Speed

SURPRISING = 4.0
"""Standard deviations from which a contact, a known value or a prior disagrees with the travel.
Normal errors exceed them in 6e-5; errors of networks are larger for drives outside a family."""

# Number of weighted draws, and effective draws that are enough: 10 of 400 are beyond a quantile of
# 2.5 %. 400,000 draws take 10 s: only known values and priors use them. A contact that needs as
# many is left out.
_ROUNDS = ((4_000, 400), (40_000, 100), (400_000, 100))
_LEAST = 100  # effective draws of an estimate: they give the median an error of 0.13 sd
_ONE_DRIVE = 20.3  # squared distance of two posteriors of 7 parameters: 99.5 % of a chi-square


class Inference(NamedTuple):
    """The inference of drives by the networks of families.

    Attributes:
        families: Function that opens state networks, the narrowest family first. ``choose_family``
            selects one by the travel; if a recorded contact disagrees, the others are tried.
        given: Knowledge in addition to the records.
        draws, seed: Number of posterior draws of an estimate, and seed.
        misfit_p_value: p-value below which a record is outside a family.
    """

    families: Callable[[], Iterable[StateNetwork]]
    given: Given
    draws: int
    misfit_p_value: float
    seed: int

    def infer(self, records: Sequence[DriveRecord], speeds: tuple[Speed, ...]) -> list[Estimate]:
        """Infer all records of a drive, in their order, with definitions of its speeds."""
        usable = [record for record in records if not record.reason]
        estimates = self._infer_in(self.families(), usable) if usable else []
        if any(map(_contact_disagrees, estimates)):
            others = [levels for levels in self.families() if levels is not estimates[0].levels]
            wider = self._infer_in(others, usable) if others else estimates
            if not any(e.misfit or e.unresolved or _contact_disagrees(e) for e in wider):
                estimates = wider
        completed = {}
        for estimate in estimates:
            raw = estimate.record.raw
            measured_values = {"speeds": speeds, "measured": raw.measured(speeds, estimate.contact)}
            measured_values["remarks"] = (*raw.remarks_on(), *estimate.remarks)
            completed[id(estimate.record)] = replace(estimate, **measured_values)
        return [completed.get(id(record)) or Estimate(record) for record in records]

    def _infer_in(
        self, families: Iterable[StateNetwork], usable: Sequence[DriveRecord]
    ) -> list[Estimate]:
        """Infer records in the family for which they give most evidence."""
        levels, matches, _ = choose_family(
            families,
            lambda levels: [(e.motion, levels.match(e.motion, e.seen)) for e in usable],
            self.misfit_p_value,
        )
        estimates, operations = [], {}
        for record, (_, match) in zip(usable, matches, strict=True):
            misfit = match.p_value < self.misfit_p_value
            key = record.operation.number, record.operation.breaker, record.operation.phase
            group = estimates if misfit else operations.setdefault(key, [])
            group.append(Estimate(record, levels, match, misfit))
        for together in operations.values():
            parts = [together]
            if len(together) > 1 and (square := self._distance(together)) > _ONE_DRIVE:
                remark = say("motions-contradict", square=square, most=_ONE_DRIVE)
                parts = [[replace(estimate, remarks=(remark,))] for estimate in together]
            for part in parts:
                estimates += self._infer_together(part)
        return estimates

    def _distance(self, operation: Sequence[Estimate]) -> float:
        """Return the squared distance between the posteriors of both records of an operation."""
        rng = generator(self.seed, "motions", operation[0].record.operation.number)
        draw = partial(operation[0].levels.draw, draws=_ROUNDS[0][1], rng=rng, size=self.given.size)
        drawn = (draw({part.record.motion: part.record.seen}) for part in operation)
        return squared_distance(*(np.log(draws.theta) for draws in drawn))

    def _infer_together(
        self, operation: Sequence[Estimate], contacts: Collection[str] | None = None
    ) -> list[Estimate]:
        """Infer one operation by its travel and the recorded contacts of motions, all by default.

        If a contact is surprising, or too few draws are left, the most surprising is left out.
        """
        timed = {e.record.motion: e.record for e in operation if e.record.timed}
        contacts = set(timed) if contacts is None else contacts
        rng = generator(self.seed, "levels", operation[0].record.operation.number)
        count = self.draws
        drawn, weights, effective = self._weighted(operation, contacts, rng)
        draws, strokes = drawn[0].draws, drawn[0].stroke
        sds = {
            motion: float(_surprise(e.switched, e.raw.contact.sd, draws.switching[motion]))
            for motion, e in timed.items()
        }
        few = effective < min(_LEAST, weights.size / 2)
        worst = max(contacts, key=lambda motion: abs(sds[motion]), default="")
        if worst and (few or abs(sds[worst]) > SURPRISING):
            return self._infer_together(operation, contacts - {worst})
        fields = {"effective_size": effective, "contact_given": self.given.restricts}
        if few:
            reason = say("few-draws", left=round(effective), of=weights.size)
            fields |= {"draws": None, "stroke": None, "unresolved": reason}
        else:
            if weights.size != count or weights.min() < 1.0:
                chosen = systematic(weights, count, rng.random(), rng)
                draws, strokes = draws.of(chosen), None if strokes is None else strokes[chosen]
            share = np.log(draws.theta).var(axis=0) / self.given.prior_variance(drawn[0])
            fields |= {"draws": draws, "stroke": strokes, "prior_share": share}
        remarks = [*self._disagreements(drawn)]
        for k, part in enumerate(drawn):
            motion, doubts = part.record.motion, [*part.remarks]
            if motion in timed.keys() - contacts:
                late = in_digits(part.record.raw.contact.time - part.record.raw.moves, 4)
                doubts.append(say("contact-disagrees", time=late, sds=sds[motion]))
            drawn[k] = replace(part, remarks=(*doubts, *remarks), surprise=sds.get(motion, np.nan))
            drawn[k], remarks = replace(drawn[k], contact_used=motion in contacts, **fields), ()
        return drawn

    def _weighted(
        self, operation: Sequence[Estimate], contacts: Collection[str], rng: np.random.Generator
    ) -> tuple[list[Estimate], np.ndarray, float]:
        """Draw from the posterior of an operation until enough draws have weight.

        Returns:
            Estimates with all draws, weights of the draws, ``(d,)``, and their effective number.
        """
        seen = {estimate.record.motion: estimate.record.seen for estimate in operation}
        strokes = [estimate.record.raw.reading.quantities()["stroke"] for estimate in operation]
        rest = min((e for e in strokes if not e.reason), key=lambda e: e.sd, default=None)
        rounds = [*_ROUNDS] if self.given.restricts else [*_ROUNDS[:2]]
        if not (self.given.restricts or contacts):  # nothing weights the draws
            rounds[0] = self.draws, _LEAST
        # A user's prior may be wider than the family's prior at the given size.
        size, best = None if self.given.prior else self.given.size, (None, None, -1.0)
        for n, enough in rounds:
            if n == _ROUNDS[2][0] and best[2] * 10.0 < _LEAST:
                break  # even ten times the draws would be too few
            draws = operation[0].levels.draw(seen, n, rng, size=size)
            stroke = None if rest is None else rng.spawn(1)[0].normal(rest.value, rest.sd, n)
            fields = {"draws": draws, "stroke": stroke, "motions": tuple(draws.release)}
            drawn = [replace(estimate, **fields) for estimate in operation]
            weights = self._weights(drawn, contacts) * _possible(drawn)
            effective = float(weights.sum() ** 2 / (np.square(weights).sum() or 1.0))
            best = max(best, (drawn, weights, effective), key=itemgetter(2))
            if best[2] >= min(enough, n / 2):
                break
        return best

    def _weights(self, estimates: Sequence[Estimate], contacts: Collection[str]) -> np.ndarray:
        """Return weights of draws, ``(d,)``, the largest 1; all 0 if none is possible."""
        draws, given = estimates[0].draws, self.given
        log = np.zeros(len(draws.theta))
        if given.prior is not None:
            family = given.family_prior(estimates[0])
            with np.errstate(invalid="ignore"):
                log += given.prior.log_prob(draws.theta) - family.log_prob(draws.theta)
            # Draws without a given size lack the part of the family's prior along the size.
            along = family.standardise(draws.theta) @ family.size_axes
            log -= 0.5 * np.square(along).sum(axis=1)
        for record in (estimate.record for estimate in estimates):
            if record.motion in contacts:
                late = draws.switching[record.motion] - record.switched
                log -= 0.5 * np.square(late / record.raw.contact.sd)
        for name, (value, sd) in given.known.items():
            if (drawn := _drawn(estimates, name)) is not None:
                log -= 0.5 * np.square((drawn - value) / sd)
        log = np.where(np.isfinite(log), log, -np.inf)
        return np.exp(log - log.max()) if np.isfinite(log.max()) else np.zeros(log.size)

    def _disagreements(self, estimates: Sequence[Estimate]) -> Iterator[str]:
        """Yield remarks on known values and medians of a prior that disagree with the travel."""
        for name, (value, sd) in self.given.known.items():
            drawn = _drawn(estimates, name)
            if drawn is not None and abs(sds := _surprise(value, sd, drawn)) > SURPRISING:
                numbers = {"value": in_digits(value, 4), "sd": in_digits(sd, 4)}
                yield say("known-value-disagrees", name=name, sds=sds, **numbers)
            elif drawn is None and name == "spring_compression":
                yield say("known-value-unused", name=name)
        if (prior := self.given.prior) is not None:
            logs = np.log(estimates[0].draws.theta)
            deviations = _surprise(np.log(prior.medians), prior.log_sds, logs)
            worst = int(np.abs(deviations).argmax())
            if abs(deviations[worst]) > SURPRISING:
                yield say("prior-disagrees", name=NAMES[worst], sds=deviations[worst])


def _contact_disagrees(estimate: Estimate) -> bool:
    return estimate.record.timed and not estimate.misfit and not estimate.contact_used


def _possible(estimates: Sequence[Estimate]) -> np.ndarray:
    """Return which draws ``(d,)`` compress the contact spring, and switch the contact between the
    rest positions.
    """
    compression = estimates[0].inferred("spring_compression")
    possible = True if compression is None else compression > 0.0
    for estimate in estimates:
        shape, motion = estimate.record.shape, estimate.record.motion
        times = estimate.draws.switching[motion] / shape.duration
        arrival = np.min(SHAPE_TIMES[shape.way >= 1.0], initial=np.inf)
        possible = possible & (times < arrival) & (np.interp(times, SHAPE_TIMES, shape.way) > 0.0)
    return possible


def _surprise(value: np.ndarray, sd: np.ndarray, draws: np.ndarray) -> np.ndarray:
    """Return how far values ``(...)`` are from draws ``(d, ...)``, in sds of both."""
    return (value - draws.mean(axis=0)) / np.hypot(draws.std(axis=0), sd)


def _drawn(estimates: Sequence[Estimate], name: str) -> np.ndarray | None:
    """Return draws of a quantity, ``(d,)``, from the first record that has them."""
    drawn = (estimate.inferred(name) for estimate in estimates)
    return next((draws for draws in drawn if draws is not None), None)


def squared_distance(one: np.ndarray, other: np.ndarray) -> float:
    """Return the squared Mahalanobis distance between the means of two sets of draws ``(d, p)``."""
    off = one.mean(axis=0) - other.mean(axis=0)
    return float(off @ np.linalg.solve(np.cov(one.T) + np.cov(other.T), off))
