"""Whether two visits were measured alike, and which limits the second one keeps."""

from collections.abc import Mapping, Sequence

import numpy as np

from breaker.answers.changed import Compared
from breaker.answers.judgement import NORMAL, Told, judge
from breaker.answers.scatter import usual_scatter, visit_error
from breaker.mechanism import NAMES, Limit, Speed
from breaker.records import Raw

__all__ = ["judged_today", "unlike"]

# Shares of a stroke: by more than the first a worn drive differs only if its time does, too, as a
# ratio scales ways alone; by more than the second, no wear of the family of drives does.
_FEW, _MOST = 0.03, 0.1
_SAME = 1e-6  # share to which two stated ratios are one


def unlike(
    rows: Sequence[Mapping],
    strokes: Mapping[str, Mapping[str, float]],
    ratios: Mapping[str, float | None],
) -> list[dict]:
    """Return what shows that two visits were measured differently.

    Args:
        rows: What ``measured_changes`` returns.
        strokes: What networks see of either visit, ``Compared.strokes``.
        ratios: Of the linkage, as the files of either visit state it; None where they do not.

    Returns:
        Rows of ``what`` differs, its ``unit`` and ``motion``, and its value ``before`` and
        ``today``: the ratio, or a stroke by more than its uncertainty and 3 %, or 10 % where a
        travel time differs, too.

    Example:
        >>> unlike([], {"closing": {"before": 178.0, "today": 291.9}}, {})[0]["what"]
        'inferred stroke'
        >>> unlike([], {}, {"before": 1.0, "today": 1.64})
        [{'what': 'linkage ratio', 'unit': '', 'motion': '', 'before': 1.0, 'today': 1.64}]
    """
    found, (first, second) = [], (ratios.get(visit) for visit in ("before", "today"))
    if first and second and abs(second - first) > _SAME * first:
        about = {"what": "linkage ratio", "unit": "", "motion": ""}
        found.append(about | {"before": first, "today": second})
    slower = any(row["name"] == "travel_time" and _apart(row, _FEW) for row in rows)
    measured = {row["motion"]: row for row in rows if row["name"] == "stroke"}
    for motion, seen in strokes.items():
        sd = np.sqrt(2.0) * usual_scatter("stroke", seen["before"], seen["before"])
        of = {"inferred": seen | {"sd": sd}, "measured": measured.get(motion)}
        for kind in ("measured", "inferred"):
            if (each := of[kind]) and _apart(each, _MOST if slower else _FEW):
                values = {visit: each[visit] for visit in ("before", "today")}
                found.append({"what": f"{kind} stroke", "unit": "mm", "motion": motion} | values)
                break
    return found


def _apart(row: Mapping[str, float], share: float) -> bool:
    """Whether a quantity differs by more than a share and its uncertainty or repeatability."""
    usual = row.get("repeatability", 0.0) / 100.0 * row["before"]
    difference = abs(row["today"] - row["before"])
    return difference > max(NORMAL[95] * row["sd"], usual) + share * row["before"]


def judged_today(
    found: Compared,
    today: Mapping[str, Sequence[Raw]],
    limits: Sequence[Limit],
    speeds: Sequence[Speed],
    seed: int,
) -> list[dict]:
    """Return what ``judge`` does of limits at the second of two visits.

    Of what records show, the mean of the visit is judged; of changes of parameters, those between
    both visits. A comparison does not tell quantities of the model.
    """
    read = {motion: [raw.measured(speeds) for raw in raws] for motion, raws in today.items()}

    def told(limit: Limit, name: str) -> Told:
        if limit.of == "change":
            if len(found.ratios) != 1:
                return Told(reason="changes of parameters are not told")
            (ratios,) = found.ratios.values()
            return Told(draws=100.0 * (ratios[:, NAMES.index(name)] - 1.0))
        if limit.of == "model":
            return Told(reason="of the model: breaker infer tells it")
        shown = [each[name] for each in read[limit.motion]]
        visit = np.array([each[:2] for each in shown if np.isfinite(each.value)], float)
        if not len(visit):
            return Told(reason=shown[0].reason)
        mean = float(visit[:, 0].mean())
        stroke = float(np.nanmean([each["stroke"].value for each in read[limit.motion]] or np.nan))
        return Told(mean, visit_error([visit], usual_scatter(name, mean, stroke)))

    return judge(limits, told, seed, "visits")
