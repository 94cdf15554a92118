"""Lives made up: what ``forecast_of`` returns, and ``states_of``, as decisions and figures want."""

import numpy as np
import xarray as xr

from breaker.common.randomness import generator
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
    """A life told at ``asked``; ``limits`` are words by name, ``parts`` the rest of them."""
    size = len(parts["limit"])
    data = {"new": np.zeros(size)} | values
    return xr.Dataset(
        {name: (_DIMS[name], each) for name, each in data.items()}
        | {name: ("change", each) for name, each in changes.items()},
        {
            "operation": operation,
            "asked": asked,
            "parameter": list(NAMES),
            "motion": ["closing", "opening"],
            "quantile": _QUANTILE,
            "limit": list(limits),
            "words": ("limit", list(limits.values())),
        }
        | {f"part_{name}": ("part", list(each)) for name, each in parts.items()},
        attrs,
    )


# ---- of two limits that are reached, or not, at given operations ---------------------------------

OPERATIONS = np.arange(1, 501)
_TWO = {"slow": "measured travel_time above 1 ms", "stiff": "change of gamma_a above +1 %"}


def a_life(
    fails=(450.0, np.inf),
    *,
    told=100,
    half=(0.01, 0.95),
    family="medium_voltage",
    operations=OPERATIONS,
):
    """A life whose first limit is measured, its second on the change of gamma_a.

    Args:
        fails: Operation at which the median of each is beyond its limit.
        half: Half a 90 % interval of each quantity; the way to either limit is 1.
    """
    asked = operations[49::10]
    left = np.maximum(np.array(fails)[None, :] - asked[:, None], 0.0)
    gone = np.where(np.isfinite(fails), asked[:, None] / np.array(fails), 0.0)
    changed = np.zeros((asked.size, len(NAMES), 3))
    changed[:, NAMES.index("gamma_a")] = (asked / 100.0)[:, None] * [1.5, 2.0, 2.5]
    changed[:, NAMES.index("L"), 2] = 3.0
    parts = {"limit": _TWO, "quantity": ("travel_time", "gamma_a"), "bound": (1.0, 1.0)}
    parts |= {"upper": (True, True), "unit": ("ms", "%")}
    changes = {"noticed": [310], "start": [300], "earliest": [295], "latest": [305]}
    changes |= {"kind": ["rate"], "certainty": [20.0], "maintenance": [False]}
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
        "p_nearer": np.where((asked < told)[:, None], np.nan, np.isfinite(fails).astype(float)),
        "turns": np.full((asked.size, 41), np.inf),
        "noticed_in": np.full(asked.size, 50.0),
        "remaining": left[..., None] * [0.5, 1.0, 1.5],
        "lives": left[..., None] * np.linspace(0.9, 1.1, 41),
        "value": gone[..., None] + np.array(half)[:, None] * [-1.0, 0.0, 1.0],
    }
    attrs = {"family": family, "agreement": 0.4, "reported_from": told, "needed": told}
    attrs |= {"threshold": 10.0, "horizon": 10000}
    life = life_of(operations, asked, _TWO, parts, changes, values, attrs)
    return life.assign_coords(of=("limit", ["record", "change"]))


# ---- of four limits, each in another state at the end --------------------------------------------

LIMITS = {  # words, state at the end, probability, bound when new is 0, and the value
    "slow": ("measured travel_time above 9.5 ms", 3, 1.0, 1.0, [1.1, 1.2, 1.3]),
    "dry": ("change of gamma_a above +15 %", 2, 0.1, 15.0, [4.0, 6.0, 9.0]),
    "tired": ("change of f below -5 %", 1, 0.0, -5.0, [-1.5, -1.0, -0.5]),
    "wide": ("L above 10.65 mm", 0, 0.3, 0.5, [-0.5, 0.1, 0.9]),
}
_WORDS, _STATES, _BEYOND, _BOUNDS, _VALUES = zip(*LIMITS.values(), strict=True)
_LEFT = [[0.0, 0.0, 0.0], [90.0, 210.0, np.inf], [np.inf] * 3, [0.0, 50.0, np.inf]]


def life_data(operations=200, changes=("rate",)):
    """Follow a drive of which gamma_a and f change, and whose changes begin evenly spaced."""
    rng, number = generator(31, "test", "life"), np.arange(1, operations + 1)
    asked = number[9::2]
    rates = np.array([0, 0, 0, 0.1, 0, -0.03, 0])
    changed = np.multiply.outer(asked, rates)[..., None] * [0.8, 1.0, 1.3]
    changed[:, 1] = [-3.0, 0.0, 0.5]
    remaining = np.maximum(np.array(_LEFT) + (operations - asked)[:, None, None], 0.0)
    remaining[:, 0] = np.maximum(operations - 20 - asked, 0.0)[:, None] * [0.8, 1.0, 1.2]
    start = (np.linspace(0.4, 0.9, len(changes)) * operations).astype(int)
    evidence = rng.uniform(-1.0, 5.0, operations)
    evidence[: operations // 20] = np.nan
    values = {
        "evidence": evidence,
        "weight": rng.uniform(0.1, 1.4, operations),
        "changed": np.sort(changed),
        "unchanged": np.tile(rates == 0, (len(asked), 1)) * 0.4,
        "remaining": remaining,
        "value": np.tile(_VALUES, (len(asked), 1, 1)),
    }
    parts = {"limit": LIMITS, "bound": _BOUNDS, "upper": np.array(_BOUNDS) > 0}
    parts |= {"unit": ("ms", "%", "%", "mm")}
    moments = {"noticed": start + 4, "start": start, "earliest": start - 3, "latest": start + 2}
    moments |= {"kind": np.array(changes, dtype=str), "certainty": np.full(len(start), 12.0)}
    attrs = {
        "family": "medium",
        "agreement": 0.5,
        "reported_from": 20,
        "needed": 20,
        "threshold": 10.0,
    }
    words = dict(zip(LIMITS, _WORDS, strict=True))
    return life_of(number, asked, words, parts, moments, values, attrs)


def standing_data(life):
    """Stand ok first, and in the last quarter as ``LIMITS`` says; the last limit never."""
    number, each = life.operation.values, ("operation", "limit")
    late = (number > 0.75 * len(number))[:, None]
    state = np.where(late, _STATES, [1, 1, 1, 0])
    state[number < life.reported_from] = 0
    by = np.where(late & (state >= 2), [number[-1] - 20, number[-1] + 40, 0, 0], np.inf)
    nowhere = [np.nan] * 3
    return xr.Dataset(
        {
            "state": (each, state.astype(np.int8)),
            "p_exceeded": (each, np.where(late, _BEYOND, [0.0, 0.0, 0.0, 0.3])),
            "service_by": (each, by),
            "recommended_since": (each, np.where(state >= 2, 0.75 * number[-1] + 1, np.nan)),
            "drive_state": ("operation", state.max(axis=1).astype(np.int8)),
            "remaining": ((*each, "quantile"), np.tile(_LEFT, (len(number), 1, 1))),
            "certain": ("limit", [0.75 * len(number) + 1, *nowhere]),
            "crossed": ("limit", [0.75 * len(number) - 9, *nowhere]),
        },
        {name: life[name] for name in ("operation", "limit", "quantile", "words")},
    )
