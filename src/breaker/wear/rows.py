"""The results that are stored for each operation of a trend: names, dims and values."""

from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr
from scipy.special import ndtri

from breaker.mechanism import NAMES, Limit
from breaker.model import Prior
from breaker.wear.changepoint import KINDS, Tracker
from breaker.wear.hypotheses import Hypotheses
from breaker.wear.learned import PHASES
from breaker.wear.lifetime import Horizon, Remaining
from breaker.wear.state import State

__all__ = ["QUANTILES", "age_bins", "dataset", "limit_coords", "row", "start_quantiles"]

QUANTILES = (0.05, 0.5, 0.95)
"""Quantiles of everything that is stored."""

_HALF = 1.6449  # sds of a normal in half its 90 % interval
_PER_CENT = 100.0
_NODES = ndtri((np.arange(20) + 0.5) / 20)  # equally probable points of a standard normal

Row = Mapping[str, tuple[tuple[str, ...], np.ndarray]]
"""Dims, without the operation, and value of everything that is stored, by name."""


def age_bins(last: int) -> np.ndarray:
    """Return the edges of the ages in which run lengths are counted, operations, geometric."""
    return np.concatenate([[0.0], np.geomspace(1.0, max(last, 2), 60), [np.inf]])


def row(
    state: State, left: Remaining, tracker: Tracker, prior: Prior, horizon: Horizon
) -> dict[str, tuple[tuple[str, ...], np.ndarray]]:
    """Return the levels, slopes, change and remaining lives after an operation.

    Levels are in the units of the parameters, slopes and scatter in percent, slopes per thousand
    operations. Intervals are of 90 %.
    """
    p, h = len(NAMES), state.hypotheses
    mean, cov = h.level()
    half = _HALF * np.sqrt(np.diag(cov))
    ends = np.stack([mean - half, mean, mean + half])  # (3, 2 p)
    levels, slopes = prior.destandardise(ends[:, :p]), _PER_CENT * prior.log_sds * ends[:, p:]
    began = h.began_within(state.first, state.since)  # by the last alarm
    kinds = np.bincount(h.kind + 1, began, len(KINDS) + 1)[1:]
    unknown = np.full(len(KINDS), np.nan)
    ages = np.histogram(h.operation - h.start, age_bins(horizon.operations), weights=h.weight)[0]
    return {
        "level": (("parameter",), levels[1]),
        "level_interval": (("parameter", "bound"), levels[[0, 2]].T),
        "slope": (("parameter",), slopes[1]),
        "slope_interval": (("parameter", "bound"), slopes[[0, 2]].T),
        "scatter": ((), _PER_CENT * tracker.scatters[h.scatter] @ h.weight),
        "run_length_probability": (("age",), ages),
        "start_interval": (("quantile",), start_quantiles(h, began, state.first, state.since)),
        "kind_probability": (("kind",), kinds / began.sum() if began.sum() > 0 else unknown),
        "remaining": (("limit", "quantile"), left.quantiles(QUANTILES)),
        "toward": (("limit",), left.toward),
        "beyond": (("limit",), left.beyond),
        "value": (("part", "quantile"), np.quantile(left.now, QUANTILES, axis=0).T),
    }


def dataset(
    operations: np.ndarray,
    rows: Sequence[Row],
    limits: Sequence[Limit],
    last: int,
    motions: Sequence[str],
) -> xr.Dataset:
    """Put the rows of operations ``(o,)`` into one dataset.

    Args:
        rows: At least one.
        last: Age of the last bin of run lengths, operations.
    """
    edges = age_bins(last)
    coords = {
        "operation": operations,
        "parameter": list(NAMES),
        "phase": [f"{motion} {phase}" for motion in motions for phase in PHASES],
        "bound": ["lower", "upper"],
        "kind": list(KINDS),
        "quantile": list(QUANTILES),
        **limit_coords(limits),
        "age_lower": ("age", edges[:-1]),
        "age_upper": ("age", edges[1:]),
    }
    data = {
        name: (("operation", *dims), np.array([row[name][1] for row in rows]))
        for name, (dims, _) in rows[0].items()
    }
    return xr.Dataset(data, coords=coords)


def limit_coords(limits: Sequence[Limit]) -> dict[str, object]:
    """Return the coordinates of limits and of their parts."""
    parts = [(limit, part) for limit in limits for part in limit.parts]
    return {
        "limit": [limit.name for limit in limits],
        "words": ("limit", [limit.words for limit in limits]),
        "part_limit": ("part", [limit.name for limit, _ in parts]),
        "part_quantity": ("part", [quantity for _, (quantity, _, _) in parts]),
        "part_bound": ("part", [bound for _, (_, bound, _) in parts]),
        "part_upper": ("part", [is_upper for _, (_, _, is_upper) in parts]),
    }


def start_quantiles(h: Hypotheses, began: np.ndarray, earliest: int, latest: int) -> np.ndarray:
    """Median and 90 % interval of the segment's beginning, ``(3,)``, operations.

    A hypothesis that others were merged into stands for a normal of their starts. None began before
    the first operation or after its alarm. It may be the change of an earlier alarm, noticed again.
    """
    apart = np.sqrt(h.start_variance)[:, None] * _NODES
    starts = np.clip(h.start[:, None] + apart, earliest, latest)
    return _quantiles(starts.ravel(), np.repeat(began, _NODES.size), QUANTILES)


def _quantiles(values: np.ndarray, weight: np.ndarray, shares: Sequence[float]) -> np.ndarray:
    """Quantiles of weighted values, nan where nothing has a weight."""
    if not weight.sum() > 0:
        return np.full(len(shares), np.nan)
    order = np.argsort(values, kind="stable")
    ladder = np.cumsum(weight[order]) / weight.sum()
    place = np.minimum(np.searchsorted(ladder, shares), len(values) - 1)
    return values[order][place].astype(float)
