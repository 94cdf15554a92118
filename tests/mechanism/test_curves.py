"""The exact mechanism against integrated and closed-form solutions, and its answers at the edges.

Two references, written from the paper's equations and sharing nothing with the module but the
order of the parameters: ``integrate`` (``solve_ivp`` with event location, which knows nothing of
the event) and ``propagate`` (matrix exponentials, exact where the time of the event is known).
"""

import numba
import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm
from scipy.optimize import brentq

from breaker.mechanism import curves
from breaker.mechanism.curves import rest_position, travel
from breaker.mechanism.parameters import MOTIONS, NAMES
from breaker.model.randomness import generator

TIGHT = {"method": "DOP853", "rtol": 1e-11, "atol": 1e-12}


def changed(theta, **values):
    """Parameters ``(..., p)`` with some of them set by name."""
    theta = np.array(theta, dtype=np.float64)
    for name, value in values.items():
        theta[..., NAMES.index(name)] = value
    return theta


def draws(prior, n, *purpose):
    rng = generator(1, "test", "mechanism", *purpose)
    return prior.sample(n, rng), 0.3 * rng.standard_normal(n)


# ---- references ------------------------------------------------------------------------------


def integrate(theta, times, motion):
    """Integrate one operation that starts at 0: travel (t,), switching time, reopening."""
    mu, k_a, k_b, gamma_a, gamma_b, f, gap = theta.tolist()
    pull = f if motion == "closing" else 0.0

    def free(t, y):
        x_a, v_a, x_b, v_b = y.tolist()
        spring = k_b * (x_b - x_a) + gamma_b * (v_b - v_a)
        return v_a, pull - k_a * x_a - gamma_a * v_a + spring, v_b, -mu * spring

    def closed(t, y):
        x_a, v_a, _, _ = y.tolist()
        return v_a, pull - k_a * x_a - gamma_a * v_a + k_b * (gap - x_a) - gamma_b * v_a, 0.0, 0.0

    def distance(t, y):
        return y[2] - gap

    def force(t, y):
        return k_b * (y[0] - gap) + gamma_b * y[1]

    distance.direction, force.direction = 1, -1
    held = (f + k_b * gap) / (k_a + k_b)
    if motion == "closing":
        modes, start, rest = ((free, distance), (closed, force)), np.zeros(4), 0.0
    else:
        modes, start, rest = ((closed, force), (free, distance)), np.array([held, 0, gap, 0]), held

    position = np.full(len(times), rest)
    (mode, event), (next_mode, next_event) = modes
    event.terminal = True
    before = solve_ivp(mode, (0, times[-1]), start, events=event, dense_output=True, **TIGHT)
    touched = before.t_events[0].size > 0
    switching = before.t_events[0][0] if touched else np.inf
    first = (times > 0) & (times <= switching)
    if first.any():
        position[first] = before.sol(times[first])[0]
    if not touched:
        return position, switching, False
    state = before.y[:, -1].copy()
    if motion == "closing":
        state[2:] = gap, 0.0
    second = times > switching
    after = solve_ivp(
        next_mode, (switching, times[-1]), state, t_eval=times[second], events=next_event, **TIGHT
    )
    position[second] = after.y[0]
    falls = after.t_events[0].size > 0 or force(switching, state) <= 0
    return position, switching, motion == "closing" and bool(falls)


def system(theta, mode, pull):
    """Matrix (5, 5) of the linear system of (x_a, v_a, x_b, v_b, 1)."""
    mu, k_a, k_b, gamma_a, gamma_b, _, _ = theta
    matrix = np.zeros((5, 5))
    matrix[0, 1] = 1.0
    matrix[1] = -(k_a + k_b), -(gamma_a + gamma_b), k_b, gamma_b, pull
    if mode == "free":
        matrix[2, 3] = 1.0
        matrix[3] = mu * k_b, mu * gamma_b, -mu * k_b, -mu * gamma_b, 0.0
    return matrix


def states(theta, mode, pull, start, times):
    """States (t, 5) of one mode at times after its start, by matrix exponentials."""
    return expm(system(theta, mode, pull) * np.asarray(times)[:, None, None]) @ start


