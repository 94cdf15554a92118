"""Compute what changed between two inspections of a drive: measured quantities and parameters.

Measured quantities are compared by their means. Networks of a family of drives infer changes of
the parameters from the mean record of each inspection. Their answer holds for drives of the family
only, and closing and opening have to agree. A quantity changed where the 90 % interval of its
change, the probability of no change included, excludes zero. Limits decide whether that matters.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from math import erfc
from typing import NamedTuple, Self

import numpy as np

from breaker.common.plain_values import Plain, plainly
from breaker.diagnosis.limits import NORMAL
from breaker.family.inputs import Mean, mean_and_change, mean_record, shrunk_variance
from breaker.family.membership import choose_family
from breaker.family.networks import (
    EFFECTS,
    LEAST_AGREEMENT,
    ChangeNetwork,
    StateNetwork,
    agreement_of,
    plausible_wear,
)
from breaker.model.parameters import NAMES, PARAMETERS, Parameter
from breaker.model.quantities import CURRENTS, Speed, quantities_of
from breaker.records.measurements import Measured
from breaker.records.record import Record

SURE = 0.95
"""Probability from which an explanation, or a change to one side, is reported alone."""

USUAL_SCATTER = 0.004
"""Usual scatter of parameters, durations and quantities from operation to operation, as a share."""

_DRAWS = 4000  # quantiles of 5 % are then known to 0.3 %
# Prior probability that a measured quantity has not changed, and sd of changes, as a share: one
# that is known to 0.3 % is reported from 4 sds on, in 1 of 15,000 unchanged ones.
_UNCHANGED, _CHANGES = 0.9, 0.1
# Larger scatter than usual: share of the value, ms, and share of the stroke; voltages vary.
# An over-travel may be 0, and its change is compared with no less than that share of the stroke.
_SCATTER = {
    **dict.fromkeys(CURRENTS, (0.02, 0.0, 0.0)),
    **dict.fromkeys(("over_travel", "opening_over_travel"), (0.05, 0.0, 0.002)),
    "bounce_time": (0.2, 0.3, 0.0),
    "start": (0.03, 0.0, 0.0),
}
_INFERRED = {name: Parameter(name, "1", meaning) for name, meaning in EFFECTS.items()}
_INFERRED |= {parameter.name: parameter for parameter in PARAMETERS}


class Pair(NamedTuple):
    """Records of two inspections, of the same motions, and their means.

    Attributes:
        before, today: Records by motion.
        first, second: Means before and today by motion, in units of the first.
        own: Means of today by motion, in their own units.
    """

    before: Mapping[str, Sequence[Record]]
    today: Mapping[str, Sequence[Record]]
    first: Mapping[str, Mean]
    second: Mapping[str, Mean]
    own: Mapping[str, Mean]

    @classmethod
    def of(
        cls, before: Mapping[str, Sequence[Record]], today: Mapping[str, Sequence[Record]]
    ) -> Self:
        """Average the records of each inspection."""
        first = {motion: mean_record(raws) for motion, raws in before.items()}
        second = {motion: mean_record(today[motion], first[motion].units) for motion in first}
        own = {motion: mean_record(today[motion]) for motion in first}
        return cls(before, today, first, second, own)


@dataclass(frozen=True, eq=False)
class NetworkChanges(Plain):
    """Changes between two inspections that networks infer.

    Attributes:
        family: Family of the networks, or the nearest one.
        matches: "p_value" and "parts" of the match with it, by motion and inspection.
        state: "estimated", with draws; "outside_family"; "beyond_wear", larger than any wear of the
            family; "operations_disagree", of closing and opening that contradict each other.
        agreement: "p_value" of the "parameter" in which motions agree least; 1 of a single one.
        draws: Posterior draws of the relative change of each parameter, then of each additional
            effect as a share of the closing force (``build_up``: of the duration), ``(d,)``.
        wear: Usual change of each parameter by wear in the family, as a share.
    """

    family: str
    matches: Mapping[str, Mapping[str, Mapping]]
    state: str
    agreement: Mapping[str, float | str]
    draws: Mapping[str, Sequence[float]] = field(default_factory=dict)
    wear: Mapping[str, float] = field(default_factory=dict)

    def shares(self, unchanged: float) -> dict[str, np.ndarray]:
        """Return the draws where a share of them, evenly among them, is of no change.

        The share is the probability of another measurement, of which networks know nothing.
        """
        still = np.diff(np.floor(unchanged * np.arange(_DRAWS + 1))) > 0.0
        return {name: np.where(still, 0.0, each) for name, each in self.draws.items()}


@dataclass(frozen=True, kw_only=True)
class QuantityChange(Plain):
    """The change of a quantity between two inspections.

    Attributes:
        name, unit, meaning: Name, unit and definition of the quantity.
        motion: Motion; empty if inferred.
        before, today: Measured means of both inspections, in the unit; None if inferred.
        difference, sd: Measured difference and its standard deviation, in the unit.
        p_unchanged: Probability of no change.
        change: 5, 50 and 95 % quantiles, percent; of draws with those of no change.
        if_changed: The same quantiles if there is a change.
        p_worse: Probability of a change to the worse; None where neither side is.
        changed: Whether the change differs from zero.
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

    @property
    def measured(self) -> bool:
        """Whether the change was measured, not inferred."""
        return self.before is not None

    @property
    def is_worse(self) -> bool:
        """Whether the quantity changed, and probably to the worse."""
        return self.changed and (self.p_worse or 0.0) > 0.5

    @property
    def words(self) -> str:
        """Name of the quantity in a sentence, with its motion where the name lacks it."""
        word = _INFERRED[self.name].word if self.name in _INFERRED else ""
        name = word or self.name.replace("_", " ")
        return name if self.motion in self.name else f"{name} ({self.motion})"


