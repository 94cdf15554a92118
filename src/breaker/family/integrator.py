"""The compiled integration of a richer drive: forces, Runge-Kutta steps, touch and parting.

The state is arc and speed of the drive, position and speed of the contact. The numbers of a drive
come as one row, in the order of ``rich_drive.Drive``. Steps are of fifth order (Dormand & Prince,
1980, J. Comput. Appl. Math. 6, 19), each as long as its error allows. One file has all that may
change, as numba sees changes of one file only.
"""

import numpy as np
from scipy.integrate import RK45

from breaker.common.compiling import compiled

_fast = compiled()
STAGES = np.vstack([np.pad(RK45.A, ((0, 0), (0, 1))), RK45.B])  # the last is the step itself
TIMES, ERROR = STAGES.sum(axis=1), RK45.E

_LOADED = 1.5  # closing forces, beyond which friction does not grow with the load
_SMOOTH_WAY = 0.3  # mm, beyond which a preload is fully there
_SLOWEST = 0.02  # mm/ms, a contact that bounces with less stays
_LASTING = 4.0  # ms after the release, where a random force in time is largest
_HALVINGS = 60
_LOOKS = 40  # places along the way at which random forces may hold a drive up
_AT_EVENT = 1e-10  # mm or mm/ms^2, that a touch or a parting may be off
_AT_STOP = 1e-9  # mm, within which a contact is at its stop
_FIRST, _SHORTEST, _LONGEST = 0.01, 1e-8, 2.0  # ms, steps
_TOLERANCE = 1e-6  # mm and mm/ms, error of a step
_MOST = 100_000  # steps
_SHARES = 0.1, 0.5  # of the way, whose times are a motion's own measure
_FREE, _CLOSED, _FLYING = 0, 1, 2  # flying: a held contact has parted, but not reached its stop
_ELASTIC, _HELD, _SLIDING = 0, 1, 2

(MU, K_A, K_B, GAMMA_A, GAMMA_B, F, GAP, TURN, LEAN, DRY, PRE_A, PRE_B, BUILD_UP) = range(13)
(TRAIN_MASS, TRAIN_FRICTION, RESTITUTION, CLOSING_STOP) = range(13, 17)
OPENING_STOP, FALL, DRAG, CONTACT = 22, 28, 29, 31
WAY_FORCE, TIME_FORCE, SPEED_FORCE = 32, 39, 46
PROGRESS, STICK, GROWTH, DRAG_POWER, READING, SLIP, LOAD = *range(53, 58), 64, 65
FRICTION_SPEED = 66
REACH, DAMPING, POWER, DEPTH, STIFFNESS, PROFILE = range(6)  # of a stop, from its first number on
_STROKE = 10.0  # mm, to which the lever's turn and the fall of the force refer


@_fast
def _sign(x):
    """A smooth sign; the hyperbolic tangent costs as much as all other forces together."""
    return np.tanh(x) if abs(x) < 19.0 else np.sign(x)


@_fast
def _lever(n, arc):
    """Travel, its slope and its bend where the arm's end has moved along its arc."""
    bend = n[TURN] / _STROKE
    if bend < 1e-9:
        ratio = np.cos(n[LEAN])
        return arc * ratio, ratio, 0.0
    turn = bend * arc - n[LEAN]
    return (np.sin(turn) + np.sin(n[LEAN])) / bend, np.cos(turn), -bend * np.sin(turn)


@_fast
def _stop(n, first, beyond, speed):
    """Force against going further in, ``beyond`` mm past the rest position."""
    way = beyond + n[first + REACH]
    force = n[first + STIFFNESS] * max(0.0, beyond)
    if way > 0.0 and n[first + DAMPING] > 0.0:
        size = n[first + DAMPING] * min(1.0, way / n[first + DEPTH])
        if n[first + PROFILE] != 0.0:  # narrower and narrower where above 0, wider where below
            share = min(1.0, way / n[first + REACH]) if n[first + REACH] > 0.0 else 1.0
            size *= np.exp(n[first + PROFILE] * (share - 1.0 * (n[first + PROFILE] > 0.0)))
        power = size * abs(speed) ** n[first + POWER]
        force += power if speed > 0.0 else -power
    return max(0.0, force)


