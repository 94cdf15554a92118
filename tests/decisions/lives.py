"""A life made up: what ``follow_life`` returns, with limits that stand as a test wants them."""

import numpy as np
import xarray as xr

from breaker.mechanism import NAMES

OPERATIONS = np.arange(1, 501)
LIMITS = ("slow", "stiff")


def a_life(fails=(450.0, np.inf), *, told=100, half=(0.01, 0.31), family="medium_voltage"):
    """A life whose first limit is measured, its second on the change of gamma_a.

    Args:
        fails: Operation at which the median of each is beyond its limit.
        half: Half a 90 % interval of each quantity; the way to either limit is 1.
    """
    asked = OPERATIONS[49::10]
    n = asked.size
    left = np.maximum(np.array(fails)[None, :] - asked[:, None], 0.0)
    spread = np.array([0.9, 1.0, 1.1])
    gone = np.where(np.isfinite(fails), asked[:, None] / np.array(fails), 0.0)
    value = gone[..., None] + np.array(half)[:, None] * np.array([-1.0, 0.0, 1.0])
    changed = np.zeros((n, len(NAMES), 3))
    changed[:, NAMES.index("gamma_a")] = (asked / 100.0)[:, None] * [1.5, 2.0, 2.5]
    changed[:, NAMES.index("L"), 2] = 3.0
    unchanged = np.where(changed[..., 1] > 0.0, 0.0, 1.0)
    beyond = (left == 0.0).astype(float)
    evidence = np.where(OPERATIONS > 50, 0.5, np.nan)
    parts = {"limit": LIMITS, "quantity": ("travel_time", "gamma_a"), "bound": (1.0, 1.0)}
    parts |= {"upper": (True, True), "unit": ("ms", "%")}
    steady = left[..., None] * spread
    return xr.Dataset(
        {
            "evidence": ("operation", evidence),
            "weight": ("operation", np.ones(OPERATIONS.size)),
            "p_value": ("motion", [0.5, 0.6]),
            "changed": (("asked", "parameter", "quantile"), changed),
            "unchanged": (("asked", "parameter"), unchanged),
            "names": ("asked", np.full(n, "gamma_a")),
            "beyond": (("asked", "limit"), beyond),
            "remaining": (("asked", "limit", "quantile"), left[..., None] * [0.5, 1.0, 1.5]),
            "steady": (("asked", "limit", "quantile"), steady),
            "value": (("asked", "part", "quantile"), value),
            "new": ("part", [0.0, 0.0]),
            "noticed": ("change", [310]),
            "start": ("change", [300]),
            "earliest": ("change", [295]),
            "latest": ("change", [305]),
            "kind": ("change", ["rate"]),
            "certainty": ("change", [20.0]),
            "change_names": ("change", ["gamma_a or f"]),
        },
        {
            "operation": OPERATIONS,
            "asked": asked,
            "parameter": list(NAMES),
            "motion": ["closing", "opening"],
            "quantile": [0.05, 0.5, 0.95],
            "limit": list(LIMITS),
            "words": ("limit", ["measured travel_time above 1 ms", "change of gamma_a above +1 %"]),
            "of": ("limit", ["record", "change"]),
        }
        | {f"part_{name}": ("part", list(each)) for name, each in parts.items()},
        {"family": family, "agreement": 0.4, "told": told, "threshold": 10.0, "margin": 0.8},
    )
