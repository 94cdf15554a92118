"""Lives made up: what ``forecast_of`` returns, and ``states_of``, as decisions and figures want."""

import numpy as np
import xarray as xr

from breaker.model.parameters import NAMES

OPERATIONS = np.arange(1, 501)
LIMITS = {"slow": "measured travel_time above 1 ms", "stiff": "change of gamma_a above +1 %"}
UNKNOWN = {"breaker": "", "phase": "", "date": "", "event": "", "not_used": ""}
UNKNOWN |= {"temperature": np.nan, "voltage": np.nan}


def a_life(
    fails=(450.0, np.inf), *, reported_from=100, family="medium_voltage", operations=OPERATIONS
):
    """A life whose first limit is measured, its second on the change of gamma_a. Its rate changes
    at 60 % of the operations.

    Args:
        fails: Operation at which the median of each is beyond its limit.
        reported_from: Operation from which on the life is reported.
    """
    asked, count = operations[49::10], operations.size
    left = np.maximum(fails - asked[:, None], 0.0)
    changed = np.zeros((asked.size, len(NAMES), 3))
    changed[:, NAMES.index("gamma_a")] = (asked / 100.0)[:, None] * [1.5, 2.0, 2.5]
    changed[:, NAMES.index("L"), 2] = 3.0
    nearer = np.where(asked[:, None] < reported_from, np.nan, 1.0 * np.isfinite(fails))
    value = (asked[:, None] / fails)[..., None] + np.outer([0.01, 0.95], [-1.0, 0.0, 1.0])
    start = int(0.6 * count)
    change = {"noticed": start + 10, "start": start, "earliest": start - 5, "latest": start + 5}
    change |= {"kind": "rate", "certainty": 20.0, "maintenance": False}
    data = {
        "evidence": ("operation", np.where(operations > 50, 0.5, np.nan)),
        "weight": ("operation", np.ones(count)),
        "p_value": ("motion", [0.5, 0.6]),
        "changed": (("asked", "parameter", "quantile"), changed),
        "unchanged": (("asked", "parameter"), np.where(changed[..., 1] > 0.0, 0.0, 1.0)),
        "p_exceeded": (("asked", "limit"), (left == 0.0).astype(float)),
        "p_nearer": (("asked", "limit"), nearer),
        "turns": (("asked", "draw"), np.full((asked.size, 41), np.inf)),
        "noticed_in": ("asked", np.full(asked.size, 50.0)),
        "remaining": (("asked", "limit", "quantile"), left[..., None] * [0.5, 1.0, 1.5]),
        "lives": (("asked", "limit", "draw"), left[..., None] * np.linspace(0.9, 1.1, 41)),
        "value": (("asked", "part", "quantile"), value),
        "new": ("part", np.zeros(2)),
        **{name: ("operation", np.full(count, item)) for name, item in UNKNOWN.items()},
        **{name: ("change", np.array([item])) for name, item in change.items()},
    }
    coords = {"operation": operations, "asked": asked, "parameter": list(NAMES)}
    coords |= {"motion": ["closing", "opening"], "quantile": [0.05, 0.5, 0.95]}
    coords |= {"limit": list(LIMITS), "words": ("limit", list(LIMITS.values()))}
    coords |= {"of": ("limit", ["record", "change"])}
    parts = {"limit": list(LIMITS), "quantity": ["travel_time", "gamma_a"], "bound": [1.0, 1.0]}
    parts |= {"upper": [True, True], "unit": ["ms", "%"]}
    coords |= {f"part_{name}": ("part", items) for name, items in parts.items()}
    attrs = {"family": family, "agreement": 0.4, "threshold": 10.0, "horizon": 10000}
    attrs |= {"reported_from": reported_from, "needed": reported_from}
    return xr.Dataset(data, coords, attrs)
