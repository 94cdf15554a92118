"""Numbers of a run that texts state, and posteriors in blocks of an endurance test (Fig. 10).

The numbers form a flat table with one name per number, rounded as texts state it, such as
``closing.contraction.gamma_a`` for 0.96. README and pages take their numbers from the table of the
default run.
"""

from itertools import combinations

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import ArrayLike

from breaker.model.parameters import NAMES
from breaker.paper.calibration import family_p_value
from breaker.paper.validation import correlation, prior_check


def numbers_of_motion(
    *,
    quality: pd.DataFrame,
    exactness: pd.DataFrame,
    prior: xr.Dataset,
    validation: xr.Dataset,
    operations: xr.Dataset,
    predictive: xr.Dataset,
    family: xr.Dataset | None = None,
    truth: xr.Dataset | None = None,
) -> dict[str, str]:
    """Return the numbers of one motion by name, without the motion.

    Args:
        quality: Table of the quality of both posteriors.
        exactness: Table of the exactness, one row.
        prior: Curves of the prior, ``travel (curve, time)``.
        validation: Posteriors of simulated records.
        operations: Records of the endurance test, ``travel (operation, time)``, with posteriors by
            the paper's network.
        predictive: Predicted records at a few stages, with ``share_inside (stage)``.
        family: The same records, with posteriors by the family's network.
        truth: True parameters of the simulated test, ``value (operation, parameter)``; None for
            measured records.
    """
    used = operations.isel(operation=np.flatnonzero(operations.accepted.values))
    network = quality[quality.posterior == "amortised"].set_index("output")
    exact = exactness.iloc[0]
    inside = prior_check(prior.travel.values, used.travel.values).inside
    numbers = {
        **_each("contraction", network.contraction[list(NAMES)], 2),
        **_ends("coverage_95", 100 * network.coverage_95),
        "calibration_p": _p(family_p_value(network.calibration_p)),
        "efficiency_median": _written(100 * exact.efficiency_median, 0),
        "efficiency_lowest": _written(100 * exact.efficiency_lowest, 0),
        "gap": _written(exact.gap_nats, 2),
        **_of_correlations(validation.draws.sel(output=list(NAMES)).values),
        "prior_inside": _written(100 * inside.mean(), 0),
        "misfit": _written(100 * used.misfit.values.mean(), 0),
        **_ends("inside", 100 * predictive.share_inside.values),
    }
    if truth is not None:
        numbers |= _of_simulated_test(truth, blocks_of(operations), blocks_of(family))
    return numbers


def _of_correlations(draws: np.ndarray) -> dict[str, str]:
    """Return the median correlation of each pair of parameters within posteriors ``(n, d, p)``."""
    log = np.ones(len(NAMES), dtype=bool)
    median = np.median([correlation(draw, log=log) for draw in draws], axis=0)
    pairs = combinations(range(len(NAMES)), 2)
    return {f"correlation.{NAMES[i]}.{NAMES[j]}": _written(median[i, j], 2) for i, j in pairs}


def _of_simulated_test(truth: xr.Dataset, paper: xr.Dataset, family: xr.Dataset) -> dict[str, str]:
    """Return coverage in blocks, and changes of parameters, percent."""
    numbers = _each("true_change", moved(truth_in_blocks(paper, truth.value)), 1)
    numbers |= _each("paper_change", moved(paper["value"].sel(quantile=0.5).values), 1)
    for by, blocks in (("paper", paper), ("family", family)):
        numbers |= _each(f"{by}_holds", 100 * held(blocks, truth.value), 0)
    return numbers


def _written(value: float, digits: int) -> str:
    """Write a number with ``digits`` decimals, never -0."""
    return f"{round(float(value), digits) + 0.0:.{digits}f}"


def _p(value: float) -> str:
    """Write a probability with two significant digits, without an exponent."""
    return np.format_float_positional(float(value), precision=2, fractional=False, trim="-")


def _each(name: str, values: ArrayLike, digits: int) -> dict[str, str]:
    """Write a value for each parameter."""
    both = zip(NAMES, values, strict=True)
    return {f"{name}.{key}": _written(value, digits) for key, value in both}


def _ends(name: str, values: ArrayLike) -> dict[str, str]:
    ends = {"lowest": np.min(values), "highest": np.max(values)}
    return {f"{name}.{end}": _written(value, 0) for end, value in ends.items()}


# ---- blocks of operations ------------------------------------------------------------------------

QUANTILES = (0.05, 0.5, 0.95)


def blocks_of(inferred: xr.Dataset, most: int = 40) -> xr.Dataset:
    """Summarise posteriors, ``draws (operation, draw, output)``, in at most ``most`` blocks of a
    life with about equal numbers of operations; more blocks would overlap in a figure.

    Returns:
        Dataset over ``block``: ``value (block, parameter, quantile)``, the median over a block's
        operations of the quantiles of their posteriors, nan if no operation has a posterior;
        ``first``, ``last`` and ``operation``, numbers of the first and last operation and their
        mean; ``count``, operations in the block; ``answered``, operations with a posterior.
    """
    draws = inferred.draws.sel(output=list(NAMES)).transpose("operation", "draw", "output").values
    quantiles = np.moveaxis(np.quantile(draws, QUANTILES, axis=1), 0, -1)
    known, numbers = np.isfinite(quantiles).all(axis=(1, 2)), inferred.operation.values
    parts = np.array_split(np.arange(numbers.size), min(most, numbers.size))
    value = np.full((len(parts), *quantiles.shape[1:]), np.nan)
    for k, part in enumerate(parts):
        if known[part].any():
            value[k] = np.median(quantiles[part][known[part]], axis=0)
    first, last = (np.array([numbers[part[end]] for part in parts]) for end in (0, -1))
    return xr.Dataset(
        {
            "value": (("block", "parameter", "quantile"), value),
            "first": ("block", first),
            "last": ("block", last),
            "count": ("block", [part.size for part in parts]),
            "answered": ("block", [known[part].sum() for part in parts]),
        },
        {"parameter": list(NAMES), "quantile": list(QUANTILES)}
        | {"operation": ("block", (first + last) / 2)},
    )


def truth_in_blocks(blocks: xr.Dataset, truth: xr.DataArray) -> np.ndarray:
    """Return the means of true values ``(operation, parameter)`` in the blocks, ``(b, p)``."""
    values, numbers = truth.sel(parameter=list(NAMES)).values, truth.operation.values
    ends = zip(blocks["first"].values, blocks["last"].values, strict=True)
    return np.array([values[(numbers >= a) & (numbers <= b)].mean(axis=0) for a, b in ends])


def held(blocks: xr.Dataset, truth: xr.DataArray) -> np.ndarray:
    """Return the share of blocks with a posterior whose 90 % band contains the truth ``(operation,
    parameter)``, ``(p,)``; nan where no block has a posterior.
    """
    low, _, high = np.moveaxis(blocks["value"].values, -1, 0)
    true, known = truth_in_blocks(blocks, truth), np.isfinite(low)
    inside = known & (low <= true) & (true <= high)
    with np.errstate(invalid="ignore"):
        return inside.sum(axis=0) / known.sum(axis=0)


def moved(values: np.ndarray) -> np.ndarray:
    """Return the change of values ``(b, p)`` from the first finite block to the last, percent,
    ``(p,)``; nan where all values are nan.
    """
    known = np.isfinite(values)
    first, last = known.argmax(axis=0), len(values) - 1 - known[::-1].argmax(axis=0)
    column = np.arange(values.shape[1])
    return 100.0 * (values[last, column] / values[first, column] - 1.0)
