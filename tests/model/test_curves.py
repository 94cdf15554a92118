"""Exact curves against integrated and closed-form solutions, its answers at the edges, and
what it refuses."""

from itertools import accumulate

import numba
import numpy as np
import pytest
from scipy.linalg import expm
from scipy.optimize import brentq

from breaker.common.randomness import generator
from breaker.model import curves
from breaker.model.curves import check, travel
from breaker.model.equations import fastest_rate
from breaker.model.parameters import MOTIONS, NAMES
from tests.model_references import changed, contact_force, integrate, propagate, system


def draws(prior, n, *purpose):
    rng = generator(1, "test", "mechanism", *purpose)
    return prior.sample(n, rng), 0.3 * rng.standard_normal(n)


@pytest.mark.parametrize("motion", MOTIONS)
def test_integration_agrees(prior, sensor, motion):
    """60 prior draws with onsets. The reference is good to 1e-9; a contact stays closed."""
    theta, onset = draws(prior, 60, "integration")
    onset[:10] *= 10  # so that some start before the record, and some late
    result = travel(theta, sensor.times, motion, onset=onset)
    expected = [
        integrate(row, sensor.times - start, motion)
        for row, start in zip(theta, onset, strict=True)
    ]
    position, switching = map(np.array, zip(*expected, strict=True))
    np.testing.assert_allclose(result.travel, position, rtol=0, atol=1e-8)
    np.testing.assert_allclose(result.switching, switching, rtol=0, atol=1e-8)


@pytest.mark.parametrize(("k_b", "atol"), [(None, 1e-11), (1e2, 1e-8), (1e3, 1e-8), (1e5, 1e-7)])
@pytest.mark.parametrize("motion", MOTIONS)
def test_matrix_exponentials_agree(prior, sensor, motion, k_b, atol):
    """To round-off, with the event as a condition: at the switching time the contact is at the
    gap, or its force is zero. With a stiff contact spring nothing fails and nothing is lost."""
    theta, _ = draws(prior, 20, "propagate")
    theta = theta if k_b is None else changed(theta[:3], k_b=k_b)
    times = sensor.times
    for row, position, event in zip(theta, *travel(theta, times, motion), strict=True):
        expected, state, _ = propagate(row, times, motion, event)
        np.testing.assert_allclose(position, expected, rtol=0, atol=atol)
        margin = state[2] - row[-1] if motion == "closing" else contact_force(row, state)
        assert margin == pytest.approx(0.0, abs=atol)


@pytest.mark.parametrize("motion", MOTIONS)
def test_bytes_depend_on_nothing_but_the_row(prior, sensor, motion, monkeypatch):
    """Not on other rows, their order, the blocks or the threads that they are in."""
    theta, onset = draws(prior, 200, "bytes")
    whole = travel(theta, sensor.times, motion, onset=onset)
    before, results = numba.get_num_threads(), []
    try:
        for rows, threads in ((7, 1), (199, 1), (8192, numba.config.NUMBA_NUM_THREADS)):
            monkeypatch.setattr(curves, "_ROWS", rows)
            numba.set_num_threads(threads)
            results.append(travel(theta, sensor.times, motion, onset=onset))
    finally:
        numba.set_num_threads(before)
    backwards = travel(theta[::-1], sensor.times, motion, onset=onset[::-1])
    results.append([backward[::-1] for backward in backwards])
    for k in (0, 63, 64, 199):
        alone = travel(theta[[k]], sensor.times, motion, onset=onset[[k]])
        assert all(a.tobytes() == b[[k]].tobytes() for a, b in zip(alone, whole, strict=True))
    for other in results:
        assert all(a.tobytes() == b.tobytes() for a, b in zip(other, whole, strict=True))


def test_rates_are_bounded_but_not_by_much(prior):
    """The bound decides on the lengths of intervals, and so on accuracy and cost. With a closed
    contact it is that of an oscillator, w + g, whose norm is at least 0.8 times that."""
    for row in draws(prior, 50, "rates")[0]:
        modes = {word: system(row, word, 0.0)[:4, :4] for word in ("free", "closed")}
        for word, mode in modes.items():
            assert np.abs(np.linalg.eigvals(mode)).max() < fastest_rate(row, free=word == "free")
        square, damping = -modes["closed"][1, :2]
        norm = np.linalg.norm([[0.0, square**0.5], [-(square**0.5), -damping]], 2)
        assert 0.8 < norm / fastest_rate(row, free=False) < 1.0


@pytest.mark.parametrize("motion", MOTIONS)
def test_event_exactly_at_a_sample(prior, sensor, motion):
    theta, _ = draws(prior, 20, "at a sample")
    usual = travel(theta, sensor.times, motion)
    for row, position, event in zip(theta[:, None], *usual, strict=True):
        times = np.union1d(sensor.times, [event])
        at = np.searchsorted(times, event)
        result = travel(row, times, motion)
        assert result.switching[0] == pytest.approx(event, abs=1e-12)
        np.testing.assert_allclose(np.delete(result.travel[0], at), position, rtol=0, atol=1e-12)
        around = travel(row, event + np.array([-1e-9, 0, 1e-9]), motion).travel[0]
        assert result.travel[0, at] == pytest.approx(around[1], abs=1e-12)
        assert np.abs(np.diff(around)).max() < 1e-8  # 1e-9 ms at no more than 10 mm/ms
        # A record that ends there has the event or not, within round-off.
        for end, answer in ((event - 1e-9, False), (event + 1e-9, True)):
            assert np.isfinite(travel(row, np.array([0.0, end]), motion).switching[0]) == answer


