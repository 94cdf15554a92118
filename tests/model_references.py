"""References for the model, written from the paper's equations.

They share nothing with it but the order of the parameters: ``integrate`` (``solve_ivp`` with event
location) and ``propagate`` (matrix exponentials, exact where the time of the event is known).
"""

import numpy as np
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from breaker.model.parameters import NAMES

TIGHT = {"method": "DOP853", "rtol": 1e-11, "atol": 1e-12}


def changed(theta, **values):
    """Parameters ``(..., p)`` with some of them set by name."""
    theta = np.array(theta, dtype=np.float64)
    for name, value in values.items():
        theta[..., NAMES.index(name)] = value
    return theta


def integrate(theta, times, motion):
    """Integrate one operation that starts at 0: travel (t,) and switching time."""
    mu, k_a, k_b, gamma_a, gamma_b, f, gap = theta.tolist()
    closing, held = motion == "closing", (f + k_b * gap) / (k_a + k_b)
    pull = f if closing else 0.0

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
    mode, event, next_mode = (free, distance, closed) if closing else (closed, force, free)
    start = np.zeros(4) if closing else np.array([held, 0, gap, 0])
    event.terminal = True
    position = np.full(len(times), start[0])
    before = solve_ivp(mode, (0, times[-1]), start, events=event, dense_output=True, **TIGHT)
    touched = before.t_events[0].size > 0
    switching = before.t_events[0][0] if touched else np.inf
    first, second = (times > 0) & (times <= switching), times > switching
    if first.any():
        position[first] = before.sol(times[first])[0]
    if not touched:
        return position, switching
    state = before.y[:, -1].copy()
    if closing:
        state[2:] = gap, 0.0
    after = solve_ivp(next_mode, (switching, times[-1]), state, t_eval=times[second], **TIGHT)
    position[second] = after.y[0]
    return position, switching


def system(theta, mode, pull):
    """Matrix (5, 5) of the linear system of (x_a, v_a, x_b, v_b, 1)."""
    mu, k_a, k_b, gamma_a, gamma_b, _, _ = theta
    matrix = np.zeros((5, 5), dtype=theta.dtype)
    matrix[0, 1] = 1.0
    matrix[1] = -(k_a + k_b), -(gamma_a + gamma_b), k_b, gamma_b, pull
    if mode == "free":
        matrix[2, 3] = 1.0
        matrix[3] = mu * k_b, mu * gamma_b, -mu * k_b, -mu * gamma_b, 0.0
    return matrix


def propagate(theta, times, motion, switching):
    """Travel (t,) of one operation that starts at 0 and switches at a known time, its state
    (x_a, v_a, x_b, v_b, 1) just before, and the matrix of its first mode.

    Parameters and times may be complex: what is before and after is a matter of their real parts.
    """
    _, k_a, k_b, _, _, f, gap = theta
    held, closing = (f + k_b * gap) / (k_a + k_b), motion == "closing"
    pull, modes = (f, ("free", "closed")) if closing else (0.0, ("closed", "free"))
    first, second = (system(theta, mode, pull) for mode in modes)
    start = np.array([0.0, 0, 0, 0, 1] if closing else [held, 0, gap, 0, 1.0])
    position = np.full(len(times), start[0], dtype=theta.dtype)
    now, event = np.real(times), np.real(switching)
    state = expm(first * (switching if event < np.inf else times[-1])) @ start
    before, after = (now > 0) & (now <= event), now > event
    position[before] = (expm(first * times[before, None, None]) @ start)[:, 0]
    if after.any():
        then = state.copy()
        then[2:4] = gap, 0.0
        position[after] = (expm(second * (times[after] - switching)[:, None, None]) @ then)[:, 0]
    return position, state, first


def contact_force(theta, state):
    _, _, k_b, _, gamma_b, _, gap = theta
    return k_b * (state[..., 0] - gap) + gamma_b * state[..., 1]
