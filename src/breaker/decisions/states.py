"""How a drive stands to each of its limits after every operation: one vocabulary, one record each.

A limit is *now* where it is exceeded, or the operation has come by which to service; *plan* where
that is within the planning horizon; *healthy* before; and *unknown* where too little is known:
before the drive was followed long enough, without records, or where a service would have to be
planned for a quantity, or a date, that is known too badly. Such a limit is told apart, with its
probability, and hides no other.

The operation by which to service is after a share of what is left for almost sure. What is told
moves by evidence alone: where the estimate leaves it by a share of what is left.

Shapes: ``o`` operations, ``a`` of them asked, ``l`` limits.
"""

from collections.abc import Mapping

import numpy as np
import xarray as xr

__all__ = ["STATES", "standing", "steady"]

STATES = ("unknown", "healthy", "plan", "now")
"""States of a limit and of a drive, the most urgent last."""

_RAISE, _CLEAR = 0.95, 0.5  # probability from which a limit is exceeded, and below which no more
_VAGUE = 0.3  # half a 90 % interval over the way to a limit, from which the limit cannot be told
_EARLY = 0.5  # life that is left for almost sure over that left by half, below which it is vague
_STAYS = 1.5  # planning horizons, within which a plan stays one
_MOVES = 0.4  # share of what is left, by which an estimate leaves what is told
_UNKNOWN, _HEALTHY, _PLAN, _NOW = range(len(STATES))


def standing(life: xr.Dataset, settings: Mapping, per_operation: np.ndarray) -> xr.Dataset:
    """Say how the drive stands.

    Args:
        life: What ``wear.follow_life`` returns.
        settings: The section ``planning`` of the configuration: ``operations`` and ``years`` ahead.
        per_operation: Days from one operation to the next, of late, ``(o,)``; nan if not known.

    Returns:
        Dataset over ``operation`` and ``limit``: ``state``, number in ``STATES``; ``beyond``, the
        probability that it is exceeded; ``service_by``, a number, inf without one; ``left``, by
        ``quantile``, operations, 0 where it is exceeded; and over ``operation`` the drive's own
        ``drive_state``, ``subject``, the limit that it is about (-1 without one), and
        ``drive_service_by``. Over ``limit``: ``certain`` and ``crossed``, the first operation at
        which it is exceeded for sure, and from which on it is likelier than not; nan if it is not
        exceeded at the end.
    """
    asked, operations = life.asked.values, life.operation.values
    beyond = life.beyond.values
    exceeded = _latched(beyond >= _RAISE, beyond < _CLEAR)
    early = life.steady.values[..., 0]
    due = asked[:, None] + np.where(np.isfinite(early), life.attrs["margin"] * early, early)
    by = np.array([steady(each, asked) for each in due.T]).reshape(-1, len(asked)).T
    at = np.searchsorted(asked, operations, side="right") - 1
    shown, at = at >= 0, np.maximum(at, 0)
    by, over = np.where(shown[:, None], by[at], np.inf), exceeded[at] & shown[:, None]
    gone = (operations - asked[at])[:, None, None]
    left = np.maximum(life.remaining.values[at] - gone, 0.0)
    left = np.where(shown[:, None, None], left, np.nan)
    beyond = np.where(shown[:, None], beyond[at], np.nan)
    unknown = np.isnan(beyond) | (operations < life.attrs["told"])[:, None]
    soon = _soon(by - operations[:, None], settings, per_operation)
    unknown |= _vague(life)[at] & soon
    state = np.where(soon, np.where(by <= operations[:, None], _NOW, _PLAN), _HEALTHY)
    state = np.where(over, _NOW, np.where(unknown, _UNKNOWN, state))
    by = np.where(unknown & ~over, np.inf, np.where(over, np.minimum(by, operations[:, None]), by))
    certain, crossed = _since(over, beyond, operations)
    drive, subject = _drive(state, by)
    each = ("operation", "limit")
    return xr.Dataset(
        {
            "state": (each, state.astype(np.int8)),
            "beyond": (each, beyond),
            "service_by": (each, by),
            "left": ((*each, "quantile"), np.where(over[..., None], 0.0, left)),
            "certain": ("limit", certain),
            "crossed": ("limit", crossed),
            "drive_state": ("operation", drive.astype(np.int8)),
            "drive_service_by": ("operation", by.min(axis=1, initial=np.inf)),
            "subject": ("operation", subject),
        },
        {name: life[name] for name in ("operation", "limit", "quantile")},
        {"states": list(STATES)},
    )