@pytest.mark.parametrize(
    ("motion", "share", "event"),
    [("closing", 0.3, np.inf), *(("opening", share, 0.0) for share in (0.5, 0.999, 1.0))],
)
def test_free_motion_to_the_end(prior, sensor, motion, share, event):
    """A force that holds the drive short of the gap; or too little of it, and the contact parts at
    once. At share 1 the contact force is zero within round-off, and so is the time."""
    theta, _ = draws(prior, 5, "never")
    theta = changed(theta, f=share * theta[:, NAMES.index("k_a")] * theta[:, -1])
    result = travel(theta, sensor.times, motion, onset=0.7)
    np.testing.assert_allclose(result.switching, event, rtol=0, atol=0 if share < 1 else 1e-12)
    for row, position in zip(theta, result.travel, strict=True):
        expected, _, _ = propagate(row, sensor.times - 0.7, motion, event)
        np.testing.assert_allclose(position, expected, rtol=0, atol=1e-11)


def peaks(theta, end, step=0.02):
    """Times and heights of the free contact's maxima that are the highest so far."""
    mode, start = system(theta, "free", theta[NAMES.index("f")]), np.array([0, 0, 0, 0, 1.0])
    one_step = expm(mode * step)
    path = np.array([*accumulate(range(int(end / step)), lambda y, _: one_step @ y, initial=start)])
    highest = np.maximum.accumulate(path[:, 2])
    for k in np.flatnonzero((path[:-1, 3] > 0) & (path[1:, 3] <= 0)):
        stop = brentq(lambda t, y=path[k]: (expm(mode * t) @ y)[3], 0, step, xtol=1e-14)
        top = (expm(mode * stop) @ path[k])[2]
        if top >= highest[k]:
            yield k * step + stop, top


def light_damping(n):
    """Drives that hardly lose energy: the contact's way has ripples, and several maxima in an
    interval of the method."""
    rng = generator(1, "test", "mechanism", "ripples")
    low = np.log([0.3, 0.05, 1e-3, 1e-3, 1e-3, 1.0, 1.0])
    high = np.log([30.0, 1.0, 3.0, 3e-2, 3e-2, 1.0, 1.0])
    return np.exp(rng.uniform(low, high, (n, 7)))


def test_touch_by_a_ripple():
    """Every maximum that is the highest so far stops a contact whose gap lies just under it; the
    highest of all does not stop one whose gap lies above it."""
    stops, times = 0, np.array([0.0, 40.0])
    for row in light_damping(60):
        mode, start = system(row, "free", row[NAMES.index("f")]), np.array([0, 0, 0, 0, 1.0])
        for time, top in peaks(row, 40.0):
            acceleration = (mode @ expm(mode * time) @ start)[3]
            for below in (1e-4, 1e-7):
                gap = top * (1 - below)
                switching = travel(changed(row, L=gap)[None], times, "closing").switching[0]
                # The parabola under the maximum; its next term is smaller by the root of ``below``.
                before = np.sqrt(2 * top * below / -acceleration)
                assert switching == pytest.approx(time - before, abs=0.2 * before)
                assert (expm(mode * switching) @ start)[2] == pytest.approx(gap, rel=1e-11)
            stops += 1
    assert stops > 50


@pytest.mark.parametrize("wrong", [np.nan, np.inf, 0.0, -1.0])
def test_impossible_parameters_are_refused_by_name(prior, sensor, wrong):
    theta = draws(prior, 30, "refused")[0]
    theta[19, NAMES.index("k_b")] = theta[29, NAMES.index("f")] = wrong
    with pytest.raises(ValueError, match=rf"2 of 30 .* k_b = {wrong} in row 19"):
        travel(theta, sensor.times, "closing")


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"theta": np.ones((3, 6))}, r"\(n, 7\)"),
        *(({"times": np.array(t)}, "times") for t in [[0.0, 0.0], [0.0, np.nan], []]),
        ({"onset": np.append(np.zeros(29), np.inf)}, r"one per row, \(30,\)"),
        ({"onset": np.zeros(2)}, "onset must be one finite time"),
        ({"motion": "close"}, r"unknown motion 'close'.*closing, opening"),
    ],
)
def test_wrong_arguments_are_refused(prior, sensor, change, words):
    usual = {"theta": draws(prior, 30, "refused")[0], "times": sensor.times, "motion": "closing"}
    with pytest.raises(ValueError, match=words):
        travel(**({"onset": 0.0} | usual | change))


@pytest.mark.parametrize(("k_b", "onset"), [(1e20, 0.0), (1e308, 0.0), (0.04, -1e9)])
def test_drives_that_are_too_fast_are_refused_by_row(prior, sensor, k_b, onset):
    """A motion long before the record counts as well."""
    theta, onsets = draws(prior, 30, "refused")[0], np.zeros(30)
    check(theta, sensor.times, "closing", onsets)
    theta[19, NAMES.index("k_b")], onsets[19] = k_b, onset
    with pytest.raises(ValueError, match=r"row 19 .* 'k_b'"):
        check(theta, sensor.times, "closing", onsets)
