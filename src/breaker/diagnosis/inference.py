"""Posterior draws of the records of a drive, by the state networks of a family.

The records of both motions of an operation give one posterior, unless they contradict each other.
Recorded contacts, known values and a prior of one's own weight its draws. A recorded contact that
disagrees with the travel has no weight, so that it never costs an estimate; measured times and
speeds keep it. Everything else is measured, at the inferred contact where none is recorded.
"""

from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import replace
from itertools import tee

import numpy as np

from breaker.common.numerals import in_digits
from breaker.common.randomness import generator, systematic
from breaker.diagnosis.estimate import DriveRecord, Estimate, EstimateSettings, Given
from breaker.diagnosis.words import say
from breaker.family.membership import choose_family
from breaker.family.networks import StateNetwork
from breaker.family.shape import SHAPE_TIMES
from breaker.model.parameters import NAMES, Size
from breaker.model.quantities import Speed

SURPRISING = 4.0
"""Standard deviations from which on a contact, a known value or a prior disagrees with the travel:
6e-5 of normal errors, and networks err by more than their intervals for drives of other kinds."""

# Draws that are weighted, more where few are left. 400,000 take 10 s: they are for known values and
# priors, and only where they can be enough. A contact that needs as many is left out.
_ROUNDS = (4_000, 40_000, 400_000)
_ENOUGH = 400.0  # effective draws that need no further round: quantiles of 2.5 % have 10 beyond
_LEAST = 100.0  # effective draws of an estimate: an error of the median of 0.13 sd
_DRAWS = 1_000  # of either motion, for mean and covariance in the test of their contradiction
_ONE_DRIVE = 20.3  # squared distance of two posteriors of 7 parameters, 99.5 % of a chi-square


def infer_drive(
    records: Sequence[DriveRecord],
    families: Iterable[StateNetwork],
    given: Given,
    speeds: tuple[Speed, ...],
    settings: EstimateSettings,
) -> list[Estimate]:
    """Infer all records of a drive, in their order.

    Args:
        records: The records.
        families: State networks, the narrowest family first; ``choose_family`` selects one by the
            travel. Where a recorded contact disagrees with it, the other families are tried.
        given: Knowledge besides the records.
        speeds: Definitions of speeds.
        settings: Settings of the estimates.
    """
    usable = [record for record in records if not record.reason]
    if not usable:
        return [Estimate(record) for record in records]
    families, again = tee(families)
    estimates = _infer_in(families, usable, given, speeds, settings)
    if any(map(_contact_disagrees, estimates)):
        others = [levels for levels in again if levels is not estimates[0].levels]
        wider = _infer_in(others, usable, given, speeds, settings) if others else estimates
        if not any(e.misfit or e.unresolved or _contact_disagrees(e) for e in wider):
            estimates = wider
    by_record = {id(estimate.record): _measured(estimate) for estimate in estimates}
    return [by_record.get(id(record), Estimate(record)) for record in records]


def _contact_disagrees(estimate: Estimate) -> bool:
    return estimate.record.timed and not estimate.misfit and not estimate.contact_used


def _measured(estimate: Estimate) -> Estimate:
    """Add what the record shows, at the inferred contact where none is recorded."""
    raw = estimate.record.raw
    remarks = (*raw.remarks_on(), *estimate.remarks)
    measured = raw.measured(estimate.speeds, estimate.contact)
    return replace(estimate, measured=measured, remarks=remarks)


def _infer_in(
    families: Iterable[StateNetwork],
    usable: Sequence[DriveRecord],
    given: Given,
    speeds: tuple[Speed, ...],
    settings: EstimateSettings,
) -> list[Estimate]:
    """Infer records in the family of which they give most evidence."""
    levels, matches, _ = choose_family(
        families,
        lambda levels: [(one.motion, levels.match(one.motion, one.seen)) for one in usable],
        settings.misfit_p_value,
    )
    estimates, operations = [], {}
    for record, (_, match) in zip(usable, matches, strict=True):
        misfit = match.p_value < settings.misfit_p_value
        estimate = Estimate(record, levels, match, misfit, speeds)
        key = record.operation.number, record.operation.breaker, record.operation.phase
        if misfit:
            estimates.append(estimate)
        else:
            operations.setdefault(key, []).append(estimate)
    for operation in operations.values():
        remark = _contradiction(operation, given, settings.seed) if len(operation) > 1 else ""
        alone = [[replace(estimate, remarks=(remark,))] for estimate in operation]
        for together in alone if remark else [operation]:
            estimates += _infer_together(together, given, settings)
    return estimates


