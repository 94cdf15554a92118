"""The trends of measured quantities, and when limits on them are first exceeded.

What a record itself shows is followed as parameters are (``changepoint``), each quantity by itself:
its level goes along a line that may bend or jump, and operations scatter about it. Errors are those
of the records, and one of reading that they share, as of a rest that is crept to: it does not
average out, nor does it hide a change. The model and its error do not enter.

Values are shares of the quantity's *unit*, so any quantity of a drive of any size has the same
prior. The unit is the median of the first values, or a hundred times their spread where that is
more, as of a small rebound. The prior's sd of a level is a tenth of it, as that of most parameters
is, and that of a slope follows from it as theirs do.

A limit is read from draws of the lines of its quantities, which are independent of each other.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import xarray as xr
from scipy.special import ndtri

from breaker.mechanism import Limit
from breaker.model import generator
from breaker.wear.changepoint import PER, Tracker
from breaker.wear.events import Event, started_anew
from breaker.wear.hypotheses import confirmed
from breaker.wear.lifetime import Horizon, Remaining, draw_lines
from breaker.wear.rows import QUANTILES, limit_coords, start_quantiles

__all__ = ["follow_measured"]

_SHARE = 0.1  # prior sd of a level, units of its quantity
_SHARED = 1.0  # sds of one record's error, that of reading which all records of a drive share
_SPREADS = 100.0  # of the first values, least unit
_NORMAL = 1.4826  # sd of a normal over the median of its distances from its median
_LEAST = 1e-6  # units, least error of a value
_DRAWS = 500  # lines of a prediction


class _Trend(NamedTuple):
    """What is known of a quantity after each operation, in its own unit; nan before any value.

    Attributes:
        lines: Draws of its level and its slope per operation, ``(o, d, 2)``.
        level, slope: Their 5, 50 and 95 % quantiles, slopes per thousand operations, ``(o, 3)``.
        scatter: sd from operation to operation, ``(o,)``.
        change_probability: Of a change that was not reported yet, ``(o,)``.
        alarm: Whether one is reported, ``(o,)``.
        start: Quantiles of where the last one that was reported began, by now, ``(o, 3)``.
    """

    lines: np.ndarray
    level: np.ndarray
    slope: np.ndarray
    scatter: np.ndarray
    change_probability: np.ndarray
    alarm: np.ndarray
    start: np.ndarray


def follow_measured(
    data: Mapping[str, xr.Dataset],
    limits: Sequence[Limit],
    settings: Mapping,
    seed: int,
    events: Mapping[int, Event] | None = None,
) -> xr.Dataset:
    """Follow the measured quantities of limits through all operations.

    Args:
        data: Of each motion, ``accepted (operation)``, ``measured`` and ``measured_sd (operation,
            quantity)``, as ``records.read_curves`` returns them.
        limits: Limits on measured quantities of these motions.
        settings: The section ``wear_model`` of the configuration.
        events: What was done before operations, by their number: any parameter may move any
            quantity, so level and slope start anew, the level alone where it was the transducer.

    Returns:
        Dataset over ``operation``: ``event``, ``remaining``, ``toward`` and ``beyond`` of each
        ``limit``, and the ``value`` of each ``part``, as in a trend. Over ``followed``, motion and
        quantity: ``level`` and ``slope`` (per thousand operations) with 90 % intervals, ``scatter``
        in ``followed_unit``; ``change_probability``, ``alarm`` and ``start_interval``, likewise.

    Example:
        >>> import yaml
        >>> from breaker.shipped import DEFAULTS
        >>> rng, n = np.random.default_rng(1), 300
        >>> values = 9.0 + 0.001 * np.arange(n) + 0.05 * rng.standard_normal(n)  # ms
        >>> both = {"measured": values, "measured_sd": np.full(n, 0.05)}
        >>> data = xr.Dataset(
        ...     {name: (("operation", "quantity"), each[:, None]) for name, each in both.items()}
        ...     | {"accepted": ("operation", np.ones(n, dtype=bool))},
        ...     {"operation": np.arange(n), "quantity": ["travel_time"]},
        ... )
        >>> slow = Limit("slow", "closing", (("travel_time", 9.5, True),), of="record")
        >>> settings = yaml.safe_load(DEFAULTS.read_text(encoding="utf-8"))["wear_model"]
        >>> found = follow_measured({"closing": data}, [slow], settings, 1)
        >>> float(found.remaining.sel(limit="slow", quantile=0.5)[-1].round(-2))  # in truth 201
        200.0
    """
    operations = np.unique(np.concatenate([each.operation.values for each in data.values()]))
    units = {
        (limit.motion, name): unit
        for limit in limits
        for name, unit in zip(limit.quantities, limit.units, strict=True)
    }
    trends = {}
    for motion, name in units:
        values, sds = _values(data[motion], name, operations)
        rng = generator(seed, "measured", motion, name)
        trends[motion, name] = _followed(operations, values, sds, settings, rng, events or {})
    known = ((events or {}).get(operation, Event("")).told(operation) for operation in operations)
    data = _dataset(operations, limits, units, trends, settings["horizon"])
    return data.assign(event=("operation", np.array([*known], dtype=str)))


def _dataset(
    operations: np.ndarray,
    limits: Sequence[Limit],
    units: Mapping[tuple[str, str], str],
    trends: Mapping[tuple[str, str], _Trend],
    farthest: int,
) -> xr.Dataset:
    """What ``follow_measured`` returns, of trends and units by motion and quantity."""
    lefts = [_left(each, trends, farthest) for each in limits]
    parts = [trends[limit.motion, name] for limit in limits for name in limit.quantities]
    by, of = ("limit", "operation"), ("followed", "operation")
    found = {
        "remaining": ((*by, "quantile"), [each.quantiles(QUANTILES) for each in lefts]),
        "toward": (by, [each.toward for each in lefts]),
        "beyond": (by, [each.beyond for each in lefts]),
        "value": (("part", "operation", "quantile"), [each.level for each in parts]),
    }
    for name in ("level", "slope"):
        ends = np.array([getattr(each, name) for each in trends.values()])
        found[name] = (of, ends[..., 1])
        found[f"{name}_interval"] = ((*of, "bound"), ends[..., [0, 2]])
    found["start_interval"] = ((*of, "quantile"), [each.start for each in trends.values()])
    for name in ("scatter", "change_probability", "alarm"):
        found[name] = (of, [getattr(each, name) for each in trends.values()])
    coords = {
        "operation": operations,
        "quantile": list(QUANTILES),
        "bound": ["lower", "upper"],
        "followed": [f"{motion} {name}" for motion, name in units],
        "followed_unit": ("followed", list(units.values())),
        **limit_coords(limits),
    }
    return xr.Dataset(found, coords).transpose("operation", ...)


def _values(data: xr.Dataset, name: str, operations: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Values of a quantity and their errors at operations, ``(o,)``, nan where there is none."""
    own = data[["measured", "measured_sd"]].sel(quantity=name).where(data.accepted)
    own = own.reindex(operation=operations)
    return own.measured.values, own.measured_sd.values


