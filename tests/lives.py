"""Lives made up: what ``forecast_of`` returns, and ``states_of``, as decisions and figures want."""

import numpy as np
import xarray as xr

from breaker.model.parameters import NAMES

_QUANTILE = [0.05, 0.5, 0.95]
_DIMS = {
    **dict.fromkeys(("evidence", "weight"), "operation"),
    "remaining": ("asked", "limit", "quantile"),
    "p_nearer": ("asked", "limit"),
    "turns": ("asked", "draw"),
    "noticed_in": "asked",
    **dict.fromkeys(("breaker", "phase", "date", "event", "not_used"), "operation"),
    **dict.fromkeys(("temperature", "voltage"), "operation"),
    "lives": ("asked", "limit", "draw"),
    "p_value": "motion",
    "changed": ("asked", "parameter", "quantile"),
    "unchanged": ("asked", "parameter"),
    "p_exceeded": ("asked", "limit"),
    "value": ("asked", "part", "quantile"),
    "new": "part",
}


def life_of(operation, asked, limits, parts, changes, values, attrs):
    """A life read at ``asked``; ``limits`` are words by name, ``parts`` the rest of them."""
    size = len(parts["limit"])
    data = {"new": np.zeros(size)} | values
    return xr.Dataset(
        {name: (_DIMS[name], item) for name, item in data.items()}
        | {name: ("change", change) for name, change in changes.items()},
        {
            "operation": operation,
            "asked": asked,
            "parameter": list(NAMES),
            "motion": ["closing", "opening"],
            "quantile": _QUANTILE,
            "limit": list(limits),
            "words": ("limit", list(limits.values())),
        }
        | {f"part_{name}": ("part", list(part)) for name, part in parts.items()},
        attrs,
    )


OPERATIONS = np.arange(1, 501)
LIMITS = {"slow": "measured travel_time above 1 ms", "stiff": "change of gamma_a above +1 %"}


def a_life(
    fails=(450.0, np.inf),
    *,
    reported_from=100,
    half=(0.01, 0.95),
    family="medium_voltage",
    operations=OPERATIONS,
    changes=("rate",),
):
    """A life whose first limit is measured, its second on the change of gamma_a.

    Args:
        fails: Operation at which the median of each is beyond its limit.
        reported_from: Operation from which on the life is reported.
        half: Half a 90 % interval of each quantity; the way to either limit is 1.
        changes: Kinds of the changes, the first of which begins at 60 % of the operations.
    """
    asked = operations[49::10]
    left = np.maximum(np.array(fails)[None, :] - asked[:, None], 0.0)
    gone = np.where(np.isfinite(fails), asked[:, None] / np.array(fails), 0.0)
    changed = np.zeros((asked.size, len(NAMES), 3))
    changed[:, NAMES.index("gamma_a")] = (asked / 100.0)[:, None] * [1.5, 2.0, 2.5]
    changed[:, NAMES.index("L"), 2] = 3.0
    parts = {"limit": LIMITS, "quantity": ("travel_time", "gamma_a"), "bound": (1.0, 1.0)}
    parts |= {"upper": (True, True), "unit": ("ms", "%")}
    count = len(changes)
    start = (np.linspace(0.6, 0.9, count) * operations.size).astype(int)
    moments = {"noticed": start + 10, "start": start, "earliest": start - 5, "latest": start + 5}
    moments |= {"kind": np.array(changes, dtype=str), "certainty": np.full(count, 20.0)}
    moments["maintenance"] = np.zeros(count, dtype=bool)
    none, empty = np.full(operations.size, np.nan), np.full(operations.size, "")
    values = {
        "evidence": np.where(operations > 50, 0.5, np.nan),
        "weight": np.ones(operations.size),
        "p_value": [0.5, 0.6],
        "changed": changed,
        "unchanged": np.where(changed[..., 1] > 0.0, 0.0, 1.0),
        **dict.fromkeys(("breaker", "phase", "date", "event", "not_used"), empty),
        **dict.fromkeys(("temperature", "voltage"), none),
        "p_exceeded": (left == 0.0).astype(float),
        "p_nearer": np.where(
            (asked < reported_from)[:, None], np.nan, np.isfinite(fails).astype(float)
        ),
        "turns": np.full((asked.size, 41), np.inf),
        "noticed_in": np.full(asked.size, 50.0),
        "remaining": left[..., None] * [0.5, 1.0, 1.5],
        "lives": left[..., None] * np.linspace(0.9, 1.1, 41),
        "value": gone[..., None] + np.array(half)[:, None] * [-1.0, 0.0, 1.0],
    }
    attrs = {
        "family": family,
        "agreement": 0.4,
        "reported_from": reported_from,
        "needed": reported_from,
    }
    attrs |= {"threshold": 10.0, "horizon": 10000}
    life = life_of(operations, asked, LIMITS, parts, moments, values, attrs)
    return life.assign_coords(of=("limit", ["record", "change"]))
