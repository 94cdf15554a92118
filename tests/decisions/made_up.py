"""Conditions, trends and curves made up for tests of decisions."""

from typing import NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from breaker.decisions.series import complete, remaining
from breaker.decisions.states import judge
from breaker.decisions.summary import verdict
from breaker.decisions.table import decide
from breaker.decisions.trust import trust_table
from breaker.mechanism.limits import from_list
from breaker.mechanism.parameters import MOTIONS, NAMES
from tests.decisions.test_trust import trust_of

NAN, INF = np.nan, np.inf
LIMITS = from_list(
    [
        {"name": "slow", "motion": "closing", "upper": {"touch_time": 10.0}},
        {"name": "tired", "motion": "closing", "upper": {"touch_time": 9.8}, "lower": {"f": 0.7}},
        {"name": "wide", "motion": "opening", "upper": {"L": 11.0}},
    ],
    MOTIONS,
)
ALARM = {"raise": 0.95, "clear": 0.5, "after": 2, "hold": 3}
SETTINGS = {"notice": 200, "toward": 0.95, "baseline": 2, "alarm_level": 0.95, "horizon": 10000}
QUANTILES = [0.05, 0.5, 0.95]
KINDS = [*NAMES, "several", "all"]


def condition_of(probability, operations=None):
    """What single operations say, ``(o, 3)``: marginals are half of the probabilities."""
    values = np.array(probability, dtype=float)
    dims = ("operation", "limit")
    return xr.Dataset(
        {"probability": (dims, values), "marginal": (dims, values / 2)},
        {
            "operation": np.arange(1, len(values) + 1) if operations is None else operations,
            "limit": [limit.name for limit in LIMITS],
            "words": ("limit", [limit.words for limit in LIMITS]),
        },
    )


def trend_of(motions, operations, **changed):
    """A trend at rest: no drift, nothing near. ``changed`` are values by the name of a limit."""
    limits = [limit for limit in LIMITS if limit.motion in motions]
    names = [limit.name for limit in limits]
    o, parts = len(operations), [(each.name, part) for each in limits for part in each.parts]
    full = {
        "remaining": np.full((o, len(limits), 3), INF),
        "toward": np.full((o, len(limits)), 0.1),
        "beyond": np.zeros((o, len(limits))),
    }
    for name, values in changed.items():
        for limit, each in values.items():
            full[name][:, names.index(limit)] = each
    dims = {"remaining": ("operation", "limit", "quantile")}
    value = np.array([9.0, 9.5, 10.0, 9.0, 9.5, 10.0, 0.75, 0.8, 0.85, 9.0, 10.0, 11.0])
    value = value.reshape(4, 3)[[i for i, each in enumerate(PARTS) if each in names]]
    p = len(NAMES)
    made = xr.Dataset(
        {name: (dims.get(name, ("operation", "limit")), each) for name, each in full.items()}
        | {
            "value": (("operation", "part", "quantile"), np.tile(value, (o, 1, 1))),
            "slope": (("operation", "parameter"), np.zeros((o, p))),
            "slope_interval": (
                ("operation", "parameter", "bound"),
                np.tile([-1.0, 1.0], (o, p, 1)),
            ),
            "alarm": ("operation", np.zeros(o, dtype=bool)),
            "event": ("operation", np.full(o, "")),
            "step": ("operation", np.zeros(o, dtype=bool)),
            "surprise": ("operation", np.full(o, 0.5)),
            "step_size": (("operation", "phase"), np.full((o, 3 * len(motions)), NAN)),
            "start_interval": (("operation", "quantile"), np.full((o, 3), NAN)),
            "kind_probability": (("operation", "kind"), np.full((o, len(KINDS)), NAN)),
        },
        {
            "operation": operations,
            "limit": [limit.name for limit in limits],
            "words": ("limit", [limit.words for limit in limits]),
            "part_limit": ("part", [name for name, _ in parts]),
            "part_quantity": ("part", [part[0] for _, part in parts]),
            "part_bound": ("part", [part[1] for _, part in parts]),
            "part_upper": ("part", [part[2] for _, part in parts]),
            "quantile": QUANTILES,
            "parameter": list(NAMES),
            "kind": KINDS,
            "phase": [f"{m} {each}" for m in motions for each in ("start", "main motion", "end")],
        },
    )
    return complete(made, SETTINGS, "both" if len(motions) == 2 else motions[0])


def changed(trend, alarm, start, interval, **kinds):
    """A trend with a change, of the kinds and with the probabilities of ``kinds``."""
    kind = np.array([[kinds.get(name, 0.0) for name in KINDS]])
    return trend.drop_dims("change").assign(
        change_alarm=("change", np.array([alarm])),
        change_start=("change", np.array([start])),
        change_interval=(("change", "bound"), np.array([interval])),
        change_kind=(("change", "kind"), kind),
        change_moved=(("change", "parameter"), kind[:, : len(NAMES)]),
    )


PARTS = [limit.name for limit in LIMITS for _ in limit.parts]


def curves_of(operations, **flags):
    o = len(operations)
    known = {
        "accepted": np.ones(o, bool),
        "resolved": np.ones(o, bool),
        "misfit": np.zeros(o, bool),
    }
    return xr.Dataset(
        {name: ("operation", np.array(each)) for name, each in (known | flags).items()},
        {"operation": operations},
    )


QUIET = np.full((4, 3), 0.01)
NUMBERS = np.arange(1, 5)


class Page(NamedTuple):
    """Everything that is decided."""

    judged: xr.Dataset
    left: xr.Dataset
    rows: pd.DataFrame
    verdict: xr.Dataset

    @property
    def last(self):
        return self.rows.iloc[-1]


def page_of(own, trend, *, baseline=2, curves=None, trust=None, alarm=ALARM, **given):
    """Everything that follows from probabilities ``(o, 3)`` and trends by source, or of both."""
    trends = {"both": trend} if isinstance(trend, xr.Dataset) else trend
    trend = next(iter(trends.values()))
    condition = condition_of(own, trend.operation.values)
    left = remaining(trends, LIMITS, trend.operation.values)
    judged = judge(condition, left, trends, alarm=alarm, toward=SETTINGS["toward"])
    curves = curves or {"closing": curves_of(trend.operation.values)}
    trust = trust_table([trust_of(MOTIONS)]) if trust is None else trust
    rows = decide(judged, left, trends, curves, trust, **{"alarm": alarm, "notice": 200} | given)
    return Page(judged, left, rows, verdict(judged, left, trends, rows, trust, baseline=baseline))
