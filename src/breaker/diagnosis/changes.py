"""Compute what changed between two inspections of a drive: measured quantities and parameters.

Measured quantities are compared by their means. Networks of a family of drives infer changes of
the parameters from the mean record of each inspection. Their estimates are valid only for drives of
the family, and closing and opening have to agree. A quantity has changed if an increase or a
decrease has a probability of at least 95 %. Limits decide whether the change matters.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import erfc
from typing import NamedTuple, Self

import numpy as np

from breaker.common.numerals import distinct
from breaker.common.plain_values import Plain
from breaker.diagnosis.limits import NORMAL
from breaker.family.inputs import Mean, mean_and_change, mean_record, shrunk_variance
from breaker.family.membership import choose_family
from breaker.family.networks import (
    EFFECTS,
    LEAST_AGREEMENT,
    SURE,
    ChangeNetwork,
    StateNetwork,
    agreement_of,
    plausible_wear,
)
from breaker.model.parameters import NAMES, PARAMETERS, Parameter
from breaker.model.quantities import CURRENTS, RESISTANCES, Speed, in_words, quantities_of
from breaker.records.measurements import Measured
from breaker.records.record import Record

USUAL_SCATTER = 0.004
"""Usual scatter of parameters, durations and quantities from operation to operation, as a share."""

_DRAWS = 4000  # gives 5 % quantiles a standard error of 0.3 %
# Prior probability that a measured quantity has not changed, and sd of changes, as a share. With an
# error of 0.3 %, changes are reported from 4 sds on: in 1 of 15,000 unchanged quantities.
_UNCHANGED, _CHANGES = 0.9, 0.1
# Quantities that scatter more than usual: share of the value, ms, and share of the stroke.
# An over-travel may be 0, so its change is relative to at least this share of the stroke.
_SCATTER = {
    **dict.fromkeys(CURRENTS, (0.02, 0.0, 0.0)),
    **dict.fromkeys(RESISTANCES, (0.1, 0.0, 0.0)),
    **dict.fromkeys(("over_travel", "opening_over_travel"), (0.05, 0.0, 0.002)),
    "bounce_time": (0.2, 0.3, 0.0),
    "start": (0.03, 0.0, 0.0),
}
# Width of an interval, percent, below which the records determine a change: half of the largest
# usual wear of dampings and contact spring. They determine 60 and 81 of 98 such changes.
_NARROW = 15.0
_INFERRED = {name: Parameter(name, "1", meaning) for name, meaning in EFFECTS.items()}
_INFERRED |= {parameter.name: parameter for parameter in PARAMETERS}


class Pair(NamedTuple):
    """Records of two inspections, of the same motions, and their means.

    Attributes:
        before, today: Records by motion.
        first, second: Means before and today by motion, in the units of the first.
    """

    before: Mapping[str, Sequence[Record]]
    today: Mapping[str, Sequence[Record]]
    first: Mapping[str, Mean]
    second: Mapping[str, Mean]

    @classmethod
    def of(cls, before: Mapping, today: Mapping, pace: float = 1.0) -> Self:
        """Average the records of each inspection; ``pace`` multiplies the time unit of today's."""
        first, second = {motion: mean_record(raws) for motion, raws in before.items()}, {}
        for motion, mean in first.items():
            units = mean.units._replace(duration=pace * mean.units.duration)
            second[motion] = mean_record(today[motion], units)
        return cls(before, today, first, second)


@dataclass(frozen=True, kw_only=True)
class QuantityChange(Plain):
    """The change of a quantity between two inspections.

    Attributes:
        name, unit, meaning: Name, unit and definition of the quantity.
        motion: Motion; empty if inferred.
        before, today: Measured means of both inspections, in the unit; None if inferred.
        difference, sd: Measured difference and its standard deviation, in the unit.
        p_unchanged: Probability of no change.
        change: 5, 50 and 95 % quantiles, percent; of all draws, also those without a change.
        if_changed: The same quantiles, given that the quantity changed.
        p_worse: Probability of a change for the worse; None if neither direction is worse.
        changed: Whether an increase or a decrease has a probability of at least 95 %.
        identifiable: Whether the records determine the change of a parameter.
    """

    name: str
    unit: str
    meaning: str
    motion: str = ""
    before: float | None = None
    today: float | None = None
    difference: float | None = None
    sd: float | None = None
    p_unchanged: float
    change: Sequence[float]
    if_changed: Sequence[float]
    p_worse: float | None
    changed: bool
    identifiable: bool = True

    @classmethod
    def of(cls, quantity: Parameter, more: float, less: float, **values: object) -> Self:
        """Return the change of a quantity, from the probabilities of an increase and a decrease."""
        worse = {1: more, -1: less}.get(quantity.worse)
        p_unchanged = max(1.0 - more - less, 0.0)  # rounding may make the difference negative
        known = {"p_unchanged": p_unchanged, "changed": max(more, less) >= SURE}
        known |= {key: getattr(quantity, key) for key in ("name", "unit", "meaning")}
        return cls(**known, p_worse=worse, **values)

    @property
    def measured(self) -> bool:
        """Whether the change was measured, not inferred."""
        return self.before is not None

    @property
    def is_worse(self) -> bool:
        """Whether the quantity changed, probably for the worse."""
        return self.changed and (self.p_worse or 0.0) > 0.5

    @property
    def words(self) -> str:
        """Name of the quantity in a sentence, with its motion if the name lacks it."""
        name = in_words(self.name)
        return name if self.motion in self.name else f"{name} ({self.motion})"

    @property
    def shown(self) -> list[str]:
        """Change, interval and unit: percent, unless the earlier value was within its error."""
        if self.measured and abs(self.before) < NORMAL[95] * (self.sd or 0.0):
            half = NORMAL[90] * self.sd
            ends = self.difference - half, self.difference, self.difference + half
            return in_unit(ends, self.unit)
        return in_unit(self.if_changed)


