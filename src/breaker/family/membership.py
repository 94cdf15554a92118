"""Membership of a record in the family: its distance from the family's shapes.

Principal components of shapes are assumed normal, and records are shapes with noise, with free rest
positions and times of normalisation. The squared Mahalanobis distance is compared with distances of
held-out drives, at the noise of the record. So its p-value is calibrated although shapes are not
normal.
"""

from collections.abc import Callable, Hashable, Iterable, Sequence
from typing import NamedTuple, TypeVar

import numpy as np

from breaker.family.inputs import Basis, NormalisedRecords
from breaker.family.shape import SHAPE_TIMES

T = TypeVar("T")

_USUAL = 0.1  # p-value from which no other family is tried: 90 % of the family's drives
_FREE = 4.0  # prior variance of rest positions and times of normalisation, wide
# Parts of a motion, in durations after 10 % of the travel.
PARTS = {"start": (-np.inf, 0.0), "main motion": (0.0, 2.0), "end": (2.0, np.inf)}


class Match(NamedTuple):
    """Comparison of a record with the family.

    Attributes:
        p_value: Share of the family's drives that are more unusual, at the record's noise.
        parts: Root mean square deviation from the nearest shape, by part of the motion, over the
            99 % quantile of the family's drives: above 1 in the parts that differ.
        nearest: The nearest shape, travel over stroke, ``(g,)``.
        evidence: Log density of the record among drives of the family, up to a common constant.
    """

    p_value: float
    parts: dict[str, float]
    nearest: np.ndarray
    evidence: float = 0.0


class Membership(NamedTuple):
    """Distances of held-out drives of a family, for one motion.

    Attributes:
        noise: Levels of the noise over the stroke, rising, ``(l,)``.
        squares, shares: Quantiles of the squared distance at each level, ``(l, k)``; their shares.
        left: 99 % quantiles of deviations of parts from the nearest shape, in noise, ``(l, 3)``.
    """

    noise: np.ndarray
    squares: np.ndarray
    shares: np.ndarray
    left: np.ndarray

    def match(self, seen: NormalisedRecords, basis: Basis) -> Match:
        """Compare one record with the family; noise below the lowest level counts as this level."""
        seen = seen._replace(noise=np.maximum(seen.noise, self.noise[0]))
        square, left, nearest, evidence = (values[0] for values in distances(seen, basis))
        log_noise = float(np.clip(np.log(seen.noise[0]), *np.log(self.noise[[0, -1]])))
        level = np.interp(log_noise, np.log(self.noise), np.arange(self.noise.size))
        low = min(int(level), self.noise.size - 2)
        share = level - low
        quantiles, usual = (
            np.exp((1.0 - share) * np.log(table[low]) + share * np.log(table[low + 1]))
            for table in (self.squares, self.left)
        )
        inside = float(np.interp(square, quantiles, self.shares, left=0.0))
        parts = dict(zip(PARTS, (left / usual).tolist(), strict=True))
        return Match(1.0 - inside, parts, nearest, float(evidence))


def distances(seen: NormalisedRecords, basis: Basis) -> tuple[np.ndarray, ...]:
    """Return how far records are from the family's shapes.

    Returns:
        Squared distances over the number of samples, ``(n,)``; root mean square deviations of each
        part from the nearest shape, in noise, ``(n, 3)``, nan without a sample; the nearest shapes,
        ``(n, g)``; and the evidence, as of ``Match``, ``(n,)``.
    """
    slope, mean = np.gradient(basis.mean, SHAPE_TIMES), basis.mean
    # First-order changes by another zero, stroke, origin and duration.
    free = np.array([np.ones_like(mean), mean, slope, SHAPE_TIMES * slope])
    free /= np.linalg.norm(free, axis=1, keepdims=True)
    directions = np.vstack([basis.directions, free])
    variances = np.append(basis.variances, np.full(len(free), _FREE))
    parts = [(begin <= SHAPE_TIMES) & (end > SHAPE_TIMES) for begin, end in PARTS.values()]
    spread, squares = np.log(variances).sum(), []
    for way, there, noise in zip(seen.way, seen.present, seen.noise, strict=True):
        rows = directions[:, there]
        off = way[there] - mean[there]
        precision = rows @ rows.T / noise**2 + np.diag(1.0 / variances)
        scores = np.linalg.solve(precision, rows @ off / noise**2)
        nearest = mean + scores @ directions
        left = (way - nearest) / noise
        total = (off @ left[there]) / noise
        evidence = -0.5 * (total + np.linalg.slogdet(precision)[1] + spread)
        in_parts = [np.square(left[part & there]) for part in parts]
        lefts = [np.sqrt(square.mean()) if square.size else np.nan for square in in_parts]
        squares.append((total / there.sum(), lefts, nearest, evidence))
    return tuple(map(np.array, zip(*squares, strict=True)))


def choose_family(
    families: Iterable[T], match: Callable[[T], Sequence[tuple[Hashable, Match]]], least: float
) -> tuple[T, list[tuple[Hashable, Match]], bool]:
    """Return the family for which records give most evidence, or the nearest if they fit none; the
    result of ``match`` for it; and whether the records fit.

    Drives of an independent simulator are often just inside the first family, with wrong estimates.
    Intervals of a wider family are wider and contain the truth.

    Args:
        families: Families, the narrowest first; the next is opened only if records are unusual.
        match: Returns the match of each record, with its group. The median of a group has to fit.
        least: p-value below which a group does not fit.
    """
    tried = []
    for family in families:
        matches = list(match(family))
        groups: dict[Hashable, list[tuple[float, float]]] = {}
        for group, result in matches:
            groups.setdefault(group, []).append((result.p_value, result.evidence))
        p_values, evidence = np.array([np.median(g, axis=0) for g in groups.values()]).T
        p_value = float(p_values.min())
        if not tried and p_value >= max(_USUAL, least):
            return family, matches, True
        off = max(np.nanmax([*result.parts.values()]) for _, result in matches)
        fits = p_value >= least
        grade = (fits, evidence.sum(), 0.0) if fits else (fits, p_value, -off)
        tried.append((grade, family, matches))
    (fits, *_), family, matches = max(tried, key=lambda entry: entry[0])
    return family, matches, fits
