"""Whether a record is of a drive of the family: its distance from the family's shapes.

Shapes of the family are taken for normal in their principal components, and records for these with
noise, whatever rests and times they were normalised by. The squared Mahalanobis distance is
compared with those of held-out drives of the family, at the record's own noise. So its p-value is
calibrated though shapes are not normal.
"""

from collections.abc import Callable, Hashable, Iterable, Mapping, Sequence
from typing import NamedTuple, TypeVar

import numpy as np

from breaker.family.inputs import Basis, NormalisedRecords
from breaker.family.shape import SHAPE_TIMES

T = TypeVar("T")

_USUAL = 0.1  # p-value from which on no other family is looked at: none has more evidence
_FREE = 4.0  # variance of what a record's own rests and times leave open: next to nothing known

PARTS = {"start": (-np.inf, 0.0), "main motion": (0.0, 2.0), "end": (2.0, np.inf)}
"""Parts of a motion, in durations after 10 % of the way."""


class Match(NamedTuple):
    """How a record fits the family.

    Attributes:
        p_value: Share of the family's drives that are farther out, at the record's noise.
        parts: By part of the motion, the root mean square of what the nearest shape leaves over
            that of 99 % of the family's drives: above 1 it is there that they differ.
        nearest: The nearest shape, way over stroke, ``(g,)``.
        evidence: Log density of the record among drives of the family, up to a common constant.
    """

    p_value: float
    parts: dict[str, float]
    nearest: np.ndarray
    evidence: float = 0.0


class Membership(NamedTuple):
    """What held-out drives of a family look like, for one motion.

    Attributes:
        noise: Levels of the noise over the stroke, rising, ``(l,)``.
        squares: Quantiles of the squared distance at each, ``(l, k)``.
        shares: Which quantiles, ``(k,)``.
        left: 99 % quantiles of what the nearest shape leaves of each part, in noise, ``(l, 3)``.
    """

    noise: np.ndarray
    squares: np.ndarray
    shares: np.ndarray
    left: np.ndarray

    def match(self, seen: NormalisedRecords, basis: Basis) -> Match:
        """Compare one record with the family, as if it had the least noise of those at least."""
        seen = seen._replace(noise=np.maximum(seen.noise, self.noise[0]))
        square, left, nearest, evidence = (each[0] for each in distances(seen, basis))
        at = float(np.clip(np.log(seen.noise[0]), *np.log(self.noise[[0, -1]])))
        level = np.interp(at, np.log(self.noise), np.arange(self.noise.size))
        low = min(int(level), self.noise.size - 2)
        share = level - low
        quantiles, usual = (
            np.exp((1.0 - share) * np.log(each[low]) + share * np.log(each[low + 1]))
            for each in (self.squares, self.left)
        )
        below = float(np.interp(square, quantiles, self.shares, left=0.0))
        parts = dict(zip(PARTS, (left / usual).tolist(), strict=True))
        return Match(1.0 - below, parts, nearest, float(evidence))

    @classmethod
    def of(cls, levels: Mapping[float, NormalisedRecords], basis: Basis) -> "Membership":
        """Return the membership by records of held-out drives at some levels of the noise.

        Args:
            levels: Records ``(n, g)`` by their noise over the stroke, rising.
        """
        count = len(next(iter(levels.values())).way)
        shares = 1.0 - np.geomspace(1.0, 0.5 / count, 64)
        found = [distances(seen, basis)[:2] for seen in levels.values()]
        squares = np.array([np.quantile(square, shares) for square, _ in found])
        left = np.array([np.nanquantile(each, 0.99, axis=0) for _, each in found])
        return cls(np.array(list(levels)), squares, shares, left)


def distances(seen: NormalisedRecords, basis: Basis) -> tuple[np.ndarray, ...]:
    """Return how far records are from the family's shapes.

    Returns:
        Squares of their distances over the number of samples of the grid, ``(n,)``; root mean
        square of what the nearest shape leaves of each part, in noise, ``(n, 3)``, nan without a
        sample; the nearest shapes, ``(n, g)``; and the evidence, as of ``Match``, ``(n,)``.
    """
    directions = np.vstack([basis.directions, _free(basis.mean)])
    variances = np.append(basis.variances, np.full(len(directions) - len(basis.directions), _FREE))
    n, part = len(seen.way), [(a <= SHAPE_TIMES) & (b > SHAPE_TIMES) for a, b in PARTS.values()]
    squares, lefts, nearest = np.empty(n), np.empty((n, len(part))), np.empty(seen.way.shape)
    evidence, spread = np.empty(n), np.log(variances).sum()
    for i, (way, there, noise) in enumerate(zip(seen.way, seen.present, seen.noise, strict=True)):
        rows = directions[:, there]
        off = way[there] - basis.mean[there]
        precision = rows @ rows.T / noise**2 + np.diag(1.0 / variances)
        scores = np.linalg.solve(precision, rows @ off / noise**2)
        nearest[i] = basis.mean + scores @ directions
        left = np.where(there, (way - nearest[i]) / noise, np.nan)
        total = (off @ left[there]) / noise
        squares[i] = total / there.sum()
        evidence[i] = -0.5 * (total + np.linalg.slogdet(precision)[1] + spread)
        lefts[i] = [
            np.sqrt(np.mean(np.square(left[each & there]))) if (each & there).any() else np.nan
            for each in part
        ]
    return squares, lefts, nearest, evidence


def _free(mean: np.ndarray) -> np.ndarray:
    """How a shape ``(g,)`` looks that was normalised by other rests and times, to first order,
    ``(4, g)``: zero, stroke, origin and duration.
    """
    slope = np.gradient(mean, SHAPE_TIMES)
    rows = np.array([np.ones_like(mean), mean, slope, SHAPE_TIMES * slope])
    return rows / np.linalg.norm(rows, axis=1, keepdims=True)


def choose_family(
    families: Iterable[T], match: Callable[[T], Sequence[tuple[Hashable, Match]]], least: float
) -> tuple[T, list[tuple[Hashable, Match]], bool]:
    """Return the family that records give most evidence of, or that which they fit best; what
    ``match`` returned of it; and whether the records fit.

    A group of records fits as well as the median of them, and all have to. A foreign drive is
    often just within the first family, with wrong answers; a wider family tells less of it, and
    that is true.

    Args:
        families: What answers for each; the next is opened only where the records are not usual.
        match: Returns how each record fits, with the group that it is in.
        least: p-value below which a group does not fit.
    """
    tried = []
    for family in families:
        matches = list(match(family))
        groups: dict[Hashable, list[Match]] = {}
        for group, each in matches:
            groups.setdefault(group, []).append(each)
        medians = [
            np.median([(e.p_value, e.evidence) for e in group], axis=0) for group in groups.values()
        ]
        p_values, evidence = np.array(medians).T
        fits = float(p_values.min())
        if not tried and fits >= max(_USUAL, least):
            return family, matches, True
        off = max(np.nanmax([*each.parts.values()]) for _, each in matches)
        grade = (True, evidence.sum(), 0.0) if fits >= least else (False, fits, -off)
        tried.append((grade, family, matches))
    grade, family, matches = max(tried, key=lambda each: each[0])
    return family, matches, bool(grade[0])