def _followed(
    operations: np.ndarray,
    values: np.ndarray,
    sds: np.ndarray,
    settings: Mapping,
    rng: np.random.Generator,
    events: Mapping[int, Event],
) -> _Trend:
    """Follow a quantity with its values and their errors, ``(o,)``, nan where there is none."""
    centre, unit, shared = _measure_of(values, sds, settings["baseline"])
    scale = _SHARE * unit  # of standardised values
    # A quantity is no linear function of what wears, so its slope changes without a change, too.
    tracker = Tracker.from_settings(settings, np.array([_SHARE]))
    tracker = replace(tracker, bend=settings["bend"])
    horizon = Horizon(settings["horizon"], rng.standard_normal((_DRAWS, 2)))
    order = rng.permutation(_DRAWS)  # draws of hypotheses are sorted, and alike in all quantities
    off = np.outer(shared * rng.standard_normal(_DRAWS), [1.0, 0.0])
    back, origin = scale * np.array([1.0, 1.0 / PER]), np.array([centre, 0.0])
    first = since = int(operations[0])
    hypotheses, seen = tracker.begin(first), 0
    found = _nothing(len(operations))
    for i, operation in enumerate(operations.tolist()):
        before, hypotheses = hypotheses, tracker.predict(hypotheses, operation)
        if seen and (event := events.get(operation, Event(""))).renews:
            which = [0] if event.parameters else []
            hypotheses = started_anew(tracker, hypotheses, which, jump=1.0)
            first = since = operation
        if learns := np.isfinite(values[i]):
            seen += 1
            error = max(sds[i], _LEAST * unit) / scale
            said = np.array([[error**-2]]), np.zeros(1), np.array([(values[i] - centre) / scale])
            hypotheses, _, _ = tracker.learn(hypotheses, *said)
        if not seen:
            continue
        mean, cov = hypotheses.level()
        sd = np.hypot(np.sqrt(np.diag(cov)), [shared / scale, 0.0])
        ends = mean[:, None] + sd[:, None] * ndtri(QUANTILES)
        found.lines[i] = origin + back * draw_lines(hypotheses, horizon)[order] + off
        found.level[i], found.slope[i] = centre + scale * ends[0], scale * ends[1]
        found.scatter[i] = unit * tracker.scatters[hypotheses.scatter] @ hypotheses.weight
        changed = found.change_probability[i] = confirmed(before, hypotheses, since)
        if learns and seen >= settings["settle"] and changed >= settings["alarm_level"]:
            found.alarm[i], since = True, operation
        began = hypotheses.began_within(first, since)
        found.start[i] = start_quantiles(hypotheses, began, first, since)
    return found


