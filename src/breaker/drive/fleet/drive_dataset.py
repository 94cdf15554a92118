"""The dataset of a fleet: for each drive its document and moments of its draws, for the ranking."""

from collections.abc import Sequence

import numpy as np
import xarray as xr

from breaker.common.plain_values import to_json
from breaker.drive.answers.type_model import TypeDraws
from breaker.drive.fleet.examination import Examined
from breaker.quantities.parameters import NAMES


def stored(examined: Sequence[Examined]) -> xr.Dataset:
    """Return what is known of drives as a dataset: documents, and draws in few numbers.

    Returns:
        Dataset over ``drive``: ``document`` (JSON), ``count``, operations that were inferred,
        ``mean (drive, parameter)`` of the logarithms of their draws, ``squares (drive, parameter,
        parameter)``, the sum of products of the deviations of operations from it, and some draws,
        ``theta (drive, draw, parameter)``; nan of a drive of which nothing was inferred.
    """
    nothing = np.full((1, 1, len(NAMES)), np.nan)
    found = TypeDraws.of(each.theta if len(each.theta) else nothing for each in examined)
    over = ("drive", "parameter")
    documents = np.array([to_json(each.document) for each in examined], dtype=str)
    return xr.Dataset(
        {
            "document": ("drive", documents),
            "count": ("drive", np.array([len(draws) for _, draws in examined])),
            "mean": (over, found.mean),
            "squares": ((*over, "other"), np.nan_to_num(found.squares)),
            "theta": (("drive", "draw", "parameter"), found.theta.astype(np.float32)),
        },
        {"parameter": list(NAMES)},
    )
