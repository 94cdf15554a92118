"""Compiled code is kept where there is a place for it, and works where there is none."""

import numba
import pytest
from numba.core import caching

from breaker.mechanism.compiling import compiled


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
