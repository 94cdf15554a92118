"""Posteriors of single operations, in blocks of a life (paper, Fig. 10), and their coverage."""

import numpy as np
import xarray as xr

from breaker.quantities.parameters import NAMES

QUANTILES = (0.05, 0.5, 0.95)
_BLOCKS = 40  # at most, of about as many operations each


def blocks_of(inferred: xr.Dataset) -> xr.Dataset:
    """Sum up the posteriors of operations in blocks of a life.

    Args:
        inferred: Draws of the parameters, ``draws (operation, draw, output)``; nan where there is
            no posterior.

    Returns:
        Dataset over ``block``: ``value (block, parameter, quantile)``, the median over a block's
        operations of the quantiles of their posteriors, nan where none has one; ``first``, ``last``
        and ``operation``, numbers of the first and the last one and their middle; ``count``, how
        many there are, and ``answered``, how many of them have a posterior.
    """
    draws = inferred.draws.sel(output=list(NAMES)).transpose("operation", "draw", "output").values
    each = np.moveaxis(np.quantile(draws, QUANTILES, axis=1), 0, -1)
    there, numbers = np.isfinite(each).all(axis=(1, 2)), inferred.operation.values
    parts = np.array_split(np.arange(numbers.size), min(_BLOCKS, numbers.size))
    value = np.full((len(parts), *each.shape[1:]), np.nan)
    for k, part in enumerate(parts):
        if there[part].any():
            value[k] = np.median(each[part][there[part]], axis=0)
    first, last = (np.array([numbers[part[end]] for part in parts]) for end in (0, -1))
    return xr.Dataset(
        {
            "value": (("block", "parameter", "quantile"), value),
            "first": ("block", first),
            "last": ("block", last),
            "count": ("block", [part.size for part in parts]),
            "answered": ("block", [there[part].sum() for part in parts]),
        },
        {"parameter": list(NAMES), "quantile": list(QUANTILES)}
        | {"operation": ("block", (first + last) / 2)},
    )


def truth_in_blocks(blocks: xr.Dataset, truth: xr.DataArray) -> np.ndarray:
    """Return the mean true values ``(operation, parameter)`` in each block, ``(b, p)``."""
    values, numbers = truth.sel(parameter=list(NAMES)).values, truth.operation.values
    ends = zip(blocks["first"].values, blocks["last"].values, strict=True)
    return np.array([values[(numbers >= a) & (numbers <= b)].mean(axis=0) for a, b in ends])


def held(blocks: xr.Dataset, truth: xr.DataArray) -> np.ndarray:
    """Return the share of blocks with a posterior whose 90 % band holds the truth, ``(p,)``.

    Args:
        blocks: What ``blocks_of`` returns.
        truth: True values, ``(operation, parameter)``.

    Returns:
        The shares; nan where no block has a posterior.
    """
    low, _, high = np.moveaxis(blocks["value"].values, -1, 0)
    true = truth_in_blocks(blocks, truth)
    known = np.isfinite(low)
    inside = known & (low <= true) & (true <= high)
    with np.errstate(invalid="ignore"):
        return inside.sum(axis=0) / known.sum(axis=0)


def moved(values: np.ndarray) -> np.ndarray:
    """Return the change of values ``(b, p)`` from the first block to the last, percent, ``(p,)``.

    Of blocks that have one; nan where none has.
    """
    there = np.isfinite(values)
    first, last = there.argmax(axis=0), len(values) - 1 - there[::-1].argmax(axis=0)
    column = np.arange(values.shape[1])
    return 100.0 * (values[last, column] / values[first, column] - 1.0)