@_fast
def _waves(n, first, angle):
    """A smooth random function: three harmonics of an angle. With it the sine of the angle."""
    s, c = np.sin(angle), np.cos(angle)
    s2, c2 = 2.0 * s * c, c * c - s * s
    total = n[first + 1] * s + n[first + 2] * c + n[first + 3] * s2 + n[first + 4] * c2
    total += n[first + 5] * (s2 * c + c2 * s) + n[first + 6] * (c2 * c - s2 * s)
    return n[first] * total, s


@_fast
def _random(n, rest, time, closing, held, state):
    """Smooth random forces, which leave both rests where they are and begin with the motion."""
    total, share, speed = 0.0, state[0] / rest, abs(state[1])
    if n[WAY_FORCE] > 0.0 and 0.0 < share < 1.0:
        force, window = _waves(n, WAY_FORCE, np.pi * share)
        total += window * window * force
    if n[TIME_FORCE] > 0.0 and time < np.inf:
        age = time / _LASTING
        total += (1.0 - held) * age * np.exp(1.0 - age) * _waves(n, TIME_FORCE, age)[0]
    if n[SPEED_FORCE] > 0.0:  # even in the speed, so that it does not keep an oscillation alive
        window = speed * speed / (1.0 + speed * speed)
        total += window * _waves(n, SPEED_FORCE, 0.5 * np.pi * speed)[0]
    return total * (n[F] if closing else n[K_A] * rest)


@_fast
def _spring(n, mode, x, rate, state):
    """Force of the contact on the drive, of a travel x that changes at a rate; 0 where rigid."""
    if n[CONTACT] == _SLIDING or (n[CONTACT] == _HELD and mode == _FREE):
        return 0.0
    u = x - state[2]
    force = n[K_B] * u + n[GAMMA_B] * (rate - state[3])
    if n[CONTACT] == _HELD:
        return force + n[PRE_B]
    return force + n[PRE_B] * _sign(u / _SMOOTH_WAY) if n[PRE_B] > 0.0 else force


@_fast
def _held(n, time):
    """Share of the closing force that is still there at a time after it is released."""
    if not time < 40.0 * n[BUILD_UP]:
        return 0.0
    share = time / n[BUILD_UP]
    return np.exp(-share if n[GROWTH] == 1.0 else -(share ** n[GROWTH]))


@_fast
def _forces(n, rest, time, closing, mode, state):
    """Forces on the drive and on the contact, per drive mass, and the lever's slope and bend."""
    arc, speed = state[0], state[1]
    x, ratio, bend = _lever(n, arc)
    spring = _spring(n, mode, x, ratio * speed, state)
    held = _held(n, time)
    force = n[F] * (1.0 - n[FALL] * x / _STROKE) * (1.0 - held if closing else held)
    friction = n[GAMMA_A] * (1.0 + (n[TRAIN_FRICTION] if closing else 0.0))
    total = (
        force
        - n[K_A] * arc * (1.0 + n[PROGRESS] * arc / _STROKE)
        - friction * speed
        - ratio * spring
        - _stop(n, CLOSING_STOP, arc - rest, speed)
        + _stop(n, OPENING_STOP, -arc, -speed)
    )
    if n[PRE_A] > 0.0:
        total -= n[PRE_A] * _sign(arc / _SMOOTH_WAY)
    if n[DRY] > 0.0:
        size = n[DRY] * (1.0 + n[STICK] * np.exp(-abs(speed) / n[SLIP]))
        load = min((n[K_A] * abs(arc) + abs(spring)) / n[F], _LOADED)
        total -= size * (1.0 + n[LOAD] * (load - 1.0)) * _sign(speed / n[FRICTION_SPEED])
    if n[DRAG] > 0.0:
        drag = n[DRAG] * abs(speed) ** n[DRAG_POWER]
        total -= drag if speed > 0.0 else -drag
    if n[WAY_FORCE] + n[TIME_FORCE] + n[SPEED_FORCE] > 0.0 and rest < np.inf:
        total += _random(n, rest, time, closing, held, state)
    return total, spring, ratio, bend


