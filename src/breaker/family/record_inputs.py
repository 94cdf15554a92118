"""Measured records as networks see them."""

import numpy as np

from breaker.family.network_inputs import NormalisedRecords
from breaker.family.normalised_shape import Shape, effective_noise, shape_of
from breaker.records.record import Record

_LEAST = 5e-5  # noise over the stroke, below which no network was trained
_SEEN = -0.4, 2.4  # durations after 10 % of the way, between which every trained record has samples
_FINEST = 0.025  # durations between samples, below which none was: finer ones count as their mean


def normalise_record(raw: Record, like: Shape | None = None) -> tuple[Shape, NormalisedRecords]:
    """Normalise a measured record: return its shape, and the same for networks, physical units.

    Args:
        like: Another record of the drive, in whose units this one is given; its own if None.

    Raises:
        ValueError: If the record has no motion from one rest to another, or does not show them.
    """
    forward = raw.left if raw.motion == "closing" else -raw.left
    shape = shape_of(forward, raw.step, like)
    known = np.flatnonzero(~np.isnan(forward))
    first, last = raw.step * known[0] - shape.origin, raw.step * known[-1] - shape.origin
    for late, seen in (
        (first > _SEEN[0] * shape.duration, f"begins {-first:.1f} ms before"),
        (last < _SEEN[1] * shape.duration, f"ends {last:.1f} ms after"),
    ):
        if late:
            raise ValueError(
                f"{seen} 10 % of the way, where the drive need not rest; record longer"
            )
    seen = network_record(shape, *raw.process, raw.step, like)
    swing = raw.ripple / (shape if like is None else like).stroke
    return shape, seen._replace(noise=np.hypot(seen.noise, swing))


def stored_shape(record: np.ndarray, step: float, like: Shape | None = None) -> Shape | None:
    """Normalise a record of a store; None if it shows no motion.

    Args:
        record: Travel towards the end of the motion, mm, ``(s,)``, padded with nan.
        step: Between samples, ms.
        like: As of ``normalise_record``.
    """
    there = np.flatnonzero(np.isfinite(record))
    try:
        return shape_of(record[: there[-1] + 1] if there.size else record, step, like)
    except ValueError:
        return None


def network_record(
    shape: Shape, sd: float, colour: float, step: float, like: Shape | None = None
) -> NormalisedRecords:
    """Return a normalised record as networks see it, one record, physical units.

    Args:
        sd, colour: Noise of a sample, mm, and the correlation of neighbouring ones.
        step: Between samples, ms.
        like: As of ``normalise_record``.
    """
    length, unit = (shape.stroke, shape.duration) if like is None else (like.stroke, like.duration)
    told = max(effective_noise(sd / length, colour, step / unit), _LEAST)
    share = step / shape.duration
    if share < _FINEST:  # the same noise, as samples that far apart have it
        share, colour = _FINEST, colour ** (_FINEST / share)
    numbers = shape.stroke, shape.duration, told, colour, share
    there = np.array([True]), shape.way[None], shape.present[None]
    return NormalisedRecords(*there, *(np.array([each]) for each in numbers))
