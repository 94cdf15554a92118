"""Whether two visits were measured alike, and which limits the second one keeps."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from breaker.common.numerals import in_digits
from breaker.common.plain_values import Plain
from breaker.drive.answers.limit_verdicts import NORMAL, Told, Verdict, judge
from breaker.drive.answers.visit_changes import (
    QuantityChange,
    VisitChanges,
    usual_scatter,
    visit_error,
)
from breaker.model.limits import Limit
from breaker.model.parameters import NAMES
from breaker.model.quantities import Speed
from breaker.records.measurements import Measured
from breaker.records.record import Record

# Shares of a stroke: by more than the first a worn drive differs only if its time does, too, as a
# ratio scales ways alone; by more than the second, no wear of the family of drives does.
_FEW, _MOST = 0.03, 0.1
# Share from which a stroke, which stops set to far less, speaks for a ratio where speeds change as
# much, to such shares of it, and times by less than that share of it.
_SCALED, _AS_MUCH, _LESS = 0.005, (0.5, 2.0), 0.5
_SAME = 1e-6  # share to which two stated ratios are one


# Of logarithms of durations: from which a pace speaks for a rate, of one motion and of both, by how
# little both differ, also as a share of what they are, as single records in noise differ by 0.02;
# and what of the noise and the usual scatter of shapes is left at most.
_PACE, _ONE, _SAME_PACE, _SAME_SHARE, _SHAPE = 0.04, 0.15, 0.015, 0.06, 0.7


@dataclass(frozen=True)
class Difference(Plain):
    """In what two visits were measured differently: what it is, its unit and motion, empty of all,
    and its value at each visit.
    """

    what: str
    unit: str
    motion: str
    before: float | str
    today: float | str

    @property
    def words(self) -> str:
        """The difference in a sentence."""
        of = f"the {self.what}{' of' * bool(self.motion)} {self.motion}".rstrip()
        was, now = (
            f"{each if isinstance(each, str) else in_digits(each, 4)} {self.unit}".rstrip()
            for each in (self.before, self.today)
        )
        return f"{of} was {was} and is {now}"


def unlike(
    rows: Sequence[QuantityChange],
    strokes: Mapping[str, Mapping[str, float]],
    stated: Mapping[str, Mapping[str, float | str]],
    paces: Mapping[str, tuple[float, float]] = MappingProxyType({}),
) -> list[Difference]:
    """Return what shows that two visits were measured differently.

    Args:
        rows: What ``measured_changes`` returns.
        strokes: What networks see of either visit, ``VisitChanges.strokes``.
        stated: What the files of either visit state, as ``stated_of`` returns it.
        paces: By what each motion lasts longer, and how its shape changed, ``VisitChanges.paces``.

    Returns:
        What files state; the scale of all ways and speeds, where they alone changed, and
        the stroke by more than two operations do, and 0.5 %; the scale of all times, where motions
        are the same at another pace; or a stroke by more than its
        uncertainty and 3 %, or 10 % where a travel time differs, too.

    Example:
        >>> unlike([], {"closing": {"before": 178.0, "today": 291.9}}, {})[0].what
        'inferred stroke'
        >>> stated = {"before": {"linkage ratio": 1.0}, "today": {"linkage ratio": 1.64}}
        >>> unlike([], {}, stated)[0].words
        'the linkage ratio was 1 and is 1.64'
    """
    found, (first, second) = [], (stated.get(visit, {}) for visit in ("before", "today"))
    for name in [each for each in first if each in second and _differ(first[each], second[each])]:
        found.append(Difference(name, "", "", first[name], second[name]))
    if rate := _rate(paces, strokes):
        what = "scale of all times, as of another rate or unit of the time,"
        found.append(Difference(what, "", "", 1.0, rate))
    slower = any(row.name == "travel_time" and _changed(row, _FEW) for row in rows)
    measured = {row.motion: row for row in rows if row.name == "stroke"}
    scales = [_scale([row for row in rows if row.motion == motion]) for motion in measured]
    # An opening alone scales where a weaker force has closed less far.
    if "closing" in measured and all(scales):
        what = "scale of all ways and speeds, as of another ratio of the transducer,"
        return [*found, Difference(what, "", "", 1.0, scales[0])]
    share = _MOST if slower else _FEW
    for motion, seen in strokes.items():
        row, (before, today) = measured.get(motion), (seen[e] for e in ("before", "today"))
        sd = np.sqrt(2.0) * usual_scatter("stroke", before, before)
        if row and _changed(row, share):
            found.append(Difference("measured stroke", "mm", motion, row.before, row.today))
        elif _apart(before, today, NORMAL[95] * sd, share):
            found.append(Difference("inferred stroke", "mm", motion, before, today))
    return found


def _rate(
    paces: Mapping[str, tuple[float, float]], strokes: Mapping[str, Mapping[str, float]]
) -> float | None:
    """By what all times are longer, where nothing else has changed: a drive that wears moves in
    another way, closing and opening by different shares, or both.
    """
    if not paces:
        return None
    logs = np.log([ratio for ratio, _ in paces.values()])
    least = _PACE if len(logs) > 1 else _ONE
    apart = max(_SAME_PACE, _SAME_SHARE * abs(logs.mean()))
    same = np.abs(logs).min() > least and np.ptp(logs) < apart
    alike = all(left < _SHAPE for _, left in paces.values())
    ways = all(abs(np.log(each["today"] / each["before"])) < _FEW for each in strokes.values())
    return float(np.exp(logs.mean())) if same and alike and ways else None


def _differ(first: float | str, second: float | str) -> bool:
    """Whether two stated things are not the same."""
    if isinstance(first, str):
        return first.casefold().split() != second.casefold().split()
    return abs(second - first) > _SAME * first


def _scale(rows: Sequence[QuantityChange]) -> float | None:
    """By what the ways of a motion are longer, where its speeds say the same and times nothing."""
    by = {row.name: row for row in rows}
    if "stroke" not in by or not _changed(by["stroke"], _SCALED):
        return None
    # Nothing else is looked at: an over-travel may be 0 and has no logarithm.
    used = (e for e in by if (e in ("stroke", "travel_time") or "_speed" in e) and by[e].before)
    logs = {name: np.log(by[name].today / by[name].before) for name in used}
    scale = logs.pop("stroke")
    speeds = [logs[name] / scale for name in logs if "_speed" in name] or [1.0]
    still = abs(logs.get("travel_time", np.nan) / scale) < _LESS
    alike = _AS_MUCH[0] < min(speeds) and max(speeds) < _AS_MUCH[1]
    return float(np.exp(scale)) if still and alike else None


def _changed(row: QuantityChange, share: float) -> bool:
    """Whether what is measured differs by more than a share and its doubt or repeatability."""
    least = max(NORMAL[95] * row.sd, row.repeatability / 100.0 * row.before)
    return _apart(row.before, row.today, least, share)


def _apart(before: float, today: float, least: float, share: float) -> bool:
    """Whether a value differs by more than the least difference that counts, and a share of it."""
    return abs(today - before) > least + share * before


def judged_today(
    found: VisitChanges,
    today: Mapping[str, Sequence[Record]],
    limits: Sequence[Limit],
    speeds: Sequence[Speed],
    seed: int,
) -> list[Verdict]:
    """Return what ``judge`` does of limits at the second of two visits.

    Of what records show, the mean of the visit is judged; of changes of parameters, those between
    both visits. A comparison does not tell quantities of the model.
    """
    read = {motion: [raw.measured(speeds) for raw in raws] for motion, raws in today.items()}
    return judge(limits, _Visits(found, read), seed, "visits")


@dataclass(frozen=True)
class _Visits:
    """What two visits tell of a quantity of a limit, by the limit's source."""

    found: VisitChanges
    read: Mapping[str, Sequence[Mapping[str, Measured]]]

    def of_change(self, _limit: Limit, name: str) -> Told:
        if len(self.found.ratios) != 1:
            return Told(reason="changes of parameters are not told")
        (ratios,) = self.found.ratios.values()
        return Told(draws=100.0 * (ratios[:, NAMES.index(name)] - 1.0))

    def of_model(self, _limit: Limit, _name: str) -> Told:
        return Told(reason="of the model: breaker infer tells it")

    def of_record(self, limit: Limit, name: str) -> Told:
        records = self.read[limit.motion]
        shown = [each[name] for each in records]
        visit = np.array([each[:2] for each in shown if np.isfinite(each.value)], float)
        if not len(visit):
            return Told(reason=shown[0].reason)
        mean = float(visit[:, 0].mean())
        stroke = float(np.nanmean([each["stroke"].value for each in records] or np.nan))
        return Told(mean, visit_error([visit], usual_scatter(name, mean, stroke)))
