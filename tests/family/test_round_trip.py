"""Curves of the model through files: the records that are read belong to the stated truth."""

import numpy as np
import pytest
from scipy.stats import chi2

from breaker.common.randomness import generator
from breaker.family.exports import through_files
from breaker.model.curves import travel
from breaker.model.parameters import MOTIONS, NAMES
from studies import layouts

CURVES = 60
# Each record's chi-square has t degrees of freedom at the truth. Two-sided, over all records of a
# motion together: a false alarm of 1e-3.
FALSE_ALARM = 1e-3


@pytest.fixture(scope="module", params=MOTIONS)
def through(request, prior, sensor):
    """Records in the nine layouts of the studies."""
    rng = generator(4, "test through files", request.param)
    of_all = prior, sensor, request.param, CURVES, rng, layouts.LAYOUTS
    measured, truth, _ = through_files(*of_all)
    return request.param, measured, truth


def tail(sensor, motion, measured, truth):
    """Smaller tail probability of each record's chi-square at a truth, ``(n,)``."""
    p = len(NAMES)
    exact = travel(truth[:, :p], sensor.times, motion, onset=truth[:, p]).travel
    square = sensor.chi_square(measured, exact)
    return np.minimum(chi2.cdf(square, sensor.samples), chi2.sf(square, sensor.samples))


def test_records_are_those_of_the_truth_and_a_wrong_truth_is_noticed(through, sensor):
    motion, measured, truth = through
    bound = FALSE_ALARM / (2 * CURVES)
    assert measured.shape == (CURVES, sensor.samples)
    assert tail(sensor, motion, measured, truth).min() > bound
    exact = travel(truth[:, :-1], sensor.times, motion, onset=truth[:, -1]).travel
    faults = {
        "one sample late": (measured, truth + np.eye(len(NAMES) + 1)[-1] * 0.4),
        "sign of the onset": (measured, truth * np.array([1.0] * len(NAMES) + [-1.0])),
        "another curve": (measured, np.roll(truth, 1, axis=0)),
        "noise of an average of four samples": (exact + 0.5 * (measured - exact), truth),
    }
    for fault, wrong in faults.items():
        assert tail(sensor, motion, *wrong).min() < bound, fault
