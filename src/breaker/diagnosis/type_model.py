r"""What breakers of a type have in common, and which of them is odd.

Breakers of a type have the same levers and dampers, so they share the error of what networks infer
of them, and more of them do not lessen it: a drive's posterior is far wider than drives of a type
are apart. So drives are compared by the means of their draws, ``x_b``, whose own error is seen from
operation to operation. Over the drives ``x_b = m + u_b + e_b`` in logarithms, with
``u_b ~ N(0, diag(tau^2))``; of a few drives one parameter is odd, and has ``s`` more. By
expectation maximisation centre m and spread tau are those of the drives that are not odd, which so
do not widen them. Evidence that a drive is odd is the logarithm of the ratio of both likelihoods.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple, Self

import numpy as np

from breaker.diagnosis.draw_weights import SURPRISING
from breaker.diagnosis.estimate import Estimate
from breaker.family.inputs import shrunk_variance
from breaker.model.prior import Prior

_ODD, _FAR = 0.02, 0.3  # share of odd drives, and the sd of the logarithm by which they are odd
_LEAST, _KNOWN = 0.1, 4.0  # spread that is expected, log-sds of the prior; as of so many drives
_OWN = 0.2  # share of a posterior's variance that is expected from operation to operation
_WIDER = 1.5  # factor on the variance seen: what operations of one visit share is not in it
_SHARED = 0.6  # share of a drive's posterior variance that is an error which its type shares
_DRAWS = 500  # of a drive, which are kept
_ROUNDS, _SETTLED = 500, 1e-7
# Spread of the lag of contacts that is expected, durations, and how well it is known, as of so many
# drives: a smaller one is better where drives of a type are alike, and worse where they are not.
_LAG, _LAG_KNOWN = 0.15, 8.0
FEWEST = 5
"""Drives of a type from which one may be told as odd."""

ODD = 7.0
"""Evidence that a drive is odd, nats: odds of 1,100, as a fleet has hundreds of drives."""


class TypeDraws(NamedTuple):
    """Draws of the drives of a type.

    Attributes:
        mean: Of the logarithms of their parameters, over all operations, ``(n, p)``.
        squares: Sum of products of the deviations of operations from it, ``(n, p, p)``.
        count: Operations, ``(n,)``.
        theta: Draws, ``(n, d, p)``.
    """

    mean: np.ndarray
    squares: np.ndarray
    count: np.ndarray
    theta: np.ndarray

    @classmethod
    def of(cls, drives: Iterable[Sequence[np.ndarray]]) -> Self:
        """Sum up draws of the operations of each drive, ``(d, p)`` each, one or more."""
        found = []
        for operations in drives:
            each = np.array([np.log(theta).mean(axis=0) for theta in operations])
            off = each - each.mean(axis=0)
            flat = np.concatenate(operations)
            some = flat[np.linspace(0, len(flat) - 1, _DRAWS).astype(int)]
            found.append((each.mean(axis=0), off.T @ off, len(operations), some))
        return cls(*map(np.array, zip(*found, strict=True)))

    @property
    def posterior(self) -> np.ndarray:
        """Mean covariance of the logarithms of a drive's draws, ``(p, p)``."""
        return np.mean([np.cov(np.log(each).T) for each in self.theta], axis=0)

    def error(self) -> np.ndarray:
        """Return the covariance of each mean, by what is seen from operation to operation."""
        squares, seen = self.squares.sum(axis=0), float((self.count - 1).sum())
        one = _WIDER * shrunk_variance(squares, seen, _OWN * self.posterior, _KNOWN)
        return one / self.count[:, None, None]


def draws_of(answers: Iterable[Estimate]) -> list[np.ndarray]:
    """Return the draws of each operation that was inferred, ``(d, p)``, in the order of answers."""
    return [*{id(each.draws): each.draws.theta for each in answers if each.draws}.values()]


def learn_contact_lag(breakers: Iterable[Iterable[Estimate]]) -> dict[str, tuple[float, float]]:
    """Learn by how much contacts of a type touch or part later than travels lead to expect.

    Networks err alike for drives of a type, so that recorded contacts of some tell of the others.

    Args:
        breakers: What was inferred of the records of each. A contact that contradicts its curve
            does not count.

    Returns:
        By motion the mean, and the sd of one more drive, in durations from 10 to 50 % of the way.
    """
    seen: dict[str, list[float]] = {}
    for answers in breakers:
        own: dict[str, list[float]] = {}
        for each in answers:
            if abs(each.surprise) <= SURPRISING:
                own.setdefault(each.record.motion, []).append(each.lag)
        for motion, lags in own.items():
            seen.setdefault(motion, []).append(float(np.mean(lags)))
    found = {}
    for motion, lags in seen.items():
        n, mean = len(lags), float(np.mean(lags))
        squares = float(np.square(np.subtract(lags, mean)).sum())
        variance = shrunk_variance(squares, n - 1, _LAG**2, _LAG_KNOWN)
        found[motion] = mean, float(np.sqrt(variance * (1.0 + 1.0 / n)))
    return found


