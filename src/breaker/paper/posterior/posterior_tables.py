"""Posteriors as tables: intervals, one row per operation and output, how exact a network is.

Works on datasets alone, so that steps that only read posteriors import neither torch nor numba.
"""

import numpy as np
import pandas as pd
import xarray as xr

from breaker.quantities.operation_metadata import metadata_names

_INTERVALS = {"interval_50": (0.25, 0.75), "interval_95": (0.025, 0.975)}

_OF_RESULT = ("p_value", "misfit", "outside_prior", "outside_support", "accepted", "reason")
_OF_RECORD = ("file", "remarks", "missing", "masked", "far_onset", "family")
_MEASURED = ("contact_time", "contact_sd", "latch_time")  # where any operation has them


def quantiles(draws: np.ndarray, *, axis: int) -> dict[str, np.ndarray]:
    """Return median and central intervals of draws, without the axis of the draws.

    Returns:
        ``median (...)``, ``interval_50`` and ``interval_95``, ``(..., 2)``: lower and upper bound.

    Example:
        >>> quantiles(np.arange(101.0), axis=0)["interval_50"].tolist()
        [25.0, 75.0]
    """
    levels = np.quantile(draws, [0.5, *sum(_INTERVALS.values(), ())], axis=axis)
    bounds = np.moveaxis(levels[1:], 0, -1)
    pairs = {name: bounds[..., 2 * i : 2 * i + 2] for i, name in enumerate(_INTERVALS)}
    return {"median": levels[0], **pairs}


def intervals(draws: np.ndarray) -> dict[str, xr.DataArray]:
    """Return ``median``, ``interval_50`` and ``interval_95`` of draws ``(o, d, q)``, with names."""
    bounds = {"dims": ("operation", "output", "bound"), "coords": {"bound": ["lower", "upper"]}}
    median, *pairs = quantiles(draws, axis=1).items()
    named = {"median": xr.DataArray(median[1], dims=("operation", "output"))}
    return named | {name: xr.DataArray(each, **bounds) for name, each in pairs}


def share_inside(
    values: np.ndarray, lower: np.ndarray, upper: np.ndarray, *, where: np.ndarray | bool = True
) -> np.ndarray:
    """Return the share of the last axis on which values lie in their band, ``(..., t) -> (...)``.

    Args:
        values: Measured curves; NaN where a sample is missing, which does not count.
        lower: Lower bound, same shape.
        upper: Upper bound, same shape.
        where: Samples that count, such as those of the main motion; all of them by default.

    Returns:
        The shares; NaN where no sample counts.
    """
    values = np.asarray(values)
    inside, counts = (values >= lower) & (values <= upper), ~np.isnan(values) & where
    with np.errstate(invalid="ignore"):
        return (inside & counts).sum(axis=-1) / counts.sum(axis=-1)


def table(result: xr.Dataset) -> pd.DataFrame:
    """Return one tidy row for each operation and output of what ``infer`` returns."""
    units = dict(zip(result.output.values, result.output_unit.values, strict=True))
    frame = result["median"].to_dataframe(name="median")[["median"]]
    for name in _INTERVALS:
        for bound in ("lower", "upper"):
            values = result[name].sel(bound=bound, drop=True)
            frame[f"{name}_{bound}"] = values.to_series()
    frame = frame.reset_index()
    frame.insert(2, "unit", frame.output.map(units))
    measured = (name for name in _MEASURED if name in result and result[name].notnull().any())
    columns = [
        *(n for n in (*_OF_RESULT, *_OF_RECORD) if n in result),
        *measured,
        *metadata_names(result),
    ]
    return frame.merge(result[columns].to_dataframe()[columns].reset_index(), on="operation")


def summary(judged: xr.Dataset, corrected: xr.Dataset) -> pd.DataFrame:
    """Sum up what ``judge`` and ``correct_validation`` return, in one row.

    The gap's standard error is that of a mean over curves. Curves whose evidence is not resolved
    have no gap, and those with faulty weights no efficiency: they are left out of these numbers
    (an infinite gap is not), and ``gap_curves`` and ``faulty_curves`` say how many there are.
    """
    gap = judged["gap"].values[judged.resolved.values & ~np.isnan(judged["gap"].values)]
    sound = judged.isel(curve=judged.faulty_weights.values == 0)
    efficiency = sound.efficiency.values if sound.sizes["curve"] else np.array([np.nan])
    numbers = {
        "motion": judged.attrs["motion"],
        "judged_curves": judged.sizes["curve"],
        "faulty_curves": judged.sizes["curve"] - sound.sizes["curve"],
        "efficiency_median": np.median(efficiency),
        "efficiency_10_percent": np.quantile(efficiency, 0.1),
        "efficiency_lowest": efficiency.min(),
        "pareto_k_below_0.7": np.mean(judged.pareto_k.values < 0.7),
        "gap_curves": gap.size,
        "gap_nats": gap.mean() if gap.size else np.nan,
        "gap_se": gap.std(ddof=1) / np.sqrt(gap.size) if gap.size > 1 else np.nan,
        "divergence_nats": sound.divergence.values.mean() if sound.sizes["curve"] else np.nan,
        "c2st_median": np.median(sound.c2st.values) if sound.sizes["curve"] else np.nan,
        "truth_log_density": judged.truth_log_density.values.mean(),
        "corrected_curves": corrected.sizes["curve"],
        "resolved": corrected.resolved.values.mean(),
        "corrected_efficiency_median": np.nanmedian(corrected.efficiency.fillna(0.0).values),
        "rounds_mean": corrected.rounds.values.mean(),
    }
    return pd.DataFrame({name: [value] for name, value in numbers.items()})
