"""Compiled integration of a richer drive: forces, Runge-Kutta steps, events of the contact, curves.

The state is arc and speed of the drive, position and speed of the contact. The numbers ``n`` of a
drive of size 1 are ``rich_drive.Drive.numbers``. Steps are of fifth order (Dormand &
Prince, 1980, J. Comput. Appl. Math. 6, 19), each as long as its error allows.

Within a step the travel is the polynomial of the fifth degree through travel, speed and
acceleration at both ends. The linkage of a transducer follows it as a slightly damped oscillator,
``d'' + 2 z w d' + w^2 d = -x''`` for the difference d of reading and travel x, solved exactly. All
compiled functions are in one file, because numba does not detect changes in other files.
"""

from enum import IntEnum

import numpy as np
from scipy.integrate import RK45

from breaker.common.compiling import compiled
from breaker.family.shape import LEVELS

_fast = compiled()
STAGES = np.vstack([np.column_stack([RK45.A, np.zeros_like(RK45.C)]), RK45.B])  # last: the step
TIMES, ERROR = sum(STAGES.T), RK45.E
# Begin and length of a piece, ms; coefficients of powers of the share of the piece, mm; oscillation
# of the linkage: coefficients of cosine and sine, mm, decay, and phase, 0 if the linkage is rigid.
_FREE = [(name, float) for name in ("cosine", "sine", "decay", "turn")]
_PIECE = np.dtype((np.record, [("begin", float), ("length", float), ("powers", "6f8"), *_FREE]))

_LOADED = 1.5  # load in closing forces, above which dry friction does not grow
_SMOOTH_WAY = 0.3  # mm, over which a preload sets in
_SLOWEST = 0.02  # mm/ms; a contact that rebounds more slowly stays closed
_LASTING = 4.0  # ms after the start of motion, at which a random force in time is largest
_RINGING = 0.05  # damping ratio z of the linkage
STROKE = 10.0  # mm, reference length of the lever's turn and the fall of the force
_LOOKS = 40  # positions at which random forces must not stop a drive
_FINEST = 50  # halvings of a piece, and largest number of iterations to locate an event
_AT_EVENT = 1e-10  # mm or mm/ms^2, tolerance of contact touch and separation
_STEPS = 0.01, 2.0  # ms, first step after an event, and longest step
_TOLERANCE = 1e-6  # mm and mm/ms, error of a step
_MOST = 100_000  # steps of a motion


Contact = IntEnum("Contact", ["ELASTIC", "HELD", "SLIDING"], start=0)
_Mode = IntEnum("_Mode", ["FREE", "CLOSED", "FLYING"], start=0)
"""Modes of the contact; a held contact that flies has separated, but not reached its stop."""


@_fast
def _sign(x):
    """Return a smooth sign, without ``tanh`` where it is 1, as it costs as much as all forces."""
    return np.tanh(x) if abs(x) < 19.0 else np.sign(x)


@_fast
def _lever(n, arc):
    """Return travel, and its first and second derivative by the arc of the arm's end."""
    bend, ratio = n.lever_turn / STROKE, np.cos(n.lever_lean)
    if bend < 1e-9:
        return arc * ratio, ratio, 0.0
    turn = bend * arc - n.lever_lean
    return (np.sin(turn) + np.sin(n.lever_lean)) / bend, np.cos(turn), -bend * np.sin(turn)


@_fast
def _stop(stop, beyond, speed):
    """Return the force of a stop, ``beyond`` mm past the rest position."""
    way = beyond + stop.reach
    force = stop.stiffness * max(0.0, beyond)
    if way > 0.0 and stop.damping > 0.0:
        size = stop.damping * min(1.0, way / stop.depth)
        if stop.profile != 0.0:  # above 0, damping grows towards the end; below 0, it falls
            share = min(1.0, way / stop.reach) if stop.reach > 0.0 else 1.0
            size *= np.exp(stop.profile * (share - 1.0 * (stop.profile > 0.0)))
        power = size * abs(speed) ** stop.power
        force += power if speed > 0.0 else -power
    return max(0.0, force)


@_fast
def _waves(waves, angle):
    """Return a smooth random function, three harmonics of an angle, and the sine of the angle."""
    a, s, c = waves.harmonics, np.sin(angle), np.cos(angle)
    s2, c2 = 2.0 * s * c, c * c - s * s
    total = a[0] * s + a[1] * c + a[2] * s2 + a[3] * c2
    total += a[4] * (s2 * c + c2 * s) + a[5] * (c2 * c - s2 * s)
    return waves.share * total, s


