"""State of each limit of a drive after every operation: unknown, ok, planned or due.

Shapes: ``o`` operations, ``a`` of them with forecasts, ``l`` limits.
"""

from collections.abc import Mapping

import numpy as np
import xarray as xr

from breaker.prognosis.series import days_of
from breaker.prognosis.service import YEAR, days_per_operation, on_date, plan

STATES = ("unknown", "ok", "planned", "due")
"""States of a limit and of a drive, the most urgent last."""

_SURE = 0.95  # probability from which a limit counts as exceeded, or the drive as nearer to it
_EARLY = 0.4  # probability to exceed a limit within the planning horizon, from which to plan
_SHARE = 0.2  # longest planning horizon, as a share of the age
_UNSEEN = 1.5  # intervals of inspection within which 5 % may exceed: the next one may be late
_STAYS = 2.0  # factor on the horizon to leave the state "planned", so that states do not alternate
_MOVES = 0.5  # change of an estimate, share of the operations left, that moves a recommendation


def next_state(before: str, p_exceeded: float, p_nearer: float, ahead: float) -> str:
    """Return the state of a limit after an operation: the first condition that is met decides.

    Args:
        before: State after the previous operation; "unknown" for the first, or after maintenance.
        p_exceeded: Probability that the limit is exceeded; nan if unknown.
        p_nearer: Probability that the drive is nearer to the limit than as new.
        ahead: Time until the limit may be exceeded, in horizons; a service is planned from 1 down.
    """
    if p_exceeded >= _SURE or before == "due":
        return "due"
    if np.isnan(p_exceeded + p_nearer):  # no record since new, or since maintenance
        return "unknown"
    far, likely = (_STAYS, 0.5) if before == "planned" else (1.0, _SURE)
    if ahead <= far and p_nearer >= likely:
        return "planned"
    return "unknown" if p_exceeded > 1.0 - _SURE and p_nearer < _SURE else "ok"


def states_of(life: xr.Dataset, planning: Mapping) -> xr.Dataset:
    """Return the states of a drive and of its limits, from the result of ``life.forecast_of``, with
    ``date (operation)`` if known, and the section ``planning``.

    Returns:
        Dataset over ``operation`` and ``limit``: ``state``, number in ``STATES``; ``p_exceeded``;
        ``service_by``, inf without one, and ``service_by_date``; ``recommended_since``, the
        operation since which a service is recommended, nan without a service; ``remaining``, by
        ``quantile``, operations; ``risk``, as of ``service.plan``. Over ``operation``:
        ``drive_state`` and ``drive_since``; ``subject``, the limit that decides the state (-1
        without one); ``days`` between operations. Over ``limit``: ``certain`` and ``crossed``, the
        operations from which the limit is exceeded certainly or probably, nan if not.
    """
    asked, operations = life.asked.values, life.operation.values
    dated = days_of(life.date.values) if "date" in life else np.full(len(operations), np.nan)
    days = days_per_operation(operations, dated)
    events = life.start.values[life.maintenance.values]
    spell = np.searchsorted(events, asked, side="right")
    last = np.searchsorted(asked, operations, side="right") - 1
    then = days[np.searchsorted(operations, asked)]
    age = np.maximum(asked - np.append(operations[0], events)[spell], 1.0)
    best, risk = plan(life, planning, then, age)
    state, by = _judged(life, _ahead(life, planning, then, age), best, spell)
    shown = (last >= 0) & (spell[last] == np.searchsorted(events, operations, side="right"))
    show = shown[:, None]  # the last forecast counts until a maintenance
    state, by = np.where(show, state[last], 0), np.where(show, by[last], np.inf)
    p_exceeded = np.where(show, life.p_exceeded.values[last], np.nan)
    over = state == STATES.index("due")
    left = life.remaining.values[last] - (operations - asked[last])[:, None, None]
    left = np.where(shown[:, None, None], np.maximum(left, 0.0), np.nan)
    left = np.where(over[..., None], 0.0, left)
    certain, crossed = (_since(on, operations)[-1] for on in (over, over | (p_exceeded >= 0.5)))
    both, drive = ("operation", "limit"), state.max(axis=1, keepdims=True)
    columns = {
        "state": (both, state.astype(np.int8)),
        "p_exceeded": (both, p_exceeded),
        "service_by": (both, by),
        "service_by_date": (both, on_date(by, operations, dated, days)),
        "recommended_since": (both, _since(state >= STATES.index("planned"), operations)),
        "remaining": ((*both, "quantile"), left),
        "risk": (both, np.where(show, risk[last], np.nan)),
        "certain": ("limit", certain),
        "crossed": ("limit", np.where(np.isnan(certain), np.nan, crossed)),
        "drive_state": ("operation", drive[:, 0].astype(np.int8)),
        "drive_since": ("operation", _since(drive >= STATES.index("planned"), operations)[:, 0]),
        "subject": ("operation", _subject(state, by, left[..., 1])),
        "days": ("operation", days),
    }
    coords = {name: life[name] for name in ("operation", "limit", "quantile")}
    return xr.Dataset(columns, coords, {"states": list(STATES)})


