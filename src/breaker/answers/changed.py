"""What two visits to a drive say of it: each parameter and quantity before, today, and its change.

A change is told by the probability that it is beyond a share, 5 % if not said otherwise: from 0.95
on it *changed*, up to 0.05 it *did not*, and in between records cannot tell. What is a priori
probable is in ``posterior.visits``.
"""

from collections.abc import Sequence

import numpy as np
import xarray as xr

from breaker.mechanism import NAMES, PARAMETERS, SPEEDS, Speed, evaluate, quantities_of
from breaker.posterior import Compared

__all__ = ["OF_STROKE", "SURE", "VERDICT_WORDS", "changes"]

SURE = 0.95
"""Probability from which a change is beyond a share."""

VERDICT_WORDS = ("changed", "not told", "did not change")

OF_STROKE = frozenset({"over_travel", "rebound"})
"""Ways that may be 0: their changes are in shares of the stroke."""

_QUANTILES = (0.05, 0.5, 0.95)
_OF_BOTH = {"wipe", "stroke"}  # that do not depend on the motion
# Whether more or less of it is the worse; nothing else is either.
_WORSE = dict.fromkeys(("k_a", "k_b", "f", "wipe"), -1) | dict.fromkeys(
    ("gamma_a", "gamma_b", "L", "travel_time", "touch_time", "part_time", "over_travel", "rebound"),
    1,
)


def changes(
    found: Compared, *, beyond: float = 0.05, speeds: Sequence[Speed] = SPEEDS
) -> xr.Dataset:
    """Return each parameter and quantity at both visits.

    Args:
        found: The comparison.
        beyond: Share beyond which a change counts, such as 0.05.
        speeds: How speeds are defined.

    Returns:
        Dataset over ``name``: ``before`` and ``today (name, quantile)`` in its ``unit``, ``change
        (name, quantile)`` in percent, of over-travel and rebound in percent of the stroke, and
        ``difference (name, quantile)`` in its unit, at 5, 50 and 95 %; the probabilities
        ``beyond``, ``more`` and ``less``, of a change by more than the share, up and down, and
        ``worse``, nan where neither is; ``verdict``, one of ``VERDICT_WORDS``, by ``beyond``;
        ``undefined``, the share of draws in which it does not exist at one of the visits;
        ``meaning``, ``kind`` ("parameter" or "quantity"), and ``motion``, empty where it is the
        same of both.
    """
    rows = [
        _row(each.name, each.unit, each.meaning, "parameter", "") | {"draws": draws}
        for each, draws in zip(
            PARAMETERS, np.stack([found.before, found.today], axis=-1).swapaxes(0, 1), strict=True
        )
    ]
    for motion in found.motions:
        known = quantities_of(motion, speeds)
        if motion != found.motions[0]:
            known = {name: each for name, each in known.items() if name not in _OF_BOTH}
        both = [
            evaluate(list(known), theta, motion, speeds) for theta in (found.before, found.today)
        ]
        for k, (name, each) in enumerate(known.items()):
            draws = np.column_stack([values[:, k] for values in both])
            of = "" if name in _OF_BOTH else motion
            rows.append(_row(name, each.unit, each.meaning, "quantity", of) | {"draws": draws})
    worse = _WORSE | {each.name: -1 for each in speeds}
    stroke = next(row["draws"][:, 0] for row in rows if row["name"] == "stroke")
    for row in rows:
        of = stroke if row["name"] in OF_STROKE else row["draws"][:, 0]
        row |= _judged(row.pop("draws"), of, beyond, worse.get(row["name"], 0))
    texts = ("unit", "meaning", "kind", "motion", "verdict")
    numbers = ("beyond", "more", "less", "worse", "undefined")
    ways = ("before", "today", "change", "difference")
    return xr.Dataset(
        {key: ("name", [row[key] for row in rows]) for key in (*texts, *numbers)}
        | {key: (("name", "quantile"), np.array([row[key] for row in rows])) for key in ways},
        coords={"name": [row["name"] for row in rows], "quantile": [*_QUANTILES]},
        attrs={"share": beyond, "parameters": len(NAMES)},
    )


def _row(name: str, unit: str, meaning: str, kind: str, motion: str) -> dict:
    return {"name": name, "unit": unit, "meaning": meaning, "kind": kind, "motion": motion}


def _judged(draws: np.ndarray, of: np.ndarray, beyond: float, worse: int) -> dict:
    """What draws ``(d, 2)`` at both visits say of a change, in shares of what ``(d,)`` is."""
    exists = np.isfinite(draws).all(axis=1) & np.isfinite(of)
    there = draws[exists]
    if not len(there):
        nothing = dict.fromkeys(("before", "today", "change", "difference"), [np.nan] * 3)
        nothing |= dict.fromkeys(("beyond", "more", "less", "worse"), np.nan)
        return nothing | {"undefined": 1.0, "verdict": VERDICT_WORDS[1]}
    before, today = there.T
    share = (today - before) / of[exists]
    more, less = float((share > beyond).mean()), float((share < -beyond).mean())
    total = more + less
    verdict = VERDICT_WORDS[0 if total >= SURE else 2 if total <= 1.0 - SURE else 1]
    return {
        "before": np.quantile(before, _QUANTILES),
        "today": np.quantile(today, _QUANTILES),
        "change": 100.0 * np.quantile(share, _QUANTILES),
        "difference": np.quantile(today - before, _QUANTILES),
        "beyond": total,
        "more": more,
        "less": less,
        "worse": {1: more, -1: less}.get(worse, np.nan),
        "undefined": 1.0 - len(there) / len(draws),
        "verdict": verdict,
    }