@_fast
def _random(n, rest, time, closing, held, state):
    """Return smooth random forces, which begin with the motion and vanish at rest positions."""
    total, share, speed = 0.0, state[0] / rest, abs(state[1])
    if n.way_force.share > 0.0 and 0.0 < share < 1.0:
        force, window = _waves(n.way_force, np.pi * share)
        total += window * window * force
    if n.time_force.share > 0.0 and time < np.inf:
        age = time / _LASTING
        total += (1.0 - held) * age * np.exp(1.0 - age) * _waves(n.time_force, age)[0]
    if n.speed_force.share > 0.0:  # even in the speed, so that it sustains no oscillation
        window = speed * speed / (1.0 + speed * speed)
        total += window * _waves(n.speed_force, 0.5 * np.pi * speed)[0]
    return total * (n.f if closing else n.k_a * rest)


@_fast
def _forces(n, rest, time, closing, mode, state):
    """Return forces on drive and of contact, per drive mass, and derivatives of the lever."""
    arc, speed, spring, held = state[0], state[1], 0.0, 0.0
    x, ratio, bend = _lever(n, arc)
    if n.contact == Contact.ELASTIC or (n.contact == Contact.HELD and mode != _Mode.FREE):
        u = x - state[2]  # else the contact moves rigidly, or slides without force
        spring = n.k_b * u + n.gamma_b * (ratio * speed - state[3])
        if n.contact == Contact.HELD:
            spring += n.contact_preload
        elif n.contact_preload > 0.0:
            spring += n.contact_preload * _sign(u / _SMOOTH_WAY)
    if time < 40.0 * n.build_up:  # share of the closing force: missing in closing, left in opening
        held = np.exp(-((time / n.build_up) ** n.growth))
    force = n.f * (1.0 - n.force_fall * x / STROKE) * (1.0 - held if closing else held)
    friction = n.gamma_a * (1.0 + (n.train_friction if closing else 0.0))
    total = force - n.k_a * arc * (1.0 + n.opening_progress * arc / STROKE) - friction * speed
    total -= ratio * spring
    total -= _stop(n.closing_stop, arc - rest, speed)
    total += _stop(n.opening_stop, -arc, -speed)
    if n.opening_preload > 0.0:
        total -= n.opening_preload * _sign(arc / _SMOOTH_WAY)
    if n.dry_friction > 0.0:
        size = n.dry_friction * (1.0 + n.stick * np.exp(-abs(speed) / n.slip))
        load = min((n.k_a * abs(arc) + abs(spring)) / n.f, _LOADED)
        total -= size * (1.0 + n.load * (load - 1.0)) * _sign(speed / n.friction_speed)
    if n.drag > 0.0:
        drag = n.drag * abs(speed) ** n.drag_power
        total -= drag if speed > 0.0 else -drag
    if n.way_force.share + n.time_force.share + n.speed_force.share > 0.0 and rest < np.inf:
        total += _random(n, rest, time, closing, held, state)
    return total, spring, ratio, bend


@_fast
def closed_rest(n):
    """Return the arc of the closed rest position, by bisection; nan if the contact is not pressed,
    the lever is past its dead centre, or random forces stop the drive before.
    """
    low, arc, high = 0.0, 2.5 * n.L, 5.0 * n.L
    while low < arc < high:  # until no number is between the ends
        pulls = _forces(n, np.inf, np.inf, True, _Mode.CLOSED, (arc, 0.0, n.L, 0.0))[0] > 0.0
        low, high = (arc, high) if pulls else (low, arc)
        arc = 0.5 * (low + high)
    x, ratio, _ = _lever(n, low)
    if x <= n.L or ratio <= 0.0 or low >= 5.0 * n.L * (1.0 - 1e-9):
        return np.nan
    for i in range(1, _LOOKS if n.way_force.share > 0.0 else 1):
        place = low * i / _LOOKS
        x = _lever(n, place)[0]
        mode, state = (_Mode.FREE if x < n.L else _Mode.CLOSED), (place, 0.0, min(x, n.L), 0.0)
        closes = _forces(n, low, np.inf, True, mode, state)[0] > 0.0
        if not closes or _forces(n, low, np.inf, False, mode, state)[0] >= 0.0:
            return np.nan
    return arc


@_fast
def _rates(n, rest, time, closing, mode, state, out, row):
    """Write time derivatives of the state to a row of ``out``; a view of the row is costly."""
    speed = state[1]
    total, spring, ratio, bend = _forces(n, rest, time, closing, mode, state)
    mass = 1.0 + (n.train_mass if closing else 0.0)
    if n.contact == Contact.HELD and mode == _Mode.FREE:
        mass += ratio * ratio / n.mu
        total -= ratio * bend * speed * speed / n.mu
    flies = mode == _Mode.FLYING or (n.contact == Contact.ELASTIC and mode == _Mode.FREE)
    moves = 1.0 if flies else 0.0
    out[row, 0], out[row, 1] = speed, total / mass
    out[row, 2], out[row, 3] = moves * state[3], moves * n.mu * spring