@dataclass(frozen=True, eq=False)
class TypeOfBreaker:
    """A type, learned.

    Attributes:
        medians: Of its drives, ``(p,)``.
        spread, known, shared: Log-sds, ``(p,)``: of the drives; of the medians, as few drives tell
            them; and of the error that the drives share.
        evidence: That a parameter of a drive is odd, nats, ``(n, p)``; -inf of fewer than 5 drives.
        off: How far the drive's mean is off the median, share, ``(n, p)``.
    """

    medians: np.ndarray
    spread: np.ndarray
    known: np.ndarray
    shared: np.ndarray
    evidence: np.ndarray
    off: np.ndarray

    @cached_property
    def log_sds(self) -> np.ndarray:
        """Log-sds of its prior, all parts together, ``(p,)``."""
        return np.sqrt(np.sum(np.square((self.spread, self.known, self.shared)), axis=0))

    def weights(self, theta: np.ndarray, family: Prior) -> np.ndarray:
        """Return the weights of a drive's draws ``(d, p)`` by this prior, ``(d,)``, their sum 1.

        Args:
            family: That of which the network's draws are, which knows no size.
        """
        own = 0.5 * np.square(np.log(theta / self.medians) / self.log_sds).sum(axis=1)
        log = -own - _family_log_prob(theta, family)
        weights = np.exp(log - log.max())
        return weights / weights.sum()


def _family_log_prob(theta: np.ndarray, family: Prior) -> np.ndarray:
    """Log density of the family's prior, at all sizes alike, but for a constant, ``(d,)``."""
    z, along = family.standardise(theta), family.size_axes
    return -0.5 * np.square(z - z @ along @ along.T).sum(axis=1)


def learn_type(drawn: TypeDraws, usual: np.ndarray) -> TypeOfBreaker:
    """Learn a type from its drives; of one alone, the spread is that of drives of any type.

    Args:
        usual: Log-sds of the prior of drives of any type and one size, ``(p,)``.

    Example:
        Twenty drives that differ by 2 %, and one whose friction is by 40 % more:

        >>> rng = np.random.default_rng(1)
        >>> mean = 0.02 * rng.standard_normal((21, 7))
        >>> mean[4, 3] += 0.34
        >>> theta = np.exp(mean[:, None] + 0.1 * rng.standard_normal((21, 50, 7)))
        >>> drawn = TypeDraws(mean, np.tile(1e-4 * np.eye(7), (21, 1, 1)), np.full(21, 2), theta)
        >>> found = learn_type(drawn, np.full(7, 0.2))
        >>> np.argwhere(found.evidence > 6.0).tolist(), bool(found.spread[3] < 0.04)
        ([[4, 3]], True)
    """
    x, error = drawn.mean, drawn.error()
    n, p = x.shape
    centre, least = np.median(x, axis=0), np.square(_LEAST * usual)
    variance = np.maximum(np.square(1.4826 * np.median(np.abs(x - centre), axis=0)), least)
    log_prior = np.log(np.append(1.0 - _ODD, np.full(p, _ODD / p)))
    for _ in range(_ROUNDS):
        log, mean, square = _components(x - centre, error, variance)
        log = log + log_prior
        share = np.exp(log - log.max(axis=1, keepdims=True))
        share /= share.sum(axis=1, keepdims=True)
        counts = share[:, :, None] * (1.0 - np.eye(p + 1, p, -1))  # the odd parameter counts not
        total = counts.sum(axis=(0, 1))
        moved = (counts * mean).sum(axis=(0, 1)) / total
        variance = shrunk_variance((counts * square).sum(axis=(0, 1)), total, least, _KNOWN)
        centre = centre + moved
        if np.abs(moved).max() < _SETTLED:
            break
    log, _, _ = _components(x - centre, error, variance)
    evidence = log[:, 1:] - log[:, :1] if n >= FEWEST else np.full((n, p), -np.inf)
    known = np.sqrt((variance + np.diagonal(error.mean(axis=0))) / n)
    spread = np.sqrt(variance) if n > 1 else usual
    shared = np.sqrt(_SHARED * drawn.posterior.diagonal())
    return TypeOfBreaker(np.exp(centre), spread, known, shared, evidence, np.expm1(x - centre))


def _components(
    off: np.ndarray, error: np.ndarray, variance: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Log likelihood of drives as they are usual and with each parameter odd, ``(n, 1 + p)``, and
    mean and mean square of their own deviations then, ``(n, 1 + p, p)``.
    """
    p = off.shape[1]
    wider = variance + _FAR**2 * np.vstack([np.zeros(p), np.eye(p)])
    inverse = np.linalg.inv(error[:, None] + wider[:, :, None] * np.eye(p))
    pulled = np.einsum("nkij,nj->nki", inverse, off)
    log = 0.5 * np.linalg.slogdet(inverse)[1] - 0.5 * np.einsum("nki,ni->nk", pulled, off)
    mean = wider * pulled
    own = wider - np.square(wider) * np.diagonal(inverse, axis1=2, axis2=3)
    return log, mean, np.square(mean) + own
