"""A small life and its standing, as ``follow_life`` and ``standing`` return them."""

import numpy as np
import xarray as xr

from breaker.mechanism.parameters import NAMES
from breaker.model.randomness import generator

LIMITS = {  # words, state at the end, probability, bound when new is 0, and the value
    "slow": ("measured travel_time above 9.5 ms", 3, 1.0, 1.0, [1.1, 1.2, 1.3]),
    "dry": ("change of gamma_a above +15 %", 2, 0.1, 15.0, [4.0, 6.0, 9.0]),
    "tired": ("change of f below -5 %", 1, 0.0, -5.0, [-1.5, -1.0, -0.5]),
    "wide": ("L above 10.65 mm", 0, 0.3, 0.5, [-0.5, 0.1, 0.9]),
}
_LEFT = [[0.0, 0.0, 0.0], [90.0, 210.0, np.inf], [np.inf] * 3, [0.0, 50.0, np.inf]]
QUANTILE = [0.05, 0.5, 0.95]


def life_data(operations=200, changes=("rate",)):
    """Follow a drive of which gamma_a and f change, and whose changes begin evenly spaced."""
    rng, number = generator(31, "test", "life"), np.arange(1, operations + 1)
    asked = number[9::2]
    rates = np.array([0, 0, 0, 0.1, 0, -0.03, 0])
    changed = np.multiply.outer(asked, rates)[..., None] * [0.8, 1.0, 1.3]
    changed[:, 1] = [-3.0, 0.0, 0.5]
    remaining = np.maximum(np.array(_LEFT) + (operations - asked)[:, None, None], 0.0)
    remaining[:, 0] = np.maximum(operations - 20 - asked, 0.0)[:, None] * [0.8, 1.0, 1.2]
    start = np.linspace(0.4, 0.9, len(changes)) * operations if changes else np.zeros(0)
    evidence = rng.uniform(-1.0, 5.0, operations)
    evidence[: operations // 20] = np.nan
    parts = np.array([[limit[3], *limit[4]] for limit in LIMITS.values()])
    return xr.Dataset(
        {
            "evidence": ("operation", evidence),
            "weight": ("operation", rng.uniform(0.1, 1.4, operations)),
            "changed": (("asked", "parameter", "quantile"), np.sort(changed)),
            "unchanged": (("asked", "parameter"), np.tile(rates == 0, (len(asked), 1)) * 0.4),
            "remaining": (("asked", "limit", "quantile"), remaining),
            "value": (("asked", "part", "quantile"), np.tile(parts[:, 1:], (len(asked), 1, 1))),
            "new": ("part", np.zeros(len(parts))),
            "noticed": ("change", (start + 4).astype(int)),
            "start": ("change", start.astype(int)),
            "earliest": ("change", start.astype(int) - 3),
            "latest": ("change", start.astype(int) + 2),
            "kind": ("change", np.array(changes, dtype=str)),
            "certainty": ("change", np.full(len(start), 12.0)),
            "change_names": ("change", np.array(["gamma_a or f"] * len(start), dtype=str)),
        },
        {
            "operation": number,
            "asked": asked,
            "parameter": list(NAMES),
            "quantile": QUANTILE,
            "limit": list(LIMITS),
            "words": ("limit", [limit[0] for limit in LIMITS.values()]),
            "part_limit": ("part", list(LIMITS)),
            "part_bound": ("part", parts[:, 0]),
            "part_upper": ("part", parts[:, 0] > 0),
        },
        {"family": "medium", "agreement": 0.5, "told": 20, "threshold": 10.0},
    )


def standing_data(life):
    """Stand healthy first, and in the last quarter as ``LIMITS`` says; the last limit never."""
    number, each = life.operation.values, ("operation", "limit")
    late = (number > 0.75 * len(number))[:, None]
    state = np.where(late, [limit[1] for limit in LIMITS.values()], [1, 1, 1, 0])
    state[number < life.told] = 0
    beyond = np.where(late, [limit[2] for limit in LIMITS.values()], [0.0, 0.0, 0.0, 0.3])
    by = np.where(late & (state >= 2), [number[-1] - 20, number[-1] + 40, 0, 0], np.inf)
    nowhere = [np.nan] * 3
    return xr.Dataset(
        {
            "state": (each, state.astype(np.int8)),
            "beyond": (each, beyond),
            "service_by": (each, by),
            "left": ((*each, "quantile"), np.tile(_LEFT, (len(number), 1, 1))),
            "certain": ("limit", [0.75 * len(number) + 1, *nowhere]),
            "crossed": ("limit", [0.75 * len(number) - 9, *nowhere]),
        },
        {name: life[name] for name in ("operation", "limit", "quantile", "words")},
    )
