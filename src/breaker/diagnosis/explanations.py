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
from breaker.diagnosis.changes import SURE, USUAL_SCATTER, Pair, QuantityChange, measured_change
from breaker.diagnosis.identity import Difference, Inspections
from breaker.diagnosis.limits import NORMAL
from breaker.family.inputs import Mean, mean_record, more_scattered, normalise_record
from breaker.family.sensitivities import Sensitivities
from breaker.family.shape import SHAPE_STEP, SHAPE_TIMES, Shape
from breaker.model.parameters import MOTIONS, NAMES, Parameter
from breaker.records.record import Record

OTHER_SETUP = {
    "ratio": "ratio of the transducer",
    "rate": "rate or unit of the time",
    "slack": "time to 10 % of the travel, by another slack of the transducer,",
}
"""Names of differences in the measurement, by code; the first two are causes."""

# Probability of each cause without any record, and sds of its relative change, equally probable:
# of parameters from what scatter hides to the largest wear (not of all, which would explain
# anything), of ratios from a remounted lever to another setting (1.0 and 1.64 in real files).
# studies.force_or_ratio chose them. A rate is 1 %, known to the 0.4 % by which durations scatter.
_CAUSES = {
    "none": (0.5, ()),
    "parameter": (0.3, (0.02, 0.05, 0.12)),
    "several": (0.1, (0.02, 0.05)),
    "ratio": (0.1, (0.02, 0.06, 0.2, 0.6)),
    "rate": (0.01 * USUAL_SCATTER, ()),
}
# Difference of logarithms from which a rate may differ: clocks of analysers are right, so another
# rate is another setting or unit.
_OTHER_RATE = 0.04
_WIDER = {"mu": 2.5, "k_b": 2.5, "gamma_a": 2.5, "gamma_b": 2.5}  # as families wear, relative to f
# A transducer mounted again reads a smooth function of the travel: a linearity of 0.35 % of the
# stroke (0.05 mm of 14), which changes over half of the stroke.
_SHAPE, _LENGTH = 0.0035, 0.5
_START = Parameter("start", "ms", "first detected motion to 10 % of the travel")


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
    pair: Pair,
    regressions: Mapping[tuple[str, ...], Sensitivities],
    *,
    same_transducer: bool = False,
    sliding: float = 0.0,
) -> list[Explanation]:
    """Return the explanations of two inspections, the most probable first.

    Args:
        pair: Both inspections.
        regressions: Sensitivities of the drive's family, by motions.
        same_transducer: Whether both inspections have the same transducer and ratio.
        sliding: Share of the family's drives whose contact slides. Their travel scales with the
            force as with a ratio, and only a recorded contact separates the two.
    """
    shapes = np.concatenate([mean.seen.way[0] for mean in pair.first.values()])
    logs = [_durations(side) for side in (pair.first, pair.second)]
    slopes, errors = regressions[tuple(pair.first)].of(shapes, logs[0][-1] - logs[0][0])
    scatter = USUAL_SCATTER**2 * (slopes.T @ slopes + errors.sum(axis=0))
    slower = 0.5 * float(logs[1][0] + logs[1][-1] - logs[0][0] - logs[0][-1])
    change, found = _MeanChange.of(pair, scatter), []
    if abs(slower) > _OTHER_RATE:
        paced = _MeanChange.of(pair, scatter, float(np.exp(slower)))
        both = np.isfinite(change.change + paced.change)  # densities are of the same samples
        change, paced = (
            e._replace(change=np.where(both, e.change, np.nan)) for e in (change, paced)
        )
        found.append(("rate", "", np.log(_CAUSES["rate"][0]) + paced.density()))
    for cause, parameter, prior, more in _hypotheses(change, slopes, errors, sliding):
        if not (cause == "ratio" and same_transducer):
            found.append((cause, parameter, np.log(prior) + change.density(more)))

    def amount(cause: str, parameter: str) -> list[float]:
        if cause == "rate":
            sides = slower + NORMAL[90] * USUAL_SCATTER * np.array([-1.0, 0.0, 1.0])
            return (100.0 * np.expm1(sides)).tolist()
        column = slopes[NAMES.index(parameter)] if parameter else change.way
        return change.amount(column) if parameter or cause == "ratio" else [0.0] * 3

    largest = max(log for _, _, log in found)
    weights: dict[str, dict[str, float]] = {}
    for cause, parameter, log in found:
        own = weights.setdefault(cause, {})
        own[parameter] = own.get(parameter, 0.0) + float(np.exp(log - largest))
    total, explanations = sum(sum(own.values()) for own in weights.values()), []
    for cause, own in weights.items():
        parameter = max(own, key=own.get)
        probability, about = sum(own.values()) / total, (cause, parameter)
        explanations.append(Explanation(*about, probability, amount(*about)))
    return sorted(explanations, key=lambda each: -each.probability)


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
        own = [[e for e in records if e.motion == motion] for records in inspections.values()]
        starts = [
            np.array([(e.tenth - e.raw.moves, e.raw.first_motion_sd) for e in some]) for some in own
        ]
        row = measured_change(_START, motion, starts)
        if not (row and row.changed and row.difference < 0.0):
            return []
        differences.append(Difference(OTHER_SETUP["slack"], "ms", motion, row.before, row.today))
    return differences


