"""Compiled code, kept where there is a place for it, and the same results without numba."""

import sys

import numba
import numpy as np
import pytest
from numba.core import caching

from breaker.common.compiling import compiled


def half(x):
    return x / 2.0


def test_it_is_kept_for_later_processes(tmp_path, monkeypatch):
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path))
    assert compiled()(half)(3.0) == 1.5
    assert any(tmp_path.rglob("*.nbi"))
    monkeypatch.setattr(caching.CacheImpl, "_locator_classes", [])  # no place to keep it
    assert compiled()(half)(3.0) == 1.5


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
