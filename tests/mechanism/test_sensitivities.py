"""Exact derivatives against two references, at events and edges.

``complex_step`` differentiates matrix exponentials of the paper's equations: the derivative is the
imaginary part of the curve of a parameter moved by an imaginary step, exact to round-off, kinks or
not. It takes the event's time from the simulator, and moves it as the event's condition demands.
The other is differences of the simulator, which know nothing of events.
"""

import numba
import numpy as np
import pytest
from scipy.linalg import expm

from breaker.mechanism import arguments
from breaker.mechanism.curves import rest_position, travel
from breaker.mechanism.parameters import MOTIONS, NAMES
from breaker.mechanism.sensitivities import sensitivity
from breaker.model.randomness import generator

STEP = 1e-40  # no difference is taken, so none is lost
MU, K_A, K_B, GAMMA_A, GAMMA_B, F, GAP, ONSET = range(8)


def draws(prior, n, *purpose):
    rng = generator(1, "test", "sensitivities", *purpose)
    return prior.sample(n, rng), 0.3 * rng.standard_normal(n)


# ---- references ------------------------------------------------------------------------------


def system(theta, mode, pull):
    """Matrix (5, 5) of the linear system of (x_a, v_a, x_b, v_b, 1)."""
    mu, k_a, k_b, gamma_a, gamma_b, _, _ = theta
    matrix = np.zeros((5, 5), dtype=complex)
    matrix[0, 1] = 1.0
    matrix[1] = -(k_a + k_b), -(gamma_a + gamma_b), k_b, gamma_b, pull
    if mode == "free":
        matrix[2, 3] = 1.0
        matrix[3] = mu * k_b, mu * gamma_b, -mu * k_b, -mu * gamma_b, 0.0
    return matrix


def complex_step(theta, onset, times, motion, switching, k, *, moved_event=True):
    """Derivative of one curve by output ``k``, ``(t,)``.

    With ``moved_event`` off, the event stays where it is: the fault of a derivative that forgets
    that its time depends on the parameters.
    """
    theta, onset = theta.astype(complex), complex(onset)
    if k == ONSET:
        onset += 1j * STEP
    else:
        theta[k] *= 1 + 1j * STEP
    _, k_a, k_b, _, gamma_b, f, gap = theta
    held, pull = (f + k_b * gap) / (k_a + k_b), f if motion == "closing" else 0.0
    modes = ("free", "closed") if motion == "closing" else ("closed", "free")
    first, second = (system(theta, mode, pull) for mode in modes)
    start = np.array([0, 0, 0, 0, 1] if motion == "closing" else [held, 0, gap, 0, 1])

    position = np.full(len(times), start[0], dtype=complex)
    event = switching
    if 0 < switching < np.inf:
        state = expm(first * switching) @ start
        if motion == "closing":
            margin, slope = gap - state[2], -state[3]
        else:
            margin = k_b * (state[0] - gap) + gamma_b * state[1]
            slope = k_b * state[1] + gamma_b * (first @ state)[1]
        if moved_event:
            event = switching - 1j * margin.imag / slope.real
    before = (times > onset.real) & (times <= onset.real + switching)
    after = times > onset.real + switching
    position[before] = (expm(first * (times[before] - onset)[:, None, None]) @ start)[:, 0]
    if after.any():
        then = expm(first * event) @ start
        then[2:4] = gap, 0.0
        elapsed = times[after] - onset - event
        position[after] = (expm(second * elapsed[:, None, None]) @ then)[:, 0]
    return position.imag / STEP


def assert_exact(theta, onset, times, motion):
    """Rounding: some 30 steps, whose rows are of size exp(1.8) and act on states of up to 20 mm
    (derivatives likewise), make some 30 * 6 * 20 * 1e-16 = 4e-13; a touch slower than 1 mm/ms
    divides by its speed. Hence 1e-11."""
    result, slopes = sensitivity(theta, times, motion, onset=onset)
    assert slopes.shape == (len(theta), len(times), 8)
    for row, start, event, slope in zip(theta, onset, result.switching, slopes, strict=True):
        for k in range(8):
            expected = complex_step(row, start, times, motion, event, k)
            np.testing.assert_allclose(slope[:, k], expected, rtol=0, atol=1e-11)
    return result, slopes


# ---- exactness -------------------------------------------------------------------------------


@pytest.mark.parametrize("motion", MOTIONS)
def test_complex_steps_agree(prior, sensor, motion):
    theta, onset = draws(prior, 15, "complex")
    assert_exact(theta, onset, sensor.times[::3], motion)


def test_an_event_that_stands_still_is_seen(prior, sensor):
    """The planted fault: without the derivative of the touch's time, every parameter's derivative
    is off by far more than what the test above allows. (At a parting nothing hangs on it.)"""
    theta, onset = draws(prior, 5, "complex")
    times = sensor.times[::3]
    result, slopes = sensitivity(theta, times, "closing", onset=onset)
    for row, start, event, slope in zip(theta, onset, result.switching, slopes, strict=True):
        for k in range(7):
            fault = complex_step(row, start, times, "closing", event, k, moved_event=False)
            assert np.abs(slope[:, k] - fault).max() > 1e-3


