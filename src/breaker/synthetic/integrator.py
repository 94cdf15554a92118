"""The compiled integration of a richer drive: forces, Runge-Kutta steps, touch and parting.

The state is arc and speed of the drive, position and speed of the contact, and reading and speed of
the transducer. The numbers of a drive come as one row, in the order of ``drive.Drive``; see there
for their meaning.
"""

import numpy as np

from breaker.mechanism import compiled

__all__ = ["closed_rest", "travel"]

_fast = compiled()

_SMOOTH_SPEED = 0.02  # mm/ms, above which dry friction is fully there
_SMOOTH_WAY = 0.3  # mm, beyond which a preload is fully there
_SLOWEST = 0.02  # mm/ms, a contact that bounces with less stays
_RINGING = 0.05  # damping ratio of the linkage that carries the transducer
_HALVINGS = 60
_FREE, _CLOSED = 0, 1

(MU, K_A, K_B, GAMMA_A, GAMMA_B, F, GAP, TURN, LEAN, DRY, PRE_A, PRE_B, BUILD_UP) = range(13)
(TRAIN_MASS, TRAIN_FRICTION, RESTITUTION, CLOSING_STOP) = range(13, 17)
OPENING_STOP, FALL, DRAG, LINKAGE = 21, 26, 27, 28
REACH, DAMPING, POWER, DEPTH, STIFFNESS = range(5)  # of a stop, from its first number on
_STROKE = 10.0  # mm, to which the lever's turn and the fall of the force refer


@_fast
def _lever(n, arc):
    """Travel and its slope where the arm's end has moved along its arc."""
    bend = n[TURN] / _STROKE
    turn = bend * arc - n[LEAN]
    if bend < 1e-9:
        return arc * np.cos(n[LEAN]), np.cos(n[LEAN])
    return (np.sin(turn) + np.sin(n[LEAN])) / bend, np.cos(turn)


@_fast
def _stop(n, first, beyond, speed):
    """Force against going further in, ``beyond`` mm past the rest position."""
    way = beyond + n[first + REACH]
    force = n[first + STIFFNESS] * max(0.0, beyond)
    if way > 0.0 and n[first + DAMPING] > 0.0:
        size = n[first + DAMPING] * min(1.0, way / n[first + DEPTH])
        power = size * abs(speed) ** n[first + POWER]
        force += power if speed > 0.0 else -power
    return max(0.0, force)


@_fast
def _forces(n, rest, time, closing, state):
    """Forces on the drive and on the contact, per drive mass."""
    arc, speed, contact, contact_speed = state[0], state[1], state[2], state[3]
    x, ratio = _lever(n, arc)
    u = x - contact
    spring = (
        n[K_B] * u
        + n[GAMMA_B] * (ratio * speed - contact_speed)
        + n[PRE_B] * np.tanh(u / _SMOOTH_WAY)
    )
    held = np.exp(-time / n[BUILD_UP]) if n[BUILD_UP] > 0.0 else 0.0
    force = n[F] * (1.0 - n[FALL] * x / _STROKE) * (1.0 - held if closing else held)
    friction = n[GAMMA_A] * (1.0 + (n[TRAIN_FRICTION] if closing else 0.0))
    total = (
        force
        - n[K_A] * arc
        - n[PRE_A] * np.tanh(arc / _SMOOTH_WAY)
        - friction * speed
        - n[DRY] * np.tanh(speed / _SMOOTH_SPEED)
        - n[DRAG] * speed * abs(speed)
        - ratio * spring
        - _stop(n, CLOSING_STOP, arc - rest, speed)
        + _stop(n, OPENING_STOP, -arc, -speed)
    )
    return total, spring


@_fast
def closed_rest(n):
    """Arc at rest, held closed by the closing force, by bisection; nan without contact force."""
    low, high = 0.0, 5.0 * n[GAP]
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        if _forces(n, np.inf, np.inf, True, (middle, 0.0, n[GAP], 0.0))[0] > 0.0:
            low = middle
        else:
            high = middle
    pressed = _forces(n, np.inf, np.inf, True, (low, 0.0, n[GAP], 0.0))[1] > 0.0
    return 0.5 * (low + high) if pressed else np.nan