@_fast
def closed_rest(n):
    """Arc at rest, held closed by the closing force, by bisection; nan where the contact is not
    pressed, the lever is past its dead centre, or random forces hold the drive up on its way.
    """
    low, high = 0.0, 5.0 * n[GAP]
    for _ in range(_HALVINGS):
        arc = 0.5 * (low + high)
        pulls = _forces(n, np.inf, np.inf, True, _CLOSED, (arc, 0.0, n[GAP], 0.0))[0] > 0.0
        low, high = (arc, high) if pulls else (low, arc)
    x, ratio, _ = _lever(n, low)
    if x <= n[GAP] or ratio <= 0.0 or low >= 5.0 * n[GAP] * (1.0 - 1e-9):
        return np.nan
    for i in range(1, _LOOKS if n[WAY_FORCE] > 0.0 else 1):
        arc = low * i / _LOOKS
        x = _lever(n, arc)[0]
        mode, state = (_FREE if x < n[GAP] else _CLOSED), (arc, 0.0, min(x, n[GAP]), 0.0)
        closes = _forces(n, low, np.inf, True, mode, state)[0] > 0.0
        if not closes or _forces(n, low, np.inf, False, mode, state)[0] >= 0.0:
            return np.nan
    return 0.5 * (low + high)


@_fast
def _rates(n, rest, time, closing, mode, state, out, row):
    """Time derivatives of the state, into a row of ``out``; a view of it would cost as much."""
    speed = state[1]
    total, spring, ratio, bend = _forces(n, rest, time, closing, mode, state)
    mass = 1.0 + (n[TRAIN_MASS] if closing else 0.0)
    if n[CONTACT] == _HELD and mode == _FREE:
        mass += ratio * ratio / n[MU]
        total -= ratio * bend * speed * speed / n[MU]
    flies = mode == _FLYING or (n[CONTACT] == _ELASTIC and mode == _FREE)
    moves = 1.0 if flies else 0.0
    out[row, 0], out[row, 1] = speed, total / mass
    out[row, 2], out[row, 3] = moves * state[3], moves * n[MU] * spring


@_fast
def _advance(n, rest, time, closing, mode, state, h, new, k):
    """One step of size h, into ``new``, from the rates in ``k[0]``; those of its end in ``k[6]``.

    Returns its error, mm and mm/ms; nan where it is not finite.
    """
    for stage in range(1, 7):
        for i in range(4):
            rate = 0.0
            for j in range(stage):
                rate += STAGES[stage, j] * k[j, i]
            new[i] = state[i] + h * rate
        _rates(n, rest, time + TIMES[stage] * h, closing, mode, new, k, stage)
    square = 0.0
    for i in range(4):
        off = 0.0
        for j in range(7):
            off += ERROR[j] * k[j, i]
        square += off * off
    return h * np.sqrt(square)


@_fast
def _margin(n, rest, time, closing, mode, state):
    """Positive as long as the mode lasts: way to the touch or to the parting, or contact force."""
    if n[CONTACT] != _SLIDING and mode == _CLOSED:
        force = _forces(n, rest, time, closing, mode, state)[1]
        return force if n[CONTACT] == _ELASTIC else min(force, _lever(n, state[0])[0] - n[GAP])
    if mode == _FLYING:
        return _lever(n, state[0])[0] - state[2]
    way = n[GAP] - (state[2] if n[CONTACT] == _ELASTIC else _lever(n, state[0])[0])
    return way if mode == _FREE else -way


@_fast
def _switch(n, closing, mode, state):
    """Mode after the touch or the parting; changes the state in place."""
    if n[CONTACT] == _HELD and mode != _FREE:
        x, ratio, _ = _lever(n, state[0])
        if mode == _CLOSED and x - n[GAP] > _AT_STOP:
            return _FLYING
        mass = 1.0 + (n[TRAIN_MASS] if closing else 0.0)  # picks the contact up
        state[1] = (mass * state[1] + ratio * state[3] / n[MU]) / (mass + ratio * ratio / n[MU])
        state[2], state[3] = n[GAP], 0.0
        return _FREE
    back = n[RESTITUTION] * state[3]  # of an elastic contact; all others are at rest
    state[2], state[3] = n[GAP], -back if back > _SLOWEST else 0.0
    return _CLOSED if mode == _FREE and back <= _SLOWEST else _FREE