@_fast
def _advance(n, rest, time, closing, mode, state, h, new, k):
    """Take a step of size h from the rates in ``k[0]``; write the state to ``new``, and its rates
    to ``k[6]``. Return the error, mm and mm/ms; nan if it is not finite.
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
    """Return a distance to the next event, or the contact force: positive while the mode lasts."""
    if n.contact != Contact.SLIDING and mode == _Mode.CLOSED:
        force = _forces(n, rest, time, closing, mode, state)[1]
        return force if n.contact == Contact.ELASTIC else min(force, _lever(n, state[0])[0] - n.L)
    if mode == _Mode.FLYING:
        return _lever(n, state[0])[0] - state[2]
    way = n.L - (state[2] if n.contact == Contact.ELASTIC else _lever(n, state[0])[0])
    return way if mode == _Mode.FREE else -way


@_fast
def _switch(n, closing, mode, state):
    """Return the mode after contact touch or separation; change the state in place."""
    if n.contact == Contact.HELD and mode != _Mode.FREE:
        x, ratio, _ = _lever(n, state[0])
        if mode == _Mode.CLOSED and x - n.L > _AT_EVENT:
            return _Mode.FLYING
        mass = 1.0 + (n.train_mass if closing else 0.0)  # the drive picks the contact up
        state[1] = (mass * state[1] + ratio * state[3] / n.mu) / (mass + ratio * ratio / n.mu)
        state[2], state[3] = n.L, 0.0
        return _Mode.FREE
    back = n.restitution * state[3]  # only elastic contacts move
    state[2], state[3] = n.L, -back if back > _SLOWEST else 0.0
    return _Mode.CLOSED if mode == _Mode.FREE and back <= _SLOWEST else _Mode.FREE


@_fast
def _located(n, rest, time, closing, mode, state, h, new, k):
    """Return the time in a step at which the mode ends, by false position, and take the step again
    up to there. An end that stays twice counts half (Illinois algorithm).
    """
    low, high, side = 0.0, h, 0.0
    above = max(0.0, _margin(n, rest, time, closing, mode, state))
    below = _margin(n, rest, time + h, closing, mode, new)
    for _ in range(_FINEST):
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
def _reading(n, stroke, state, rates):
    """Return the reading of a transducer without a linkage, its speed and its acceleration."""
    x, ratio, bend = _lever(n, state[0])
    speed = ratio * state[1]
    acceleration = ratio * rates[1] + bend * state[1] * state[1]
    if not n.reading.share > 0.0:
        return x, speed, acceleration
    reads, slope, curves = x, 1.0, 0.0
    for k in range(1, 7):
        turn, size = k * np.pi / stroke, n.reading.share * n.reading.harmonics[k - 1] / k
        reads += size * np.sin(turn * x) / turn
        slope += size * np.cos(turn * x)
        curves -= size * turn * np.sin(turn * x)
    return reads, speed * slope, slope * acceleration + curves * speed * speed


@_fast
def _join(piece, begin, h, start, end):
    """Set a piece to the polynomial between two readings with their speeds and accelerations."""
    way = end[0] - start[0] - h * start[1] - 0.5 * h * h * start[2]
    faster = h * (end[1] - start[1]) - h * h * start[2]
    more = h * h * (end[2] - start[2])
    piece.begin, piece.length, c = begin, h, piece.powers
    c[0], c[1], c[2] = start[0], h * start[1], 0.5 * h * h * start[2]
    c[3] = 10.0 * way - 4.0 * faster + 0.5 * more
    c[4] = -15.0 * way + 7.0 * faster - more
    c[5] = 6.0 * way - 3.0 * faster + 0.5 * more
    piece.cosine, piece.sine, piece.decay, piece.turn = 0.0, 0.0, 0.0, 0.0


@_fast
def _ring(piece, w, reading, speed):
    """Add the oscillation of the linkage to a piece, given reading and speed at its begin; return
    both at its end. Speeds are per length of the piece.
    """
    c = piece.powers
    z = 2.0 * _RINGING * w
    p3 = -20.0 * c[5] / w**2
    p2 = -(12.0 * c[4] + 3.0 * z * p3) / w**2
    p1 = -(6.0 * c[3] + 2.0 * z * p2 + 6.0 * p3) / w**2
    p0 = -(2.0 * c[2] + z * p1 + 2.0 * p2) / w**2
    c[0], c[1], c[2], c[3] = c[0] + p0, c[1] + p1, c[2] + p2, c[3] + p3
    piece.decay, piece.turn = _RINGING * w, w * np.sqrt(1.0 - _RINGING**2)
    piece.cosine = reading - c[0]
    piece.sine = (speed - c[1] + piece.decay * piece.cosine) / piece.turn
    rate, sine, cosine = 5.0 * c[5], np.sin(piece.turn), np.cos(piece.turn)
    for i in range(4, 0, -1):
        rate += i * c[i]
    free = piece.cosine * cosine + piece.sine * sine
    turned = piece.turn * (piece.sine * cosine - piece.cosine * sine)
    return _within(piece, 1.0), rate + (turned - piece.decay * free) * np.exp(-piece.decay)


@_fast
def _within(piece, u):
    """Return the reading at a share of a piece."""
    value = piece.powers[5]
    for i in range(4, -1, -1):
        value = piece.powers[i] + u * value
    if piece.turn == 0.0:
        return value
    free = piece.cosine * np.cos(piece.turn * u) + piece.sine * np.sin(piece.turn * u)
    return value + free * np.exp(-piece.decay * u)


@_fast
def follow(n, rest, closing, end, beyond):
    """Integrate a motion of a drive of size 1 with its ``closed_rest``, from the start of motion to
    ``end``, ms, or to ``beyond`` times its time from 10 to 50 %, after 10 % of the travel.

    Returns:
        Pieces of the curve, ``(s,)``, none if the motion is not finite or takes too many steps; the
        first reading, mm; and the time of first contact touch or separation, ms, or ``inf``.
    """
    pieces, count, switching = np.empty(_MOST, _PIECE), 0, np.inf
    state, new, k = np.zeros(4), np.zeros(4), np.zeros((7, 4))
    mode = _Mode.FREE
    if not closing:
        state[0], state[2], mode = rest, n.L, _Mode.CLOSED
    begin, stroke = _lever(n, state[0])[0], _lever(n, rest)[0]
    now, h, first = 0.0, _STEPS[0], np.inf
    _rates(n, rest, now, closing, mode, state, k, 0)
    released = _reading(n, stroke, state, k[0])[0]
    shows, speed = released, 0.0
    while now < end:
        error = _advance(n, rest, now, closing, mode, state, h, new, k) / _TOLERANCE
        if count == _MOST or now + h == now:
            return pieces[:0], released, switching
        factor = 0.9 * max(error, 1e-4) ** -0.2 if error < np.inf else 0.0
        if not error <= 1.0:
            h *= max(0.2, factor)
            continue
        # As in the model a contact stays after its touch, unless the drive holds it.
        held = closing and n.contact == Contact.HELD
        watched = closing == (mode == _Mode.FREE) or mode == _Mode.FLYING or held
        over = watched and _margin(n, rest, now + h, closing, mode, new) < 0.0
        taken = _located(n, rest, now, closing, mode, state, h, new, k) if over else h
        piece, to = pieces[count], _reading(n, stroke, new, k[6])
        _join(piece, now, taken, _reading(n, stroke, state, k[0]), to)
        if n.linkage > 0.0:
            shows, rate = _ring(piece, 2.0 * np.pi * taken / n.linkage, shows, speed * taken)
            speed = rate / taken
        way = abs(to[0] - begin) / stroke
        first = min(first, now) if way >= LEVELS[0] else first
        count, now = count + 1, now + taken
        if way >= LEVELS[1]:
            end = min(end, first + beyond * (now - first))
        state, new = new, state
        if over:
            switching = min(switching, now)
            mode = _switch(n, closing, mode, state)
            _rates(n, rest, now, closing, mode, state, k, 0)
            h = min(h, _STEPS[0])
        else:
            k[0] = k[6]
            h = min(_STEPS[1], h * factor)
    return pieces[:count].copy(), released, switching


@_fast
def sampled(pieces, times):
    """Return the reading at rising times, ``(t,)``, mm; at rest before the first piece."""
    result, i = np.empty(times.size), 0
    for j in range(times.size):
        while i < len(pieces) - 1 and times[j] > pieces[i].begin + pieces[i].length:
            i += 1
        result[j] = _within(pieces[i], max(0.0, times[j] - pieces[i].begin) / pieces[i].length)
    return result


@_fast
def passing(pieces, level):
    """Return the time at which the reading first passes a level, ms; nan if no piece ends past."""
    sign = 1.0 if level > _within(pieces[0], 0.0) else -1.0
    for i in range(len(pieces)):
        piece = pieces[i]
        if sign * (_within(piece, 1.0) - level) >= 0.0:
            low, high = 0.0, 1.0
            for _ in range(_FINEST):
                middle = 0.5 * (low + high)
                before = sign * (_within(piece, middle) - level) < 0.0
                low, high = (middle, high) if before else (low, middle)
            return piece.begin + high * piece.length
    return np.nan
