"""Compiled code is kept where there is a place for it, and works where there is none."""

import numba
import numpy as np
import pytest
from numba.core import caching

from breaker.common.computing import compiled


def half(x):
    return x / 2.0


def test_it_is_kept_for_later_processes(tmp_path, monkeypatch):
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path))
    assert compiled()(half)(3.0) == 1.5
    assert any(tmp_path.rglob("*.nbi"))


def test_it_works_where_nothing_can_be_kept(monkeypatch):
    monkeypatch.setattr(caching.CacheImpl, "_locator_classes", [])
    with pytest.raises(RuntimeError, match="cannot cache"):
        numba.njit(cache=True)(half)
    assert compiled()(half)(3.0) == 1.5


def test_what_is_compiled_late_gives_the_same(monkeypatch):
    late = compiled(late=True)(half)
    calls = compiled()(lambda x: late(x) + 1.0)  # compiled code calls it compiled
    monkeypatch.setattr(type(late), "left", 10)
    assert late(np.array([3.0])) == 1.5
    assert "fast" not in vars(late)
    assert late(np.ones(9))[0] == 0.5
    assert "fast" in vars(late)
    assert calls(3.0) == 2.5


def test_a_division_by_zero_is_inf_before_and_after():
    late = compiled(late=True)(lambda x: 1.0 / x)
    assert late(0.0) == late.fast(0.0) == np.inf