@pytest.mark.parametrize("motion", MOTIONS)
def test_differences_agree(prior, sensor, motion):
    """Central differences of 4th order with steps e and 2 e.

    Their error falls by 16 from 2 e to e, so their difference bounds what is left of the one with
    e; rounding of 1e-13 mm adds 2 * 1e-13 / e. Samples that an event crosses within the steps are
    left out: there the order is the first, and the bound is e times the jump of the derivative's
    slope, below 100 mm.
    """
    theta, onset = draws(prior, 100, "differences")
    result, slopes = sensitivity(theta, sensor.times, motion, onset=onset)
    step = 1e-4

    def curve(k, steps):
        moved = theta.copy()
        if k < ONSET:
            moved[:, k] *= np.exp(steps * step)
        shift = steps * step if k == ONSET else 0.0
        return travel(moved, sensor.times, motion, onset=onset + shift)

    events = np.stack([onset, onset + result.switching], axis=1)[:, None]
    near = np.abs(sensor.times[:, None] - events).min(axis=-1) < 0.05  # ms: 4 steps of any event
    for k in range(8):
        ends = {steps: curve(k, steps).travel for steps in (-4, -2, -1, 1, 2, 4)}
        fine, coarse = (
            (8 * (ends[e] - ends[-e]) - (ends[2 * e] - ends[-2 * e])) / (12 * e * step)
            for e in (1, 2)
        )
        error = np.abs(fine - slopes[..., k])
        assert np.all(error[~near] <= (np.abs(coarse - fine) + 2e-13 / step)[~near])
        assert error.max() < 100 * step
        wrong = np.roll(slopes, 1, axis=-1)[..., k]  # of another parameter
        assert np.abs(fine - wrong).max() > 0.1


@pytest.mark.parametrize("motion", MOTIONS)
def test_curves_are_those_of_travel(prior, sensor, motion):
    theta, onset = draws(prior, 50, "curves")
    result, _ = sensitivity(theta, sensor.times, motion, onset=onset)
    for one, two in zip(result, travel(theta, sensor.times, motion, onset=onset), strict=True):
        assert one.tobytes() == two.tobytes()


@pytest.mark.parametrize("motion", MOTIONS)
def test_symmetries(prior, sensor, motion):
    """Curves scale with f and L together; k and f by -2, gamma by -1 stretch time."""
    theta, onset = draws(prior, 200, "symmetries")
    result, slopes = sensitivity(theta, sensor.times, motion, onset=onset)
    np.testing.assert_allclose(slopes[..., [F, GAP]].sum(-1), result.travel, rtol=0, atol=1e-11)
    stretched = 2 * slopes[..., [K_A, K_B, F]].sum(-1) + slopes[..., [GAMMA_A, GAMMA_B]].sum(-1)
    elapsed = np.maximum(sensor.times - onset[:, None], 0.0)
    np.testing.assert_allclose(stretched, -elapsed * slopes[..., ONSET], rtol=0, atol=1e-10)


# ---- edges -----------------------------------------------------------------------------------


@pytest.mark.parametrize("motion", MOTIONS)
def test_samples_at_the_onset_and_at_the_event(prior, sensor, motion):
    """There, and on both sides of it, the derivative is one: the travel has no kink."""
    theta, onset = draws(prior, 5, "at events")
    for row, start in zip(theta[:, None], onset[:, None], strict=True):
        event = start + travel(row, sensor.times, motion, onset=start).switching
        around = np.array([-1e-9, 0.0, 1e-9])
        times = np.concatenate([start + around, event + around, [50.0]])
        _, slopes = assert_exact(row, start, times, motion)
        # 1e-9 ms at no more than 100 mm/ms, the slope of a derivative
        assert np.abs(np.diff(slopes[0, :3], axis=0)).max() < 1e-7
        assert np.abs(np.diff(slopes[0, 3:6], axis=0)).max() < 1e-7


def test_before_the_motion_only_the_held_state_moves(prior):
    theta, _ = draws(prior, 5, "rest")
    times = np.array([-5.0, -1.0, 2.0])
    _, slopes = sensitivity(theta, times, "closing", onset=2.0)
    assert np.all(slopes == 0)
    _, slopes = sensitivity(theta, times, "opening", onset=2.0)
    _, k_a, k_b, _, _, f, gap = theta.T
    held, total = rest_position(theta, "opening"), k_a + k_b
    expected = np.zeros((5, 8))
    expected[:, K_A], expected[:, K_B] = -k_a * held / total, k_b * (gap - held) / total
    expected[:, F], expected[:, GAP] = f / total, k_b * gap / total
    np.testing.assert_allclose(slopes, expected[:, None].repeat(3, axis=1), rtol=1e-13, atol=1e-15)
    assert np.all(slopes[..., [MU, GAMMA_A, GAMMA_B, ONSET]] == 0)


