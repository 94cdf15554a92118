"""Tables of how good a posterior is, one row an output."""

import numpy as np
import pandas as pd
import xarray as xr

from breaker.common.numerals import in_p
from breaker.paper.validation.calibration import coverage, judge_draws, judge_ranks, ranks
from breaker.paper.validation.diagnostics import scores
from breaker.quantities.parameters import NAMES, ONSET

_FAMILY_LEVEL = 0.01
_SAME = 1e-12  # variance of what does not vary


def quality(
    data: xr.Dataset,
    reader: xr.Dataset | None,
    limit: np.ndarray,
    *,
    prior_sd: np.ndarray,
    log: np.ndarray,
) -> pd.DataFrame:
    """Judge a validation: one row an output.

    Args:
        data: What ``amortised.validate`` returns.
        reader: The same from records that went through files, if there is one.
        limit: Mean contraction of an exact posterior, ``(q,)``.
        prior_sd: Prior sd of each output, ``(q,)``, in the scale of the next argument.
        log: Which outputs are judged by their logarithm, ``(q,)``.

    Returns:
        Columns ``calibration_p`` (uniform ranks) and ``calibrated``, whether the output is inside
        its band (see ``judge_ranks``), both again with ``_reader`` for records through files
        (missing without), ``z_mean``, ``z_sd``, ``contraction``, ``contraction_limit`` and their
        ``shortfall``, and ``coverage_50``, ``coverage_95``.
    """
    draws, truth = data.draws.values, data.truth.values
    judged = judge_draws(draws, truth)
    files = None if reader is None else judge_draws(reader.draws.values, reader.truth.values)
    wide = with_width(data)
    found = scores(wide.draws.values, wide.truth.values, prior_sd=prior_sd, log=log)
    covered = coverage(ranks(draws, truth), data.sizes["draw"], levels=(0.5, 0.95))
    return pd.DataFrame(
        {
            "output": data.output.values,
            "calibration_p": judged.p_values,
            "calibration_p_reader": np.nan if files is None else files.p_values,
            "calibrated": ~judged.outside,
            "calibrated_reader": pd.NA if files is None else ~files.outside,
            "z_mean": found.z_mean,
            "z_sd": found.z_sd,
            "contraction": found.mean_contraction,
            "contraction_limit": limit,
            "shortfall": limit - found.mean_contraction,
            "coverage_50": covered[0],
            "coverage_95": covered[1],
        }
    )


def family_quality(data: xr.Dataset, *, log: bool) -> pd.DataFrame:
    """Judge a network of a family on held-out drives: one row an output.

    Args:
        data: What ``training_rows.sample_rows`` returns.
        log: Whether parameters are judged by their logarithms.

    Returns:
        Columns ``output``, ``calibration_p`` and ``calibrated``, all outputs together at 99 %,
        ``coverage_90``, ``contraction`` (1 - mean square error of the posterior mean over the
        variance of the truth, nan where that does not vary), ``rms_error`` and ``half_width``, the
        median half width of 90 % intervals; both in the scale that an output is judged in.
    """
    draws, truth = data.draws.values, data.truth.values
    logs = log & np.isin(data.output.values, NAMES)
    draws, truth = (np.where(logs, np.log(np.where(logs, a, 1.0)), a) for a in (draws, truth))
    found = ranks(draws, truth)
    judged = judge_ranks(found, data.sizes["draw"], alpha=_FAMILY_LEVEL)
    error = draws.mean(axis=1) - truth
    low, high = np.quantile(draws, [0.05, 0.95], axis=1)
    spread = truth.var(axis=0)
    varies = spread > _SAME
    return pd.DataFrame(
        {
            "output": data.output.values,
            "calibration_p": judged.p_values,
            "calibrated": ~judged.outside,
            "coverage_90": coverage(found, data.sizes["draw"], levels=[0.9])[0],
            "contraction": 1.0 - np.square(error).mean(axis=0) / np.where(varies, spread, np.nan),
            "rms_error": np.sqrt(np.square(error).mean(axis=0)),
            "half_width": np.median(high - low, axis=0) / 2.0,
        }
    )


def parameters_of(data: xr.Dataset) -> xr.Dataset:
    """Return a validation without the times of the drive's own contact, which has no symbol."""
    return data.isel(output=np.isin(data.output.values, [*NAMES, ONSET.name]))


def with_width(data: xr.Dataset) -> xr.Dataset:
    """Return a validation without curves whose draws are all the same one; all if each is so.

    Such a posterior is of a record that was not resolved: it has a place, but neither sd nor score.
    """
    wide = (np.ptp(data.draws.values, axis=1) > 0.0).all(axis=1)
    return data.isel(curve=wide) if wide.any() else data


def quality_words(table: pd.DataFrame) -> str:
    """Describe a table of :func:`quality` in one line."""
    worst = table.loc[table.shortfall.idxmax()]
    files = ""
    if not table.calibration_p_reader.isna().any():
        files = f"; through files {_calibrated(table, '_reader')}"
    return (
        f"{_calibrated(table)}{files}; "
        f"z-score sd {table.z_sd.min():.3f} to {table.z_sd.max():.3f}; "
        f"largest shortfall of contraction {worst.shortfall:.3f} ({worst.output})"
    )


def _calibrated(table: pd.DataFrame, which: str = "") -> str:
    outside = table.output[~table[f"calibrated{which}"].astype(bool)]
    smallest = f"smallest {in_p(table[f'calibration_p{which}'].min())} of {len(table)}"
    if outside.empty:
        return f"calibrated ({smallest})"
    return f"NOT calibrated: {', '.join(outside)} ({smallest})"
