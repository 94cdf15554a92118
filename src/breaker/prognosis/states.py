"""State of each limit of a drive after every operation: unknown, ok, planned or due.

Shapes: ``o`` operations, ``a`` of them at which the life was read, ``l`` limits.
"""

from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np
import xarray as xr

from breaker.prognosis.service import YEAR, Costs, Plan, ahead_of, plan

STATES = ("unknown", "ok", "planned", "due")
"""States of a limit and of a drive, the most urgent last."""

_SURE = 0.95  # probability from which a limit is exceeded, or the drive is nearer to it
_LIKELY = 0.5  # probability from which a limit was crossed, and below which nothing is nearer
_EARLY = 0.4  # probability to exceed a limit within the planning horizon, that makes a plan
_SHARE = 0.2  # of the age, the longest planning horizon: a plan helps no earlier
_UNSEEN = 1.5  # intervals of inspection, as the next one may be late: exceeded there with 5 %
_STAYS = 2.0  # planning horizons, within which a plan stays one
_MOVES = 0.5  # share of what is left, by which an estimate has to leave what is recommended


class Facts(NamedTuple):
    """What is known of a limit after an operation.

    Attributes:
        before: Its state after the operation before; "unknown" of the first.
        maintained: Whether the drive was maintained since.
        p_exceeded: Probability that the limit is exceeded; nan where nothing is known.
        p_nearer: Probability that the drive is nearer to the limit than as new.
        soon: Whether the limit may be exceeded within the planning horizon.
        far: Whether it is not even within twice this horizon.
    """

    before: str
    maintained: bool
    p_exceeded: float
    p_nearer: float
    soon: bool
    far: bool


TRANSITIONS: tuple[tuple[str, str, Callable[[Facts], bool]], ...] = (
    ("due", "exceeded for sure", lambda f: f.p_exceeded >= _SURE),
    ("due", "due before, and not maintained", lambda f: f.before == "due" and not f.maintained),
    (
        "unknown",
        "no record since new or maintenance",
        lambda f: np.isnan(f.p_exceeded + f.p_nearer),
    ),
    (
        "planned",
        "surely nearer than as new, and perhaps exceeded soon",
        lambda f: f.p_nearer >= _SURE and f.soon,
    ),
    (
        "planned",
        "planned before, and neither far nor back",
        lambda f: (
            f.before == "planned" and not f.maintained and not f.far and f.p_nearer >= _LIKELY
        ),
    ),
    (
        "unknown",
        "perhaps exceeded, but not surely nearer than as new",
        lambda f: f.p_exceeded > 1.0 - _SURE and f.p_nearer < _SURE,
    ),
    ("ok", "else", lambda f: True),
)
"""State after an operation, words, and condition: the first condition that is met decides."""


def next_state(facts: Facts) -> str:
    """Return the state of a limit by ``TRANSITIONS``."""
    return next(state for state, _, holds in TRANSITIONS if holds(facts))


def states_of(life: xr.Dataset, planning: Mapping, per_operation: np.ndarray) -> xr.Dataset:
    """Return the states of a drive and of its limits.

    Args:
        life: What ``life.forecast_of`` returns.
        planning: That section of the configuration.
        per_operation: Recent days from one operation to the next, ``(o,)``; nan if not known.

    Returns:
        Dataset over ``operation`` and ``limit``: ``state``, number in ``STATES``; ``p_exceeded``;
        ``service_by``, inf without one; ``recommended_since``, the operation since when a service
        is recommended, nan if none is; ``remaining``, by ``quantile``, operations; ``risk``, the
        probability to fail before the next inspection. Over ``operation`` the drive's own
        ``drive_state``, ``drive_since`` and ``drive_service_by``, and ``subject``, the limit that
        they are about (-1 without one). Over ``limit``: ``certain`` and ``crossed``, the operations
        from which on it is exceeded for sure, and probably, nan if not; over
        ``ahead``, ``extra``, as of ``service.Plan``, at the end.
    """
    asked, operations = life.asked.values, life.operation.values
    events = life.start.values[life.maintenance.values]
    spell = np.searchsorted(events, asked, side="right")
    at = np.searchsorted(asked, operations, side="right") - 1
    plans = _plans(life, Costs.from_settings(planning), per_operation, events)
    state, by = _judged(life, planning, per_operation, plans.best, spell)
    shown = (at >= 0) & (spell[at] == np.searchsorted(events, operations, side="right"))
    show = shown[:, None]  # what was read last counts until a maintenance
    state, by = np.where(show, state[at], 0), np.where(show, by[at], np.inf)
    p_exceeded = np.where(show, life.p_exceeded.values[at], np.nan)
    over = state == STATES.index("due")
    left = life.remaining.values[at] - (operations - asked[at])[:, None, None]
    left = np.where(shown[:, None, None], np.maximum(left, 0.0), np.nan)
    left = np.where(over[..., None], 0.0, left)
    drive = state.max(axis=1, initial=0)
    both = ("operation", "limit")
    found = {
        "state": (both, state.astype(np.int8)),
        "p_exceeded": (both, p_exceeded),
        "service_by": (both, by),
        "recommended_since": (both, _since(state >= STATES.index("planned"), operations)),
        "remaining": ((*both, "quantile"), left),
        "risk": (both, np.where(show, plans.risk[at], np.nan)),
        "certain": ("limit", _since(over, operations)[-1]),
        "crossed": ("limit", _since(over | (p_exceeded >= _LIKELY), operations)[-1]),
        "extra": (("limit", "ahead"), plans.extra[-1]),
        "drive_state": ("operation", drive.astype(np.int8)),
        "drive_service_by": ("operation", by.min(axis=1, initial=np.inf)),
        "drive_since": ("operation", _since(drive >= STATES.index("planned"), operations)),
        "subject": ("operation", _subject(state, by, left[..., 1])),
    }
    found["crossed"][1][np.isnan(found["certain"][1])] = np.nan
    coords = {name: life[name] for name in ("operation", "limit", "quantile")}
    coords["ahead"] = ahead_of(life.attrs["horizon"])
    return xr.Dataset(found, coords, {"states": list(STATES)})


