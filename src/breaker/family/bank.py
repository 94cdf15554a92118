"""The bank of a family: curves of drives, new and worn, without size, onset, zero and noise.

The *shape* of a curve is the share of the travel between its rests over ``u = (t - t10) / T``: at
``t10`` 10 % of that travel are made, and ``T``, the *duration*, is the time from 10 to 50 %.
"""

import logging

import numpy as np
import xarray as xr

from breaker.family.drive_family import TRIES, WEAR, Family
from breaker.family.integrator import follow, passing, sampled
from breaker.family.rich_drive import CONTACTS, ELEMENTS, Drive
from breaker.family.shape import LEVELS
from breaker.model.parameters import MOTIONS, NAMES

GRID = -3.0 + 0.025 * np.arange(512)  # times u of a shape
_STORED = (-0.5, 1.75)  # of a shape, in 16 bits
_SCALE = float(np.ptp(_STORED)) / np.iinfo(np.uint16).max
_FOLLOWED = GRID[-1] + 0.5  # durations to integrate; a transducer on a linkage lags behind
_SLOWEST = 1000.0  # ms, in which a drive of size 1 must make half of its travel
_log = logging.getLogger(__name__)


def simulate_family(family: Family, drives: int, rng: np.random.Generator) -> xr.Dataset:
    """Simulate both motions of drives of a family, each new and worn. A drive with a curve without
    a shape is replaced; ``drawn_again`` counts replacements.

    Returns:
        Over dims drive, condition, motion and u: ``shape``, in 16 bits, see ``shapes``; ``stroke``
        (mm) and ``duration`` (ms); ``release`` and ``switching``, times of the start of motion and
        of touch or separation, in u; and for each drive ``parameters``, ``elements`` (at size 1),
        ``wear`` (number in ``WEAR``) and ``contact`` (number in ``CONTACTS``).

    Raises:
        RuntimeError: If few drives of the family have a shape.
    """
    rows, replaced = [], 0
    while len(rows) < drives:
        try:
            rows.append(_row(family, rng))
        except FloatingPointError as error:
            replaced += 1
            _log.debug("drawn again: %s", error)
            if replaced > TRIES + len(rows):
                raise RuntimeError(f"hardly a drive of the family has a curve: {error}") from None
    per_drive, per_motion = ("drive", "condition"), ("drive", "condition", "motion")
    layout = {
        "shape": ((*per_motion, "u"), {"scale": _SCALE, "offset": _STORED[0]}),
        "stroke": (per_drive, {"units": "mm"}),
        "duration": (per_motion, {"units": "ms"}),
        "release": (per_motion, {}),
        "switching": (per_motion, {}),
        "parameters": ((*per_drive, "parameter"), {}),
        "elements": ((*per_drive, "element"), {}),
        "wear": (("drive",), {"kinds": list(WEAR)}),
        "contact": (("drive",), {"kinds": list(CONTACTS)}),
    }
    data = {n: (d, np.stack([row[n] for row in rows]), about) for n, (d, about) in layout.items()}
    axes = {"condition": ["new", "worn"], "motion": list(MOTIONS), "u": GRID}
    axes |= {"parameter": list(NAMES), "element": list(ELEMENTS)}
    return xr.Dataset(data, axes, {"drawn_again": replaced})


def shapes(stored: np.ndarray) -> np.ndarray:
    """Return stored shapes of a bank as shares of the travel."""
    return _SCALE * stored + _STORED[0]


def _row(family: Family, rng: np.random.Generator) -> dict[str, np.ndarray]:
    """Return one drive of a bank."""
    new, kind = family.new(rng), family.kind_of_wear(rng)
    both = [_condition(drive) for drive in (new, family.worn(new, rng, kind))]
    return {name: np.stack([state[name] for state in both]) for name in both[0]} | {
        "wear": np.int8(WEAR.index(kind)),
        "contact": np.int8(CONTACTS.index(new.elements.contact)),
    }


def _condition(drive: Drive) -> dict[str, np.ndarray]:
    """Return the data of a drive of size 1 in one condition; shapes ``(m, u)`` as stored."""
    both = [follow(drive.numbers, drive.rest, m == "closing", _SLOWEST, _FOLLOWED) for m in MOTIONS]
    if not all(len(pieces) and switching < np.inf for pieces, _, switching in both):
        raise FloatingPointError(f"a motion is not finite, or does not switch: {drive}")
    stroke = abs(both[0][1] - both[1][1])  # distance between the starts of both motions
    shape = np.empty((len(MOTIONS), len(GRID)), dtype=np.uint16)
    times = np.empty((3, len(MOTIONS)))  # duration, release, switching
    for i, (pieces, begin, switching) in enumerate(both):
        way = stroke if MOTIONS[i] == "closing" else -stroke
        first, half = (passing(pieces, begin + share * way) for share in LEVELS)
        duration = half - first
        if not duration > 0.0:
            raise FloatingPointError(f"{MOTIONS[i]} does not make half of its travel: {drive}")
        shares = (sampled(pieces, first + duration * GRID) - begin) / way
        if not (shares.min() >= _STORED[0] and shares.max() <= _STORED[1]):
            raise FloatingPointError(f"{MOTIONS[i]} leaves what can be stored: {drive}")
        shape[i] = np.round((shares - _STORED[0]) / _SCALE)
        times[:, i] = duration, -first / duration, (switching - first) / duration
    return dict(zip(("duration", "release", "switching"), times, strict=True)) | {
        "shape": shape,
        "stroke": np.float64(stroke),
        "parameters": np.array(drive.theta),
        "elements": drive.row[len(NAMES) :],
    }
