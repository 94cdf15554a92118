"""Derivatives against two references, at events and edges.

``complex_step`` differentiates matrix exponentials of the paper's equations: the derivative is the
imaginary part of the curve of a parameter moved by an imaginary step, exact to round-off, kinks or
not. It takes the event's time from the simulator, and moves it as the event's condition demands.
"""

import numpy as np
import pytest

from breaker.model import curves
from breaker.model.curves import sensitivity, travel
from breaker.model.parameters import MOTIONS
from tests.model.test_curves import draws
from tests.model_references import contact_force, propagate

STEP = 1e-40  # no difference is taken, so none is lost
MU, K_A, K_B, GAMMA_A, GAMMA_B, F, GAP, ONSET = range(8)
CLOSE = 1e-6  # mm: rounding of 1e-13 mm over the step of 1e-5, and its square times 1e3 mm


def complex_step(theta, onset, times, motion, switching, k):
    """Derivative of one curve by output ``k``, ``(t,)``."""
    theta, onset = theta.astype(complex), complex(onset)
    if k == ONSET:
        onset += 1j * STEP
    else:
        theta[k] *= 1 + 1j * STEP
    event = complex(switching)
    if 0 < switching < np.inf:
        _, state, mode = propagate(theta, times + 0j, motion, event)
        if motion == "closing":
            margin, slope = theta[GAP] - state[2], -state[3]
        else:
            margin = contact_force(theta, state)
            slope = theta[K_B] * state[1] + theta[GAMMA_B] * (mode @ state)[1]
        event -= 1j * margin.imag / slope.real
    position = propagate(theta, times - onset, motion, event)[0]
    return position.imag / STEP


def assert_right(theta, onset, times, motion, atol=CLOSE):
    result, slopes = sensitivity(theta, times, motion, onset=onset)
    assert slopes.shape == (len(theta), len(times), 8)
    for row, start, event, slope in zip(theta, onset, result.switching, slopes, strict=True):
        for k in range(8):
            expected = complex_step(row, start, times, motion, event, k)
            np.testing.assert_allclose(slope[:, k], expected, rtol=0, atol=atol)
    return result, slopes


@pytest.mark.parametrize("motion", MOTIONS)
def test_complex_steps_agree(prior, sensor, motion):
    theta, onset = draws(prior, 15, "complex")
    assert_right(theta, onset, sensor.times[::3], motion)


@pytest.mark.parametrize("motion", MOTIONS)
def test_curves_are_those_of_travel_in_any_blocks(prior, sensor, motion, monkeypatch):
    """Bit by bit, and so are derivatives."""
    theta, onset = draws(prior, 50, "curves")
    result, slopes = sensitivity(theta, sensor.times, motion, onset=onset)
    for one, two in zip(result, travel(theta, sensor.times, motion, onset=onset), strict=True):
        assert one.tobytes() == two.tobytes()
    monkeypatch.setattr(curves, "_ROWS", 50)  # two rows, of 17 curves each
    again = sensitivity(theta, sensor.times, motion, onset=onset)[1]
    np.testing.assert_array_equal(again, slopes)


@pytest.mark.parametrize("motion", MOTIONS)
def test_samples_at_the_onset_and_at_the_event(prior, sensor, motion):
    """The travel has no kink there, but its slope has: first order, 1e-5 times a hundred mm."""
    theta, onset = draws(prior, 5, "at events")
    for row, start in zip(theta[:, None], onset[:, None], strict=True):
        event = start + travel(row, sensor.times, motion, onset=start).switching
        around = np.array([-1e-9, 0.0, 1e-9])
        times = np.concatenate([start + around, event + around, [50.0]])
        assert_right(row, start, times, motion, atol=1e-3)


@pytest.mark.parametrize(
    ("motion", "share", "switching"),
    [("closing", 0.3, np.inf), ("opening", 0.5, 0.0)],
    ids=["never touches", "parts at once"],
)
def test_contact_without_an_event(prior, sensor, motion, share, switching):
    """A contact that parts at once parts with the onset, whatever the parameters."""
    theta, onset = draws(prior, 5, "no event")
    theta[:, F] = share * theta[:, K_A] * theta[:, GAP]
    result, _ = assert_right(theta, onset, sensor.times[::5], motion)
    assert np.all(result.switching == switching)
