"""Records made in memory, as they are in their files."""

import numpy as np

from breaker.records.contacts import ContactTimes
from breaker.records.currents import Currents
from breaker.records.motion import Segment
from breaker.records.operations import Operation
from breaker.records.record import Record


def raw_of(way, step, moves, motion="closing"):
    """A record of a way forward ``(n,)``, mm, at steps from 0 on, ms."""
    whole = way if motion == "closing" else 3.0 - way
    known = whole[~np.isnan(whole)]
    segment = Segment(0, len(way), float(known[0]), float(known[-1]), 0.0, np.nan)
    time = step * np.arange(len(way))
    located = motion, time, whole, np.full(len(way), ""), 0.0, segment, moves, 0.0
    about = Operation(1, "a.csv"), {"travel_column": "way"}, 0.0, ContactTimes(), Currents(time), ()
    return Record(*located, *about)


def smooth(rng, motion="closing", *, stroke=80.0, noise=1e-3, late=0.0, bump=0.0, **more):
    """A motion of 10 ms from 10 to 90 %, or slower, with noise and a bump in shares of its way."""
    time = np.arange(0.0, more.get("until", 60.0), 0.1)
    way = swinging(time - 20.0 - late, 1.0, 15.0 * more.get("slow", 1.0))
    way += bump * np.exp(-np.square(time - late - 27.0))
    way = stroke * (way + noise * rng.standard_normal(time.size))
    return raw_of(way, 0.1, 19.0 + late, motion)


def swinging(time, stroke, lasts, over=0.0, fades=0.4):
    """A way from time 0 on that swings beyond its rest and back, mm."""
    share = np.maximum(time / lasts, 0.0)
    rise = np.where(share < 1.0, share**2 * (3.0 - 2.0 * share), 1.0)
    late = np.maximum(share - 0.93, 0.0)
    swing = np.sin(7.0 * late) * np.exp(-late / fades) * -np.expm1(-((late / 0.05) ** 2))
    return stroke * (rise + over * swing)