@_fast
def _located(n, rest, time, closing, mode, state, h, new, k):
    """Time in a step of size h after which the mode ends, by the rule of false position.

    Takes that step again, up to there. An end that stays for a second time counts half (Illinois).
    """
    low, high, side = 0.0, h, 0.0
    above = max(0.0, _margin(n, rest, time, closing, mode, state))
    below = _margin(n, rest, time + h, closing, mode, new)
    for _ in range(_HALVINGS):
        h = low + (high - low) * above / (above - below)
        _advance(n, rest, time, closing, mode, state, h, new, k)
        margin = _margin(n, rest, time + h, closing, mode, new)
        if abs(margin) < _AT_EVENT:
            break
        if margin > 0.0:
            low, above, below = h, margin, below * (0.5 if side > 0.0 else 1.0)
        else:
            high, below, above = h, margin, above * (0.5 if side < 0.0 else 1.0)
        side = margin
    return h


@_fast
def _keep(n, stroke, state, rates, ends):
    """What a transducer reads, its speed and its acceleration, into ``ends``."""
    x, ratio, bend = _lever(n, state[0])
    ends[0], ends[1], ends[2] = x, ratio * state[1], ratio * rates[1] + bend * state[1] * state[1]
    if n[READING] > 0.0:
        slope, curves = 1.0, 0.0
        for k in range(1, 7):
            turn, size = k * np.pi / stroke, n[READING] * n[READING + k] / k
            ends[0] += size * np.sin(turn * x) / turn
            slope += size * np.cos(turn * x)
            curves -= size * turn * np.sin(turn * x)
        ends[2] = slope * ends[2] + curves * ends[1] * ends[1]
        ends[1] *= slope


@_fast
def _copy(one, other):
    """Copy four numbers; numba takes 3 s longer to compile an assignment of the whole."""
    for i in range(4):
        other[i] = one[i]


@_fast
def follow(n, rest, closing, end, beyond):
    """Steps of a motion after the release, and when the contact first touches or parts.

    Args:
        n: Numbers of the drive, of size 1.
        rest: Its closed position, from ``closed_rest``.
        closing: Whether it closes.
        end: Time until which the motion is followed, ms.
        beyond: Time after 10 % of the way until which it is followed, in times from 10 to 50 %.

    Returns:
        Steps ``(s, 8)``: begin and length, ms, and six coefficients of the reading in powers of the
        share of a step, mm; and the time of the switching, ms, ``inf`` if there is none. No steps
        where the motion is not finite or takes too many.
    """
    steps, count, switching = np.empty((_MOST, 8)), 0, np.inf
    state, new, k = np.zeros(4), np.zeros(4), np.zeros((7, 4))
    mode = _FREE
    if not closing:
        state[0], state[2], mode = rest, n[GAP], _CLOSED
    begin, stroke = _lever(n, state[0])[0], _lever(n, rest)[0]
    now, h, first = 0.0, _FIRST, np.inf
    _rates(n, rest, now, closing, mode, state, k, 0)
    while now < end:
        error = _advance(n, rest, now, closing, mode, state, h, new, k) / _TOLERANCE
        if count == _MOST or h < _SHORTEST:
            return steps[:0], switching
        factor = 0.9 * max(error, 1e-4) ** -0.2 if error < np.inf else 0.0
        if not error <= 1.0:
            h *= max(0.2, factor)
            continue
        # As in the model a contact stays after its touch, but for one that the drive holds.
        watched = closing == (mode == _FREE) or mode == _FLYING or (closing and n[CONTACT] == _HELD)
        over = watched and _margin(n, rest, now + h, closing, mode, new) < 0.0
        taken = _located(n, rest, now, closing, mode, state, h, new, k) if over else h
        steps[count, 0], steps[count, 1] = now, taken
        _keep(n, stroke, state, k[0], steps[count, 2:])
        _keep(n, stroke, new, k[6], steps[count, 5:])
        way = abs(steps[count, 5] - begin) / stroke
        count += 1
        first = min(first, now) if way >= _SHARES[0] else first
        now += taken
        if way >= _SHARES[1]:
            end = min(end, first + beyond * (now - first))
        _copy(new, state)
        if over:
            switching = min(switching, now)
            mode = _switch(n, closing, mode, state)
            _rates(n, rest, now, closing, mode, state, k, 0)
            h = min(h, _FIRST)
        else:
            _copy(k[6], k[0])
            h = min(_LONGEST, h * factor)
    return steps[:count].copy(), switching
