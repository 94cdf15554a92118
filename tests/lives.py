"""Lives made up: what ``forecast_of`` returns, and ``states_of``, as decisions and figures want."""

import numpy as np
import xarray as xr

from breaker.model.parameters import NAMES

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
        "p_nearer": np.where(asked[:, None] < reported_from, np.nan, 1.0 * np.isfinite(fails)),
        "turns": np.full((asked.size, 41), np.inf),
        "noticed_in": np.full(asked.size, 50.0),
        "remaining": left[..., None] * [0.5, 1.0, 1.5],
        "lives": left[..., None] * np.linspace(0.9, 1.1, 41),
        "value": gone[..., None] + np.array(half)[:, None] * [-1.0, 0.0, 1.0],
    }
    attrs = {"family": family, "agreement": 0.4, "threshold": 10.0, "horizon": 10000}
    attrs |= {"reported_from": reported_from, "needed": reported_from}
    data = {"new": np.zeros(2)} | values
    coords = {"operation": operations, "asked": asked, "parameter": list(NAMES)}
    coords |= {"motion": ["closing", "opening"], "quantile": [0.05, 0.5, 0.95]}
    coords |= {"limit": list(LIMITS), "words": ("limit", list(LIMITS.values()))}
    coords |= {"of": ("limit", ["record", "change"])}
    coords |= {f"part_{name}": ("part", list(part)) for name, part in parts.items()}
    data = {name: (_DIMS[name], item) for name, item in data.items()}
    data |= {name: ("change", values) for name, values in moments.items()}
    return xr.Dataset(data, coords, attrs)