def test_contact_never_reached(prior, sensor):
    theta, onset = draws(prior, 5, "never")
    theta[:, F] = 0.3 * theta[:, K_A] * theta[:, GAP]
    result, slopes = assert_exact(theta, onset, sensor.times[::5], "closing")
    assert np.all(np.isinf(result.switching))
    assert np.all(slopes[..., GAP] == 0)


@pytest.mark.parametrize("share", [0.5, 0.999])
def test_contact_that_parts_at_once(prior, sensor, share):
    """It parts with the onset, whatever the parameters."""
    theta, onset = draws(prior, 5, "parts at once")
    theta[:, F] = share * theta[:, K_A] * theta[:, GAP]
    result, _ = assert_exact(theta, onset, sensor.times[::5], "opening")
    assert np.all(result.switching == 0)


@pytest.mark.parametrize("motion", MOTIONS)
def test_record_that_ends_in_the_first_mode(prior, motion):
    theta, onset = draws(prior, 5, "short")
    result, _ = assert_exact(theta, onset, np.array([0.5, 0.8]), motion)
    assert np.all(np.isinf(result.switching))


@pytest.mark.parametrize("motion", MOTIONS)
def test_stiff_contact_spring(prior, motion):
    """Ever more steps, ever faster ones: rounding grows with their number and with the rate, here
    some 30 times the usual."""
    theta, onset = draws(prior, 2, "stiff")
    theta[:, K_B] = 100.0
    times = np.linspace(0.0, 30.0, 9)
    result, slopes = sensitivity(theta, times, motion, onset=onset)
    for row, start, event, slope in zip(theta, onset, result.switching, slopes, strict=True):
        for k in range(8):
            expected = complex_step(row, start, times, motion, event, k)
            np.testing.assert_allclose(slope[:, k], expected, rtol=0, atol=1e-8)


def test_touch_that_comes_and_goes():
    """The derivatives are finite, and exact, up to the highest point that the contact reaches, and
    beyond it; the touch's time, which is not, is none of them.

    The reference divides by the contact's speed, the root of the distance: 1e-4 of 1 mm/ms here.
    """
    theta = np.array([[2.0, 0.045, 0.04, 0.1, 0.12, 0.2, 1.0]])
    low, high, times = 0.1, 100.0, np.linspace(0.0, 60.0, 13)
    for _ in range(60):
        theta[0, GAP] = 0.5 * (low + high)
        if np.isfinite(travel(theta, times, "closing").switching[0]):
            low = theta[0, GAP]
        else:
            high = theta[0, GAP]
    for distance in (1e-4, 1e-8, -1e-8):
        theta[0, GAP] = low * (1 - distance)
        result, slopes = sensitivity(theta, times, "closing")
        assert np.isfinite(result.switching[0]) == (distance > 0)
        for k in range(8):
            expected = complex_step(theta[0], 0.0, times, "closing", result.switching[0], k)
            np.testing.assert_allclose(slopes[0, :, k], expected, rtol=0, atol=1e-7)


# ---- rows ------------------------------------------------------------------------------------


@pytest.mark.parametrize("motion", MOTIONS)
def test_batch_is_a_loop(prior, sensor, motion):
    theta, onset = draws(prior, 40, "batch")
    _, slopes = sensitivity(theta, sensor.times, motion, onset=onset)
    for k in range(len(theta)):
        _, alone = sensitivity(theta[[k]], sensor.times, motion, onset=onset[[k]])
        assert alone[0].tobytes() == slopes[k].tobytes()


@pytest.mark.parametrize("motion", MOTIONS)
def test_blocks_and_threads_do_not_change_bytes(prior, sensor, motion, monkeypatch):
    theta, onset = draws(prior, 200, "blocks")
    before, results = numba.get_num_threads(), []
    try:
        for rows, threads in ((8192, 1), (7, 1), (64, numba.config.NUMBA_NUM_THREADS)):
            monkeypatch.setattr(arguments, "_ROWS", rows)
            numba.set_num_threads(threads)
            results.append(sensitivity(theta, sensor.times, motion, onset=onset)[1].tobytes())
    finally:
        numba.set_num_threads(before)
    assert results[0] == results[1] == results[2]


def test_what_travel_refuses_is_refused(prior, sensor):
    theta, _ = draws(prior, 4, "refused")
    theta[2, K_B] = -1.0
    with pytest.raises(ValueError, match=r"1 of 4 rows .* k_b = -1\.0 in row 2"):
        sensitivity(theta, sensor.times, "closing")
    with pytest.raises(ValueError, match="unknown motion"):
        sensitivity(theta[:1], sensor.times, "close")


def test_no_operation_is_no_derivative(sensor):
    assert sensitivity(np.empty((0, 7)), sensor.times, "closing")[1].shape == (
        0,
        151,
        len(NAMES) + 1,
    )
