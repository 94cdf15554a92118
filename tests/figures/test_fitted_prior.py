"""The figure of a fitted prior: a panel for each parameter, with its breakers."""

from types import SimpleNamespace

import numpy as np
import pytest

from breaker.figures import style
from breaker.figures.reports import fitted_prior
from breaker.model.prior import Prior
from tests.figures.drawn import assert_drawn, line_of

MEDIANS = np.array([2.0, 0.045, 0.040, 0.30, 0.12, 0.75, 10.0])


@pytest.mark.parametrize("breakers", [1, 40])
def test_a_panel_has_the_medians_of_its_breakers(breakers):
    middle = MEDIANS * np.exp(0.05 * np.arange(breakers))[:, None]
    fitted = SimpleNamespace(
        prior=Prior(1.1 * MEDIANS, np.full(7, 0.1)),
        reference=Prior(MEDIANS, np.full(7, 0.1)),
        names=[f"Q{i}" for i in range(breakers)],
        drawn=SimpleNamespace(theta=middle[:, None] * np.linspace(0.9, 1.1, 3)[:, None]),
    )
    figure = fitted_prior(fitted)
    assert_drawn(figure)
    for k, axis in enumerate(figure.axes):
        np.testing.assert_allclose(line_of(axis, style.MODEL).get_xdata(), middle[:, k])
