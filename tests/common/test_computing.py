"""Compiled loops give the same results without numba."""

import sys

import numpy as np
import pytest

from breaker.common.compiling import compiled


@pytest.mark.parametrize("numba_is_there", [False, True])
def test_loops_and_divisions_are_those_of_numpy(monkeypatch, numba_is_there):
    if not numba_is_there:
        monkeypatch.setitem(sys.modules, "numba", None)

    @compiled()
    def total(values):
        result = 0.0
        for value in values:
            result += value * value
        return result

    assert total(np.arange(5.0)) == 30.0
    ratio = compiled()(lambda a, b: a / b)
    assert ratio(np.float64(1.0), np.float64(0.0)) == np.inf
    assert np.isnan(ratio(np.float64(0.0), np.float64(0.0)))
