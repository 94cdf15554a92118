"""Compute what changed between two inspections of a drive: measured quantities and parameters.

Measured quantities are compared by their means. Networks of a family of drives infer changes of
the parameters from the mean record of each inspection. Their answer holds for drives of the family
only, and closing and opening have to agree. A quantity changed where the 90 % interval of its
change, the probability of no change included, excludes zero. Limits decide whether that matters.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import erfc

import numpy as np

from breaker.common.plain_values import Plain, plainly
from breaker.diagnosis.limits import NORMAL
from breaker.family.inputs import mean_and_change, mean_record, shrunk_variance
from breaker.family.membership import Match, choose_family
from breaker.family.networks import (
    EFFECTS,
    LEAST_AGREEMENT,
    ChangeDraws,
    ChangeNetwork,
    StateNetwork,
    agreement_of,
    plausible_wear,
)
from breaker.model.parameters import NAMES, PARAMETERS, Parameter
from breaker.model.quantities import CURRENTS, Speed, quantities_of
from breaker.records.record import Record

_QUANTILES = (0.05, 0.5, 0.95)
_SURE = 0.95  # probability of a change to one side, as that of the 90 % interval
_DRAWS = 4000  # quantiles of 5 % are then known to 0.3 %
_NARROW = 0.5  # width of an interval that determines a change, share of the family's largest wear
# Prior probability that a measured quantity has not changed, and sd of changes, as a share: one
# that is known to 0.3 % is reported from 4 sds on, in 1 of 15,000 unchanged ones.
_UNCHANGED, _CHANGES = 0.9, 0.1
_FARTHEST = 100.0  # largest log evidence, so that no probability is 0
# Usual scatter of operations: share of the value, ms, and share of the stroke. It counts like that
# of so many records more than one.
_OVER_TRAVELS = ("over_travel", "opening_over_travel")  # which may be 0
_SCATTER = dict.fromkeys(CURRENTS, (0.02, 0.0, 0.0))  # voltages vary
_SCATTER |= dict.fromkeys(_OVER_TRAVELS, (0.05, 0.0, 0.002)) | {"bounce_time": (0.2, 0.3, 0.0)}
_USUAL_SCATTER, _USUAL_RECORDS = (0.004, 0.0, 0.0), 4
_SMALLEST = 1e-3  # of the stroke, to which an over-travel near 0 is compared
_INFERRED = {name: Parameter(name, "1", meaning) for name, meaning in EFFECTS.items()}
_INFERRED |= {parameter.name: parameter for parameter in PARAMETERS}


@dataclass(frozen=True, eq=False)
class NetworkChanges:
    """Changes between two inspections that networks infer.

    Attributes:
        family: Family of the networks.
        matches: Match of the mean record with the family, by motion and inspection.
        state: "estimated", with draws; "outside_family"; "beyond_wear", larger than any wear of the
            family; "operations_disagree", of closing and opening that contradict each other.
        draws: Posterior draws of the relative change of each parameter, then of each additional
            effect as a share of ``CHANGE_OF``, ``(d,)``, by name.
        wear: Largest change of each parameter in the family, as a share.
        agreement: Probability that closing and opening differ as much, of the parameter in which
            they agree least; 1 of a single motion.
        least: Name of this parameter; empty of a single motion.
    """

    family: str
    matches: Mapping[str, Mapping[str, Match]]
    state: str
    draws: Mapping[str, np.ndarray] = field(default_factory=dict)
    wear: Mapping[str, float] = field(default_factory=dict)
    agreement: float = 1.0
    least: str = ""

    def unchanged_by(self, share: float) -> "NetworkChanges":
        """Return the changes where a share of the draws, evenly among them, is of no change.

        The share is the probability of another measurement, of which networks know nothing.
        """
        still = np.diff(np.floor(share * np.arange(_DRAWS + 1))) > 0.0
        draws = {name: np.where(still, 0.0, each) for name, each in self.draws.items()}
        return replace(self, draws=draws)


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


def measured_changes(
    before: Mapping[str, Sequence[Record]],
    today: Mapping[str, Sequence[Record]],
    speeds: Sequence[Speed],
) -> list[QuantityChange]:
    """Return the change of each quantity of a motion that records of both inspections show.

    Args:
        before, today: Records of the same motions.
        speeds: Definitions of speeds.
    """
    rows = []
    for motion in before:
        shown = [[raw.measured(speeds) for raw in raws[motion]] for raws in (before, today)]
        stroke = np.nan
        for name, quantity in quantities_of(motion, speeds, ("record",)).items():
            readings = [np.array([each[name][:2] for each in some], float) for some in shown]
            readings = [some[np.isfinite(some[:, 0])] for some in readings]
            if not all(map(len, readings)):
                continue
            first = float(readings[0][:, 0].mean())
            stroke = first if name == "stroke" else stroke
            size = max(abs(first), _SMALLEST * stroke if name in _OVER_TRAVELS else 0.0)
            if size > 0.0:
                sd = mean_error(readings, usual_scatter(name, first, stroke))
                rows.append(_measured(quantity, motion, readings, size, sd))
    return rows


def _measured(
    quantity: Parameter, motion: str, readings: Sequence[np.ndarray], size: float, sd: float
) -> QuantityChange:
    """Return the change of a measured quantity, percent of its size."""
    first, second = (float(some[:, 0].mean()) for some in readings)
    change, error = (second - first) / size, max(sd / size, 1e-12)
    wide = np.hypot(error, _CHANGES)
    evidence = np.log(wide / error) + 0.5 * change**2 * (wide**-2.0 - error**-2.0)
    odds = _UNCHANGED / (1.0 - _UNCHANGED) * np.exp(max(evidence, -_FARTHEST))
    p_changed = 1.0 / (1.0 + odds)
    more, less = (0.5 * p_changed * erfc(-s * change / error / np.sqrt(2.0)) for s in (1.0, -1.0))
    quantiles = 100.0 * (change + NORMAL[90] * error * np.array([-1.0, 0.0, 1.0]))
    return _change(
        quantity,
        motion=motion,
        before=first,
        today=second,
        difference=second - first,
        sd=sd,
        p_unchanged=1.0 - p_changed,
        change=quantiles,
        if_changed=quantiles,
        sides=(more, less),
        changed=max(more, less) >= _SURE,
    )


def _change(of: Parameter, *, sides: tuple[float, float], **values: object) -> QuantityChange:
    """Return the change of a quantity, with probabilities of more and of less."""
    worse = {1: sides[0], -1: sides[1]}.get(of.worse)
    about = {"name": of.name, "unit": of.unit, "meaning": of.meaning, "p_worse": worse}
    return plainly(QuantityChange(**about, **values))


def usual_scatter(name: str, value: float, stroke: float) -> float:
    """Return the usual scatter of a quantity from operation to operation, in its unit."""
    share, more, of_stroke = _SCATTER.get(name, _USUAL_SCATTER)
    parts = [share * value, more, of_stroke * stroke if of_stroke else 0.0]
    return float(np.linalg.norm(parts))


def mean_error(readings: Sequence[np.ndarray], usual: float) -> float:
    """Return the standard deviation of a mean of readings, or of the difference of two means.

    Args:
        readings: Values and their sds of one or two inspections, ``(n, 2)``.
        usual: Usual scatter of operations.
    """
    seen = sum(len(some) - 1 for some in readings)
    squares = sum(float(np.square(some[:, 0] - some[:, 0].mean()).sum()) for some in readings)
    total = 0.0
    for some in readings:
        known = float(np.nan_to_num(np.square(some[:, 1])).mean())
        scatter = shrunk_variance(squares, seen, known + usual**2, _USUAL_RECORDS)
        total += max(known, scatter) / len(some)
    return float(np.sqrt(total))


# ---- parameters ------------------------------------------------------------------------------


def compare(
    before: Mapping[str, Sequence[Record]],
    today: Mapping[str, Sequence[Record]],
    networks: Iterable[tuple[StateNetwork, ChangeNetwork]],
    rng: np.random.Generator,
    *,
    misfit_p_value: float = 0.001,
) -> NetworkChanges:
    """Infer the changes by the networks of the family that fits both inspections.

    Args:
        before, today: Records of the same motions.
        networks: Networks of each family; the next is opened only where records do not fit.
        misfit_p_value: p-value below which an inspection is outside a family.

    Returns:
        Changes; if no family fits, without draws and with the matches of the nearest family.
    """
    means = {
        (motion, inspection): mean_record(records[motion]).seen
        for motion in before
        for inspection, records in (("before", before), ("today", today))
    }
    (state, network), pairs, fits = choose_family(
        networks,
        lambda both: [(key, both[0].match(key[0], mean)) for key, mean in means.items()],
        misfit_p_value,
    )
    matches: dict[str, dict[str, Match]] = {motion: {} for motion in before}
    for (motion, inspection), match in pairs:
        matches[motion][inspection] = match
    changes = NetworkChanges(state.settings["family"], matches, "outside_family")
    if not fits:
        return changes
    seen = {m: mean_and_change(before[m], today[m], network.change_bases[m]) for m in before}

    def draw(*motions: str) -> ChangeDraws:
        references, changed = ({m: seen[m][k] for m in motions} for k in (0, 1))
        return network.draw(references, changed, _DRAWS, rng)

    together = draw(*seen)
    if not plausible_wear(np.log(together.ratios)):
        return replace(changes, state="beyond_wear")
    if len(seen) > 1:
        agreement = agreement_of(*(draw(motion).ratios for motion in seen))
        least = int(agreement.argmin())
        changes = replace(changes, agreement=float(agreement[least]), least=NAMES[least])
    if changes.agreement < LEAST_AGREEMENT:
        return replace(changes, state="operations_disagree")
    draws = dict(zip(NAMES, together.ratios.T - 1.0, strict=True)) | dict(together.effects)
    return replace(changes, state="estimated", draws=draws, wear=_largest_wear(network))


def _largest_wear(network: ChangeNetwork) -> dict[str, float]:
    """Return the largest change of each parameter by wear of the family, as a share."""
    ranges = network.settings["definition"]["wear"]["change"]
    return {name: float(np.abs(ranges[name]).max()) for name in NAMES if name in ranges}


def inferred_changes(changes: NetworkChanges) -> list[QuantityChange]:
    """Return the change of each parameter, then of each additional effect, percent.

    The records determine the change of a parameter where its interval is narrow.
    """
    rows = []
    for name, share in changes.draws.items():
        change, moved = 100.0 * np.quantile(share, _QUANTILES), share[share != 0.0]
        changed = bool(change[0] > 0.0 or change[2] < 0.0)
        narrow = bool(change[2] - change[0] < 100.0 * _NARROW * changes.wear.get(name, 0.0))
        rows.append(
            _change(
                _INFERRED[name],
                p_unchanged=(share == 0.0).mean(),
                change=change,
                if_changed=100.0 * np.quantile(moved, _QUANTILES) if moved.size else change,
                sides=((share > 0.0).mean(), (share < 0.0).mean()),
                changed=changed,
                identifiable=changed or narrow,
            )
        )
    return rows
