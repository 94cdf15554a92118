"""The bank of a family: curves of drives, new and worn, without size, onset, zero and noise.

The *shape* of a curve is the share of the travel between its rests over ``u = (t - t10) / T``: at
``t10`` 10 % of that travel are made, and ``T``, the *duration*, is the time from 10 to 50 %.
"""

import logging

import numpy as np
import xarray as xr

from breaker.family.drive_family import WEAR, Family
from breaker.family.integrator import closed_rest, follow
from breaker.family.paths import curve, passing, sampled
from breaker.family.rich_drive import CONTACTS, ELEMENTS, Drive
from breaker.family.shape import LEVELS
from breaker.model.parameters import MOTIONS, NAMES

GRID = -3.0 + 0.025 * np.arange(512)
"""Times u of a shape."""

GRID_STEP = GRID[1] - GRID[0]
"""Between them, to the last bit."""

_LOWEST, _HIGHEST = -0.5, 1.75  # of a shape, stored in 16 bits
_SCALE = (_HIGHEST - _LOWEST) / (2**16 - 1)
_FOLLOWED = GRID[-1] + 0.5  # durations; a transducer on a linkage lags behind
_TRIES = 100  # drives drawn again for one that works, before a family is given up
_SLOWEST = 1000.0  # ms of a drive of size 1, in which half of the travel has to be made
_PER_MOTION = ("drive", "condition", "motion")
_LAYOUT = {
    "shape": ((*_PER_MOTION, "u"), {"scale": _SCALE, "offset": _LOWEST}),
    "stroke": (("drive", "condition"), {"units": "mm"}),
    "duration": (_PER_MOTION, {"units": "ms"}),
    "release": (_PER_MOTION, {}),
    "switching": (_PER_MOTION, {}),
    "parameters": (("drive", "condition", "parameter"), {}),
    "elements": (("drive", "condition", "element"), {}),
    "wear": (("drive",), {"kinds": list(WEAR)}),
    "contact": (("drive",), {"kinds": list(CONTACTS)}),
}
_log = logging.getLogger(__name__)


def simulate_family(family: Family, drives: int, rng: np.random.Generator) -> xr.Dataset:
    """Simulate both motions of drives of a family, each new and worn.

    A drive one of whose curves has no shape is drawn again; ``drawn_again`` counts these.

    Returns:
        Over dims drive, condition ("new", "worn"), motion and u: ``shape``, in 16 bits, see
        ``shapes``; ``stroke`` (mm) and ``duration`` (ms); ``release`` and ``switching``, times of
        the start of motion and of the drive's own touch or separation, in u; and of each drive its
        ``parameters``, ``elements`` (of a drive of size 1), ``wear`` (number in ``WEAR``) and
        ``contact`` (number in ``CONTACTS``).

    Raises:
        RuntimeError: If hardly a drive of the family works.
    """
    rows, again = [], 0
    while len(rows) < drives:
        try:
            rows.append(_row(family, rng))
        except FloatingPointError as error:
            again += 1
            _log.debug("drawn again: %s", error)
            if again > _TRIES * (1 + len(rows)):
                raise RuntimeError(f"hardly a drive of the family has a curve: {error}") from None
    return xr.Dataset(
        {
            name: (dims, np.stack([row[name] for row in rows]), about)
            for name, (dims, about) in _LAYOUT.items()
        },
        {
            "condition": ["new", "worn"],
            "motion": list(MOTIONS),
            "u": GRID,
            "parameter": list(NAMES),
            "element": list(ELEMENTS),
        },
        {"drawn_again": again},
    )


def shapes(stored: np.ndarray) -> np.ndarray:
    """Return shapes of a bank as they are stored, as shares of the travel."""
    return _SCALE * stored + _LOWEST


def _row(family: Family, rng: np.random.Generator) -> dict[str, np.ndarray]:
    """One drive of a bank."""
    new = family.new(rng)
    kind = family.kind_of_wear(rng)
    both = [_condition(drive) for drive in (new, family.worn(new, rng, kind))]
    return {name: np.stack([one[name] for one in both]) for name in both[0]} | {
        "wear": np.int8(WEAR.index(kind)),
        "contact": np.int8(CONTACTS.index(new.elements.contact)),
    }


def _condition(drive: Drive) -> dict[str, np.ndarray]:
    """What a bank has of a drive of size 1 in one condition; shapes ``(m, u)`` as stored."""
    rest = closed_rest(drive.numbers)
    ways = [follow(drive.numbers, rest, m == "closing", _SLOWEST, _FOLLOWED) for m in MOTIONS]
    if not all(len(steps) and switching < np.inf for steps, switching in ways):
        raise FloatingPointError(f"a motion is not finite, or does not switch: {drive}")
    stroke = abs(ways[0][0][0, 2] - ways[1][0][0, 2])  # between where both motions begin
    shape = np.empty((len(MOTIONS), len(GRID)), dtype=np.uint16)
    times = np.empty((3, len(MOTIONS)))  # duration, release, switching
    for i, (steps, switching) in enumerate(ways):
        begin, way = steps[0, 2], stroke if MOTIONS[i] == "closing" else -stroke
        pieces = curve(steps, drive.elements.linkage)
        first, half = (passing(pieces, begin + share * way) for share in LEVELS)
        duration = half - first
        if not duration > 0.0:
            raise FloatingPointError(f"{MOTIONS[i]} does not make half of its travel: {drive}")
        shares = (sampled(pieces, first + duration * GRID) - begin) / way
        if not (shares.min() >= _LOWEST and shares.max() <= _HIGHEST):
            raise FloatingPointError(f"{MOTIONS[i]} leaves what can be stored: {drive}")
        shape[i] = np.round((shares - _LOWEST) / _SCALE)
        times[:, i] = duration, -first / duration, (switching - first) / duration
    return dict(zip(("duration", "release", "switching"), times, strict=True)) | {
        "shape": shape,
        "stroke": np.float64(stroke),
        "parameters": np.array(drive.theta),
        "elements": drive.numbers[len(NAMES) :],
    }
