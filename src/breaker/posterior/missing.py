r"""Records with missing samples: which a network takes, and how others are completed for it.

A missing sample is NaN. A network answers for records of the kind that it was trained on. For one
that takes whole records the missing samples are drawn given those that are there, several times
(Rubin, 1987, "Multiple imputation for nonresponse in surveys"); its posterior is then the mean of
those of the completed records. Records are taken for jointly normal for this, with the moments that
they have under the prior, so the posterior is an approximation. The correction makes it exact,
because the likelihood of the samples that are there is known.
"""

import math
from functools import lru_cache

import numpy as np

from breaker.model import Model, generator, simulate

_CURVES = 2000  # of which the moments of records are taken


def check(measured: np.ndarray, samples: int, motion: str, *, taken: float = 1.0) -> None:
    """Raise an error for records that a network does not answer for.

    Args:
        measured: Records, ``(o, t)``, mm.
        taken: Largest share of missing samples that it was trained with, where it has to take the
            records as they are; they are completed if not given.

    Raises:
        ValueError: If the shape is another, a sample is infinite, or too many or all are missing;
            the message has the remedy.
    """
    if measured.ndim != 2 or measured.shape[1] != samples:
        raise ValueError(f"records must have the shape (o, {samples}), not {measured.shape}")
    infinite = np.isinf(measured).any(axis=1)
    if infinite.any():
        raise ValueError(f"{infinite.sum()} of {len(measured)} records have infinite samples")
    empty = np.isnan(measured).all(axis=1)
    if empty.any():
        raise ValueError(f"{empty.sum()} of {len(measured)} records have no sample")
    beyond = lacking(measured, taken)
    if beyond.any():
        summary = f"network.{motion}.summary"
        remedy = f"a larger {summary}.deep_set.missing" if taken else f"{summary}.kind: deep_set"
        raise ValueError(
            f"{beyond.sum()} of {len(measured)} records miss more than {taken:.0%} of the samples, "
            f"for which the network of {motion} has no density; train it with {remedy}"
        )


def lacking(measured: np.ndarray, taken: float) -> np.ndarray:
    """Say which records ``(o, t)`` miss more than a share of their samples, ``(o,)``."""
    allowed = math.floor(round(taken * measured.shape[1], 6))
    return np.isnan(measured).sum(axis=1) > allowed


@lru_cache(maxsize=8)
def _moments(model: Model) -> tuple[np.ndarray, np.ndarray]:
    """Mean ``(t,)`` and covariance ``(t, t)`` of records under the prior.

    Of the curves by simulation, of what the sensor adds exactly.
    """
    bank = simulate(model, _CURVES, generator(0, "moments of records", model.motion))
    curves = bank.travel.values.astype(np.float64)
    mean, sensor = curves.mean(axis=0), model.sensor
    errors = sensor.noise_sd**2 * np.eye(len(mean)) + sensor.zero_sd**2
    return mean, (curves - mean).T @ (curves - mean) / len(curves) + errors


def expected(model: Model, record: np.ndarray) -> np.ndarray:
    """Fill in the missing samples of a record ``(t,)`` by those expected, given the others.

    Args:
        model: Joint model of a network, which takes the model for right.
        record: Record, mm; NaN where a sample is missing.

    Example:
        >>> from breaker.model import Prior, Sensor
        >>> prior = Prior([2.0, 0.045, 0.040, 0.30, 0.12, 0.75, 10.0], [0.1] * 7)
        >>> sensor = Sensor(-2.0, 58.0, 151, noise_sd=0.1, onset_sd=0.3, zero_sd=0.1)
        >>> model = Model(prior, sensor, "closing")
        >>> record = model.curves(np.append(prior.medians, 0.0)[None])[0]
        >>> lacking = np.where(np.arange(151) % 5 < 2, record, np.nan)
        >>> bool(np.abs(expected(model, lacking) - record).max() < 0.3)
        True
    """
    return _given(model, record)[0]


def completed(model: Model, record: np.ndarray, count: int) -> np.ndarray:
    """Draw the missing samples of a record ``(t,)`` given the others, ``(count, t)``, mm.

    By the same random numbers for every record, so that it depends on nothing but the record.
    """
    filled, root = _given(model, record)
    rng = generator(0, "completed records", model.motion)
    normal = rng.standard_normal((count, len(record)))
    result, lost = np.tile(filled, (count, 1)), np.isnan(record)
    result[:, lost] += normal[:, lost] @ root.T
    return result


def _given(model: Model, record: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A record filled by what is expected, ``(t,)``, and the root of the covariance left of the m
    missing samples, ``(m, m)``."""
    mean, covariance = _moments(model)
    lost = np.isnan(record)
    across, own = covariance[~lost][:, lost], covariance[lost][:, lost]
    weights = np.linalg.solve(covariance[~lost][:, ~lost], across)
    filled = np.array(record, dtype=np.float64)
    filled[lost] = mean[lost] + (record - mean)[~lost] @ weights
    # The noise of each missing sample is in the covariance left, so it has a root.
    return filled, np.linalg.cholesky(own - across.T @ weights)