def propagate(theta, times, motion, switching):
    """Travel (t,) of one operation that starts at 0 and switches at a known time, and its state
    (x_a, v_a, x_b, v_b) just before."""
    _, k_a, k_b, _, _, f, gap = theta
    held = (f + k_b * gap) / (k_a + k_b)
    closing = motion == "closing"
    pull, modes = (f, ("free", "closed")) if closing else (0.0, ("closed", "free"))
    start = np.array([0, 0, 0, 0, 1.0] if closing else [held, 0, gap, 0, 1.0])
    middle = states(theta, modes[0], pull, start, [min(switching, times[-1])])[0]
    before = (times > 0) & (times <= switching)
    position = np.full(len(times), start[0])
    position[before] = states(theta, modes[0], pull, start, times[before])[:, 0]
    then = middle.copy()
    then[2:4] = gap, 0.0
    after = times > switching
    position[after] = states(theta, modes[1], pull, then, times[after] - switching)[:, 0]
    return position, middle[:4]


def contact_force(theta, state):
    _, _, k_b, _, gamma_b, _, gap = theta
    return k_b * (state[..., 0] - gap) + gamma_b * state[..., 1]


# ---- exactness -------------------------------------------------------------------------------


@pytest.mark.parametrize("motion", MOTIONS)
def test_integration_agrees(prior, sensor, motion):
    """500 prior draws with onsets. The reference is good to 1e-9; a relative error of 1e-7 in one
    parameter would show."""
    theta, onset = draws(prior, 500, "integration")
    result = travel(theta, sensor.times, motion, onset=onset)
    expected = [
        integrate(row, sensor.times - start, motion)
        for row, start in zip(theta, onset, strict=True)
    ]
    position, switching, reopening = map(np.array, zip(*expected, strict=True))
    assert np.all(np.isfinite(switching))
    np.testing.assert_allclose(result.travel, position, rtol=0, atol=1e-8)
    np.testing.assert_allclose(result.switching, switching, rtol=0, atol=1e-8)
    np.testing.assert_array_equal(result.reopening, reopening)
    for k, name in enumerate(NAMES):
        wrong = theta.copy()
        wrong[:, k] *= 1 + 1e-7
        fault = travel(wrong, sensor.times, motion, onset=onset)
        assert np.abs(fault.travel - position).max() > 1e-8
        if (motion, name) != ("opening", "mu"):  # a closed contact does not know the mass ratio
            assert np.abs(fault.switching - switching).max() > 1e-8


def test_matrix_exponentials_agree(prior, sensor):
    """To round-off, with the event as a condition: at the switching time the contact is at the
    gap, or its force is zero."""
    theta, _ = draws(prior, 20, "propagate")
    times = sensor.times
    for row, position, switching in zip(theta, *travel(theta, times, "closing")[:2], strict=True):
        expected, state = propagate(row, times, "closing", switching)
        np.testing.assert_allclose(position, expected, rtol=0, atol=1e-11)
        assert state[2] == pytest.approx(row[-1], abs=1e-11)
    for row, position, switching in zip(theta, *travel(theta, times, "opening")[:2], strict=True):
        expected, state = propagate(row, times, "opening", switching)
        np.testing.assert_allclose(position, expected, rtol=0, atol=1e-11)
        assert contact_force(row, state) == pytest.approx(0.0, abs=1e-13)


@pytest.mark.parametrize("motion", MOTIONS)
def test_same_on_every_grid(prior, sensor, motion):
    theta, onset = draws(prior, 50, "grid")
    result = travel(theta, sensor.times, motion, onset=onset)
    coarse = [0, 7, 31, 33, 80, 149, 150]
    rng = generator(1, "test", "mechanism", "irregular")
    more = np.union1d(sensor.times, rng.uniform(-2, 58, 3000))
    for times, chosen in ((sensor.times[coarse], coarse), (more, slice(None))):
        other = travel(theta, times, motion, onset=onset)
        shared = np.isin(times, sensor.times)
        np.testing.assert_allclose(
            other.travel[:, shared], result.travel[:, chosen], rtol=0, atol=1e-12
        )
        np.testing.assert_allclose(other.switching, result.switching, rtol=0, atol=1e-12)
    for k in (0, 6, 30, 150):
        single = travel(theta, sensor.times[[k]], motion, onset=onset)
        np.testing.assert_allclose(single.travel[:, 0], result.travel[:, k], rtol=0, atol=1e-12)
        # Switching is known as far as the record goes.
        known = result.switching + onset < sensor.times[k]
        np.testing.assert_array_equal(np.isfinite(single.switching), known)
        np.testing.assert_allclose(
            single.switching[known], result.switching[known], rtol=0, atol=1e-12
        )


