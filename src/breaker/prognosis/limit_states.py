"""How a drive stands to each of its limits after every operation: one vocabulary, one record each.

A limit is *now* where it is exceeded, or the operation has come by which to service, and stays so
until work on the drive; *plan* where the cheapest time of a service is within the planning horizon;
*healthy* before; and *unknown* where too little is known, or where a service would have to be
planned for a quantity that may be as new or at the limit. Such a limit hides no other.

A plan is told from when it is within the horizon, and moved by evidence alone: where the estimate
leaves it by a share of what is left, or the 5 % quantile of the operations left comes before it.

Shapes: ``o`` operations, ``a`` of them asked, ``l`` limits.
"""

from collections.abc import Mapping

import numpy as np
import xarray as xr
from scipy.special import ndtri

from breaker.prognosis.forecast import Future
from breaker.prognosis.service_plan import YEAR, Costs, Plan, plan

STATES = ("unknown", "healthy", "plan", "now")
"""States of a limit and of a drive, the most urgent last."""

_RAISE, _CLEAR = 0.95, 0.5  # probability from which a limit is exceeded, and crossed
_STAYS = 1.5  # planning horizons, within which a plan stays one,
_STEADY = 0.1  # share of the operations since new for which estimates must be beyond, to revoke it
_MOVES = 0.5  # share of what is left, by which an estimate leaves what is told,
_LATER = 0.01  # and of the operations since new, which a later date has to bring
_UNKNOWN, _HEALTHY, _PLAN, _NOW = range(len(STATES))


def standing(life: xr.Dataset, settings: Mapping, per_operation: np.ndarray) -> xr.Dataset:
    """Say how the drive stands.

    Args:
        life: What ``life_results.follow_life`` returns.
        settings: The section ``planning`` of the configuration.
        per_operation: Days from one operation to the next, of late, ``(o,)``; nan if not known.

    Returns:
        Dataset over ``operation`` and ``limit``: ``state``, number in ``STATES``; ``beyond``, the
        probability that it is exceeded; ``service_by``, inf without one; ``since``, the operation
        since when a service has been told, nan if none is; ``left``, by ``quantile``, operations;
        ``risk``, the probability to fail before the next inspection. Over ``operation`` the drive's
        own ``drive_state``, ``drive_since`` and ``drive_service_by``, and ``subject``, the limit
        that they are about (-1 without one). Over ``limit``: ``certain`` and ``crossed``, the first
        operation at which it is exceeded for sure, and from which on it is likelier than not, nan
        if not; ``rate`` and, over ``ahead``, ``extra``, as of ``service_plan.Plan``, at the end.
    """
    asked, operations = life.asked.values, life.operation.values
    work = life.start.values[life.work.values]
    at, shown = _last_asked(asked, operations, work)
    plans = _plans(life, Costs.from_settings(settings), per_operation, work)
    by, unsure = _services(life, settings, per_operation, plans.best, work)
    exceeded = _latched(life.beyond.values >= _RAISE, np.searchsorted(work, asked, side="right"))
    by, over, beyond = np.where(shown, by[at], np.inf), exceeded[at] & shown, life.beyond.values
    left = life.remaining.values[at] - (operations - asked[at])[:, None, None]
    told = (shown & (np.isfinite(by) | ~unsure[at]))[..., None]
    left = np.where(told, np.maximum(left, 0.0), np.nan)
    beyond = np.where(shown, beyond[at], np.nan)
    early = np.isnan(beyond) | (operations < life.attrs["told"])[:, None]
    state = _states(by, early | unsure[at], over, operations[:, None])
    by = np.where(over, np.minimum(by, _begun(over, operations[:, None])), by)
    drive, subject = _drive(state, np.where(np.isfinite(by), by, left[..., 1]))
    left, each = np.where(over[..., None], 0.0, left), ("operation", "limit")
    return xr.Dataset(
        {
            "state": (each, state.astype(np.int8)),
            "beyond": (each, beyond),
            "service_by": (each, by),
            "since": (each, _told(state, operations[:, None])),
            "left": ((*each, "quantile"), left),
            "risk": (each, np.where(np.isnan(left[..., 0]), np.nan, plans.risk[at])),
            **dict(zip(("certain", "crossed"), _since(over, beyond, operations), strict=True)),
            "rate": ("limit", plans.rate[-1]),
            "extra": (("limit", "ahead"), plans.extra[-1]),
            "drive_state": ("operation", drive.astype(np.int8)),
            "drive_service_by": ("operation", by.min(axis=1, initial=np.inf)),
            "drive_since": ("operation", _told(drive, operations)),
            "subject": ("operation", subject),
        },
        {name: life[name] for name in ("operation", "limit", "quantile")}
        | {"ahead": _future(life).ahead()},
        {"states": list(STATES)},
    )