class _MeanChange(NamedTuple):
    """Change of the means over the stroke: for each motion on the grid, then at the contact.

    Attributes:
        way: Mean travel before, ``(n,)``.
        change: Mean travel today minus ``way``, ``(n,)``; nan where an inspection has no samples,
            or recorded no contact.
        smooth: Covariance of the change of an unchanged drive, without noise, ``(n, n)``.
        noise: Variance of the noise, ``(n,)``.
    """

    way: np.ndarray
    change: np.ndarray
    smooth: np.ndarray
    noise: np.ndarray

    @classmethod
    def of(cls, pair: Pair, scatter: np.ndarray, pace: float = 1.0) -> Self:
        """Compare the means of two inspections, the second in a time that runs slower by a factor.

        Args:
            pair: Both inspections.
            scatter: Covariance of a curve from operation to operation, ``(n, n)``.
            pace: Factor on the durations of today.
        """
        parts, smooth = [], np.zeros_like(scatter)
        for k, (motion, first) in enumerate(pair.first.items()):
            raws, units = (pair.before[motion], pair.today[motion]), first.units
            second = pair.second[motion]
            if pace != 1.0:
                units = units._replace(duration=pace * units.duration)
                second = mean_record(raws[1], units)
            way, noise = _with_contact(first, raws[0], first.units)
            after, more = _with_contact(second, raws[1], units)
            parts.append((way, after - way, noise + more))
            start = np.append(np.gradient(first.seen.way[0], SHAPE_STEP), 0.0)
            slower = np.append(SHAPE_TIMES, 0.0) * start
            some = slice(k * way.size, (k + 1) * way.size)
            own = scatter[some, some]
            factor = more_scattered((first, second), float(np.trace(own)))
            own = factor * (own + USUAL_SCATTER**2 * np.outer(slower, slower))
            own = own * sum(1.0 / len(each) for each in raws)
            # Zero and start of each mean are unknown: sds of a stroke and a duration.
            smooth[some, some] = own + 1.0 + np.outer(start, start)
        way, change, noise = map(np.concatenate, zip(*parts, strict=True))
        turned = np.repeat([motion == "opening" for motion in pair.first], parts[0][0].size)
        place = np.where(turned, 1.0 - way, way)
        distance = np.subtract.outer(place, place) / _LENGTH
        smooth += _SHAPE**2 * np.exp(-0.5 * np.square(distance))
        return cls(way, change, smooth, noise)

    def density(self, more: np.ndarray | float = 0.0) -> float:
        """Return the log density of the change; ``more`` is added to its covariance."""
        there, covariance = self._there(more)
        factor = np.linalg.cholesky(covariance)
        white = np.linalg.solve(factor, self.change[there])
        return float(-0.5 * white @ white - np.log(np.diag(factor)).sum())

    def amount(self, column: np.ndarray) -> list[float]:
        """Return quantiles of the factor of a column ``(n,)`` that explains the change, percent."""
        there, covariance = self._there()
        column, change = column[there], self.change[there]
        solved = np.linalg.solve(covariance, np.column_stack([column, change]))
        precision, score = column @ solved
        half = NORMAL[90] * np.sqrt(precision)
        return [float(100.0 * each / precision) for each in (score - half, score, score + half)]

    def _there(self, more: np.ndarray | float = 0.0) -> tuple[np.ndarray, np.ndarray]:
        """Return where the change is known, and its covariance there."""
        there = np.isfinite(self.change)
        return there, (self.smooth + np.diag(self.noise) + more)[np.ix_(there, there)]


def _durations(means: Mapping[str, Mean]) -> np.ndarray:
    """Return logarithms of the durations of each motion."""
    return np.log([float(mean.seen.duration[0]) for mean in means.values()])


def _hypotheses(
    change: _MeanChange, slopes: np.ndarray, errors: np.ndarray, sliding: float
) -> Iterator[tuple[str, str, float, np.ndarray | float]]:
    """Yield cause, parameter, prior probability, and covariance of the change by this cause."""
    yield "none", "", _CAUSES["none"][0], 0.0
    wider = np.square([_WIDER.get(name, 1.0) for name in NAMES])[:, None, None]
    changed = wider * (slopes[:, :, None] * slopes[:, None] + errors)  # by an sd of 1
    on_grid = np.arange(change.way.size) % (SHAPE_TIMES.size + 1) < SHAPE_TIMES.size
    slid = np.outer(change.way * on_grid, change.way * on_grid)
    probability, sizes = _CAUSES["parameter"]
    prior = probability / len(NAMES) / len(sizes)
    for size in sizes:
        for name, each in zip(NAMES, changed, strict=True):
            yield "drive", name, prior, size**2 * each
        if sliding > 0.0:
            yield "drive", "f", prior * sliding, size**2 * slid
    probability, sizes = _CAUSES["several"]
    for size in sizes:
        yield "drive", "", probability / len(sizes), size**2 * changed.sum(axis=0)
    factor = 1.0 + change.amount(change.way)[1] / 100.0
    larger = (factor**2 - 1.0) * change.smooth  # a ratio scales these errors
    probability, sizes = _CAUSES["ratio"]
    for size in sizes:
        more = size**2 * np.outer(change.way, change.way) + larger
        yield "ratio", "", probability / len(sizes), more


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