@pytest.mark.parametrize("motion", MOTIONS)
def test_batch_is_a_loop(prior, sensor, motion):
    """Bit by bit, in whatever order."""
    theta, onset = draws(prior, 40, "batch")
    batch = travel(theta, sensor.times, motion, onset=onset)
    for k in range(len(theta)):
        alone = travel(theta[[k]], sensor.times, motion, onset=onset[[k]])
        for one, many in zip(alone, batch, strict=True):
            assert one[0].tobytes() == many[k].tobytes()
    backwards = travel(theta[::-1], sensor.times, motion, onset=onset[::-1])
    assert backwards.travel[::-1].tobytes() == batch.travel.tobytes()


@pytest.mark.skipif(numba.config.NUMBA_NUM_THREADS < 2, reason="numba has only one thread here")
@pytest.mark.parametrize("motion", MOTIONS)
def test_threads_do_not_change_bytes(prior, sensor, motion):
    theta, onset = draws(prior, 500, "threads")
    before, results = numba.get_num_threads(), []
    try:
        for threads in (1, 2):
            numba.set_num_threads(threads)
            results.append(travel(theta, sensor.times, motion, onset=onset))
    finally:
        numba.set_num_threads(before)
    for one, two in zip(*results, strict=True):
        assert one.tobytes() == two.tobytes()


@pytest.mark.parametrize("motion", MOTIONS)
def test_blocks_do_not_change_bytes(prior, sensor, motion, monkeypatch):
    theta, onset = draws(prior, 200, "blocks")
    whole = travel(theta, sensor.times, motion, onset=onset)
    for rows in (1, 7, 64, 199):
        monkeypatch.setattr(curves, "_ROWS", rows)
        for one, many in zip(travel(theta, sensor.times, motion, onset=onset), whole, strict=True):
            assert one.tobytes() == many.tobytes()


@pytest.mark.parametrize("motion", MOTIONS)
def test_onset_shifts_the_motion(prior, sensor, motion):
    theta, onset = draws(prior, 20, "onset")
    onset *= 10  # so that some start before the record, and some late
    result = travel(theta, sensor.times, motion, onset=onset)
    for k, start in enumerate(onset):
        shifted = travel(theta[[k]], sensor.times - start, motion)
        np.testing.assert_allclose(result.travel[k], shifted.travel[0], rtol=0, atol=1e-12)
        assert result.switching[k] == pytest.approx(shifted.switching[0], abs=1e-12)
        rests = sensor.times <= start
        assert np.all(result.travel[k, rests] == rest_position(theta[k], motion))
    same = travel(theta, sensor.times, motion, onset=1.5).travel
    np.testing.assert_array_equal(
        same, travel(theta, sensor.times, motion, onset=np.full(20, 1.5)).travel
    )


@pytest.mark.parametrize("motion", MOTIONS)
def test_record_that_ends_before_the_motion(prior, motion):
    theta, _ = draws(prior, 3, "early")
    result = travel(theta, np.array([-5.0, -1.0, 2.0]), motion, onset=2.0)
    assert np.all(result.travel == rest_position(theta, motion)[:, None])
    assert np.all(np.isinf(result.switching))
    assert not result.reopening.any()


def test_rest_positions(prior):
    """Eqs. (6) and (7): the open state is zero; in the closed one all forces cancel."""
    theta, _ = draws(prior, 5, "rest")
    assert np.all(rest_position(theta, "closing") == 0)
    held = rest_position(theta, "opening")
    _, k_a, k_b, _, _, f, gap = theta.T
    np.testing.assert_allclose(f - k_a * held - k_b * (held - gap), 0.0, atol=1e-14)
    assert rest_position(theta.reshape(5, 1, 7), "opening").shape == (5, 1)