def _last_asked(
    asked: np.ndarray, operations: np.ndarray, work: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Where an operation was asked last, ``(o,)``, and whether since the last work, ``(o, 1)``."""
    at = np.searchsorted(asked, operations, side="right") - 1
    done, when = np.searchsorted(work, operations, side="right"), asked[np.maximum(at, 0)]
    shown = (at >= 0) & (np.searchsorted(work, when, side="right") == done)
    return np.maximum(at, 0), shown[:, None]


def _states(
    by: np.ndarray, untold: np.ndarray, over: np.ndarray, operations: np.ndarray
) -> np.ndarray:
    """Return the state of each limit, ``(o, l)``, by when its service is told."""
    state = np.where(by <= operations, _NOW, np.where(np.isfinite(by), _PLAN, _HEALTHY))
    return np.where(over, _NOW, np.where(untold & np.isinf(by), _UNKNOWN, state))


def _future(life: xr.Dataset) -> Future:
    """What may become of the wear, as the life was judged by."""
    return Future(**{name: life.attrs[name] for name in Future._fields})


def _plans(life: xr.Dataset, costs: Costs, per_operation: np.ndarray, work: np.ndarray) -> Plan:
    """Plans of all limits, ``(a, l)`` and ``(a, l, ahead)``."""
    operations, asked = life.operation.values, life.asked.values
    place = np.searchsorted(operations, asked)
    past = np.maximum(asked - float(operations[0]), 1.0)
    last = np.append(operations[0], work)[np.searchsorted(work, asked, side="right")]
    about = {
        "age": np.maximum(asked - last, 1.0).astype(float),
        "days": per_operation[place],
        "spacing": past / np.maximum(place, 1),
    }
    future, lives = _future(life), np.moveaxis(life.lives.values, 1, 0)
    found = [plan(future, costs, each, past, **about) for each in lives]
    if not found:
        none = np.zeros((asked.size, 0))
        return Plan(none, none, np.zeros((asked.size, 0, future.ahead().size)), none)
    return Plan(*(np.stack(each, axis=1) for each in zip(*found, strict=True)))


def _services(
    life: xr.Dataset,
    settings: Mapping,
    per_operation: np.ndarray,
    best: np.ndarray,
    work: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """When to service, and what would have to be planned, but is not known, ``(a, l)`` each."""
    asked, known = life.asked.values, life.asked.values >= life.attrs["told"]
    days = per_operation[np.searchsorted(life.operation.values, asked)]
    horizon = np.fmax(settings["operations"], settings["years"] * YEAR / days)
    last = asked[:, None] + life.remaining.values[..., 0]
    vague, soon = _vague(life), best <= horizon[:, None]
    sure = known[:, None] & ~vague & ~np.isnan(best)
    done = np.searchsorted(work, asked, side="right")
    age = asked - np.append(life.operation.values[0], work)[done]
    by = planned(np.where(sure, asked[:, None] + best, np.nan), last, asked, horizon, done, age)
    return by, vague & soon


def _drive(state: np.ndarray, by: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the state of the drive and the limit that it is about, -1 without one, ``(o,)``."""
    by = np.nan_to_num(by, nan=np.inf, posinf=np.inf)
    drive = state.max(axis=1, initial=_UNKNOWN)
    urgent = np.where((state == drive[:, None]) & (state > _UNKNOWN), by, np.inf)
    if not state.shape[1]:
        return drive, np.full(len(drive), -1)
    return drive, np.where(np.isfinite(urgent).any(axis=1), urgent.argmin(axis=1), -1)


def _latched(on: np.ndarray, spell: np.ndarray) -> np.ndarray:
    """Return what holds from ``on`` until the spell is over, ``(a, l)`` of bool."""
    at = np.arange(len(on))[:, None]
    last = np.maximum.accumulate(np.where(on, at, -1), axis=0)
    return (last >= 0) & (spell[np.maximum(last, 0)] == spell[:, None])


def _begun(on: np.ndarray, operations: np.ndarray) -> np.ndarray:
    """Return the operation at which what is on began, ``(o, ...)``; 0 before the first."""
    begins = on & ~np.concatenate([np.zeros_like(on[:1]), on[:-1]])
    return np.maximum.accumulate(np.where(begins, operations, 0), axis=0)


def _told(state: np.ndarray, operations: np.ndarray) -> np.ndarray:
    """Return the operation since when a service has been told, ``(o, ...)``; nan if none is."""
    return np.where(state >= _PLAN, _begun(state >= _PLAN, operations), np.nan)


def _vague(life: xr.Dataset) -> np.ndarray:
    """Say of which limits a quantity may be both as new and at the limit, ``(a, l)``.

    An error that all readings share does not count, as it is none of the change since new.
    """
    new, bound, value = life.new.values, life.part_bound.values, life.value.values
    common, middle = ndtri(0.95) * life.common.values[..., None], value[..., 1:2]
    with np.errstate(divide="ignore", invalid="ignore"):
        apart = np.sqrt(np.maximum(np.square(value - middle) - common**2, 0.0))
        apart = middle + np.sign(value - middle) * apart
        changed = np.where(common > 0.0, apart, value)
        least, most = ((each - new[:, None]) / (bound - new)[:, None] for each in (changed, value))
    unsure = ~((least.min(axis=-1) > 0.0) | (most.max(axis=-1) < 1.0))
    of = life.part_limit.values
    every = [unsure[:, of == name].any(axis=1) for name in life.limit.values]
    return np.array(every, dtype=bool).reshape(-1, len(value)).T


def planned(
    estimate: np.ndarray,
    last: np.ndarray,
    operations: np.ndarray,
    horizon: np.ndarray,
    spell: np.ndarray,
    age: np.ndarray,
) -> np.ndarray:
    """Return by when to service, ``(a, l)``; inf while that is not within the planning horizon.

    Costs are flat, so a small change of the path moves their least from soon to never: a plan is
    revoked only by estimates beyond the horizon that last. What is due stays so until the next
    spell.

    >>> estimate, asked = np.array([900.0, 640, 660, 450, 460])[:, None], [100, 200, 300, 350, 355]
    >>> about = np.full(5, 500.0), np.zeros(5), np.zeros(5)
    >>> planned(estimate, estimate + 50, np.array(asked), *about)[:, 0].tolist()
    [inf, 640.0, 640.0, 450.0, 450.0]

    Args:
        estimate: Operations by which to service, ``(a, l)``; inf without one, nan not known.
        last: Operations that what is told must not exceed.
        operations: After which they were estimated, ``(a,)``.
        horizon: How many operations ahead a service is planned, ``(a,)``.
        spell: Number of the work on the drive that was done last, ``(a,)``.
        age: Operations since, ``(a,)``.
    """
    found = np.full(estimate.shape, np.inf)
    rows = list(zip(operations.tolist(), horizon, spell, age, strict=True))
    for j, columns in enumerate(zip(estimate.T.tolist(), last.T.tolist(), strict=True)):
        told, before, begun = np.inf, None, None
        for i, (new, most, (operation, ahead, work, old)) in enumerate(
            zip(*columns, rows, strict=True)
        ):
            told, before = told if work == before else np.inf, work
            earlier = rows[max(i - 1, 0)][0]
            left, moves, capped = new - operation, new - operation <= ahead, min(new, most)
            beyond = left > _STAYS * ahead
            begun = (operation if begun is None else begun) if beyond else None
            gone = beyond and operation - begun >= _STEADY * old
            if np.isfinite(told):
                far = abs(capped - told) > _MOVES * max(capped - operation, told - operation, 2.0)
                # Where it is about to come, all that is gained counts.
                far = (far and not beyond) or told - operation <= 1.5 * (operation - earlier)
                far &= capped < told or capped - told > _LATER * old
                moves = (far or gone or told > most) and told > operation
            if moves or (new == new and most <= operation < told):  # perhaps exceeded already
                stays = not gone and capped - operation <= _STAYS * ahead
                told = capped if stays or capped <= operation else np.inf
            found[i, j] = told
    return np.floor(found)


def _since(
    over: np.ndarray, beyond: np.ndarray, operations: np.ndarray
) -> tuple[tuple[str, np.ndarray], ...]:
    """Return since when limits are exceeded for sure, and since when likely, by ``limit``."""
    at = np.arange(len(over))[:, None]
    first = np.where(over, 0, at + 1).max(axis=0, initial=0)  # after the last that is not
    unlikely = (at <= first) & ~(beyond >= _CLEAR)
    begins = np.minimum(np.where(unlikely, at + 1, 0).max(axis=0, initial=0), first)
    places = np.minimum([first, begins], len(over) - 1)
    certain, crossed = np.where(over[-1], operations[places], np.nan)
    return ("limit", certain), ("limit", crossed)