def _soon(ahead: np.ndarray, settings: Mapping, per_operation: np.ndarray) -> np.ndarray:
    """Say which services are to be planned, those so many operations ahead, ``(o, l)``."""
    with np.errstate(invalid="ignore"):
        years = ahead * per_operation[:, None] / (365.25 * settings["years"])
        horizons = np.fmin(ahead / settings["operations"], years)
    return _latched(horizons <= 1.0, horizons > _STAYS)


def _drive(state: np.ndarray, by: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the state of the drive and the limit that it is about, -1 without one, ``(o,)``."""
    drive = state.max(axis=1, initial=_UNKNOWN)
    urgent = np.where((state == drive[:, None]) & (state > _UNKNOWN), by, np.inf)
    if not state.shape[1]:
        return drive, np.full(len(drive), -1)
    return drive, np.where(np.isfinite(urgent).any(axis=1), urgent.argmin(axis=1), -1)


def _latched(on: np.ndarray, off: np.ndarray) -> np.ndarray:
    """Return what holds from ``on`` until ``off``, ``(o, l)`` of bool each.

    >>> on_off = np.array([[0, 1, 0, 0], [0, 0, 0, 1]])[:, :, None] > 0
    >>> _latched(*on_off)[:, 0]
    array([False,  True,  True, False])
    """
    at = np.arange(len(on))[:, None]
    last = np.maximum.accumulate(np.where(on | off, at, -1), axis=0)
    return np.take_along_axis(on, np.maximum(last, 0), axis=0) & (last >= 0)


def _vague(life: xr.Dataset) -> np.ndarray:
    """Say of which limits the quantity, or the life that is left, is known badly, ``(a, l)``."""
    value = life.value.values
    half = (value[..., 2] - value[..., 0]) / 2.0
    way = np.abs(life.part_bound.values - life.new.values)
    unsure = ~(half <= _VAGUE * way)
    of, early, middle = life.part_limit.values, *np.moveaxis(life.steady.values[..., :2], -1, 0)
    every = [unsure[:, of == name].any(axis=1) for name in life.limit.values]
    badly = (early < _EARLY * middle) & (life.of.values != "record")
    return np.array(every, dtype=bool).reshape(-1, len(value)).T | badly


def steady(estimate: np.ndarray, operations: np.ndarray) -> np.ndarray:
    """Return what is told of an estimated operation, ``(a,)``, moved by evidence alone.

    >>> steady(np.array([500.0, 510, 380, 385]), np.array([100, 200, 300, 370])).tolist()
    [500.0, 500.0, 380.0, 380.0]

    Args:
        estimate: Operations by which to service, ``(a,)``; inf beyond the horizon, nan not known.
        operations: After which they were estimated, ``(a,)``.
    """
    told, given, found = np.inf, 0.0, []
    for new, operation in zip(estimate.tolist(), operations.tolist(), strict=True):
        room = max(1.0, min(_MOVES * (max(new, told) - operation), 1e12))
        apart = np.inf if np.isinf(new) or np.isinf(told) else abs(new - told)
        due = told <= operation  # stays so, unless there is more left than when that was told
        if apart > room and not np.isnan(new) and (not due or new - operation > given):
            told, given = new, new - operation
        found.append(told)
    return np.floor(np.array(found))


def _since(
    over: np.ndarray, beyond: np.ndarray, operations: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return since when limits are exceeded for sure, and since when likely, ``(l,)`` each."""
    certain, crossed = np.full((2, over.shape[1]), np.nan)
    for j in np.flatnonzero(over[-1]):
        first = len(over) - int(np.argmin(over[::-1, j])) if not over[:, j].all() else 0
        likely = np.nan_to_num(beyond[: first + 1, j]) >= _CLEAR
        begins = first + 1 - int(np.argmin(likely[::-1])) if not likely.all() else 0
        certain[j], crossed[j] = operations[first], operations[min(begins, first)]
    return certain, crossed