def test_motions_end_at_rest(prior):
    """Long after, closing holds where opening starts, and opening is back at zero."""
    theta, _ = draws(prior, 20, "end")
    late = np.array([5000.0])
    closed = travel(theta, late, "closing").travel[:, 0]
    np.testing.assert_allclose(closed, rest_position(theta, "opening"), rtol=1e-12)
    np.testing.assert_allclose(travel(theta, late, "opening").travel, 0.0, atol=1e-9)


def test_scaling_of_lengths_and_times(prior, sensor):
    """Lengths ten-fold: f and L. Times three-fold: k and f by 1/9, gamma by 1/3."""
    theta, _ = draws(prior, 20, "scaling")
    lengths = np.where(np.isin(NAMES, ["f", "L"]), 10.0, 1.0)
    rates = np.where(np.isin(NAMES, ["k_a", "k_b", "f"]), 1 / 9, 1.0)
    rates[np.isin(NAMES, ["gamma_a", "gamma_b"])] = 1 / 3
    for motion in MOTIONS:
        plain = travel(theta, sensor.times, motion)
        longer = travel(theta * lengths, sensor.times, motion)
        np.testing.assert_allclose(longer.travel, 10 * plain.travel, rtol=0, atol=1e-11)
        np.testing.assert_allclose(longer.switching, plain.switching, rtol=1e-12)
        slower = travel(theta * rates, 3 * sensor.times, motion)
        np.testing.assert_allclose(slower.travel, plain.travel, rtol=0, atol=1e-11)
        np.testing.assert_allclose(slower.switching, 3 * plain.switching, rtol=1e-12)


# ---- edges -----------------------------------------------------------------------------------


@pytest.mark.parametrize("motion", MOTIONS)
def test_event_exactly_at_a_sample(prior, sensor, motion):
    theta, _ = draws(prior, 20, "at a sample")
    usual = travel(theta, sensor.times, motion)
    for row, position, event in zip(theta[:, None], *usual[:2], strict=True):
        times = np.union1d(sensor.times, [event])
        at = np.searchsorted(times, event)
        result = travel(row, times, motion)
        assert result.switching[0] == pytest.approx(event, abs=1e-12)
        np.testing.assert_allclose(np.delete(result.travel[0], at), position, rtol=0, atol=1e-12)
        around = travel(row, event + np.array([-1e-9, 0, 1e-9]), motion).travel[0]
        assert result.travel[0, at] == pytest.approx(around[1], abs=1e-12)
        assert np.abs(np.diff(around)).max() < 1e-8  # 1e-9 ms at no more than 10 mm/ms
        # A record that ends there has the event or not, within round-off.
        for end, found in ((event - 1e-9, False), (event + 1e-9, True)):
            assert np.isfinite(travel(row, np.array([0.0, end]), motion).switching[0]) == found
        last = travel(row, np.array([0.0, event]), motion)
        assert last.travel[0, 1] == pytest.approx(around[1], abs=1e-12)
        assert last.switching[0] in (pytest.approx(event, abs=1e-12), np.inf)


def test_contact_never_reached(prior, sensor):
    """The force holds the drive short of the gap: free motion to the end."""
    theta, _ = draws(prior, 5, "never")
    theta = changed(theta, f=0.3 * theta[:, NAMES.index("k_a")] * theta[:, -1])
    result = travel(theta, sensor.times, "closing")
    assert np.all(np.isinf(result.switching))
    assert not result.reopening.any()
    for row, position in zip(theta, result.travel, strict=True):
        expected, _ = propagate(row, sensor.times, "closing", np.inf)
        np.testing.assert_allclose(position, expected, rtol=0, atol=1e-11)


@pytest.mark.parametrize("share", [0.5, 0.999, 1.0])
def test_contact_force_not_positive_at_the_start_parts_at_once(prior, sensor, share):
    theta, _ = draws(prior, 5, "parts at once")
    theta = changed(theta, f=share * theta[:, NAMES.index("k_a")] * theta[:, -1])
    result = travel(theta, sensor.times, "opening", onset=0.7)
    # At share 1 the force is zero within round-off, and so is the time.
    np.testing.assert_allclose(result.switching, 0.0, rtol=0, atol=0 if share < 1 else 1e-12)
    for row, position in zip(theta, result.travel, strict=True):
        expected, _ = propagate(row, sensor.times - 0.7, "opening", 0.0)
        np.testing.assert_allclose(position, expected, rtol=0, atol=1e-11)


