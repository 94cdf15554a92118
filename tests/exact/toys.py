"""Targets of particles whose posterior is known."""

from typing import NamedTuple

import numpy as np
from scipy.special import ndtr, ndtri

from breaker.drive.exact.particles import Target

_SEEN = 8  # residuals


class Known(NamedTuple):
    """A target, and its posterior.

    Attributes:
        target: What particles are led to.
        mean, sd: Of what is asked, ``(a,)``.
        log_evidence: Nats.
    """

    target: Target
    mean: np.ndarray
    sd: np.ndarray
    log_evidence: float


def normal(design, seen):
    """Posterior of scores ``(m,)`` with residuals ``design @ scores - seen``: mean, covariance, and
    log evidence.
    """
    precision = np.eye(design.shape[1]) + design.T @ design
    covariance = np.linalg.inv(precision)
    mean = covariance @ design.T @ seen
    square = seen @ seen - mean @ precision @ mean
    return mean, covariance, -0.5 * (np.linalg.slogdet(precision)[1] + square)


def traced(numbers):
    """Numbers of scores, and what takes slopes back, by differences."""
    beside = 1e-5

    def trace(scores):
        base = numbers(scores)

        def back(slopes):
            found = np.empty(scores.shape)
            for j, by in enumerate(beside * np.eye(scores.shape[1])):
                found[:, j] = ((numbers(scores + by) - base) * slopes).sum(axis=1) / beside
            return found

        return base, back

    return trace


ONE_KIND = {"kinds": lambda scores: np.zeros(len(scores), int), "shares": np.ones(1), "fixed": ()}


def as_they_are(numbers):
    """What emulators see."""
    return numbers


def bent() -> Known:
    """Numbers are bent functions of three scores, and residuals linear in the scores: the posterior
    is normal, but an emulator, which sees the numbers, has to learn it. Two more scores move
    nothing, one of which is drawn anew.
    """
    rng = np.random.default_rng(1)
    design = np.diag([6.0, 3.0, 1.5]) @ rng.standard_normal((3, _SEEN)) / np.sqrt(_SEEN)
    design = design.T
    seen = design @ [0.8, -1.0, 0.5] + 0.7 * rng.standard_normal(_SEEN)
    mean, covariance, log_evidence = normal(design, seen)

    def redrawn(scores, rng):
        return np.column_stack([scores[:, :4], rng.standard_normal(len(scores))])

    def numbers(scores):
        return np.sinh(scores[:, :3])

    target = Target(
        unknowns=5,
        numbers=numbers,
        inputs=as_they_are,
        traced=traced(numbers),
        residuals=lambda numbers: np.arcsinh(numbers) @ design.T - seen,
        **ONE_KIND,
        asked=np.arcsinh,
        redrawn=redrawn,
    )
    return Known(target, mean, np.sqrt(np.diag(covariance)), log_evidence)


def switched() -> Known:
    """A score decides whether a mechanism is there, whose size is another one: asked are what it
    acts beside, and whether it is there.
    """
    rng = np.random.default_rng(2)
    beside, by = rng.standard_normal((2, _SEEN))
    base, scale = 0.6, 0.3  # of the size of the mechanism
    seen = 0.5 * beside + 0.4 * base * by + 0.5 * rng.standard_normal(_SEEN)
    without = normal(beside[:, None], seen)
    having = normal(np.column_stack([beside, scale * by]), seen - base * by)
    odds = np.exp(having[2] - without[2])
    share = odds / (1.0 + odds)  # as likely as not before
    means, variances = zip(*((m[0], c[0, 0]) for m, c, _ in (without, having)), strict=True)
    mean = (1.0 - share) * means[0] + share * means[1]
    square = (1.0 - share) * (variances[0] + means[0] ** 2)
    square += share * (variances[1] + means[1] ** 2)
    sds = np.sqrt([square - mean**2, share * (1.0 - share)])

    def numbers(scores):
        return np.column_stack([scores[:, 0], (scores[:, 1] > 0.0) * (base + scale * scores[:, 2])])

    def redrawn(scores, rng):
        new, half = scores.copy(), 0.5 * rng.random(len(scores))
        new[:, 1] = ndtri(np.where(scores[:, 1] > 0.0, 1.0 - half, half))
        return new

    target = Target(
        unknowns=4,
        numbers=numbers,
        inputs=as_they_are,
        traced=traced(numbers),
        residuals=lambda n: np.outer(n[:, 0], beside) + np.outer(n[:, 1], by) - seen,
        **ONE_KIND,
        asked=lambda n: np.column_stack([n[:, 0], n[:, 1] != 0.0]),
        redrawn=redrawn,
    )
    log_evidence = np.logaddexp(having[2], without[2]) - np.log(2.0)
    return Known(target, np.array([mean, share]), sds, float(log_evidence))


def kinds(working, off=0.0) -> Target:
    """Two kinds, chosen by the first score, as likely as each other: of their draws so much works.

    Of drives that work, drawn again within a kind, the kinds have the same share again. The second
    has residuals that are ``off`` farther, in each of two.
    """
    working = np.asarray(working)

    def kind(scores):
        return (scores[:, 0] > 0.0).astype(int)

    def numbers(scores):
        works = ndtr(scores[:, 1]) < working[kind(scores)]
        return np.column_stack([kind(scores), scores[:, 2:], works])

    return Target(
        unknowns=4,
        numbers=numbers,
        inputs=as_they_are,
        traced=traced(numbers),
        residuals=lambda n: np.where(n[:, 3:] > 0.0, n[:, 1:3] + off * n[:, :1], np.nan),
        kinds=kind,
        shares=np.array([0.5, 0.5]),
        fixed=(0,),
        asked=lambda n: n[:, 1:3].copy(),
        redrawn=lambda scores, _: scores,
    )