def in_unit(change: Sequence[float], unit: str = "%") -> list[str]:
    """Return a change and its interval, in digits that distinguish its ends, and the unit."""
    low, middle, high = distinct(change, 2, sign=True)
    return [f"{middle} {unit}", f"{low} to {high}", unit]


def measured_changes(pair: Pair, speeds: Sequence[Speed]) -> list[QuantityChange]:
    """Return the change of each quantity of each motion that both inspections measured."""
    rows = []
    for motion in pair.before:
        shown = [[raw.measured(speeds) for raw in raws[motion]] for raws in pair[:2]]
        for name, quantity in quantities_of(motion, speeds, ("record",)).items():
            readings = [_readings(quantity_values, name) for quantity_values in shown]
            if all(map(len, readings)):
                rows.append(measured_change(quantity, motion, readings, _mean_stroke(shown[0])))
    return [row for row in rows if row]


def measured_change(
    quantity: Parameter, motion: str, readings: Sequence[np.ndarray], stroke: float = 0.0
) -> QuantityChange | None:
    """Return the change of a measured quantity, percent; None if its earlier value was 0.

    ``readings`` are values and sds of each inspection, ``(n, 2)``; ``stroke`` is the earlier, mm.
    """
    first, second = (float(values[:, 0].mean()) for values in readings)
    scale = max(abs(first), stroke * _scatter_of(quantity.name)[2])
    if scale == 0.0:
        return None
    sd, difference = mean_error(readings, quantity.name, stroke), second - first
    change, error = difference / scale, max(sd / scale, np.finfo(float).eps)
    wide = np.hypot(error, _CHANGES)
    evidence = np.log(wide / error) + 0.5 * change**2 * (wide**-2.0 - error**-2.0)
    p_changed = 1.0 / (1.0 + _UNCHANGED / (1.0 - _UNCHANGED) * np.exp(evidence))
    more, less = (0.5 * p_changed * erfc(-s * change / error / np.sqrt(2.0)) for s in (1.0, -1.0))
    ends = 100.0 * (change + NORMAL[90] * error * np.array([-1.0, 0.0, 1.0]))
    means = {"motion": motion, "before": first, "today": second, "difference": difference, "sd": sd}
    return QuantityChange.of(quantity, more, less, **means, change=ends, if_changed=ends)


def _readings(shown: Iterable[Mapping[str, Measured]], name: str) -> np.ndarray:
    """Return values of a quantity and their sds, ``(n, 2)``, from the records that measure it."""
    readings = np.array([quantity_values[name][:2] for quantity_values in shown], float)
    return readings[np.isfinite(readings[:, 0])]


def mean_of(shown: Sequence[Mapping[str, Measured]], name: str) -> Measured:
    """Return the mean of a quantity over the records of an inspection."""
    readings = _readings(shown, name)
    if not len(readings):
        return shown[0][name]
    error = mean_error([readings], name, _mean_stroke(shown))
    return Measured(float(readings[:, 0].mean()), error, "")


def _mean_stroke(shown: Sequence[Mapping[str, Measured]]) -> float:
    """Return the mean stroke of records, mm; 0 if no record reaches its rest position."""
    strokes = _readings(shown, "stroke")[:, 0]
    return float(strokes.sum()) / max(strokes.size, 1)


def _scatter_of(name: str) -> tuple[float, float, float]:
    return _SCATTER.get(name, (USUAL_SCATTER, 0.0, 0.0))


def mean_error(readings: Sequence[np.ndarray], name: str, stroke: float) -> float:
    """Return the standard deviation of a mean of readings, or of the difference of two means.

    The scatter from operation to operation combines the usual and the observed scatter.
    ``readings`` are values and sds of one or two inspections, ``(n, 2)``; ``stroke`` is in mm.
    """
    share, more, of_stroke = _scatter_of(name)
    usual = np.square([share * readings[0][:, 0].mean(), more, of_stroke * stroke]).sum()
    degrees = sum(len(values) - 1 for values in readings)
    squares = sum(len(values) * values[:, 0].var() for values in readings)
    total = 0.0
    for values in readings:
        stated = np.nan_to_num(np.square(values[:, 1])).mean()
        total += max(stated, shrunk_variance(squares, degrees, stated + usual)) / len(values)
    return float(np.sqrt(total))