def test_parting_at_once_is_the_limit_of_a_weak_contact(prior, sensor):
    theta, _ = draws(prior, 5, "weak contact")
    edge = theta[:, NAMES.index("k_a")] * theta[:, -1]
    weak = travel(changed(theta, f=edge * (1 + 1e-9)), sensor.times, "opening")
    none = travel(changed(theta, f=edge * (1 - 1e-9)), sensor.times, "opening")
    assert np.all((weak.switching > 0) & (weak.switching < 1e-3))
    assert np.all(none.switching == 0)
    np.testing.assert_allclose(weak.travel, none.travel, rtol=0, atol=1e-6)


def one_mass(theta, times, motion):
    """Drive and contact as one mass: (1 + 1/mu) x'' = f - k_a x - gamma_a x', before the touch."""
    mu, k_a, _, gamma_a, _, f, gap = theta
    mass = 1 + 1 / mu
    pull = f if motion == "closing" else 0.0
    matrix = np.array([[0, 1, 0], [-k_a / mass, -gamma_a / mass, pull / mass], [0, 0, 0]])
    start = np.array([0.0 if motion == "closing" else gap, 0, 1])
    return (expm(matrix * np.asarray(times)[:, None, None]) @ start)[:, 0]


def test_stiff_contact_spring_is_one_rigid_mass(prior):
    """The error of the limit falls with 1/k_b in closing and 1/sqrt(k_b) in opening, where the
    drive springs back by the little that the contact spring was pressed."""
    theta, _ = draws(prior, 3, "rigid")
    times = np.linspace(0.0, 58.0, 30)
    for row in theta:
        gap = row[-1]
        touch = brentq(lambda t, row=row: one_mass(row, [t], "closing")[0] - row[-1], 0.1, 30)
        before = times < touch - 0.1
        stop = np.where(before, one_mass(row, times, "closing"), gap)
        for k_b in (1e3, 1e5):
            stiff = changed(row, k_b=k_b)[None]
            closing = travel(stiff, times, "closing")
            assert np.abs(closing.switching[0] - touch) < 10 / k_b
            assert np.abs(closing.travel[0] - stop)[before].max() < 10 / k_b
            # The drive stops within v / sqrt(k_b) of the contact.
            after = times > touch + 0.1
            assert np.abs(closing.travel[0] - gap)[after].max() < 3 / np.sqrt(k_b)
            opening = travel(stiff, times, "opening")
            assert opening.switching[0] < 2 / np.sqrt(k_b)
            limit = one_mass(row, times, "opening")
            assert np.abs(opening.travel[0] - limit).max() < 2 / np.sqrt(k_b)


@pytest.mark.parametrize("k_b", [1e2, 1e3, 1e5])
@pytest.mark.parametrize("motion", MOTIONS)
def test_stiff_contact_spring_is_exact(prior, motion, k_b):
    """Nothing fails and nothing is lost, against matrix exponentials."""
    theta = changed(draws(prior, 3, "stiff")[0], k_b=k_b)
    times = np.linspace(0.0, 58.0, 16)
    for row, position, event in zip(theta, *travel(theta, times, motion)[:2], strict=True):
        expected, state = propagate(row, times, motion, event)
        np.testing.assert_allclose(position, expected, rtol=0, atol=1e-8)
        if motion == "closing":
            assert state[2] == pytest.approx(row[-1], abs=1e-8)
        else:
            assert contact_force(row, state) == pytest.approx(0.0, abs=1e-8)


def test_stiff_contact_spring_against_integration(prior):
    times = np.linspace(0.0, 20.0, 11)
    for motion in MOTIONS:
        theta = changed(draws(prior, 1, "stiff")[0], k_b=1e3)
        position, switching, _ = integrate(theta[0], times, motion)
        result = travel(theta, times, motion)
        np.testing.assert_allclose(result.travel[0], position, rtol=0, atol=1e-8)
        assert result.switching[0] == pytest.approx(switching, abs=1e-8)


# ---- touching only just ----------------------------------------------------------------------


