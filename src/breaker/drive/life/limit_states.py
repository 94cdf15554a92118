"""How a drive stands to each of its limits after every operation: one vocabulary, one record each.

A limit is *now* where it is exceeded, or the operation has come by which to service; *plan* where
that is within the planning horizon; *healthy* before; and *unknown* where too little is known:
before the drive was followed long enough, without records, or where a service would have to be
planned for a quantity, or a life, that is known too badly. Such a limit is told apart, with its
probability, and hides no other; what is left to it is not told.

The operation by which to service is after a share of what is left for almost sure. It is told from
when it is within the horizon, and moved by evidence alone: where the estimate leaves it by a share
of what is left.

Shapes: ``o`` operations, ``a`` of them asked, ``l`` limits.
"""

from collections.abc import Mapping

import numpy as np
import xarray as xr

from breaker.mechanism.limit_sources import SOURCES

STATES = ("unknown", "healthy", "plan", "now")
"""States of a limit and of a drive, the most urgent last."""

_RAISE, _CLEAR = 0.95, 0.5  # probability from which a limit is exceeded, and below which no more
_VAGUE = 0.3  # half a 90 % interval over the way to a limit, from which the limit cannot be told
_EARLY = 0.6  # life that is left for almost sure over that left by half, below which it is vague
_STAYS = 1.5  # planning horizons, within which a plan stays one
_MOVES = 0.5  # share of what is left, by which an estimate leaves what is told,
_LATER = 0.05  # and of the planning horizon, which a later date has to bring
_UNKNOWN, _HEALTHY, _PLAN, _NOW = range(len(STATES))


def standing(life: xr.Dataset, settings: Mapping, per_operation: np.ndarray) -> xr.Dataset:
    """Say how the drive stands.

    Args:
        life: What ``life_results.follow_life`` returns.
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
    at = np.searchsorted(asked, operations, side="right") - 1
    shown, at = (at >= 0)[:, None], np.maximum(at, 0)
    by, badly, soon = _services(life, settings, per_operation)
    by, over = np.where(shown, by[at], np.inf), exceeded[at] & shown
    gone = (operations - asked[at])[:, None, None]
    left = np.maximum(life.remaining.values[at] - gone, 0.0)
    left = np.where((shown & (np.isfinite(by) | ~badly[at]))[..., None], left, np.nan)
    beyond = np.where(shown, beyond[at], np.nan)
    unknown = np.isnan(beyond) | (operations < life.attrs["told"])[:, None] | soon[at]
    state = np.where(by <= operations[:, None], _NOW, np.where(np.isfinite(by), _PLAN, _HEALTHY))
    state = np.where(unknown & np.isinf(by), _UNKNOWN, state)
    state = np.where(over, _NOW, state)
    begins = over & ~np.vstack([np.zeros((1, over.shape[1]), dtype=bool), over[:-1]])
    since = np.maximum.accumulate(np.where(begins, operations[:, None], 0), axis=0)
    by = np.where(over, np.minimum(by, since), by)
    certain, crossed = _since(over, beyond, operations)
    next_ = np.nan_to_num(np.where(np.isfinite(by), by, left[..., 1]), nan=np.inf, posinf=np.inf)
    drive, subject = _drive(state, next_)
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


def _services(
    life: xr.Dataset, settings: Mapping, per_operation: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """When to service, what is known too badly, and would have to be planned, ``(a, l)`` each."""
    asked = life.asked.values
    days = per_operation[np.searchsorted(life.operation.values, asked)]
    horizon = np.fmax(settings["operations"], settings["years"] * 365.25 / days)
    badly, early = _vague(life), life.steady.values[..., 0]
    due = asked[:, None] + np.where(np.isfinite(early), life.attrs["margin"] * early, early)
    known = (asked >= life.attrs["told"])[:, None] & ~badly
    soon = badly & (due - asked[:, None] <= horizon[:, None])
    return planned(np.where(known, due, np.nan), asked, horizon), badly, soon


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
    inferred = [SOURCES[of].inferred for of in life.of.values.tolist()]
    badly = (early < _EARLY * middle) & np.array(inferred, dtype=bool)
    return np.array(every, dtype=bool).reshape(-1, len(value)).T | badly


def planned(estimate: np.ndarray, operations: np.ndarray, horizon: np.ndarray) -> np.ndarray:
    """Return by when to service, ``(a, l)``; inf while that is not within the planning horizon.

    A date is told once an estimate is within the horizon, and moved by evidence alone.

    >>> estimate = np.array([900.0, 640, 660, 450, 460])[:, None]
    >>> planned(estimate, np.array([100, 200, 300, 350, 355]), np.full(5, 500.0))[:, 0].tolist()
    [inf, 640.0, 640.0, 450.0, 450.0]

    Args:
        estimate: Operations by which to service, ``(a, l)``; inf without one, nan not known.
        operations: After which they were estimated, ``(a,)``.
        horizon: How many operations ahead a service is planned, ``(a,)``.
    """
    found = np.full(estimate.shape, np.inf)
    for j, column in enumerate(estimate.T.tolist()):
        told, given = np.inf, 0.0
        for i, (new, operation, ahead) in enumerate(zip(column, operations, horizon, strict=True)):
            left, moves = new - operation, new - operation <= ahead
            if np.isfinite(told):
                far = abs(new - told) > _MOVES * max(left, told - operation, 2.0)
                far &= new < told or new - told > _LATER * ahead
                # What is due stays so, unless there is more left than when that was told.
                moves = (far or left > _STAYS * ahead) and (left > given or told > operation)
            if moves:
                told, given = new if left <= _STAYS * ahead else np.inf, left
            found[i, j] = told
    return np.floor(found)


def _since(
    over: np.ndarray, beyond: np.ndarray, operations: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return since when limits are exceeded for sure, and since when likely, ``(l,)`` each."""
    at = np.arange(len(over))[:, None]
    first = np.where(over, 0, at + 1).max(axis=0, initial=0)  # after the last that is not
    unlikely = (at <= first) & ~(beyond >= _CLEAR)
    begins = np.minimum(np.where(unlikely, at + 1, 0).max(axis=0, initial=0), first)
    places = np.minimum([first, begins], len(over) - 1)
    certain, crossed = np.where(over[-1], operations[places], np.nan)
    return certain, crossed
