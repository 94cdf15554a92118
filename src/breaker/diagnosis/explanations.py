"""Explanations of two inspections, compared by their likelihoods: the drive, or its measurement.

A drive that its force holds closed moves less far and less fast with a weaker force, almost as with
another ratio of the transducer. The means of both inspections decide: a ratio scales all travel and
leaves the times between positions as they were, which no parameter does. The change of a
drive comes from ``sensitivities`` of its family, whose errors count, so that an explanation is not
preferred because the family is wrong. Each explanation is a normal distribution of the change. A
ratio that changed together with the drive is not among them: with a little of a ratio, errors of
the family would explain any change of the force better. It is reported as several changes.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple, Self

import numpy as np

from breaker.common.numerals import in_digits
from breaker.common.plain_values import Plain
from breaker.diagnosis.identity import Difference
from breaker.diagnosis.limits import NORMAL
from breaker.family.inputs import Mean, mean_record, more_scattered, normalise_record
from breaker.family.sensitivities import Sensitivities
from breaker.family.shape import SHAPE_STEP, SHAPE_TIMES, Shape
from breaker.model.parameters import NAMES
from breaker.records.record import Record

# Probabilities before any record: that nothing changed, one parameter, several, the ratio; and the
# rate (1 %, known to the 0.4 % by which operations scatter). Clocks of analysers are right: another
# rate is another setting or unit, and its logarithm differs by more than this.
_UNCHANGED, _ONE, _SEVERAL, _RATIO, _RATE = 0.5, 0.3, 0.1, 0.1, 0.01 * 0.004
_OTHER_RATE = 0.04
# Sds of changes, each as probable: those of wear, from what scatter hides to the largest, and of
# ratios, from a remounted lever to another setting of the analyser (1.0 and 1.64 in real files).
_SIZES, _RATIOS = (0.02, 0.05, 0.12), (0.02, 0.06, 0.2, 0.6)
_WIDER = {"mu": 2.5, "k_b": 2.5, "gamma_a": 2.5, "gamma_b": 2.5}  # as the families wear, over f
_SCATTER = 0.004  # usual, of each parameter and of durations from operation to operation
# Of the stroke: a transducer mounted anew reads another smooth function of the travel, by 0.05 mm
# of 14 (a linearity of 0.35 %), in closing as in opening; it changes over half of the stroke.
_SHAPE, _LENGTH = 0.0035, 0.5
_ENDS = np.array([-1.0, 0.0, 1.0])
_FREE = 10.0  # sd of zero and start of a mean, in strokes and durations: as good as unknown


SURE = 0.95
"""Probability from which on an explanation is reported alone."""

_NAMES = {"ratio": "ratio of the transducer", "rate": "rate or unit of the time"}


@dataclass(frozen=True)
class Explanation(Plain):
    """Why two inspections differ.

    Attributes:
        cause: "none", "drive", "ratio" or "rate".
        parameter: Of a drive, the parameter that explains most alone; empty if several are better.
        probability: Of this cause; all of them add up to 1.
        change: 5, 50 and 95 % quantiles of its change, percent, given this cause.
    """

    cause: str
    parameter: str
    probability: float
    change: Sequence[float]


def measured_otherwise(explanations: Sequence[Explanation]) -> float:
    """Return the probability that the inspections were measured differently."""
    return sum(each.probability for each in explanations if each.cause in ("ratio", "rate"))


def otherwise_measured(explanations: Sequence[Explanation]) -> list[Difference]:
    """Return how inspections were measured differently where this is nearly certain."""
    if measured_otherwise(explanations) < SURE:
        return []
    cause = next(each for each in explanations if each.cause in _NAMES)
    return [Difference(_NAMES[cause.cause], "", "", 1.0, 1.0 + cause.change[1] / 100.0)]


def in_words(explanations: Sequence[Explanation]) -> str:
    """Say which explanations are possible where a change of the measurement is one of them."""
    likely = [e for e in explanations if e.probability > 1.0 - SURE]
    if not any(each.cause in _NAMES for each in likely):
        return ""
    said = []
    for each in likely:
        what = _NAMES.get(each.cause) or each.parameter or "several parameters of the drive"
        low, middle, high = (in_digits(e, 2, sign=True) for e in each.change)
        amount = f" by {middle} % ({low} to {high})" if any(each.change) else ""
        change = "nothing changed" if each.cause == "none" else f"{what} changed{amount}"
        said.append(f"{change}, probability {each.probability:.2f}")
    return f"Either {'; or '.join(said)}. Check ratio and rate" if said[1:] else f"The {said[0]}"


class _Pair(NamedTuple):
    """Two inspections, over the stroke: grids of all motions, each with the travel at its contact.

    Attributes:
        way: Mean before, ``(n,)``; ``change``, what follows to that of today.
        there: Where both have samples, or recorded the contact.
        smooth, noise: Covariance of the change where nothing has changed, ``(n, n)``, but for the
            noise, and the variance of that, ``(n,)``.
    """

    way: np.ndarray
    change: np.ndarray
    there: np.ndarray
    smooth: np.ndarray
    noise: np.ndarray

    @classmethod
    def of(cls, visits: Sequence[Mapping], scatter: np.ndarray, pace: float = 1.0) -> Self:
        """Compare the means of two visits, today's in a time that runs so many times as slowly.

        Args:
            visits: Records by motion, before and today.
            scatter: Covariance of a curve from operation to operation, ``(n, n)``.
        """
        ways, afters, places, noises, smooth = [], [], [], [], np.zeros_like(scatter)
        for k, motion in enumerate(visits[0]):
            raws = [visit[motion] for visit in visits]
            first = mean_record(raws[0])
            like = first.units._replace(duration=pace * first.units.duration)
            means = first, mean_record(raws[1], like)
            units = first.units, like
            (way, noise), (after, more) = map(_with_contact, means, raws, units)
            ways.append(way)
            afters.append(after)
            noises.append(noise + more)
            places.append(way if motion == "closing" else 1.0 - way)
            some = slice(k * way.size, (k + 1) * way.size)
            start = np.append(np.gradient(first.seen.way[0], SHAPE_STEP), 0.0)
            slower = np.append(SHAPE_TIMES, 0.0) * start
            count = sum(1.0 / len(each) for each in raws)
            own = scatter[some, some]
            factor = more_scattered(means, float(np.trace(own)))
            own = own + _SCATTER**2 * np.outer(slower, slower)
            smooth[some, some] = count * factor * own
            smooth[some, some] += _FREE**2 * (1.0 + np.outer(start, start))
        way, after, place, noise = map(np.concatenate, (ways, afters, places, noises))
        there = np.isfinite(after - way)
        apart = np.subtract.outer(place, place) / _LENGTH
        smooth += _SHAPE**2 * np.exp(-0.5 * np.square(apart))
        return cls(way, after - way, there, smooth, noise)

    def density(self, more: np.ndarray | float = 0.0) -> float:
        """Log density of the change with a covariance ``(n, n)`` of more than the usual."""
        factor = np.linalg.cholesky(self._covariance(more))
        white = np.linalg.solve(factor, self.change[self.there])
        return float(-0.5 * white @ white - np.log(np.diag(factor)).sum())

    def amount(self, column: np.ndarray) -> list[float]:
        """Quantiles of the factor of a column ``(n,)`` that explains the change, percent."""
        column, change = column[self.there], self.change[self.there]
        solved = np.linalg.solve(self._covariance(), np.column_stack([column, change]))
        precision, score = column @ solved
        return (100.0 * (score + NORMAL[90] * np.sqrt(precision) * _ENDS) / precision).tolist()

    def _covariance(self, more: np.ndarray | float = 0.0) -> np.ndarray:
        return (self.smooth + np.diag(self.noise) + more)[np.ix_(self.there, self.there)]


def _with_contact(mean: Mean, raws: Sequence[Record], units: Shape) -> tuple[np.ndarray, ...]:
    """Mean travel over the stroke on the grid, nan where there are no samples, then where contacts
    were recorded; and their variances.
    """
    found = []
    for raw in raws:
        if np.isfinite(raw.contact.time):
            shape, seen = normalise_record(raw, units)
            at = (raw.contact.time - raw.time[raw.segment.begin] - shape.origin) / units.duration
            way, slope = (
                np.interp(at, SHAPE_TIMES, each)
                for each in (shape.way, np.gradient(shape.way, SHAPE_STEP))
            )
            error = slope * np.nan_to_num(raw.contact.sd) / units.duration
            found.append((way, error**2 + seen.noise[0] ** 2))
    way, variance = np.mean(found, axis=0) if found else (np.nan, 0.0)
    grid = np.where(mean.seen.present[0], mean.seen.way[0], np.nan)
    noise = np.full(grid.size, mean.seen.noise[0] ** 2)
    return np.append(grid, way), np.append(noise, variance / max(len(found), 1))


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
        regressions: Of the drive's family, by motions.
        same_transducer: Whether both inspections have the same transducer and ratio.
        sliding: Share of the family's drives whose contact slides. Their travel scales with the
            force as with a ratio, and only a recorded contact tells these apart.
    """
    means = [{m: mean_record(raws) for m, raws in each.items()} for each in (before, today)]
    (*_, last), (*_, later) = ([e.seen.duration[0] for e in each.values()] for each in means)
    first, second = (next(iter(each.values())).seen for each in means)
    ways = np.concatenate([each.seen.way[0] for each in means[0].values()])
    slopes, errors = regressions[tuple(before)].of(ways, float(np.log(last / first.duration[0])))
    scatter = _SCATTER**2 * (slopes.T @ slopes + errors.sum(axis=0))
    pair = _Pair.of((before, today), scatter)
    sizes = np.square([_WIDER.get(name, 1.0) for name in NAMES])[:, None, None]
    changed = sizes * (slopes[:, :, None] * slopes[:, None] + errors)  # by an sd of 1
    several = changed.sum(axis=0)
    pace = float(np.sqrt(later * second.duration[0] / last / first.duration[0]))
    paced = _Pair.of((before, today), scatter, pace)
    both = pair.there & paced.there  # densities of the same samples
    pair, paced = (each._replace(there=both) for each in (pair, paced))
    on_grid = np.arange(len(scatter)) % (SHAPE_TIMES.size + 1) < SHAPE_TIMES.size
    moved = np.outer(pair.way * on_grid, pair.way * on_grid)
    logs = {("none", ""): [np.log(_UNCHANGED) + pair.density()]}

    def add(cause: str, parameter: str, prior: float, more: np.ndarray) -> None:
        logs.setdefault((cause, parameter), []).append(np.log(prior) + pair.density(more))

    for size in _SIZES:
        for name, each in zip(NAMES, changed, strict=True):
            add("drive", name, _ONE / len(NAMES) / len(_SIZES), size**2 * each)
        if sliding > 0.0:
            add("drive", "f", _ONE / len(NAMES) / len(_SIZES) * sliding, size**2 * moved)
    for size in _SIZES[:-1]:  # all parameters by the largest would explain anything
        add("drive", "", _SEVERAL / len(_SIZES[:-1]), size**2 * several)
    scaled = pair.amount(pair.way)
    larger = ((1.0 + scaled[1] / 100.0) ** 2 - 1.0) * pair.smooth  # a ratio scales these errors
    for size in () if same_transducer else _RATIOS:
        more = size**2 * np.outer(pair.way, pair.way) + larger
        add("ratio", "", _RATIO / len(_RATIOS), more)
    if abs(np.log(pace)) > _OTHER_RATE:
        logs["rate", ""] = [np.log(_RATE) + paced.density()]
    amounts = {name: pair.amount(slope) for name, slope in zip(NAMES, slopes, strict=True)}
    amounts |= {"ratio": scaled, "rate": [100.0 * (pace - 1.0)] * 3}
    return _most_probable(logs, amounts)


def _most_probable(logs: Mapping[tuple, Sequence], amounts: Mapping) -> list[Explanation]:
    """Return explanations from log weights by cause and parameter."""
    most = max(max(each) for each in logs.values())
    weights = {key: float(np.exp(np.subtract(each, most)).sum()) for key, each in logs.items()}
    found = []
    for cause in dict.fromkeys(cause for cause, _ in logs):
        own = {key[1]: weight for key, weight in weights.items() if key[0] == cause}
        parameter = max(own, key=own.get)
        change = amounts.get(parameter or cause, [0.0] * 3)
        probability = sum(own.values()) / sum(weights.values())
        found.append(Explanation(cause, parameter, probability, change))
    return sorted(found, key=lambda each: -each.probability)