def peaks(theta, end, step=0.02):
    """Times and heights of the free contact's maxima that are the highest so far."""
    mode, start = system(theta, "free", theta[NAMES.index("f")]), np.array([0, 0, 0, 0, 1.0])
    one_step = expm(mode * step)
    path = [start]
    for _ in range(int(end / step)):
        path.append(one_step @ path[-1])
    path = np.array(path)
    height = np.maximum.accumulate(path[:, 2])
    turns = np.flatnonzero((path[:-1, 3] > 0) & (path[1:, 3] <= 0))

    def refined(k):
        stop = brentq(lambda t: (expm(mode * t) @ path[k])[3], 0, step, xtol=1e-14)
        return k * step + stop, (expm(mode * stop) @ path[k])[2]

    found = [refined(k) for k in turns]
    return [(time, top) for (time, top), k in zip(found, turns, strict=True) if top >= height[k]]


def light_damping(n):
    """Drives that hardly lose energy: the contact's way has ripples, and several maxima in an
    interval of the method."""
    rng = generator(1, "test", "mechanism", "ripples")
    low = np.log([0.3, 0.05, 1e-3, 1e-3, 1e-3, 1.0, 1.0])
    high = np.log([30.0, 1.0, 3.0, 3e-2, 3e-2, 1.0, 1.0])
    return np.exp(rng.uniform(low, high, (n, 7)))


def assert_just_touches(theta, time, top, end):
    """The touch is there a little under a maximum and gone above it."""
    times = np.array([0.0, end])
    for below in (1e-4, 1e-7):
        result = travel(changed(theta, L=top * (1 - below))[None], times, "closing")
        mode, start = system(theta, "free", theta[NAMES.index("f")]), np.array([0, 0, 0, 0, 1.0])
        acceleration = (system(theta, "free", theta[5]) @ expm(mode * time) @ start)[3]
        # The parabola under the maximum; its next term is smaller by the root of ``below``.
        before = np.sqrt(2 * top * below / -acceleration)
        assert result.switching[0] < time
        assert result.switching[0] == pytest.approx(time - before, abs=0.2 * before)
        at_touch = (expm(mode * result.switching[0]) @ start)[2]
        assert at_touch == pytest.approx(top * (1 - below), rel=1e-11)


def test_touch_by_a_maximum_alone(prior):
    """A damped drive with little force: the contact touches at its first maximum or never."""
    theta, _ = draws(prior, 30, "grazing")
    theta = changed(theta, gamma_a=0.1)
    for row in theta:
        time, top = peaks(row, 60.0)[0]
        assert_just_touches(row, time, top, 60.0)
        above = changed(row, L=top * (1 + 1e-9))[None]
        assert np.isinf(travel(above, np.array([0.0, 60.0]), "closing").switching[0])


def test_touch_found_by_bisection(prior, sensor):
    """The largest gap that is still reached, found from the answers alone, is the maximum."""
    row = changed(draws(prior, 1, "bisection")[0][0], gamma_a=0.1)
    low, high = 1.0, 1000.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        reached = travel(changed(row, L=middle)[None], sensor.times, "closing").switching[0]
        low, high = (middle, high) if np.isfinite(reached) else (low, middle)
    _, top = peaks(row, 58.0)[0]
    assert low == pytest.approx(top, rel=1e-12)


def test_touch_by_a_ripple():
    """Every maximum that is the highest so far stops a contact whose gap lies just under it."""
    found = 0
    for row in light_damping(120):
        for time, top in peaks(row, 40.0):
            assert_just_touches(row, time, top, 40.0)
            found += 1
    assert found > 100


# ---- reopening -------------------------------------------------------------------------------


def lowest_force(theta, times, switching):
    """Lowest contact force after the touch of a closing, by matrix exponentials."""
    f, gap = theta[5], theta[6]
    _, state = propagate(theta, times, "closing", switching)
    start = np.array([state[0], state[1], gap, 0.0, 1.0])
    later = np.linspace(0.0, times[-1] - switching, 2000)
    step = expm(system(theta, "closed", f) * later[1])
    path = [start]
    for _ in later[1:]:
        path.append(step @ path[-1])
    return contact_force(theta, np.array(path)).min()


