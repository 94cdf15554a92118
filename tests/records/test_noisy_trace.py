"""Values of noisy curves: right on exact ones, and as uncertain as stated."""

import numpy as np
import pytest
from scipy.signal import lfilter

from breaker.records.noise import running_median
from breaker.records.noisy_trace import Trace, Uncertain, settling

TIME = np.arange(0.0, 60.0, 0.1)
CURVE = 7.0 * (1.0 + np.tanh((TIME - 30.0) / 4.0))


def trace_of(travel, noise=0.05, colour=0.0, quantum=0.0):
    return Trace(TIME, travel, noise, colour, quantum, duration=10.0, stroke=14.0)


def quantities(trace):
    """A rest, a time and a mean speed."""
    rest = trace.rest(0.0, 10.0)
    begin, end = (trace.reaches(rest + level) for level in (2.0, 9.0))
    speed = Uncertain(7.0, np.zeros_like(rest.slope)) / (end - begin)
    return rest, begin, speed, trace.at(end)


@pytest.mark.parametrize("colour", [0.0, 0.6])
def test_stated_uncertainties(colour):
    """Of 300 draws, the mean square in stated sds has an sd of 8 %; 1.35 and 0.65 are 4 sd off,
    but for the error of local fits, which is stated too.
    """
    rng, scores = np.random.default_rng(1), []
    begin, end = 30.0 + 4.0 * np.arctanh(np.array([2.0, 9.0]) / 7.0 - 1.0)
    exact = [quantity.value for quantity in quantities(trace_of(CURVE, noise=1e-3))]
    assert exact == pytest.approx([0.0, begin, 7.0 / (end - begin), 9.0], abs=2e-3)
    for _ in range(300):
        noise = rng.standard_normal(TIME.size)
        noise[1:] *= np.sqrt(1.0 - colour**2)
        trace = trace_of(CURVE + 0.05 * lfilter([1.0], [1.0, -colour], noise), colour=colour)
        result = quantities(trace)
        scores.append([(e.value - x) / trace.sd(e) for e, x in zip(result, exact, strict=True)])
    square = np.mean(np.square(scores), axis=0)
    assert np.all((square > 0.65) & (square < 1.35)), square


@pytest.mark.parametrize("lost", [0.0, 0.28])
def test_a_corner_is_not_rounded_off(lost):
    """A drive loses a share of its speed at once, which a fit without a corner does not see."""
    since, time = TIME - 30.05, Uncertain(30.05, 0.0)
    curve = np.clip(10.0 + since - lost * np.maximum(since, 0.0), 0.0, 14.0)
    rng, scores = np.random.default_rng(1), []
    for _ in range(100):
        trace = trace_of(curve + 0.02 * rng.standard_normal(TIME.size), noise=0.02)
        both = trace.at_corner(time, 0.1, 0.2), trace.at(time)
        scores.append([(item.value - 10.0) / trace.sd(item) for item in both])
    corner, rounded = np.mean(scores, axis=0)
    assert abs(corner) < 1.0
    assert np.std(scores, axis=0)[0] < 1.2
    assert lost == 0.0 or rounded < -1.5


def test_rounding_of_a_rest_does_not_average_out():
    coarse = trace_of(np.round(CURVE / 0.3) * 0.3, noise=0.3 / np.sqrt(12.0), quantum=0.3)
    assert coarse.sd(coarse.rest(0.0, 10.0)) > 0.08
    noisy = trace_of(CURVE, noise=0.4, quantum=0.3)
    assert noisy.sd(noisy.rest(0.0, 10.0)) < 0.05


ENDS = np.arange(0.0, 40.0, 1.0)
SWINGS = np.exp(-0.08 * ENDS) * np.cos(0.2 * ENDS + 0.5)
CREEPS = np.exp(-0.05 * ENDS) + 0.5 * np.exp(-0.15 * ENDS)


@pytest.mark.parametrize("shape", [SWINGS, CREEPS])
def test_where_a_curve_settles(shape):
    """Of 300 draws, the mean square error over the stated one has an sd of 8 %: 1.35 is 4 sd."""
    assert settling(13.0 + 1.3 * shape)[0] == pytest.approx(13.0, abs=0.03)
    rng, errors = np.random.default_rng(1), []
    for _ in range(300):
        rest, weights = settling(13.0 + SWINGS + 0.01 * rng.standard_normal(ENDS.size))
        errors.append((rest - settling(13.0 + SWINGS)[0]) / (0.01 * np.linalg.norm(weights)))
    assert 0.7 < np.mean(np.square(errors)) < 1.35


@pytest.mark.parametrize("curve", [ENDS, np.exp(0.05 * ENDS)])
def test_curves_that_do_not_settle(curve):
    assert settling(curve) is None


@pytest.mark.parametrize(("count", "window"), [(1, 3), (7, 5), (7, 21), (3000, 201)])
def test_running_medians_are_those_of_each_window(count, window):
    """Beyond its ends a record stands; the last is of several blocks."""
    values = np.random.default_rng(1).normal(size=count)
    around = np.arange(-(window // 2), window // 2 + 1)
    places = np.clip(np.arange(count)[:, None] + around, 0, count - 1)
    assert (running_median(values, window) == np.median(values[places], axis=1)).all()
