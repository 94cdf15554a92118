"""The dataset of a fleet: for each drive its document and moments of its draws, for the ranking."""

from collections.abc import Sequence

import numpy as np
import xarray as xr

from breaker.common.plain_values import to_json
from breaker.drive.fleet.examination import Examined
from breaker.quantities.parameters import NAMES

_DRAWS = 500  # of a drive, which are kept


def stored(examined: Sequence[Examined]) -> xr.Dataset:
    """Return what is known of drives as a dataset: documents, and draws in few numbers.

    Returns:
        Dataset over ``drive``: ``document`` (JSON), ``count``, operations that were inferred,
        ``mean (drive, parameter)`` of the logarithms of their draws, ``squares (drive, parameter,
        parameter)``, the sum of products of the deviations of operations from it, and some draws,
        ``theta (drive, draw, parameter)``; nan of a drive of which nothing was inferred.
    """
    p = len(NAMES)
    mean, squares = np.full((len(examined), p), np.nan), np.zeros((len(examined), p, p))
    theta = np.full((len(examined), _DRAWS, p), np.nan, np.float32)
    for i, (_, draws) in enumerate(examined):
        if len(draws):
            each = np.log(draws).mean(axis=1)
            mean[i] = each.mean(axis=0)
            squares[i] = (each - mean[i]).T @ (each - mean[i])
            flat = draws.reshape(-1, p)
            theta[i] = flat[np.linspace(0, len(flat) - 1, _DRAWS).astype(int)]
    over = ("drive", "parameter")
    documents = np.array([to_json(each.document) for each in examined], dtype=str)
    return xr.Dataset(
        {
            "document": ("drive", documents),
            "count": ("drive", np.array([len(draws) for _, draws in examined])),
            "mean": (over, mean),
            "squares": ((*over, "other"), squares),
            "theta": (("drive", "draw", "parameter"), theta),
        },
        {"parameter": list(NAMES)},
    )