@pytest.fixture(scope="module")
def flagged(prior, sensor):
    """Closings of 20,000 prior draws whose contact reopens, and as many of the others."""
    theta, _ = draws(prior, 20_000, "reopening")
    flag = travel(theta, sensor.times, "closing").reopening
    assert 20 <= flag.sum() <= 100  # some 0.3 %
    return theta[flag], theta[~flag][: flag.sum()]


def test_reopening_is_where_the_force_falls_to_zero(flagged, sensor):
    for theta, expected in zip(flagged, (True, False), strict=True):
        for row in theta[:20]:
            position, switching, reopens = integrate(row, sensor.times, "closing")
            assert reopens == expected
            assert (lowest_force(row, sensor.times, switching) <= 0) == expected
            # It is flagged, not modelled: the curve goes on as if the contact stayed closed.
            curve = travel(row[None], sensor.times, "closing").travel[0]
            np.testing.assert_allclose(curve, position, rtol=0, atol=1e-8)


def test_edge_of_reopening(flagged, prior, sensor):
    """Between a flagged and an unflagged closing, where the flag turns, the lowest force is 0."""
    low, high = flagged[0][:20], flagged[1][:20]
    for _ in range(40):
        middle = np.sqrt(low * high)
        flag = travel(middle, sensor.times, "closing").reopening[:, None]
        low, high = np.where(flag, middle, low), np.where(flag, high, middle)
    switching = travel(low, sensor.times, "closing").switching
    forces = [lowest_force(row, sensor.times, s) for row, s in zip(low, switching, strict=True)]
    np.testing.assert_allclose(forces, 0.0, atol=1e-5)  # of forces around f = 0.75 mm/ms²


def test_no_opening_is_flagged(flagged, sensor):
    for theta in flagged:
        assert not travel(theta, sensor.times, "opening").reopening.any()


# ---- what is refused -------------------------------------------------------------------------


@pytest.mark.parametrize("wrong", [np.nan, np.inf, -np.inf, 0.0, -1.0])
@pytest.mark.parametrize("name", NAMES)
def test_impossible_parameters_are_refused_by_name(prior, sensor, name, wrong):
    theta, _ = draws(prior, 4, "refused")
    theta[2, NAMES.index(name)] = wrong
    message = rf"1 of 4 rows .* {name} = {wrong} in row 2"
    for motion in MOTIONS:
        with pytest.raises(ValueError, match=message):
            travel(theta, sensor.times, motion)


@pytest.mark.parametrize("shape", [(7,), (3, 6), (3, 8), (2, 3, 7)])
def test_wrongly_shaped_parameters_are_refused(sensor, shape):
    with pytest.raises(ValueError, match=r"\(n, 7\)"):
        travel(np.ones(shape), sensor.times, "closing")


@pytest.mark.parametrize(
    "times", [[0.0, 1.0, 1.0], [0.0, -1.0], [0.0, np.nan], [0.0, np.inf], [[0.0, 1.0]]]
)
def test_wrong_times_are_refused(prior, times):
    with pytest.raises(ValueError, match="times"):
        travel(prior.medians[None], np.array(times), "closing")


@pytest.mark.parametrize("onset", [np.nan, np.inf, [0.0], [[0.0, 0.0]], [0.0, np.nan]])
def test_wrong_onsets_are_refused(prior, sensor, onset):
    with pytest.raises(ValueError, match="onset"):
        travel(prior.medians[None].repeat(2, axis=0), sensor.times, "closing", onset=onset)


def test_unknown_motion_is_refused(prior, sensor):
    for function in (
        lambda: travel(prior.medians[None], sensor.times, "close"),
        lambda: rest_position(prior.medians, "close"),
    ):
        with pytest.raises(ValueError, match=r"unknown motion 'close'.*closing, opening"):
            function()


def test_arguments_are_left_alone(prior, sensor):
    theta, onset = draws(prior, 3, "left alone")
    copies = theta.copy(), sensor.times.copy(), onset.copy()
    times = sensor.times.copy()
    travel(theta, times, "opening", onset=onset)
    for value, copy in zip((theta, times, onset), copies, strict=True):
        np.testing.assert_array_equal(value, copy)


def test_no_operation_is_no_curve(sensor):
    result = travel(np.empty((0, 7)), sensor.times, "closing")
    assert result.travel.shape == (0, 151)
    assert result.switching.shape == result.reopening.shape == (0,)