def parameter_change(name: str, share: np.ndarray) -> QuantityChange:
    """Return the change of a parameter or of an additional effect, percent, from posterior draws of
    the relative change, ``(d,)``.

    The records determine the change if its interval excludes zero or is narrow, unless all draws
    are without a change.
    """
    quantiles = 1.0 - SURE, 0.5, SURE
    change, moved = 100.0 * np.quantile(share, quantiles), share[share != 0.0]
    known = moved.size > 0 and (change[0] * change[2] > 0.0 or np.ptp(change) < _NARROW)
    if_changed = 100.0 * np.quantile(moved, quantiles) if moved.size else change
    sides = (share > 0.0).mean(), (share < 0.0).mean()
    values = {"change": change, "if_changed": if_changed, "identifiable": bool(known)}
    return QuantityChange.of(_INFERRED[name], *sides, **values)


@dataclass(frozen=True, eq=False)
class NetworkChanges:
    """Changes between two inspections that networks infer.

    Attributes:
        family: Family of the networks, or the nearest one.
        matches: "p_value" and "parts" of the match with it, by motion and inspection.
        state: "estimated", with draws; "outside_family"; "beyond_wear", if changes are larger than
            any wear of the family; "operations_disagree", if closing and opening contradict each
            other; "different_setup", if the inspections were measured differently.
        agreement: "p_value" of the "parameter" in which motions agree least; 1 with one motion.
        draws: Posterior draws of the relative change of each parameter, then of each additional
            effect as a share of the closing force (``build_up``: of the duration), ``(d,)``.
    """

    family: str
    matches: Mapping[str, Mapping[str, Mapping]]
    state: str = "outside_family"
    agreement: Mapping = field(default_factory={"p_value": 1.0, "parameter": ""}.copy)
    draws: Mapping[str, np.ndarray] = field(default_factory=dict)

    def unless_measured_otherwise(self, probability: float) -> "NetworkChanges":
        """Return the changes with a share of draws set to no change: the probability that the
        inspections were measured differently. If that is nearly certain, return no draws.
        """
        if probability >= SURE:
            return replace(self, state="different_setup", draws={})
        unchanged = np.arange(_DRAWS) < probability * _DRAWS
        draws = {name: np.where(unchanged, 0.0, draw) for name, draw in self.draws.items()}
        return replace(self, draws=draws)


def compare(
    pair: Pair,
    networks: Iterable[tuple[StateNetwork, ChangeNetwork]],
    rng: np.random.Generator,
    *,
    misfit_p_value: float = 0.001,
) -> NetworkChanges:
    """Infer the changes by the networks of the family that fits both inspections.

    If no family fits, there are no draws, and the matches are those of the nearest family.

    Args:
        networks: Networks of each family; the next is opened only if the records do not fit.
        misfit_p_value: p-value below which an inspection is outside a family.
    """
    seen = {("before", motion): mean.seen for motion, mean in pair.first.items()}
    seen |= {("today", motion): mean_record(raws).seen for motion, raws in pair.today.items()}
    (state, network), selected, fits = choose_family(
        networks,
        lambda both: [(key, both[0].match(key[1], mean)) for key, mean in seen.items()],
        misfit_p_value,
    )
    matches: dict[str, dict[str, dict]] = {motion: {} for motion in pair.before}
    for (inspection, motion), match in selected:
        matches[motion][inspection] = {"p_value": match.p_value, "parts": match.parts}
    changes = NetworkChanges(state.settings["family"], matches)
    if not fits:
        return changes
    references, changed = {}, {}
    for motion, mean in pair.first.items():
        both = mean_and_change(mean, pair.second[motion], network.change_bases[motion])
        references[motion], changed[motion] = both
    logs, effects = network.draw(references, changed, _DRAWS, rng)
    if not plausible_wear(logs[0]):
        return replace(changes, state="beyond_wear")
    if len(references) > 1:
        alone = [
            network.draw({motion: reference}, {motion: changed[motion]}, _DRAWS, rng)[0][0]
            for motion, reference in references.items()
        ]
        agreement = agreement_of(*alone)
        least = {"p_value": agreement.min(), "parameter": NAMES[int(agreement.argmin())]}
        changes = replace(changes, agreement=least)
        if agreement.min() < LEAST_AGREEMENT:
            return replace(changes, state="operations_disagree")
    draws = dict(zip(NAMES, np.expm1(logs[0].T), strict=True))
    draws |= {name: effect[0] for name, effect in effects.items()}
    return replace(changes, state="estimated", draws=draws)
