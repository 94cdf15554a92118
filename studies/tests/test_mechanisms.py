"""The study's simulator against exact curves of the model, and its mechanisms."""

import numpy as np
import pytest

from breaker.common.randomness import generator
from breaker.model.curves import travel
from breaker.model.parameters import MOTIONS, NAMES
from studies.mechanisms import MECHANISMS, STEP, STOPS, drawn, drive_of, simulated

UNTIL = 200.0  # the model itself may swing for long


@pytest.mark.parametrize("motion", MOTIONS)
def test_without_a_mechanism_curves_are_those_of_the_model(prior, motion):
    theta = prior.sample(20, generator(1, "test mechanisms"))
    times = np.arange(0.0, 60.0, 0.1)
    exact = travel(theta, times, motion)
    once = ~exact.reopening  # a contact that parts again is not in the model
    assert once.sum() >= 10
    for row in np.flatnonzero(once):
        curve = simulated(drive_of(theta[row]), motion, UNTIL)
        np.testing.assert_allclose(
            np.interp(times, curve.time, curve.travel), exact.travel[row], atol=1e-4
        )
        assert curve.switching == pytest.approx(exact.switching[row], abs=1e-3)


@pytest.mark.parametrize("name", MECHANISMS | STOPS)
def test_every_mechanism_goes_from_rest_to_rest(prior, name):
    for number in range(6):
        rng = generator(1, "test mechanisms", name, number)
        _, curves = drawn(name, prior, rng, until=UNTIL)
        for curve in curves.values():
            assert np.isfinite(curve.travel).all()
            stroke = abs(curve.travel[-1] - curve.travel[0])
            assert 9.0 < stroke < 25.0  # the gap and the wipe, of the prior
            assert np.ptp(curve.travel[: round(0.1 / STEP)]) < 0.01 * stroke
            assert np.ptp(curve.travel[-round(20.0 / STEP) :]) < 0.01 * stroke
            assert 0.0 < curve.tenth < 15.0
            assert 0.0 < curve.switching < 25.0


@pytest.mark.parametrize("name", [each for each in MECHANISMS if each != "none"])
def test_a_mechanism_moves_the_drive_otherwise(prior, name):
    """And less, the smaller it is."""
    changes = []
    for strength in (1.0, 0.1):
        drive, curves = drawn(name, prior, generator(1, "test mechanisms", name), strength, UNTIL)
        plain = drive_of(np.array([drive[0][each] for each in NAMES]))
        same = [simulated(plain, motion, UNTIL) for motion in MOTIONS]
        pairs = zip(curves.values(), same, strict=True)
        changes.append(max(np.abs(a.travel - b.travel).max() for a, b in pairs))
    assert 0.0 < changes[1] < changes[0]


@pytest.mark.parametrize("form", range(1, 1 + MECHANISMS["build-up"][0]["rise_form"]))
def test_a_force_that_builds_up_at_once_is_that_of_the_model(prior, form):
    plain = drive_of(prior.sample(1, generator(2, "test mechanisms"))[0])
    fast = plain.copy()
    fast["rise_form"] = fast["fall_form"] = form
    fast["wait"], fast["ring"] = 0.5, 0.5
    for constant, tolerance in ((1e-3, 0.02), (0.0, 1e-12)):
        fast["rise"] = fast["fall"] = constant
        for motion in MOTIONS:
            found, exact = (simulated(drive, motion, UNTIL) for drive in (fast, plain))
            np.testing.assert_allclose(found.travel, exact.travel, atol=tolerance)
            assert found.switching == pytest.approx(exact.switching, abs=tolerance)
