"""The figure of a fitted prior: a panel for each parameter, with its breakers."""

import numpy as np
import pytest
import xarray as xr

from breaker.figures.fitted_prior import fitted_prior
from breaker.quantities.parameters import NAMES
from tests.figures.drawn import assert_drawn

MEDIANS = np.array([2.0, 0.045, 0.040, 0.30, 0.12, 0.75, 10.0])


@pytest.mark.parametrize("breakers", [1, 3, 40])
def test_a_fitted_prior_is_drawn_as_it_was(breakers):
    middle = MEDIANS * np.exp(0.05 * np.arange(breakers))[:, None]
    by_kind = {"median": np.array([1.1 * MEDIANS, MEDIANS]), "log_sd": np.full((2, 7), 0.1)}
    by_breaker = {"low": 0.9 * middle, "middle": middle, "high": 1.1 * middle}
    data = xr.Dataset(
        {name: (("kind", "parameter"), each) for name, each in by_kind.items()}
        | {name: (("breaker", "parameter"), each) for name, each in by_breaker.items()},
        {
            "kind": ["fitted", "default"],
            "breaker": [f"Q{i}" for i in range(breakers)],
            "parameter": list(NAMES),
        },
    )
    assert_drawn(fitted_prior(data), f"fitted prior of {breakers}")