@_fast
def _rates(n, rest, time, closing, mode, state, out):
    """Time derivatives of the state, into ``out``."""
    total, spring = _forces(n, rest, time, closing, state)
    out[0] = state[1]
    out[1] = total / (1.0 + (n[TRAIN_MASS] if closing else 0.0))
    out[2] = state[3] if mode == _FREE else 0.0
    out[3] = n[MU] * spring if mode == _FREE else 0.0
    if n[LINKAGE] > 0.0:
        x, ratio = _lever(n, state[0])
        rate = 2.0 * np.pi / n[LINKAGE]
        out[4] = state[5]
        out[5] = rate * rate * (x - state[4]) + 2 * _RINGING * rate * (ratio * state[1] - state[5])


@_fast
def _advance(n, rest, time, closing, mode, state, h, new, k):
    """One classical Runge-Kutta step of size h, into ``new``; ``k`` is room for its stages."""
    _rates(n, rest, time, closing, mode, state, k[0])
    for stage in range(1, 4):
        w = h if stage == 3 else 0.5 * h
        for i in range(state.size):
            new[i] = state[i] + w * k[stage - 1, i]
        _rates(n, rest, time + w, closing, mode, new, k[stage])
    for i in range(state.size):
        new[i] = state[i] + h / 6.0 * (k[0, i] + 2.0 * k[1, i] + 2.0 * k[2, i] + k[3, i])


@_fast
def _left(n, rest, time, closing, mode, state):
    """Positive as long as the mode lasts: way to the touch, or contact force."""
    if mode == _FREE:
        return n[GAP] - state[2]
    return _forces(n, rest, time, closing, state)[1]


@_fast
def _switch(n, mode, state):
    """Mode after the touch or the parting; changes the contact's state in place."""
    speed = state[3]
    state[2], state[3] = n[GAP], 0.0
    if mode == _CLOSED:
        return _FREE
    if n[RESTITUTION] * speed > _SLOWEST:
        state[3] = -n[RESTITUTION] * speed
        return _FREE
    return _CLOSED


@_fast
def travel(n, rest, closing, times, step):
    """Travel at times after the release, ``(t,)``, and when the contact first switches.

    See ``drive.Drive.operate``.
    """
    result, switching = np.empty(times.size), np.inf
    state, new = np.zeros(6), np.zeros(6)
    k = np.zeros((4, 6))
    mode = _FREE
    if not closing:
        state[0] = rest
        state[2] = n[GAP]
        mode = _CLOSED
    begin = state[4] = _lever(n, state[0])[0]
    i = 0
    while i < times.size and times[i] <= 0.0:
        result[i] = begin
        i += 1
    now = 0.0
    while i < times.size:
        h = step
        _advance(n, rest, now, closing, mode, state, h, new, k)
        # A contact that stays after its touch does not part again, as in the model.
        ends = closing == (mode == _FREE) and _left(n, rest, now + h, closing, mode, new) < 0.0
        if ends:
            low, high = 0.0, 1.0
            for _ in range(_HALVINGS):
                middle = 0.5 * (low + high)
                _advance(n, rest, now, closing, mode, state, middle * step, new, k)
                if _left(n, rest, now + middle * step, closing, mode, new) < 0.0:
                    high = middle
                else:
                    low = middle
            h = high * step
            _advance(n, rest, now, closing, mode, state, h, new, k)
        while i < times.size and times[i] <= now + h:
            u = (times[i] - now) / h
            if n[LINKAGE] > 0.0:
                result[i] = _between(state[4:], new[4:], h, u)
            else:
                result[i] = _lever(n, _between(state, new, h, u))[0]
            i += 1
        now += h
        state[:] = new
        if ends:
            switching = min(switching, now)
            mode = _switch(n, mode, state)
    return result, switching


@_fast
def _between(state, new, h, u):
    """First of a state within a step, by the cubic through both ends and their speeds."""
    a, b = state[0], new[0]
    va, vb = h * state[1], h * new[1]
    v = u - 1.0
    return a * (1 + 2 * u) * v * v + va * u * v * v + b * u * u * (3 - 2 * u) + vb * u * u * v
