"""Curves from the steps of an integration: at any times, and where a share of the way is passed.

Within a step the travel is the polynomial of the fifth degree through travel, speed and
acceleration at both ends. The linkage of a transducer follows it as a slightly damped oscillator,
``d'' + 2 z w d' + w^2 d = -x''`` for the difference d of reading and travel x: a polynomial and a
free oscillation, without an error of steps.
"""

import numpy as np

from breaker.common.compiling import compiled

_fast = compiled()

_HALVINGS = 50
_RINGING = 0.05  # damping ratio z of the linkage
_BEGIN, _LENGTH, _FIRST, _LAST, _COSINE, _SINE, _DECAY, _TURN = 0, 1, 2, 7, 8, 9, 10, 11


@_fast
def curve(steps, period):
    """Pieces of a curve ``(s, 12)``, from steps ``(s, 8)``: see ``integrator.follow``.

    Args:
        period: Of the linkage, ms; 0 where it is rigid.

    Returns:
        Begin and length of each, ms; the coefficients of the reading in powers of the share of a
        piece, mm; and of the free oscillation on top those of cosine and sine, mm, its decay and
        its turn in the piece.
    """
    pieces = np.zeros((len(steps), 12))
    reading, speed = steps[0, 2] if len(steps) else 0.0, 0.0
    for i, (begin, h, x0, v0, a0, x1, v1, a1) in enumerate(steps):
        piece = pieces[i]
        way = x1 - x0 - h * v0 - 0.5 * h * h * a0
        faster = h * (v1 - v0) - h * h * a0
        more = h * h * (a1 - a0)
        piece[0], piece[1], piece[2], piece[3] = begin, h, x0, h * v0
        piece[4], piece[5] = 0.5 * h * h * a0, 10.0 * way - 4.0 * faster + 0.5 * more
        piece[6], piece[7] = (
            -15.0 * way + 7.0 * faster - more,
            6.0 * way - 3.0 * faster + 0.5 * more,
        )
        if period > 0.0:
            _ring(piece, 2.0 * np.pi * h / period, reading, speed * h)
            reading, speed = _within(piece, 1.0), _rate(piece, 1.0) / h
    return pieces


@_fast
def _ring(piece, w, reading, speed):
    """Add to a piece of travel what the linkage does, from reading and speed at its begin."""
    c = piece[_FIRST : _LAST + 1]
    z = 2.0 * _RINGING * w
    p3 = -20.0 * c[5] / w**2
    p2 = -(12.0 * c[4] + 3.0 * z * p3) / w**2
    p1 = -(6.0 * c[3] + 2.0 * z * p2 + 6.0 * p3) / w**2
    p0 = -(2.0 * c[2] + z * p1 + 2.0 * p2) / w**2
    c[0], c[1], c[2], c[3] = c[0] + p0, c[1] + p1, c[2] + p2, c[3] + p3
    piece[_DECAY], piece[_TURN] = _RINGING * w, w * np.sqrt(1.0 - _RINGING**2)
    piece[_COSINE] = reading - c[0]
    piece[_SINE] = (speed - c[1] + piece[_DECAY] * piece[_COSINE]) / piece[_TURN]


@_fast
def _within(piece, u):
    """Reading at a share of a piece."""
    value = piece[_LAST]
    for i in range(_LAST - 1, _FIRST - 1, -1):
        value = piece[i] + u * value
    if piece[_TURN] == 0.0:
        return value
    free = piece[_COSINE] * np.cos(piece[_TURN] * u) + piece[_SINE] * np.sin(piece[_TURN] * u)
    return value + free * np.exp(-piece[_DECAY] * u)


@_fast
def _rate(piece, u):
    """Its derivative by the share."""
    value = 5.0 * piece[_LAST]
    for i in range(4, 0, -1):
        value = i * piece[_FIRST + i] + u * value
    turn, decay = piece[_TURN], piece[_DECAY]
    s, c = np.sin(turn * u), np.cos(turn * u)
    free = piece[_COSINE] * c + piece[_SINE] * s
    turned = turn * (piece[_SINE] * c - piece[_COSINE] * s)
    return value + (turned - decay * free) * np.exp(-decay * u)


@_fast
def sampled(pieces, times):
    """Reading at rising times, ``(t,)``, mm; at rest before the first piece."""
    result, i = np.empty(times.size), 0
    for j in range(times.size):
        while i < len(pieces) - 1 and times[j] > pieces[i, _BEGIN] + pieces[i, _LENGTH]:
            i += 1
        result[j] = _within(pieces[i], max(0.0, times[j] - pieces[i, _BEGIN]) / pieces[i, _LENGTH])
    return result


@_fast
def passing(pieces, level):
    """Time at which the reading first is a level, ms; nan if at no piece's end it is past it."""
    sign = 1.0 if level > _within(pieces[0], 0.0) else -1.0
    for piece in pieces:
        if sign * (_within(piece, 1.0) - level) >= 0.0:
            low, high = 0.0, 1.0
            for _ in range(_HALVINGS):
                middle = 0.5 * (low + high)
                if sign * (_within(piece, middle) - level) < 0.0:
                    low = middle
                else:
                    high = middle
            return piece[_BEGIN] + high * piece[_LENGTH]
    return np.nan
