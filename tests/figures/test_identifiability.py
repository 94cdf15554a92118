"""The figure of identifiability: contraction of every source where it is, and in numbers."""

import pytest

from breaker.figures.exactness import identifiability
from breaker.paper import validation as comparison
from tests.figures.drawn import assert_drawn
from tests.validation.made import NAMES, contractions


@pytest.mark.parametrize(("outputs", "shift"), [(8, 0.0), (7, 0.5)], ids=["usual", "below zero"])
def test_a_posterior_wider_than_its_prior_is_in_sight(outputs, shift):
    """Also without an onset, and of a posterior wider than its prior, which stays in sight."""
    values = contractions(NAMES[:outputs], shift=shift)
    values.pop("drive")
    found = comparison.reached(values, NAMES[:outputs])
    figure = identifiability(found, motion="closing")
    assert figure.axes[0].get_xlim()[0] <= min(0.0, found.lower.values.min())
    assert_drawn(figure)
