"""The quality of a posterior as a table, and in words."""

import numpy as np
import pandas as pd
import xarray as xr

from breaker.validation.calibration import calibration_p_values, coverage, family_p_value, ranks
from breaker.validation.diagnostics import scores

__all__ = ["quality", "words"]


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
        data: What ``inference.validate`` returns.
        reader: The same from records that went through files, if there is one.
        limit: Mean contraction of an exact posterior, ``(q,)``.
        prior_sd: Prior sd of each output, ``(q,)``, in the scale of the next argument.
        log: Which outputs are judged by their logarithm, ``(q,)``.

    Returns:
        Columns ``calibration_p`` (uniform ranks; see ``calibration_p_values``),
        ``calibration_p_reader`` (the same through files; nan without), ``z_mean``, ``z_sd``,
        ``contraction``, ``contraction_limit`` and their ``shortfall``, and ``coverage_50``,
        ``coverage_95``.
    """
    draws, truth = data.draws.values, data.truth.values
    d = data.sizes["draw"]
    rank = ranks(draws, truth)
    judged = scores(draws, truth, prior_sd=prior_sd, log=log)
    covered = coverage(rank, d, levels=(0.5, 0.95)).observed
    p_reader = np.full(len(limit), np.nan)
    if reader is not None:
        through_files = ranks(reader.draws.values, reader.truth.values)
        p_reader = calibration_p_values(through_files, d)
    return pd.DataFrame(
        {
            "output": data.output.values,
            "calibration_p": calibration_p_values(rank, d),
            "calibration_p_reader": p_reader,
            "z_mean": judged.z_mean,
            "z_sd": judged.z_sd,
            "contraction": judged.mean_contraction,
            "contraction_limit": limit,
            "shortfall": limit - judged.mean_contraction,
            "coverage_50": covered[0],
            "coverage_95": covered[1],
        }
    )


def words(table: pd.DataFrame) -> str:
    """Say what a table of ``quality`` shows, in one line."""
    worst = table.loc[table.shortfall.idxmax()]
    spread = f"{table.z_sd.min():.3f} to {table.z_sd.max():.3f}"
    files = ""
    if not table.calibration_p_reader.isna().any():
        files = f", through files {family_p_value(table.calibration_p_reader):.2g}"
    return (
        f"calibration p of all outputs together {family_p_value(table.calibration_p):.2g}{files}; "
        f"z-score sd {spread}; largest shortfall of contraction {worst.shortfall:.3f} "
        f"({worst.output})"
    )