def _measure_of(values: np.ndarray, sds: np.ndarray, count: int) -> tuple[float, float, float]:
    """Where a quantity starts, its unit, and the error that its records share, by the first ones.

    >>> values, sds = np.array([9.0, np.nan, 9.2, 9.1]), np.full(4, 0.1)
    >>> tuple(round(each, 3) for each in _measure_of(values, sds, 100))
    (9.1, 14.826, 0.1)
    """
    first = np.flatnonzero(np.isfinite(values))[:count]
    if not first.size:
        return 0.0, 1.0, 0.0
    centre = float(np.median(values[first]))
    spread = _NORMAL * float(np.median(np.abs(values[first] - centre)))
    unit = max(abs(centre), _SPREADS * spread) or 1.0
    return centre, unit, _SHARED * float(np.median(sds[first]))


def _nothing(o: int) -> _Trend:
    """The trend of a quantity of which nothing is known yet."""
    shapes = (o, _DRAWS, 2), (o, 3), (o, 3), (o,), (o,)
    unknown = (np.full(shape, np.nan) for shape in shapes)
    return _Trend(*unknown, np.zeros(o, dtype=bool), np.full((o, 3), np.nan))


def _left(limit: Limit, trends: Mapping[tuple[str, str], _Trend], farthest: int) -> Remaining:
    """Remaining lives of a limit after each operation, in the place of limits ``(o, d)``.

    A part holds along a line from one operation on, or up to one; all of them from the last of the
    former on, if that is before the first of the latter.
    """
    lines = np.stack([trends[limit.motion, name].lines for name in limit.quantities], axis=-1)
    level, slope = lines[:, :, 0], lines[:, :, 1]  # (o, d, part)
    excess = limit.excess(level)
    rise = limit.excess(level + slope) - excess
    with np.errstate(divide="ignore", invalid="ignore"):
        turn = -excess / rise
    holds, nearer = excess > 0, rise > 0
    begins = np.where(holds, 0.0, np.where(nearer, np.floor(turn) + 1.0, np.inf)).max(axis=-1)
    ends = np.where(nearer, np.inf, np.where(holds, turn, 0.0)).min(axis=-1)
    begins = np.where((begins < ends) & (begins <= farthest), begins, np.inf)
    unknown = np.isnan(excess).any(axis=(1, 2))
    begins[unknown] = np.nan
    toward = np.where(unknown, np.nan, (holds | nearer).all(axis=-1).mean(axis=-1))
    return Remaining(begins, toward, level)
