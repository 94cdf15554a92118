"""What two visits to a drive say of it: measured changes, and those of its parameters.

What a record shows is measured in both visits and compared. What it does not show, parameters and
the times of the contact, is inferred by networks of a family of drives, from the mean of either
visit. They answer for drives of the family only, and closing and opening have to agree.

A quantity *changed* where its 90 % interval, with the probability of no change at all, excludes
zero. It *did not* where a change beyond a share, 5 % if not said otherwise, has a probability of at
most 0.05. In between records cannot tell. Whether a change matters is decided by limits.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import erfc

import numpy as np

from breaker.common.plain_values import Plain, plainly
from breaker.diagnosis.explanations import Explanation, measured_otherwise
from breaker.diagnosis.limits import NORMAL
from breaker.family.inputs import (
    Mean,
    mean_and_change,
    mean_record,
    shrunk_variance,
)
from breaker.family.membership import Match, choose_family
from breaker.family.networks import (
    EFFECTS,
    LEAST_AGREEMENT,
    ChangeNetwork,
    StateNetwork,
    agreement_of,
    plausible_wear,
)
from breaker.model.parameters import NAMES, PARAMETERS, Parameter
from breaker.model.quantities import AFTER_RELEASE, CURRENTS, QUANTITIES, Speed, quantities_of
from breaker.records.record import Record

VERDICT_WORDS = ("changed", "not told", "did not change")

_OF_FORCE = 0.2  # of the share, from which on a mechanism counts, in shares of ``CHANGE_OF``
_SURE = 0.95  # probability from which a quantity has changed, or not beyond a share
_QUANTILES = (0.05, 0.5, 0.95)
_DRAWS = 4000
# Shares of the stroke: a way that changes by less did not, and a way below is as good as none.
_LITTLE, _NEXT_TO_NONE = 0.01, 1e-3

# Of what is measured: probability of no change, and sd of changes, as a share; a quantity is then
# reported from 4 sds on where it is known to 0.3 %, in 1 of 15,000 unchanged ones.
_STILL, _CHANGES = 0.9, 0.1
_FARTHEST = 100.0  # of a log evidence: no probability is smaller

# Usual scatter of operations, and how well it is known, as from so many records more than one.
_SCATTER, _KNOWN = 0.004, 4
_PAST = 0.05, 0.002  # of ways past a rest: of themselves, and of the stroke
_BOUNCE = 0.2, 0.3  # of a bounce: of itself, and ms, as it hits another time each time
_CURRENT = 0.02  # of what coils and motors draw, whose voltage varies
_PAST_REST = {"over_travel", "opening_over_travel"}  # ways that may be 0


@dataclass(frozen=True, eq=False)
class NetworkChanges:
    """What networks infer of the change between two visits.

    Attributes:
        family: Name of the drives they were trained on.
        matches: How the mean of each visit fits these, by motion and visit.
        fits: Whether all do; if not, there are no draws.
        ratios: Draws of the parameters over what they were, ``(d, p)``: of both motions together,
            or of each where they contradict each other; by the motions they are of. None, of
            ``later`` neither, where the change is larger than any wear of the family.
        later: By how much touch or separation come later, share of the time that they took before,
            ``(d,)``, by motion.
        mechanisms: Draws of by how much mechanisms have changed, ``(d,)``, shares of
            ``CHANGE_OF``, by name; none where closing and opening contradict each other.
        agreement: Of the parameter in which motions agree least, the probability that they do as
            little; 1 of a single motion.
        least: This parameter; empty if there is none.
        explanations: Why the visits differ, the most probable first. Draws are of the drive alone
            until ``with_explanations``.
    """

    family: str
    matches: Mapping[str, Mapping[str, Match]]
    fits: bool
    ratios: Mapping[tuple[str, ...], np.ndarray] = field(default_factory=dict)
    later: Mapping[str, np.ndarray] = field(default_factory=dict)
    mechanisms: Mapping[str, np.ndarray] = field(default_factory=dict)
    agreement: float = 1.0
    least: str = ""
    explanations: Sequence[Explanation] = ()


@dataclass(frozen=True, kw_only=True)
class QuantityChange(Plain):
    """By how much a quantity has changed between two visits.

    Attributes:
        name, unit, meaning: Of the quantity.
        kind: "measured", "parameter", "time" or "mechanism".
        motion: Empty where it is of both.
        before, today: What is measured at each visit, in its unit; ``difference`` and its ``sd``.
        unchanged: Probability of no change at all.
        change: Its 5, 50 and 95 % quantiles, percent; of draws with those of no change.
        if_changed: The same quantiles if there is a change.
        beyond, more, less: Probability of a change by more than the share, of over-travel and
            rebound by more than 1 % of the stroke if that is more; up, and down.
        worse: Probability of any change to the worse; None where neither side is.
        zone: Of a speed, from where to where it is the mean.
        verdict: One of ``VERDICT_WORDS``.
    """

    name: str
    unit: str
    meaning: str
    kind: str
    motion: str
    before: float | None = None
    today: float | None = None
    difference: float | None = None
    sd: float | None = None
    unchanged: float | None
    change: Sequence[float]
    if_changed: Sequence[float]
    beyond: float
    more: float
    less: float
    worse: float | None
    zone: str | None = None
    verdict: str

    @property
    def sure(self) -> bool:
        """Whether it has changed."""
        return self.verdict == VERDICT_WORDS[0]

    @property
    def measured(self) -> bool:
        """Whether the records themselves show it."""
        return self.kind == "measured"

    @property
    def of(self) -> str:
        """The motion, where the name does not tell it."""
        return "" if self.motion in self.name or self.kind == "time" else self.motion

    @property
    def label(self) -> str:
        """Name of the quantity, with the motion where the name does not tell it."""
        return f"{self.name} ({self.of})" if self.of else self.name


def compare(
    before: Mapping[str, Sequence[Record]],
    today: Mapping[str, Sequence[Record]],
    networks: Iterable[tuple[StateNetwork, ChangeNetwork]],
    rng: np.random.Generator,
    *,
    misfit_p_value: float = 0.001,
) -> NetworkChanges:
    """Compare two visits by the networks of the family that ``choose_family`` finds for both.

    Args:
        before, today: Records of the same motions.
        networks: Those of each family; the next is opened only where records do not fit.
        misfit_p_value: p-value below which a visit is not of a drive of the family.

    Returns:
        The comparison; if no family fits, without draws, and with the matches of the nearest.
    """
    means = {m: {"before": mean_record(before[m]), "today": mean_record(today[m])} for m in before}
    found, levels, network = _nearest(means, networks, misfit_p_value)
    if not found.fits:
        return found
    both = {m: mean_and_change(before[m], today[m], network.change_bases[m]) for m in before}
    references, changed = ({m: each[k] for m, each in both.items()} for k in (0, 1))
    draws = {
        motions: network.draw(
            *({m: each[m] for m in motions} for each in (references, changed)), _DRAWS, rng
        )
        for motions in dict.fromkeys([tuple(both), *((m,) for m in both)])
    }
    whole, *alone = draws
    if not plausible_wear(np.log(draws[whole].ratios)):
        return found
    state = levels.draw(references, _DRAWS, rng)
    took = {m: np.median(state.switching[m] - state.release[m]) for m in both}
    agreement = np.ones(len(NAMES))
    if alone:
        agreement = agreement_of(*(draws[motions].ratios for motions in alone))
    apart = agreement.min() < LEAST_AGREEMENT
    return replace(
        found,
        ratios={motions: draws[motions].ratios for motions in (alone if apart else [whole])},
        later={m: draws[(m,) if apart else whole].later[m] / took[m] for m in both},
        mechanisms={} if apart else draws[whole].effects,
        agreement=float(agreement.min()),
        least=NAMES[int(agreement.argmin())] if alone else "",
    )


def _nearest(
    means: Mapping[str, Mapping[str, Mean]],
    networks: Iterable[tuple[StateNetwork, ChangeNetwork]],
    misfit_p_value: float,
) -> tuple[NetworkChanges, StateNetwork, ChangeNetwork]:
    """The family that ``choose_family`` finds for both visits, and its networks."""
    (levels, network), matches, fits = choose_family(
        networks,
        lambda each: [
            ((motion, visit), each[0].match(motion, mean.seen))
            for motion, visits in means.items()
            for visit, mean in visits.items()
        ],
        misfit_p_value,
    )
    by: dict[str, dict[str, Match]] = {motion: {} for motion in means}
    for (motion, visit), match in matches:
        by[motion][visit] = match
    return NetworkChanges(levels.settings["family"], by, fits), levels, network


def with_explanations(found: NetworkChanges, explanations: Sequence[Explanation]) -> NetworkChanges:
    """Return a comparison in which the drive has not changed by the share of draws that is the
    probability that nothing but the measurement has; networks know of no other ratio or rate.
    """
    (parameter, amount), *_ = [(e.parameter, e.change) for e in explanations if e.cause == "drive"]
    if parameter and found.ratios:
        ratios = next(iter(found.ratios.values()))[:, NAMES.index(parameter)]
        if (changed := ratios[ratios != 1.0]).size:
            amount = (100.0 * (np.quantile(changed, _QUANTILES) - 1.0)).tolist()
    explanations = [replace(e, change=amount) if e.cause == "drive" else e for e in explanations]
    share = measured_otherwise(explanations)

    def mixed(draws: np.ndarray, same: float = 0.0) -> np.ndarray:
        still = np.diff(np.floor(share * np.arange(len(draws) + 1))) > 0.0  # evenly among them
        return np.where(still.reshape(-1, *[1] * (draws.ndim - 1)), same, draws)

    return replace(
        found,
        ratios={motions: mixed(draws, 1.0) for motions, draws in found.ratios.items()},
        later={motion: mixed(draws) for motion, draws in found.later.items()},
        mechanisms={name: mixed(draws) for name, draws in found.mechanisms.items()},
        explanations=explanations,
    )


def changes(found: NetworkChanges, beyond: float = 0.05) -> list[QuantityChange]:
    """Return the change of each parameter and of the times of the contact.

    Args:
        found: The comparison.
        beyond: Share beyond which a change counts, such as 0.05.
    """
    rows = []
    for motions, ratios in found.ratios.items():
        of = motions[0] if len(found.ratios) > 1 else ""
        parts = zip(PARAMETERS, ratios.T, strict=True)
        rows += [_inferred(each, "parameter", of, draws - 1.0, beyond) for each, draws in parts]
    for motion, draws in found.later.items():
        rows.append(_inferred(QUANTITIES[AFTER_RELEASE[motion]], "time", motion, draws, beyond))
    return rows


def mechanism_changes(found: NetworkChanges, beyond: float = 0.05) -> list[QuantityChange]:
    """Return the change of each mechanism beside the model.

    Changes are in percent of ``CHANGE_OF``, and count from a fifth of the share on.
    """
    return [
        _inferred(Parameter(name, "1", EFFECTS[name]), "mechanism", "", draws, share)
        for share in [_OF_FORCE * beyond]
        for name, draws in found.mechanisms.items()
    ]


def _inferred(
    of: Parameter, kind: str, motion: str, share: np.ndarray, beyond: float
) -> QuantityChange:
    """The change of a quantity by draws of its relative change, ``(d,)``."""
    more, less = ((sign * share > beyond).mean() for sign in (1.0, -1.0))
    change = 100.0 * np.quantile(share, _QUANTILES)
    changed = share[share != 0.0]
    about = {"kind": kind, "motion": motion, "unchanged": (share == 0.0).mean()}
    about["if_changed"] = 100.0 * np.quantile(changed, _QUANTILES) if changed.size else change
    sure = change[0] > 0.0 or change[2] < 0.0
    sides = (share > 0.0).mean(), (share < 0.0).mean()
    return _change(of, (more, less), sides, sure, change=change, **about)


def _change(
    of: Parameter,
    beyond: tuple[float, float],
    sides: tuple[float, float],
    sure: bool,
    **values: object,
) -> QuantityChange:
    """The change of a quantity, with probabilities up and down: beyond the share, and of any."""
    (more, less), total = beyond, sum(beyond)
    found = QuantityChange(
        name=of.name,
        unit=of.unit,
        meaning=of.meaning,
        beyond=total,
        more=more,
        less=less,
        worse={1: sides[0], -1: sides[1]}.get(of.worse),
        zone=getattr(of, "zone", "") or None,
        verdict=VERDICT_WORDS[0 if sure else 2 if total <= 1.0 - _SURE else 1],
        **values,
    )
    return plainly(found)


def measured_changes(
    before: Mapping[str, Sequence[Record]],
    today: Mapping[str, Sequence[Record]],
    speeds: Sequence[Speed],
    beyond: float = 0.05,
) -> list[QuantityChange]:
    """Return what the records themselves show.

    The mean of a visit; its variance is that of the readings and of the scatter of operations, seen
    in both visits and, of few records, beside what is usual.

    Args:
        before, today: Records of the same motions.
        speeds: How speeds are defined.
        beyond: Share beyond which a change counts.

    Returns:
        The change of each quantity of a motion that both visits show.
    """
    rows = []
    for motion in before:
        read = [[raw.measured(speeds) for raw in raws[motion]] for raws in (before, today)]
        stroke = np.nan
        for name, quantity in quantities_of(motion, speeds, ("record",)).items():
            visits = [np.array([each[name][:2] for each in visit], float) for visit in read]
            both = [visit[np.isfinite(visit[:, 0])] for visit in visits]
            if not all(map(len, both)):
                continue
            first, second = (float(each[:, 0].mean()) for each in both)
            stroke = first if name == "stroke" else stroke
            of = max(abs(first), _NEXT_TO_NONE * stroke * (name in _PAST_REST))
            if not of > 0.0:
                continue
            usual = usual_scatter(name, first, stroke)
            change, sd = (second - first) / of, visit_error(both, usual) / of
            counts = max(beyond, _LITTLE * stroke / of) if name in _PAST_REST else beyond
            beyond_counts = tuple(_above(counts, sign * change, sd) for sign in (1.0, -1.0))
            still = _still(change, sd)
            sides = tuple((1.0 - still) * _above(0.0, sign * change, sd) for sign in (1.0, -1.0))
            sure = max(sides) >= _SURE
            interval = 100.0 * (change + NORMAL[90] * sd * np.array([-1.0, 0.0, 1.0]))
            values = {"kind": "measured", "motion": motion, "unchanged": still, "sd": of * sd}
            values |= {"before": first, "today": second, "difference": second - first}
            values |= {"change": interval, "if_changed": interval}
            rows.append(_change(quantity, beyond_counts, sides, sure, **values))
    return rows


def _still(change: float, sd: float) -> float:
    """Probability of no change of what is measured, from its change and sd, shares."""
    sd = max(sd, 1e-12)
    wide = np.hypot(sd, _CHANGES)
    evidence = np.log(wide / sd) + 0.5 * change**2 * (wide**-2.0 - sd**-2.0)
    still = _STILL * np.exp(max(evidence, -_FARTHEST))
    return float(still / (still + 1.0 - _STILL))


def _above(limit: float, mean: float, sd: float) -> float:
    """Probability that a normal number is above a limit."""
    return 0.5 * erfc((limit - mean) / (np.sqrt(2.0) * max(sd, 1e-12)))


def usual_scatter(name: str, value: float, stroke: float) -> float:
    """Return how far a quantity usually scatters from operation to operation, in its unit."""
    if name in _PAST_REST:
        return float(np.hypot(*np.multiply(_PAST, (value, stroke))))
    if name == "bounce_time":
        return float(np.hypot(_BOUNCE[0] * value, _BOUNCE[1]))
    return (_CURRENT if name in CURRENTS else _SCATTER) * abs(value)


def visit_error(visits: Sequence[np.ndarray], usual: float) -> float:
    """Return the standard deviation of a mean of readings, or of the difference of two.

    Args:
        visits: Readings of each, and their sds, ``(n, 2)``.
        usual: Scatter of operations that is usual.
    """
    total = 0.0
    for each in visits:
        known = float(np.nan_to_num(np.square(each[:, 1])).mean())
        total += max(known, _scattered(visits, usual, known)) / len(each)
    return float(np.sqrt(total))


def _scattered(visits: Sequence[np.ndarray], usual: float, known: float) -> float:
    """Return the variance of a reading: as seen in visits, beside what is usual and known of it."""
    seen = sum(len(each) - 1 for each in visits)
    squares = sum(float(np.square(each[:, 0] - each[:, 0].mean()).sum()) for each in visits)
    return shrunk_variance(squares, seen, known + usual**2, _KNOWN)