def _infer_together(
    operation: Sequence[Estimate], given: Given, settings: EstimateSettings
) -> list[Estimate]:
    """Infer one operation, without recorded contacts that disagree with its travel."""
    contacts = {estimate.record.motion for estimate in operation if estimate.record.timed}
    while True:
        rng = generator(settings.seed, "levels", operation[0].record.operation.number)
        estimates, weights = _weighted(operation, given, contacts, settings.draws, rng)
        few = estimates[0].effective_size < min(_LEAST, weights.size / 2)
        off = {e.record.motion: abs(e.surprise) for e in estimates if e.contact_used}
        disagree = {motion for motion, sds in off.items() if sds > SURPRISING}
        if few and off:
            disagree = disagree or {max(off, key=off.get)}
        if not disagree:
            break
        contacts -= disagree
    remarks = [*_disagreements(estimates, given)]
    if few:
        why = say("few-draws", left=round(estimates[0].effective_size), of=weights.size)
        inferred = {"draws": None, "stroke": None, "unresolved": why}
    else:
        draws, strokes = estimates[0].draws, estimates[0].stroke
        if weights.size != settings.draws or weights.min() < 1.0:
            chosen = systematic(weights, settings.draws, rng.random(), rng)
            draws, strokes = draws.of(chosen), None if strokes is None else strokes[chosen]
        share = np.square(np.log(draws.theta).std(axis=0) / given.prior_log_sds(estimates[0]))
        inferred = {"draws": draws, "stroke": strokes, "prior_share": share}
    first = [replace(estimates[0], remarks=(*estimates[0].remarks, *remarks)), *estimates[1:]]
    return [replace(estimate, **inferred) for estimate in first]


def _weighted(
    operation: Sequence[Estimate],
    given: Given,
    contacts: Collection[str],
    count: int,
    rng: np.random.Generator,
) -> tuple[list[Estimate], np.ndarray]:
    """Draw from the posterior of an operation until enough draws have weight.

    Args:
        contacts: Motions whose recorded contact is used.
        count: Draws of the estimate, all that are needed where nothing weights them.

    Returns:
        The estimates with all draws, and weights of these, ``(d,)``, the largest 1.
    """
    seen = {estimate.record.motion: estimate.record.seen for estimate in operation}
    measured = [estimate.record.raw.reading.quantities()["stroke"] for estimate in operation]
    rest = min((one for one in measured if not one.reason), key=lambda one: one.sd, default=None)
    restricted = given.prior is not None or bool(given.known)
    first = _ROUNDS[0] if restricted or contacts else count
    rounds = [(first, given.size), (_ROUNDS[1], given.size)]
    if given.prior is not None:  # it may be wider than the family's, whose draws then lack its ends
        rounds.append((_ROUNDS[1], None))
    if restricted:
        rounds.append((_ROUNDS[2], given.size))
    best = None, None, -1.0
    for n, size in rounds:
        if n == _ROUNDS[2] and not _LEAST / 10 <= best[2] < _LEAST:
            break
        draws = operation[0].levels.draw(seen, n, rng, size=size)
        strokes = None if rest is None else rng.spawn(1)[0].normal(rest.value, rest.sd, n)
        about = {"draws": draws, "stroke": strokes, "motions": tuple(draws.release)}
        estimates = [replace(estimate, **about) for estimate in operation]
        weights = _weights(estimates, given, size, contacts) * _possible(estimates)
        weights /= weights.max() or 1.0
        effective = float(weights.sum() ** 2 / (np.square(weights).sum() or 1.0))
        if effective > best[2]:
            best = estimates, weights, effective
        if effective >= min(_ENOUGH, n / 2):
            break
    estimates, weights, effective = best
    about = {"effective_size": effective, "contact_given": restricted}
    return [_with_contact(replace(e, **about), contacts) for e in estimates], weights


