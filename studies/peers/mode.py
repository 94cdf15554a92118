"""Draws to start the exact posterior from, of any drive, without a network.

The mode of the exact posterior is climbed to by Gauss-Newton steps, damped as far as each has to
be to gain (Levenberg, 1944; Marquardt, 1963). A record of little noise has many local modes, and
one of much noise has one. So the climb begins with as much noise as lets the prior's centre explain
the record, and takes the noise away step by step. Draws are of a wide Student-t with the curvature
at the mode. Adaptive importance sampling (``breaker.paper.correction.correct``)
makes the exact posterior of them, as of a network's.
"""

from dataclasses import replace

import numpy as np

from breaker.paper.joint_model import Model, linearise

_LESS = 1 / 3  # of the noise, from one climb to the next
_STEPS, _LAST_STEPS = 8, 40  # of each climb, and of the last
_REACHED, _LAST_REACHED = 0.5, 1e-3  # nats that a step can still gain
_FARTHEST = 3.0  # prior sd in all, of a step
_DAMPING, _FACTOR = 1e-3, 10.0  # share of the prior's precision, at first; its change
_SHORTEST = 1e-7  # prior sd: a step that still gains nothing ends the climb
_INSIDE = 1e-3  # prior sd from the border of the prior's support, as far as a mode may come
_FREEDOM = 5.0  # of the Student-t


def approximate(model: Model, record: np.ndarray, n: int, rng: np.random.Generator) -> np.ndarray:
    """Return draws about the mode of a record's posterior, ``(n, q)``, physical units.

    Args:
        record: On the sensor's grid, ``(t,)``, mm.
    """
    highest, precision = mode(model, record)
    root = np.linalg.inv(np.linalg.cholesky(precision))  # root.T @ root is the covariance
    spread = np.sqrt(rng.chisquare(_FREEDOM, n) / _FREEDOM)
    wide = rng.standard_normal((n, len(highest))) / spread[:, None]
    return model.destandardise(highest + wide @ root)


def mode(model: Model, record: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the mode of a record's posterior, and the negative curvature of its log there.

    Args:
        record: On the sensor's grid, ``(t,)``, mm.

    Returns:
        Standardised outputs, ``(q,)``, and the curvature, ``(q, q)``, without second derivatives of
        the curve. Where the mode is on the border of the prior's support, it is just inside.

    Example:
        >>> from breaker.model.prior import Prior
        >>> from breaker.model.sensor import Sensor
        >>> prior = Prior([2.0, 0.045, 0.040, 0.30, 0.12, 0.75, 10.0], [0.1] * 7)
        >>> sensor = Sensor(-2.0, 58.0, 151, noise_sd=0.1, onset_sd=0.3, zero_sd=0.1)
        >>> model = Model(prior, sensor, "closing")
        >>> record = model.curves(np.append(model.prior.medians, 0.0)[None])[0]
        >>> highest, precision = mode(model, record)  # the prior's centre explains the record
        >>> bool(np.abs(highest).max() < 0.01), precision.shape
        (True, (8, 8))
    """
    z = np.zeros(len(model.outputs))
    left = record - model.curves(model.destandardise(z[None]))[0]
    ratio = max(np.std(left) / model.sensor.noise_sd, _LESS)
    rungs = np.log(ratio) / -np.log(_LESS)
    for rung in range(int(np.clip(np.ceil(rungs), 1, 30)), 0, -1):
        sensor = replace(model.sensor, noise_sd=model.sensor.noise_sd * _LESS**-rung)
        z, _ = _climb(replace(model, sensor=sensor), record, z, _STEPS, _REACHED)
    return _climb(model, record, z, _LAST_STEPS, _LAST_REACHED)


def _climb(
    model: Model, record: np.ndarray, z: np.ndarray, steps: int, reached: float
) -> tuple[np.ndarray, np.ndarray]:
    """Climb from outputs ``(q,)`` until no step gains enough; also returns the curvature there."""
    prior = np.eye(len(z))
    height, residual, slopes = _look(model, record, z)
    damping = _DAMPING
    for _ in range(steps):
        precision, uphill = slopes @ slopes.T + prior, slopes @ residual - z
        step = _step(model, z, precision + damping * prior, uphill)
        length = np.linalg.norm(step)
        gain = uphill @ step - 0.5 * step @ precision @ step
        if length < _SHORTEST or (gain < reached and damping <= _DAMPING):
            break
        there = z + step * min(1.0, _FARTHEST / length)
        found = _look(model, record, there)
        if found[0] > height:
            z, (height, residual, slopes) = there, found
            damping /= _FACTOR
        else:
            damping *= _FACTOR
    return z, slopes @ slopes.T + prior


def _step(model: Model, z: np.ndarray, precision: np.ndarray, uphill: np.ndarray) -> np.ndarray:
    """The step to the top of a parabola, or to its highest point inside the prior's support."""
    slope, offset = model.prior.condition
    slope = np.pad(slope, (0, len(z) - len(slope)))
    step, across = np.linalg.solve(precision, np.column_stack([uphill, slope])).T
    lacking = _INSIDE * np.linalg.norm(slope) - (slope @ (z + step) + offset)
    return step + max(lacking, 0.0) / (slope @ across) * across


def _look(model: Model, record: np.ndarray, z: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
    """Log density but for a constant, and residuals ``(r,)`` with minus their slopes ``(q, r)``.

    The density is ``-inf``, and nothing is simulated, where that of the prior is.
    """
    if not np.isfinite(model.log_prior(z[None])[0]):
        return -np.inf, np.zeros(0), np.zeros((len(z), 0))
    curves, (slopes,) = linearise(model, z[None])
    residual = model.sensor.whiten(record - curves[0])
    return -0.5 * float(residual @ residual + z @ z), residual, slopes