def _subject(state: np.ndarray, by: np.ndarray, left: np.ndarray) -> np.ndarray:
    """Return the limit that decides the state of the drive, ``(o,)``; -1 without one."""
    most = (state == state.max(axis=1, keepdims=True)) & (state > 0)
    soonest = np.where(np.isfinite(by), by, np.nan_to_num(left, nan=np.inf))
    urgency = np.where(most, soonest, np.inf)
    return np.where(np.isfinite(urgency).any(axis=1), urgency.argmin(axis=1), -1)


def _ahead(life: xr.Dataset, planning: Mapping, days: np.ndarray, age: np.ndarray) -> np.ndarray:
    """Return the time until limits may be exceeded, ``(a, l)``, in planning horizons or intervals
    without inspection, the smaller of both; ``days`` and ``age`` are as of ``plan``.
    """
    horizon = np.fmax(planning["operations"], planning["years"] * YEAR / days)
    horizon = np.minimum(horizon, _SHARE * age)[:, None]
    unseen = _UNSEEN * np.maximum(np.diff(life.asked, prepend=life.asked[:1]), 1.0)[:, None]
    early = np.quantile(life.lives.values, _EARLY, axis=-1, method="inverted_cdf")
    return np.minimum(early / horizon, life.remaining.values[..., 0] / unseen)


def _judged(
    life: xr.Dataset, ahead: np.ndarray, best: np.ndarray, spell: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the state of each limit, and when to service at latest, inf without, ``(a, l)``."""
    asked, p_exceeded, p_nearer = (life[e].values for e in ("asked", "p_exceeded", "p_nearer"))
    left = np.floor(np.fmin(best, life.remaining.values[..., 0]))
    states, nearest = np.zeros(best.shape, dtype=int), np.full(best.shape, np.inf)
    for i, j in np.ndindex(best.shape):
        state, by = "unknown", np.inf
        if i and spell[i] == spell[i - 1]:  # no maintenance since
            state, by = STATES[states[i - 1, j]], nearest[i - 1, j]
        state = next_state(state, p_exceeded[i, j], p_nearer[i, j], ahead[i, j])
        if state == "planned":
            nearest[i, j] = _moved(by, asked[i], left[i, j])
        elif state == "due":
            nearest[i, j] = min(by, asked[i])
        states[i, j] = STATES.index(state)
    return states, nearest


def _moved(by: float, now: float, left: float) -> float:
    """Return when to service by a new estimate; a recommendation stays if it is about as good.

    >>> [_moved(by, 1000, 300.0) for by in (1600.0, 1160.0, 1140.0, 990.0)]
    [1300.0, 1160.0, 1300.0, 990.0]
    """
    if by <= now:
        return by
    early = now + left - by > _MOVES * left
    return now + left if early or by > now + left else by


def _since(on: np.ndarray, operations: np.ndarray) -> np.ndarray:
    """Return the operation since which a condition ``on`` is true, ``(o, l)``; nan if false."""
    begins = on & ~np.concatenate([np.zeros_like(on[:1]), on[:-1]])
    begins = np.where(begins, operations[:, None], np.nan)
    return np.where(on, np.fmax.accumulate(begins, axis=0), np.nan)
