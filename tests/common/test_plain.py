"""Compiled code without numba: the same results, and divisions by zero as numpy has them."""

import sys

import numpy as np
import pytest

from breaker.common.computing import compiled, numba_or_plain


@pytest.fixture
def alone(monkeypatch):
    monkeypatch.setitem(sys.modules, "numba", None)


def loops(decorate):
    @decorate
    def total(values):
        found = 0.0
        for each in values:
            found += each * each
        return found

    return total


@pytest.mark.parametrize("late", [False, True])
def test_results_are_the_same(alone, late):
    values = np.arange(5.0)
    assert loops(compiled(late=late))(values) == loops(lambda function: function)(values) == 30.0


@pytest.mark.parametrize("late", [False, True])
@pytest.mark.parametrize("number", [float, np.float64])
def test_a_division_by_zero_is_as_of_numpy(alone, late, number):
    ratio = compiled(late=late)(lambda a, b: a / b)
    assert ratio(number(1.0), number(0.0)) == np.inf
    assert np.isnan(ratio(number(0.0), number(0.0)))


def test_options_of_numba_are_left_out(alone):
    njit, prange = numba_or_plain()
    assert njit(error_model="numpy", forceinline=True)(lambda: 3)() == 3
    assert njit(lambda: 4)() == 4
    assert prange is range


def test_with_numba_it_is_numba():
    njit, _ = numba_or_plain()
    assert njit.__module__.startswith("numba")
