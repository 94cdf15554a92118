"""Records with missing samples, or with samples off the sensor's grid: which of them are accepted.

A missing sample is NaN. Times are given in ms and handed to networks in steps of the sensor's
grid. A network answers for records of the kind that it was trained on, and for no others: what it
has never seen is refused here, with the remedy, before it gets an answer that looks like one.
"""

from typing import Protocol

import numpy as np

from breaker.model import Sensor

__all__ = ["Accepts", "positions"]

_ON_GRID = 1e-6  # steps: times read from a text are off by less


class Accepts(Protocol):
    """What a summary network says of the records that it takes.

    Attributes:
        accepts_missing: Whether it takes missing samples and samples off the grid at all.
        missing, uneven: Largest share of missing samples, and share of uneven records, that it
            was trained with.
        fewest: Samples that a record needs at least; of those that accept missing ones.
    """

    accepts_missing: bool
    missing: float
    uneven: float
    fewest: int


def positions(
    measured: np.ndarray, times: np.ndarray | None, sensor: Sensor, *, motion: str, taken: Accepts
) -> np.ndarray | None:
    """Check records, and return where on the sensor's grid their samples are.

    Args:
        measured: Records, ``(o, t)``, mm; NaN where a sample is missing.
        times: Times of the samples, ``(t,)`` or ``(o, t)``, ms around the nominal first motion;
            None for the sensor's own. Those of missing samples do not matter.
        sensor: The sensor of the model.
        motion: Motion of the model, for the messages.
        taken: The model's summary network.

    Returns:
        Times in steps of the grid, ``(o, t)``, or None where they are the grid's own.

    Raises:
        ValueError: If the model does not answer for such records; the message has the remedy.
    """
    own = measured.ndim == 2 and measured.shape[1] == sensor.samples
    if measured.ndim != 2 or (times is None and not own):
        raise ValueError(f"records must have the shape (o, {sensor.samples}), not {measured.shape}")
    key = f"network.{motion}.summary"
    _check(measured, key=key, taken=taken)
    if times is None:
        return None
    present = np.isfinite(measured)
    steps = _steps(times, present, sensor)
    nearest = np.rint(steps)
    if (np.abs(steps - nearest) < _ON_GRID).all():
        if own and (nearest == np.arange(sensor.samples))[present].all():
            return None
        steps = nearest
    elif taken.accepts_missing and not taken.uneven:
        raise ValueError(
            "samples lie off the sensor's grid, and the network was trained on it alone; train "
            f"with {key}.deep_set.uneven above 0"
        )
    if not taken.accepts_missing:
        raise ValueError(
            "samples lie at other times than the sensor's grid; train a network that takes them "
            f"({key}.kind: deep_set)"
        )
    most = present.sum(axis=1).max(initial=0)
    if most > sensor.samples:
        raise ValueError(
            f"a record has {most} samples, the sensor's grid {sensor.samples}; leave some out"
        )
    return steps


def _check(measured: np.ndarray, *, key: str, taken: Accepts) -> None:
    """Check that samples are finite, or missing where that is allowed.

    Args:
        measured: Records, ``(o, t)``, mm.
        key: Section of the configuration that the remedies are in.
        taken: The model's summary network.

    Raises:
        ValueError: If records are infinite, or lack samples that they need.
    """
    missing = np.isnan(measured)
    bad = ~np.isfinite(measured) & ~(missing & taken.accepts_missing)
    if bad.any():
        text = f"{bad.any(axis=1).sum()} of {len(bad)} records are not finite; reject them first"
        if missing.any() and not taken.accepts_missing:
            text += f", or train a network that takes missing samples ({key}.kind: deep_set)"
        raise ValueError(text)
    if taken.accepts_missing:
        there = (~missing).sum(axis=1)
        few = there < taken.fewest
        if few.any():
            raise ValueError(
                f"{few.sum()} of {len(few)} records have fewer than {taken.fewest} samples (one "
                f"has {there.min()}), and the network was trained with up to {taken.missing:.0%} "
                f"missing; reject them, or train with a larger {key}.deep_set.missing"
            )


def _steps(times: np.ndarray, present: np.ndarray, sensor: Sensor) -> np.ndarray:
    """Times in steps of the grid, ``(o, t)``; 0 where the sample is missing."""
    times = np.asarray(times, dtype=np.float64)
    if times.shape not in (present.shape, present.shape[1:]):
        raise ValueError(
            f"times must have the shape {present.shape} of the records, or {present.shape[1:]}, "
            f"not {times.shape}"
        )
    steps = np.where(present, (times - sensor.start) / sensor.step, 0.0)
    inside = (steps > -_ON_GRID) & (steps < sensor.samples - 1 + _ON_GRID)
    if not inside.all():
        raise ValueError(
            f"{(~inside.all(axis=1)).sum()} of {len(inside)} records have samples outside of the "
            f"sensor's {sensor.start:g} to {sensor.stop:g} ms, or at no finite time; leave them out"
        )
    return steps.clip(0.0, sensor.samples - 1)