# ---- measured quantities ---------------------------------------------------------------------


def measured_changes(pair: Pair, speeds: Sequence[Speed]) -> list[QuantityChange]:
    """Return the change of each quantity of a motion that records of both inspections show."""
    rows = []
    for motion in pair.before:
        shown = [[raw.measured(speeds) for raw in raws[motion]] for raws in pair[:2]]
        stroke = mean_stroke(shown[0])
        for name, quantity in quantities_of(motion, speeds, ("record",)).items():
            readings = [readings_of(some, name) for some in shown]
            if all(map(len, readings)):
                rows.append(measured_change(quantity, motion, readings, stroke))
    return [row for row in rows if row]


def readings_of(shown: Iterable[Mapping[str, Measured]], name: str) -> np.ndarray:
    """Return values of a quantity and their sds, ``(n, 2)``, of the records that show it."""
    readings = np.array([each[name][:2] for each in shown], float)
    return readings[np.isfinite(readings[:, 0])]


def mean_stroke(shown: Sequence[Mapping[str, Measured]]) -> float:
    """Return the mean stroke of records, mm; 0 where none reaches its rest."""
    strokes = readings_of(shown, "stroke")[:, 0]
    return float(strokes.mean()) if strokes.size else 0.0


def measured_change(
    quantity: Parameter, motion: str, readings: Sequence[np.ndarray], stroke: float = 0.0
) -> QuantityChange | None:
    """Return the change of a measured quantity, percent; None of one that was 0.

    Args:
        quantity: The quantity.
        motion: Its motion.
        readings: Values and sds of both inspections, ``(n, 2)`` each.
        stroke: Stroke before, mm.
    """
    first, second = (float(some[:, 0].mean()) for some in readings)
    size = max(abs(first), stroke * _scatter_of(quantity.name)[2])
    if size == 0.0:
        return None
    sd = mean_error(readings, quantity.name, stroke)
    change, error = (second - first) / size, max(sd / size, np.finfo(float).eps)
    wide = np.hypot(error, _CHANGES)
    evidence = np.log(wide / error) + 0.5 * change**2 * (wide**-2.0 - error**-2.0)
    p_changed = 1.0 / (1.0 + _UNCHANGED / (1.0 - _UNCHANGED) * np.exp(evidence))
    more, less = (0.5 * p_changed * erfc(-s * change / error / np.sqrt(2.0)) for s in (1.0, -1.0))
    quantiles = 100.0 * (change + NORMAL[90] * error * np.array([-1.0, 0.0, 1.0]))
    return _change(
        quantity,
        (more, less),
        motion=motion,
        before=first,
        today=second,
        difference=second - first,
        sd=sd,
        p_unchanged=1.0 - p_changed,
        change=quantiles,
        if_changed=quantiles,
        changed=max(more, less) >= SURE,
    )


def _change(of: Parameter, sides: tuple[float, float], **values: object) -> QuantityChange:
    """Return the change of a quantity, with probabilities of more and of less."""
    worse = {1: sides[0], -1: sides[1]}.get(of.worse)
    about = {"name": of.name, "unit": of.unit, "meaning": of.meaning, "p_worse": worse}
    return plainly(QuantityChange(**about, **values))


def _scatter_of(name: str) -> tuple[float, float, float]:
    return _SCATTER.get(name, (USUAL_SCATTER, 0.0, 0.0))


