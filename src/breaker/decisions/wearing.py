"""What wears: parameters and measured quantities whose slope surely differs from zero, steadily.

One counts as wearing once its slope differs from zero at 5 % for seven parameters together, and
until it has not done so by itself for a hundred operations, or a known event: it does not come and
go while an odd record makes a change seem possible.
"""

from collections.abc import Mapping

import numpy as np
import xarray as xr

from breaker.decisions.alarms import latched, latest

__all__ = ["drifts", "rates", "wearing", "with_measured"]

_SURE, _MAY_BE = 2.69, 1.645  # sds: 5 % for seven parameters together, and for one
_LASTING = 100  # operations in a row after which what is no longer sure is dropped
_HALF = 1.645  # sds in half a 90 % interval


def with_measured(
    trends: Mapping[str, xr.Dataset], measured: xr.Dataset | None
) -> dict[str, xr.Dataset]:
    """Return trends with one more source, "measured", whose slopes are percent of the first level.

    Args:
        trends: Whole trends by source.
        measured: What ``wear.follow_measured`` returns, if limits are on any.
    """
    if measured is None:
        return dict(trends)
    level = measured.level.transpose("operation", "followed").values
    known = np.isfinite(level)
    begin = np.abs(level[known.argmax(axis=0), np.arange(level.shape[1])])
    scale = xr.DataArray(100.0 / np.where(begin > 0, begin, np.nan), dims="followed")
    slopes = measured[["slope", "slope_interval"]] * scale
    slopes = slopes.rename(followed="parameter").transpose("operation", "parameter", ...)
    return {**trends, "measured": slopes.assign(event=measured.event)}


def drifts(trends: Mapping[str, xr.Dataset], operations: np.ndarray) -> dict[str, np.ndarray]:
    """Return the direction in which each parameter wears: 1 up, -1 down, 0 not, by source.

    Args:
        trends: What ``with_measured`` returns: with ``slope``, ``slope_interval`` and ``event``.
        operations: Numbers of the operations, ``(o,)``.

    Returns:
        Arrays ``(o, parameter)`` of int.
    """
    found = {}
    for source, trend in trends.items():
        data = trend[["slope", "slope_interval"]].reindex(operation=operations)
        sd = np.diff(data.slope_interval.values, axis=-1)[..., 0] / (2.0 * _HALF)
        with np.errstate(invalid="ignore", divide="ignore"):
            z = data.slope.values / sd
        anew = trend.event.reindex(operation=operations, fill_value="").values[:, None] != ""
        sure = {sign: sign * z > _SURE for sign in (1, -1)}
        up, down = (
            latched(on, anew | sure[-sign] | _lasts(sign * z < _MAY_BE, operations))
            for sign, on in sure.items()
        )
        found[source] = up.astype(int) - down
    return found


def _lasts(holds: np.ndarray, operations: np.ndarray) -> np.ndarray:
    """Say where something ``(o, k)`` has held for so many operations."""
    last = np.maximum(latest(~holds), 0)
    return holds & (operations[:, None] - operations[last] >= _LASTING)


def wearing(trends: Mapping[str, xr.Dataset], directions: Mapping[str, np.ndarray]) -> list[str]:
    """Name what wears after each operation, such as "both: f falls, L rises", ``(o,)``.

    Args:
        trends: As of ``drifts``.
        directions: What ``drifts`` returns.
    """
    told = []
    for rows in zip(*directions.values(), strict=True):
        words = []
        for source, row in zip(directions, rows, strict=True):
            names = trends[source].parameter.values
            each = [f"{names[j]} {'rises' if row[j] > 0 else 'falls'}" for j in np.flatnonzero(row)]
            words += [f"{source}: {', '.join(each)}"] if each else []
        told.append("; ".join(words))
    return told


def rates(
    trends: Mapping[str, xr.Dataset], directions: Mapping[str, np.ndarray], *, most: int = 3
) -> str:
    """Name what wears at the end, in percent per 1,000 operations, at most ``most`` per source."""
    words = []
    for source, rows in directions.items():
        trend = trends[source].isel(operation=-1)
        slopes = trend.slope.values
        steepest = np.argsort(-np.abs(slopes), kind="stable")
        names = trend.parameter.values
        each = [f"{names[j]} {_percent(slopes[j])}" for j in steepest if rows[-1, j]]
        words += [f"{source}: {', '.join(each[:most])}"] if each else []
    return "; ".join(words)


def _percent(value: float) -> str:
    return f"{value:+.0f} %" if abs(value) >= 10 else f"{value:+.2g} %"