def _subject(state: np.ndarray, by: np.ndarray, left: np.ndarray) -> np.ndarray:
    """Return the limit that the state of the drive is about, ``(o,)``; -1 without one."""
    if not state.shape[1]:
        return np.full(len(state), -1)
    urgency = np.where(np.isfinite(by), by, np.nan_to_num(left, nan=np.inf))
    most = (state == state.max(axis=1, keepdims=True)) & (state > 0)
    urgency = np.where(most, urgency, np.inf)
    return np.where(np.isfinite(urgency).any(axis=1), urgency.argmin(axis=1), -1)


def _plans(life: xr.Dataset, costs: Costs, per_operation: np.ndarray, events: np.ndarray) -> Plan:
    """Plans of all limits, ``(a, l)`` and ``(a, l, ahead)``."""
    operations, asked = life.operation.values, life.asked.values
    place, ahead = np.searchsorted(operations, asked), ahead_of(life.attrs["horizon"])
    about = {"age": _age(life, events), "days": per_operation[place]}
    noticed = life.noticed_in.values
    found = [
        plan(ahead, costs, lives, life.turns.values, noticed, **about)
        for lives in np.moveaxis(life.lives.values, 1, 0)
    ]
    if not found:
        none = np.zeros((asked.size, 0))
        return Plan(none, none, np.zeros((asked.size, 0, ahead.size)))
    return Plan(*(np.stack(each, axis=1) for each in zip(*found, strict=True)))


def _age(life: xr.Dataset, events: np.ndarray) -> np.ndarray:
    """Operations since new, or since the last maintenance, at least 1, ``(a,)``."""
    begins = np.append(life.operation.values[0], events)
    last = begins[np.searchsorted(events, life.asked.values, side="right")]
    return np.maximum(life.asked.values - last, 1.0).astype(float)


def _judged(
    life: xr.Dataset,
    planning: Mapping,
    per_operation: np.ndarray,
    best: np.ndarray,
    spell: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """State of each limit, and by when to service, inf without a plan, ``(a, l)`` each."""
    asked = life.asked.values
    days = per_operation[np.searchsorted(life.operation.values, asked)]
    horizon = np.fmax(planning["operations"], planning["years"] * YEAR / days)
    late = _SHARE * _age(life, life.start.values[life.maintenance.values])
    horizon = np.minimum(horizon, late)[:, None]
    unseen = _UNSEEN * np.maximum(np.diff(asked, prepend=asked[:1]), 1.0)[:, None]
    least = life.remaining.values[..., 0]
    early = np.quantile(life.lives.values, _EARLY, axis=-1, method="inverted_cdf")
    ahead = np.minimum(early / horizon, least / unseen)  # in horizons
    left = np.floor(np.fmin(best, least))
    states, found = np.zeros(best.shape, dtype=int), np.full(best.shape, np.inf)
    for j in range(best.shape[1]):
        state, by = "unknown", np.inf
        for i in range(len(asked)):
            maintained = bool(i and spell[i] != spell[i - 1])
            p_exceeded = float(life.p_exceeded.values[i, j])
            p_nearer = float(life.p_nearer.values[i, j])
            soon, far = bool(ahead[i, j] <= 1.0), bool(ahead[i, j] > _STAYS)
            state = next_state(Facts(state, maintained, p_exceeded, p_nearer, soon, far))
            if state == "planned":
                by = _moved(np.inf if maintained else by, asked[i], left[i, j])
            elif state == "due":
                by = min(by, asked[i])
            else:
                by = np.inf
            states[i, j], found[i, j] = STATES.index(state), by
    return states, found


def _moved(by: float, now: float, left: float) -> float:
    """By when to service, by a new estimate: what was recommended stays if it is about as good.

    >>> [_moved(by, 1000, 300.0) for by in (np.inf, 1250.0, 1600.0, 990.0)]
    [1300.0, 1250.0, 1300.0, 990.0]
    """
    if by <= now:
        return by
    early = now + left - by > _MOVES * left
    return now + left if early or by > now + left else by


def _since(on: np.ndarray, operations: np.ndarray) -> np.ndarray:
    """Return the operation since when something holds, ``(o, ...)``; nan where it does not."""
    operations = operations.reshape(-1, *[1] * (on.ndim - 1))
    begins = on & ~np.concatenate([np.zeros_like(on[:1]), on[:-1]])
    return np.where(on, np.maximum.accumulate(np.where(begins, operations, 0), axis=0), np.nan)