def _with_contact(estimate: Estimate, contacts: Collection[str]) -> Estimate:
    """Compare the recorded contact with the draws, and remark where it is left out."""
    record = estimate.record
    if not record.timed:
        return estimate
    contact, remarks = record.raw.contact, estimate.remarks
    sds = float(_surprise(record.switched, contact.sd, estimate.draws.switching[record.motion]))
    if not (used := record.motion in contacts):
        time = in_digits(contact.time - record.raw.moves, 4)
        remarks = (*remarks, say("contact-disagrees", time=time, sds=sds))
    return replace(estimate, contact_used=used, surprise=sds, remarks=remarks)


def _surprise(value: np.ndarray, sd: np.ndarray, draws: np.ndarray) -> np.ndarray:
    """Return how far values ``(...)`` are from draws ``(d, ...)``, in sds of both."""
    return (value - draws.mean(axis=0)) / np.hypot(draws.std(axis=0), sd)


def _drawn(estimates: Sequence[Estimate], name: str) -> np.ndarray | None:
    """Return draws of a quantity, ``(d,)``, by the first record that has it."""
    drawn = (estimate.inferred(name) for estimate in estimates)
    return next((draws for draws in drawn if draws is not None), None)


def _disagreements(estimates: Sequence[Estimate], given: Given) -> Iterator[str]:
    """Yield remarks on known values and medians of a prior that disagree with the travel."""
    for name, (value, sd) in given.known.items():
        drawn = _drawn(estimates, name)
        if drawn is not None and abs(sds := _surprise(value, sd, drawn)) > SURPRISING:
            about = {"value": in_digits(value, 4), "sd": in_digits(sd, 4)}
            yield say("known-value-disagrees", name=name, sds=sds, **about)
        elif drawn is None and name == "spring_compression":
            yield say("known-value-unused", name=name)
    if given.prior is not None:
        logs = np.log(estimates[0].draws.theta)
        every = _surprise(np.log(given.prior.medians), given.prior.log_sds, logs)
        worst = int(np.abs(every).argmax())
        if abs(every[worst]) > SURPRISING:
            yield say("prior-disagrees", name=NAMES[worst], sds=every[worst])


def _weights(
    estimates: Sequence[Estimate], given: Given, size: Size | None, contacts: Collection[str]
) -> np.ndarray:
    """Return weights of draws at a size, ``(d,)``, the largest 1; all 0 if none is possible."""
    draws = estimates[0].draws
    log = np.zeros(len(draws.theta))
    if given.prior is not None:
        family = given.family_prior(estimates[0])
        with np.errstate(invalid="ignore"):
            log += given.prior.log_prob(draws.theta) - family.log_prob(draws.theta)
        if size is None:  # draws of an unknown size lack the part of the family's prior along sizes
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


def _possible(estimates: Sequence[Estimate]) -> np.ndarray:
    """Return which draws ``(d,)`` compress the contact spring, and switch the contact on the way
    between the rest positions.
    """
    compression = estimates[0].inferred("spring_compression")
    possible = True if compression is None else compression > 0.0
    for estimate in estimates:
        shape, motion = estimate.record.shape, estimate.record.motion
        at = estimate.draws.switching[motion] / shape.duration
        arrival = np.min(SHAPE_TIMES[shape.way >= 1.0], initial=np.inf)
        possible = possible & (at < arrival) & (np.interp(at, SHAPE_TIMES, shape.way) > 0.0)
    return possible


def _contradiction(operation: Sequence[Estimate], given: Given, seed: int) -> str:
    """Return a remark if the posteriors of both records are too far from each other; "" if not."""
    rng = generator(seed, "motions", operation[0].record.operation.number)
    logs = []
    for estimate in operation:
        seen = {estimate.record.motion: estimate.record.seen}
        drawn = estimate.levels.draw(seen, _DRAWS, rng, size=given.size)
        logs.append(np.log(drawn.theta))
    square = squared_distance(*logs)
    return say("motions-contradict", square=square, most=_ONE_DRIVE) if square > _ONE_DRIVE else ""


def squared_distance(one: np.ndarray, other: np.ndarray) -> float:
    """Return the squared Mahalanobis distance between the means of draws ``(d, p)`` and others."""
    off = one.mean(axis=0) - other.mean(axis=0)
    return float(off @ np.linalg.solve(np.cov(one.T) + np.cov(other.T), off))
