"""Explain the change between two inspections by the drive or by its measurement.

A closing force that falls shortens the travel and lowers speeds, almost as another ratio of the
transducer does. Likelihoods of the change of the mean records decide. A ratio scales all travel and
leaves the times between positions; no parameter does. The effect of a parameter comes from
``sensitivities`` of the drive's family, and their errors count, so that no explanation is preferred
because the family is wrong. A ratio that changed together with the drive is not an explanation of
its own: with a small change of the ratio, errors of the family would explain any change of force.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple, Self

import numpy as np

from breaker.common.plain_values import Plain
from breaker.diagnosis.changes import QuantityChange
from breaker.diagnosis.estimate import DriveRecord
from breaker.diagnosis.identity import Difference, Inspections
from breaker.diagnosis.limits import NORMAL
from breaker.family.inputs import Mean, mean_record, more_scattered, normalise_record
from breaker.family.sensitivities import Sensitivities
from breaker.family.shape import SHAPE_STEP, SHAPE_TIMES, Shape
from breaker.model.parameters import MOTIONS, NAMES
from breaker.records.record import Record

SURE = 0.95
"""Probability from which an explanation is reported alone."""

OTHER_SETUP = {
    "ratio": "ratio of the transducer",
    "rate": "rate or unit of the time",
    "slack": "time to 10 % of the travel, by another slack of the transducer,",
}
"""Names of differences in the measurement, by code; the first two are causes."""

# Probabilities without any record; studies.force_or_ratio chose them. A rate is 1 %, known to the
# 0.4 % by which durations scatter from operation to operation.
_PRIOR = {"none": 0.5, "parameter": 0.3, "several": 0.1, "ratio": 0.1, "rate": 0.01 * 0.004}
# Difference of logarithms from which a rate may differ: clocks of analysers are right, so another
# rate is another setting or unit.
_OTHER_RATE = 0.04
# Sds of relative changes, equally probable: of parameters, from what scatter hides to the largest
# wear; of ratios, from a remounted lever to another setting (1.0 and 1.64 in real files).
_SIZES, _RATIOS = (0.02, 0.05, 0.12), (0.02, 0.06, 0.2, 0.6)
_WIDER = {"mu": 2.5, "k_b": 2.5, "gamma_a": 2.5, "gamma_b": 2.5}  # as families wear, relative to f
_SCATTER = 0.004  # usual sd of each parameter and of durations from operation to operation
# A transducer mounted again reads a smooth function of the travel: a linearity of 0.35 % of the
# stroke (0.05 mm of 14), which changes over half of the stroke.
_SHAPE, _LENGTH = 0.0035, 0.5
_FREE = 10.0  # sd of zero and start of a mean, in strokes and durations: as good as unknown
_SLACK = 4.0  # sds from which a start of motion differs: 1 of 30,000 by chance, in one motion
_START_SCATTER = 0.03  # of the time to 10 % of the travel, from operation to operation


@dataclass(frozen=True)
class Explanation(Plain):
    """A cause of the change between two inspections.

    Attributes:
        cause: "none", "drive", "ratio" or "rate".
        parameter: Parameter of the drive that alone explains most; empty if several explain more.
        probability: Probability of the cause; those of all causes add up to 1.
        change: 5, 50 and 95 % quantiles of the change, percent, given this cause.
    """

    cause: str
    parameter: str
    probability: float
    change: Sequence[float]


def explain(
    before: Mapping[str, Sequence[Record]],
    today: Mapping[str, Sequence[Record]],
    regressions: Mapping[tuple[str, ...], Sensitivities],
    *,
    same_transducer: bool = False,
    sliding: float = 0.0,
) -> list[Explanation]:
    """Return the explanations of two inspections, the most probable first.

    Args:
        before, today: Records of the same motions.
        regressions: Sensitivities of the drive's family, by motions.
        same_transducer: Whether both inspections have the same transducer and ratio.
        sliding: Share of the family's drives whose contact slides. Their travel scales with the
            force as with a ratio, and only a recorded contact separates the two.
    """
    first, last = next(iter(before)), list(before)[-1]
    means = [{m: mean_record(raws).seen for m, raws in each.items()} for each in (before, today)]
    starts, ends = ([float(e[m].duration[0]) for e in means] for m in (first, last))
    shapes = np.concatenate([each.way[0] for each in means[0].values()])
    slopes, errors = regressions[tuple(before)].of(shapes, float(np.log(ends[0] / starts[0])))
    scatter = _SCATTER**2 * (slopes.T @ slopes + errors.sum(axis=0))
    pace = float(np.sqrt(ends[1] * starts[1] / ends[0] / starts[0]))
    pair, densities = _Pair.of((before, today), scatter, 1.0), {}
    if abs(np.log(pace)) > _OTHER_RATE:
        paced = _Pair.of((before, today), scatter, pace)
        both = pair.there & paced.there  # densities are of the same samples
        pair, paced = (each._replace(there=both) for each in (pair, paced))
        densities["rate", ""] = [np.log(_PRIOR["rate"]) + paced.density()]
    densities["none", ""] = [np.log(_PRIOR["none"]) + pair.density()]
    ratios = () if same_transducer else _RATIOS
    for key, prior, more in _hypotheses(pair, slopes, errors, sliding, ratios):
        densities.setdefault(key, []).append(np.log(prior) + pair.density(more))
    amounts = {name: pair.amount(slope) for name, slope in zip(NAMES, slopes, strict=True)}
    amounts |= {"ratio": pair.amount(pair.way), "rate": [100.0 * (pace - 1.0)] * 3}
    return _most_probable(densities, amounts)


def other_measurement(explanations: Sequence[Explanation]) -> float:
    """Return the probability that the inspections were measured differently."""
    return sum(each.probability for each in explanations if each.cause in OTHER_SETUP)


def measured_differences(explanations: Sequence[Explanation]) -> list[Difference]:
    """Return the difference in the measurement where one is nearly certain."""
    if other_measurement(explanations) < SURE:
        return []
    cause = next(each for each in explanations if each.cause in OTHER_SETUP)
    return [Difference(OTHER_SETUP[cause.cause], "", "", 1.0, 1.0 + cause.change[1] / 100.0)]


def slack_differences(
    inspections: Inspections, measured: Sequence[QuantityChange]
) -> list[Difference]:
    """Return differences in the start of motion as another slack of the transducer causes them.

    Slack hides the first travel: the time from the first detected motion to 10 % of the travel is
    shorter in closing and opening, and the speed from 50 to 90 % has not changed. A time that is
    longer may also be a force that builds up later, which is a change of the drive.
    """
    later = {row.motion: row for row in measured if row.name == f"{row.motion}_speed_50_90"}
    if len(later) < len(MOTIONS) or any(row.changed for row in later.values()):
        return []
    differences = []
    for motion in MOTIONS:
        (was, sd), (now, more) = (_start(records, motion) for records in inspections.values())
        if not now - was < -_SLACK * np.hypot(sd, more):
            return []
        differences.append(Difference(OTHER_SETUP["slack"], "ms", motion, was, now))
    return differences


def _start(records: Sequence[DriveRecord], motion: str) -> tuple[float, float]:
    """Return the mean time from the first detected motion to 10 % of the travel, and its sd, ms."""
    own = [record for record in records if record.motion == motion]
    times = np.array([record.tenth - record.raw.moves for record in own])
    error = np.mean([record.raw.first_motion_sd**2 for record in own])
    error += (_START_SCATTER * times.mean()) ** 2
    scatter = times.var(ddof=1) if len(own) > 1 else 0.0
    return float(times.mean()), float(np.sqrt(max(error, scatter) / len(own)))


class _Pair(NamedTuple):
    """The means of two inspections over the stroke: for each motion the grid, then the contact.

    Attributes:
        way: Mean travel before, ``(n,)``.
        change: Mean travel today minus ``way``, ``(n,)``.
        there: Whether both inspections have samples, or recorded the contact, ``(n,)`` of bool.
        smooth: Covariance of the change of an unchanged drive, without noise, ``(n, n)``.
        noise: Variance of the noise, ``(n,)``.
    """

    way: np.ndarray
    change: np.ndarray
    there: np.ndarray
    smooth: np.ndarray
    noise: np.ndarray

    @classmethod
    def of(cls, inspections: Sequence[Mapping], scatter: np.ndarray, pace: float) -> Self:
        """Compare the means of two inspections, the second in a time that runs slower by a factor.

        Args:
            inspections: Records by motion, before and today.
            scatter: Covariance of a curve from operation to operation, ``(n, n)``.
            pace: Factor on the durations of today.
        """
        parts, smooth = [], np.zeros_like(scatter)
        for k, (motion, raws) in enumerate(inspections[0].items()):
            both = raws, inspections[1][motion]
            first = mean_record(raws)
            units = first.units._replace(duration=pace * first.units.duration)
            means = first, mean_record(both[1], units)
            way, noise = _with_contact(first, raws, first.units)
            after, more = _with_contact(means[1], both[1], units)
            place = way if motion == "closing" else 1.0 - way
            parts.append((way, after - way, noise + more, place))
            start = np.append(np.gradient(first.seen.way[0], SHAPE_STEP), 0.0)
            slower = np.append(SHAPE_TIMES, 0.0) * start
            some = slice(k * way.size, (k + 1) * way.size)
            own = scatter[some, some]
            factor = more_scattered(means, float(np.trace(own)))
            own = own + _SCATTER**2 * np.outer(slower, slower)
            smooth[some, some] = sum(1.0 / len(each) for each in both) * factor * own
            smooth[some, some] += _FREE**2 * (1.0 + np.outer(start, start))
        way, change, noise, place = map(np.concatenate, zip(*parts, strict=True))
        distance = np.subtract.outer(place, place) / _LENGTH
        smooth += _SHAPE**2 * np.exp(-0.5 * np.square(distance))
        return cls(way, change, np.isfinite(change), smooth, noise)

    def density(self, more: np.ndarray | float = 0.0) -> float:
        """Return the log density of the change; ``more`` is added to its covariance."""
        factor = np.linalg.cholesky(self._covariance(more))
        white = np.linalg.solve(factor, self.change[self.there])
        return float(-0.5 * white @ white - np.log(np.diag(factor)).sum())

    def amount(self, column: np.ndarray) -> list[float]:
        """Return quantiles of the factor of a column ``(n,)`` that explains the change, percent."""
        column, change = column[self.there], self.change[self.there]
        solved = np.linalg.solve(self._covariance(), np.column_stack([column, change]))
        precision, score = column @ solved
        half = NORMAL[90] * np.sqrt(precision)
        return [float(100.0 * each / precision) for each in (score - half, score, score + half)]

    def _covariance(self, more: np.ndarray | float = 0.0) -> np.ndarray:
        return (self.smooth + np.diag(self.noise) + more)[np.ix_(self.there, self.there)]


def _hypotheses(
    pair: _Pair, slopes: np.ndarray, errors: np.ndarray, sliding: float, ratios: Sequence[float]
) -> Iterator[tuple[tuple[str, str], float, np.ndarray]]:
    """Yield cause and parameter, prior probability, and covariance of the change by this cause."""
    wider = np.square([_WIDER.get(name, 1.0) for name in NAMES])[:, None, None]
    changed = wider * (slopes[:, :, None] * slopes[:, None] + errors)  # by an sd of 1
    on_grid = np.arange(pair.way.size) % (SHAPE_TIMES.size + 1) < SHAPE_TIMES.size
    slid = np.outer(pair.way * on_grid, pair.way * on_grid)
    prior = _PRIOR["parameter"] / len(NAMES) / len(_SIZES)
    for size in _SIZES:
        for name, each in zip(NAMES, changed, strict=True):
            yield ("drive", name), prior, size**2 * each
        if sliding > 0.0:
            yield ("drive", "f"), prior * sliding, size**2 * slid
    for size in _SIZES[:-1]:  # all parameters by the largest size would explain anything
        yield ("drive", ""), _PRIOR["several"] / len(_SIZES[:-1]), size**2 * changed.sum(axis=0)
    factor = 1.0 + pair.amount(pair.way)[1] / 100.0
    larger = (factor**2 - 1.0) * pair.smooth  # a ratio scales these errors
    for size in ratios:
        more = size**2 * np.outer(pair.way, pair.way) + larger
        yield ("ratio", ""), _PRIOR["ratio"] / len(ratios), more


def _with_contact(mean: Mean, raws: Sequence[Record], units: Shape) -> tuple[np.ndarray, ...]:
    """Return mean travel over the stroke on the grid and at the contact, and its variance.

    Travel is nan where there are no samples, and where no contact was recorded.
    """
    contacts = []
    for raw in raws:
        if np.isfinite(raw.contact.time):
            shape, seen = normalise_record(raw, units)
            at = (raw.contact.time - raw.time[raw.segment.begin] - shape.origin) / units.duration
            way = np.interp(at, SHAPE_TIMES, shape.way)
            slope = np.interp(at, SHAPE_TIMES, np.gradient(shape.way, SHAPE_STEP))
            error = slope * np.nan_to_num(raw.contact.sd) / units.duration
            contacts.append((way, error**2 + seen.noise[0] ** 2))
    way, variance = np.mean(contacts, axis=0) if contacts else (np.nan, 0.0)
    grid = np.where(mean.seen.present[0], mean.seen.way[0], np.nan)
    noise = np.full(grid.size, mean.seen.noise[0] ** 2)
    return np.append(grid, way), np.append(noise, variance / max(len(contacts), 1))


def _most_probable(densities: Mapping[tuple, Sequence], amounts: Mapping) -> list[Explanation]:
    """Return explanations of log densities by cause and parameter, the most probable first."""
    largest = max(max(each) for each in densities.values())
    weights = {k: float(np.exp(np.subtract(e, largest)).sum()) for k, e in densities.items()}
    explanations = []
    for cause in dict.fromkeys(cause for cause, _ in weights):
        own = {key[1]: weight for key, weight in weights.items() if key[0] == cause}
        parameter = max(own, key=own.get)
        change = amounts.get(parameter or cause, [0.0] * 3)
        probability = sum(own.values()) / sum(weights.values())
        explanations.append(Explanation(cause, parameter, probability, change))
    return sorted(explanations, key=lambda each: -each.probability)