def mean_error(readings: Sequence[np.ndarray], name: str, stroke: float) -> float:
    """Return the standard deviation of a mean of readings, or of the difference of two means.

    The usual scatter of the quantity from operation to operation counts with what is seen of it.

    Args:
        readings: Values and their sds of one or two inspections, ``(n, 2)``.
        name: Name of the quantity.
        stroke: mm.
    """
    share, more, of_stroke = _scatter_of(name)
    usual = np.square([share * readings[0][:, 0].mean(), more, of_stroke * stroke]).sum()
    seen = sum(len(some) - 1 for some in readings)
    squares = sum(float(np.square(some[:, 0] - some[:, 0].mean()).sum()) for some in readings)
    total = 0.0
    for some in readings:
        known = float(np.nan_to_num(np.square(some[:, 1])).mean())
        total += max(known, shrunk_variance(squares, seen, known + usual)) / len(some)
    return float(np.sqrt(total))


# ---- parameters ------------------------------------------------------------------------------


def compare(
    pair: Pair,
    networks: Iterable[tuple[StateNetwork, ChangeNetwork]],
    rng: np.random.Generator,
    *,
    misfit_p_value: float = 0.001,
) -> NetworkChanges:
    """Infer the changes by the networks of the family that fits both inspections.

    Args:
        pair: Both inspections.
        networks: Networks of each family; the next is opened only where records do not fit.
        rng: Generator of the draws.
        misfit_p_value: p-value below which an inspection is outside a family.

    Returns:
        Changes; if no family fits, without draws and with the matches of the nearest family.
    """
    sides = {"before": pair.first, "today": pair.own}
    keys = [(motion, side) for motion in pair.before for side in sides]
    (state, network), found, fits = choose_family(
        networks,
        lambda both: [((m, side), both[0].match(m, sides[side][m].seen)) for m, side in keys],
        misfit_p_value,
    )
    matches: dict[str, dict[str, dict]] = {motion: {} for motion in pair.before}
    for (motion, side), match in found:
        matches[motion][side] = plainly({"p_value": match.p_value, "parts": match.parts})
    agreement = {"p_value": 1.0, "parameter": ""}
    about = {"family": state.settings["family"], "matches": matches, "agreement": agreement}
    if not fits:
        return NetworkChanges(**about, state="outside_family")
    seen = {
        m: mean_and_change(pair.first[m], pair.second[m], network.change_bases[m])
        for m in pair.before
    }
    motions = [[*seen], *([motion] for motion in seen if len(seen) > 1)]
    references, changed = ({m: each[k] for m, each in seen.items()} for k in (0, 1))
    (logs, effects), *alone = (
        network.draw({m: references[m] for m in some}, {m: changed[m] for m in some}, _DRAWS, rng)
        for some in motions
    )
    if not plausible_wear(logs[0]):
        return NetworkChanges(**about, state="beyond_wear")
    if alone:
        apart = agreement_of(*(each[0] for each, _ in alone))
        agreement |= plainly({"p_value": apart.min(), "parameter": NAMES[int(apart.argmin())]})
        if apart.min() < LEAST_AGREEMENT:
            return NetworkChanges(**about, state="operations_disagree")
    draws = dict(zip(NAMES, np.exp(logs[0].T) - 1.0, strict=True))
    draws |= {name: each[0] for name, each in effects.items()}
    ranges = network.settings["definition"]["wear"]["change"]
    wear = {name: float(np.abs(ranges[name]).mean()) for name in NAMES if name in ranges}
    return NetworkChanges(**about, state="estimated", draws=draws, wear=wear)


def inferred_changes(changes: NetworkChanges, unchanged: float = 0.0) -> list[QuantityChange]:
    """Return the change of each parameter, then of each additional effect, percent.

    The records determine the change of a parameter where its interval is narrower than the
    family's usual wear. ``unchanged`` is the probability of another measurement.
    """
    rows, quantiles = [], (1.0 - SURE, 0.5, SURE)
    for name, share in changes.shares(unchanged).items():
        change, moved = 100.0 * np.quantile(share, quantiles), share[share != 0.0]
        changed = bool(change[0] > 0.0 or change[2] < 0.0)
        narrow = bool(change[2] - change[0] < 100.0 * changes.wear.get(name, 0.0))
        rows.append(
            _change(
                _INFERRED[name],
                ((share > 0.0).mean(), (share < 0.0).mean()),
                p_unchanged=(share == 0.0).mean(),
                change=change,
                if_changed=100.0 * np.quantile(moved, quantiles) if moved.size else change,
                changed=changed,
                identifiable=changed or narrow,
            )
        )
    return rows
