"""How much each draw of a network counts beside what is given: a prior, facts, a timed contact."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from breaker.answers.answer import Answer, Given
from breaker.answers.operations import Record
from breaker.family import LEAST_AGREEMENT, agreement_of
from breaker.mechanism import NAMES, Size, in_digits, in_p, powers
from breaker.records import SHAPE_TIMES

_CONTRADICTED = 3.0  # sd, of a fact
SURPRISING = 4.0
"""Standard deviations of the contact's time from which on it contradicts the curve."""

_DRAWS = 1000  # of each motion, by which they are held against each other


def weights_of(answers: Sequence[Answer], given: Given, size: Size | None) -> np.ndarray:
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
            along, _ = np.linalg.qr((powers() / family.log_sds).T)
            log -= 0.5 * np.square(family.standardise(draws.theta) @ along).sum(axis=1)
    for answer in answers:
        if answer.record.timed and abs(surprise_of(answer)) <= SURPRISING:
            off = draws.switching[answer.record.motion] - _contact(answer.record)
            log -= 0.5 * np.square(off / answer.record.raw.contact.sd)
    for name, (value, sd) in given.known.items():
        if (known := _of_fact(answers, name)) is not None:
            log -= 0.5 * np.square((known - value) / sd)
    log = np.where(np.isfinite(log), log, -np.inf)
    if not np.isfinite(log.max()):
        return np.zeros(log.size)
    weights = np.exp(log - log.max())
    return weights / weights.sum()


def _of_fact(answers: Sequence[Answer], name: str) -> np.ndarray | None:
    """Draws of what a fact is about, ``(d,)``, by the first record that has it."""
    about = (answer.inferred(name) for answer in answers)
    return next((each for each in about if each is not None), None)


def _contact(record: Record) -> float:
    """When the contact was seen to switch, ms after 10 % of the way."""
    return record.raw.contact.time - record.tenth


def possible(answers: Sequence[Answer]) -> np.ndarray:
    """Which draws ``(d,)`` may be: the stroke is longer than the gap, and the contact switches
    between the rests, on the way there.
    """
    found = np.ones(len(answers[0].draws.theta), bool)
    for answer in answers:
        shape, at = answer.record.shape, answer.draws.switching[answer.record.motion]
        there = SHAPE_TIMES[shape.way >= 1.0]
        found &= (answer.inferred("L") < shape.stroke) & ~(answer.inferred("wipe") <= 0.0)
        found &= at < (there[0] if there.size else np.inf) * shape.duration
    return found


def apart(answers: Sequence[Answer], rng: np.random.Generator) -> str:
    """In which parameter records of an operation contradict each other, in words; "" if in none."""
    alone = [
        each.levels.draw({each.record.motion: each.record.seen}, _DRAWS, rng).theta
        for each in answers
    ]
    agreement = agreement_of(*alone)
    least = int(agreement.argmin())
    if agreement[least] >= LEAST_AGREEMENT:
        return ""
    return (
        f"closing and opening contradict each other ({NAMES[least]}, {in_p(agreement[least])}): "
        "each is inferred by itself, and no drive of the family has both; trust what is measured"
    )


def surprise_of(answer: Answer) -> float:
    """How far the contact's time is from what the draws lead to expect, sd; nan if not timed."""
    if not answer.record.timed:
        return np.nan
    expected = answer.draws.switching[answer.record.motion]
    sd = np.hypot(expected.std(), answer.record.raw.contact.sd)
    return float((_contact(answer.record) - expected.mean()) / sd)


def contradicted(answers: Sequence[Answer], given: Given) -> list[str]:
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
