"""Weights of a network's draws, given a prior of the drive, facts about it, or a timed contact."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from breaker.common.numerals import in_digits
from breaker.diagnosis.estimate import Estimate, Given
from breaker.family.networks import agreement_of
from breaker.family.shape import SHAPE_TIMES
from breaker.family.untold import APART
from breaker.model.parameters import NAMES, Size

_CONTRADICTED = 3.0  # sd, of a fact
SURPRISING = 4.0
"""Standard deviations of the contact's time from which on it contradicts the curve."""

_DRAWS = 1000  # of each motion, by which they are held against each other
_LEAST = np.log(0.01)  # evidence of one drive, of which pairs of one have less in at most 1 %
_SURE = 1e-3  # of the prior's variance, that two records leave at most less than nothing


def weights_of(answers: Sequence[Estimate], given: Given, size: Size | None) -> np.ndarray:
    """Weights of draws ``(d,)`` at a size, their sum 1; all 0 where none is possible.

    A contact whose time contradicts the curve is of another phase or record, and is not used.
    """
    draws = answers[0].draws
    log = np.zeros(len(draws.theta))
    if given.prior is not None:
        family = replace(given, prior=None).prior_of(answers[0].levels)
        with np.errstate(invalid="ignore"):
            log += given.prior.log_prob(draws.theta) - family.log_prob(draws.theta)
        if size is None:  # all alike: what sizes would change is no part of the family's prior
            along = family.standardise(draws.theta) @ family.size_axes
            log -= 0.5 * np.square(along).sum(axis=1)
    for answer in answers:
        record = answer.record
        if record.timed and abs(surprise_of(answer)) <= SURPRISING:
            off = draws.switching[record.motion] - record.switched
            log -= 0.5 * np.square(off / record.raw.contact.sd)
    for name, (value, sd) in given.known.items():
        if (known := _of_fact(answers, name)) is not None:
            log -= 0.5 * np.square((known - value) / sd)
    log = np.where(np.isfinite(log), log, -np.inf)
    if not np.isfinite(log.max()):
        return np.zeros(log.size)
    weights = np.exp(log - log.max())
    return weights / weights.sum()


def _of_fact(answers: Sequence[Estimate], name: str) -> np.ndarray | None:
    """Draws of what a fact is about, ``(d,)``, by the first record that has it."""
    about = (answer.inferred(name) for answer in answers)
    return next((each for each in about if each is not None), None)


def possible(answers: Sequence[Estimate]) -> np.ndarray:
    """Which draws ``(d,)`` may be: the stroke is longer than the gap, and the contact switches
    between the rests, on the way there.
    """
    found = np.ones(len(answers[0].draws.theta), bool)
    for answer in answers:
        shape, at = answer.record.shape, answer.draws.switching[answer.record.motion]
        there = SHAPE_TIMES[shape.way >= 1.0]
        found &= (answer.inferred("spring_compression") > 0.0) & ~(answer.way_to_rest <= 0.0)
        found &= at < (there[0] if there.size else np.inf) * shape.duration
    return found


def apart(answers: Sequence[Estimate], given: Given, rng: np.random.Generator) -> str:
    """Whether records of an operation are of two drives rather than one, in words; "" if not."""
    alone = [
        each.levels.draw({each.record.motion: each.record.seen}, _DRAWS, rng, size=given.size).theta
        for each in answers
    ]
    evidence = evidence_of_one(*map(np.log, alone), *given.prior_moments(answers[0]))
    if evidence >= _LEAST:
        return ""
    least = int(agreement_of(*alone).argmin())
    return (
        f"{APART}, most in {NAMES[least]}: that they are of two "
        f"drives of the family is {_times(-evidence)} times as probable as that they "
        "are of one. Each is inferred by itself; trust what is measured"
    )


def _times(log: float) -> str:
    """A ratio of probabilities in words, of its logarithm."""
    return "more than a million" if log > np.log(1e6) else in_digits(np.exp(log), 2)


def evidence_of_one(
    one: np.ndarray, other: np.ndarray, mean: np.ndarray, covariance: np.ndarray
) -> float:
    """Return the logarithm of the evidence that two records are of one drive and not of two.

    It is that of ``int q(z | one) q(z | other) / p(z) dz``, all taken for normal. Of records of one
    drive no more than a share s has an evidence below ``log s`` (Markov's inequality).

    Args:
        one, other: Draws of the logarithms of the parameters from either record, ``(d, p)``.
        mean, covariance: Of the prior, ``(p,)`` and ``(p, p)``.
    """
    prior = np.linalg.inv(covariance)
    first, second = (np.linalg.inv(np.cov(each.T)) for each in (one, other))
    a, b = one.mean(axis=0) - mean, other.mean(axis=0) - mean
    sizes, axes = np.linalg.eigh(first + second - prior)
    sizes = np.maximum(sizes, _SURE * np.linalg.eigvalsh(prior)[0])
    both = axes.T @ (first @ a + second @ b)
    square = a @ first @ a + b @ second @ b - both @ (both / sizes)
    logs = [np.linalg.slogdet(each)[1] for each in (first, second, prior)]
    return float(0.5 * (logs[0] + logs[1] - logs[2] - np.log(sizes).sum() - square))


def surprise_of(answer: Estimate) -> float:
    """How far the contact's time is from what the draws lead to expect, sd; nan if not timed."""
    if not answer.record.timed:
        return np.nan
    expected = answer.draws.switching[answer.record.motion]
    sd = np.hypot(expected.std(), answer.record.raw.contact.sd)
    return float((answer.record.switched - expected.mean()) / sd)


def contradicted(answers: Sequence[Estimate], given: Given) -> list[str]:
    """Which facts the records of an operation contradict, in words."""
    remarks = []
    for name, (value, sd) in given.known.items() if answers[0].draws else ():
        known = _of_fact(answers, name)
        off = 0.0 if known is None else (float(np.median(known)) - value) / sd
        if abs(off) > _CONTRADICTED:
            remarks.append(
                f"the record contradicts known.{name}, {in_digits(value, 4)} with an sd of "
                f"{in_digits(sd, 4)}: the "
                f"posterior is {off:+.1f} sd off; check its value and unit, or widen it"
            )
    return remarks
