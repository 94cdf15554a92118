"""Linear modes against matrix exponentials, zeros of polynomials, and compiled code kept fresh."""

import os
import subprocess
import sys
from math import comb
from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import expm

from breaker.mechanism import curves as mechanism
from breaker.mechanism import modes, sensitivities, tangents
from breaker.model.randomness import generator


def system(mode):
    """Matrix (4, 4) of a mode."""
    m0, m1, m2, m3, m4, m5, _ = mode
    return np.array([[0, 1, 0, 0], [-m0, -m1, m2, m3], [0, 0, 0, 1], [m4, m5, -m4, -m5]])


@pytest.mark.parametrize("free", [True, False])
def test_rows_and_exponentials(prior, free):
    """The norm of A h in coordinates scaled by mass is at most 1.8; so rounding is some 1e-15 times
    exp(1.8), times the scale of a speed against a position."""
    u = np.linspace(-1, 1, 7)
    for theta in prior.sample(10, generator(1, "test", "modes")):
        mode, h = modes.mode_of(theta, free), modes.REACH / modes.rate_of(theta, free)
        buffers = modes.make_buffers()
        modes.propagate(mode, h, *buffers[:3])
        np.testing.assert_allclose(buffers.half, expm(system(mode) * h), rtol=0, atol=1e-13)
        np.testing.assert_allclose(buffers.whole, expm(2 * system(mode) * h), rtol=0, atol=1e-13)
        y = np.array([1.0, -0.5, 2.0, 0.3])
        for i in range(2):
            modes.coefficients(buffers.rows, i, tuple(y), buffers.position)
            expected = [(expm(system(mode) * h * each) @ y)[2 * i] for each in u]
            np.testing.assert_allclose(
                np.polynomial.polynomial.polyval(u, buffers.position), expected, atol=1e-13
            )


def test_rates_bound_the_systems(prior):
    """In coordinates scaled by mass, and speeds by the root of the stiffness."""
    for theta in prior.sample(50, generator(1, "test", "rates")):
        mu, k_a, k_b = theta[:3]
        for free in (True, False):
            omega = np.sqrt(k_a + k_b * (1 + mu * free))
            scale = np.array([omega, 1, omega / np.sqrt(mu), 1 / np.sqrt(mu)])
            matrix = system(modes.mode_of(theta, free)) * scale[:, None] / scale
            kept = slice(None) if free else slice(2)  # a closed contact stands still
            assert np.linalg.norm(matrix[kept, kept], 2) <= modes.rate_of(theta, free) * (1 + 1e-12)


def polynomial(roots, leading):
    """Coefficients (k,) of a polynomial with given roots."""
    out = np.zeros(modes.TERMS)
    out[: len(roots) + 1] = leading * np.polynomial.polynomial.polyfromroots(roots)
    return out


@pytest.mark.parametrize(
    ("roots", "leading", "first"),
    [
        ([0.3], -1.0, 0.3),
        ([-0.9, 0.2, 0.7], -1.0, -0.9),
        ([0.51, 0.52], 1.0, 0.51),  # a dip between two nodes
        ([-1.2, 0.1], 1.0, -1.0),  # not positive from the start
        ([1.3], -1.0, np.inf),
        ([0.25, 1.5], 1.0, 0.25),  # at a node
        ([], 1.0, np.inf),
    ],
)
def test_first_zero(roots, leading, first):
    buffers = modes.make_buffers()
    found = modes.first_zero(polynomial(roots, leading), buffers.slope, buffers.nodes)
    assert found == pytest.approx(first, abs=1e-13)


def test_a_dip_that_stays_positive_is_no_zero():
    buffers = modes.make_buffers()
    for above, first in ((1e-9, np.inf), (-1e-9, 0.5)):
        margin = polynomial([0.5, 0.5], 1.0)
        margin[0] += above
        found = modes.first_zero(margin, buffers.slope, buffers.nodes)
        assert found == pytest.approx(first, abs=1e-4)


def test_values_do_not_depend_on_their_neighbours():
    """Vectors of eight and what is left over: the same bytes."""
    coefficients = np.array([(-1.0) ** k / comb(24, k) for k in range(modes.TERMS)])
    times, whole = np.linspace(-1, 1, 21), np.empty((1, 21))
    modes.values(coefficients, times, 0, 21, 0.1, 1.3, whole, 0)
    for first, stop in ((0, 1), (3, 11), (4, 21), (20, 21)):
        part = np.full((1, 21), np.nan)
        modes.values(coefficients, times, first, stop, 0.1, 1.3, part, 0)
        np.testing.assert_array_equal(part[0, first:stop], whole[0, first:stop])
        assert np.isnan(part).sum() == 21 - (stop - first)


# ---- compiled code on disk -------------------------------------------------------------------


def test_an_edit_of_a_module_that_is_called_into_is_seen(tmp_path):
    """A second run takes what the first has compiled; after the edit it is compiled anew."""
    (tmp_path / "outer.py").write_text("", encoding="utf-8")

    def run(value):
        (tmp_path / "inner.py").write_text(
            "from breaker.modes import checksum, compiled\n"
            "SOURCE = checksum(__file__)\n\n\n"
            f"@compiled\ndef value():\n    return {value}\n",
            encoding="utf-8",
        )
        (tmp_path / "outer.py").write_text(
            "import inner\nfrom numba import njit\n\n\n"
            "def made_of(source):\n"
            "    @njit(cache=True)\n"
            "    def outer():\n"
            "        _ = source\n"
            "        return inner.value()\n\n"
            "    return outer\n\n\n"
            "outer = made_of(inner.SOURCE)\n"
            "print(outer(), sum(outer.stats.cache_hits.values()))\n",
            encoding="utf-8",
        )
        os.utime(tmp_path / "outer.py", (0, 0))  # it never changes
        result = subprocess.run(
            [sys.executable, "outer.py"],
            cwd=tmp_path,
            env={**os.environ, "NUMBA_CACHE_DIR": str(tmp_path / "cache")},
            capture_output=True,
            text=True,
            check=True,
        )
        return result.stdout.split()

    assert run(1) == ["1", "0"]
    assert run(1) == ["1", "1"]
    assert run(2) == ["2", "0"]


def test_entries_know_all_that_they_are_made_of():
    known = {
        mechanism._simulate: [modes],
        sensitivities._differentiate: [modes, tangents],
    }
    for entry, modules in known.items():
        (cell,) = entry.py_func.__closure__
        sources = np.atleast_1d(cell.cell_contents).tolist()
        assert sources == [modes.checksum(Path(module.__file__)) for module in modules]
