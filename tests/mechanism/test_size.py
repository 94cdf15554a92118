"""Factors of sizes; that curves scale with them is tested by the quantities read from these."""

import numpy as np
import pytest

from breaker.model.parameters import PARAMETERS, Size, powers
from breaker.model.quantities import QUANTITIES


def test_factors_follow_from_units():
    size = Size(2.0, 4.0)
    assert [size.factor(unit) for unit in ("1", "mm", "ms", "mm/ms²")] == [1, 2, 4, 0.125]
    for quantity in (*PARAMETERS, *QUANTITIES.values()):
        assert size.factor(quantity.unit) > 0
    assert np.exp(np.log([2.0, 4.0]) @ powers()) == pytest.approx(size.factors)


@pytest.mark.parametrize("wrong", [(0.0, 1.0), (1.0, -1.0), (np.nan, 1.0), (1.0, np.inf)])
def test_no_size(wrong):
    with pytest.raises(ValueError, match="must be positive"):
        Size(*wrong)
