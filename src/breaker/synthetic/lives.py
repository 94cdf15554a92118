r"""Simulated lives: drives of the model that wear, change their wear, and reach a limit.

Change points and remaining life are judged on them. A life has parameters of the prior in new
condition, drifts along one or two kinds of wear from its first operation on, and scatters from
operation to operation. Once, one kind of wear changes its rate. By how much is set by the *ratio*:
the change of the slope over the standard error with which it would be known 3 % of the life later,
if one knew when and of what it was, from all records of both motions up to then. So a ratio of 5 is
a change that an ideal observer sees at five standard errors within 3 % of the life, whatever the
parameter and the scatter. The limit is on the parameter that changes, or on what an engineer
measures of it, and is where its trend is at the end of the nominal life.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from breaker.mechanism import NAMES, Limit, evaluate, travel
from breaker.model import Model, generator, information

__all__ = ["KINDS", "WINDOW", "Life", "simulate_life"]

WINDOW = 0.03  # share of the life within which a change should be found

KINDS = {"f": -1.0, "k_a": -1.0, "gamma_a": 1.0, "L": 1.0, "k_b": -1.0}
"""Kinds of wear: tiring closing spring, opening spring, dry grease, erosion, contact spring; and
whether the parameter grows."""

_LIMITS = {  # what shows a kind of wear: motion, quantity
    "f": (("closing", "f"), ("closing", "touch_time"), ("closing", "closing_speed")),
    "k_a": (("opening", "k_a"), ("opening", "opening_speed")),
    "gamma_a": (("opening", "gamma_a"), ("closing", "touch_time"), ("opening", "opening_speed")),
    "L": (("closing", "L"), ("closing", "touch_time"), ("closing", "wipe")),
    "k_b": (("opening", "k_b"),),
}
_PER = 1000.0  # operations in the unit of slopes
_TRIES = 200


@dataclass(frozen=True)
class Life:
    """One life.

    Attributes:
        operations: Numbers of the operations, ``(n,)``, up to failure.
        trend: Standardised parameters without scatter, ``(n, p)``.
        theta: Parameters of every operation, ``(n, p)``.
        change: Operation after which the wear changes.
        changed: Name of the parameter whose slope changes.
        ratio: Change of its slope over the standard error defined above.
        scatter: Scatter of each parameter, share, ``(p,)``.
        limit: The limit that ends the life: where the trend is at the nominal number of operations.
        failure: First operation at which the trend is beyond it.
    """

    operations: np.ndarray
    trend: np.ndarray
    theta: np.ndarray
    change: int
    changed: str
    ratio: float
    scatter: np.ndarray
    limit: Limit
    failure: int

    def records(
        self, model: Model, every: int, rng: np.random.Generator
    ) -> tuple[np.ndarray, np.ndarray]:
        """Record every so many operations of one motion; return their numbers and records."""
        chosen = self.operations % every == 0
        sensor, theta = model.sensor, self.theta[chosen]
        onset = sensor.onset_sd * rng.standard_normal(len(theta))
        curves = travel(theta, sensor.times, model.motion, onset=onset).travel
        return self.operations[chosen], sensor.corrupt(curves, rng)


def simulate_life(models: Mapping[str, Model], settings: Mapping, seed: int, number: int) -> Life:
    """Draw a life.

    Args:
        models: Joint model of each motion, with one prior.
        settings: The section ``lives`` of the configuration.
        seed: Seed of the set of lives.

    Raises:
        RuntimeError: If none of many draws makes a life that ends at a limit.
    """
    rng = generator(seed, "life", number)
    ratio = _log_uniform(settings["ratio"], rng)
    for _ in range(_TRIES):
        if (life := _draw(models, settings, ratio, rng)) is not None:
            return life
    raise RuntimeError(f"life {number} of seed {seed}: no limit was reached in {_TRIES} draws")


def _draw(
    models: Mapping[str, Model], settings: Mapping, ratio: float, rng: np.random.Generator
) -> Life | None:
    """Draw a life; None if it leaves the prior, or has no limit that it reaches in time."""
    prior = next(iter(models.values())).prior
    n, every = settings["operations"], settings["every"]
    changed = str(rng.choice(list(KINDS)))
    start = prior.standardise(prior.sample(1, rng))[0]
    slopes = np.zeros(len(NAMES))  # of the logarithms, per 1,000 operations; one or two kinds
    for name in rng.choice(list(KINDS), size=rng.integers(1, 3), replace=False):
        drift = KINDS[name] * _log_uniform(settings["drift"], rng) / 100.0
        slopes[NAMES.index(name)] = drift * _PER / n
    slopes /= prior.log_sds
    scatter = _log_uniform(settings["scatter"], rng) / 100.0
    scatter = scatter * np.exp(rng.uniform(*np.log([0.7, 1.4]), size=len(NAMES)))
    change = round(n * rng.uniform(*settings["change"]) / every) * every

    operations = np.arange(1, 2 * n + 1)
    line = start + operations[:, None] / _PER * slopes
    error = slope_error(models, line[change - 1], scatter / prior.log_sds, change, settings)
    i = NAMES.index(changed)
    turn = KINDS[changed] * ratio * error[i]
    line[:, i] += turn * np.maximum(operations - change, 0) / _PER
    spread = line + scatter / prior.log_sds * rng.standard_normal(line.shape)
    theta = prior.destandardise(np.clip(spread, -6.0, 6.0))
    if np.abs(spread[:n]).max() > 4.0 or not prior.supported(theta[:n]).all():
        return None

    motion, quantity = _LIMITS[changed][rng.integers(len(_LIMITS[changed]))]
    marks = prior.destandardise(line[[change - 1, n - 1]])
    at_change, at_end = evaluate([quantity], marks, motion)[:, 0].tolist()
    if not np.isfinite([at_change, at_end]).all():
        return None
    limit = Limit("end_of_life", motion, ((quantity, at_end, at_end > at_change),))
    over = limit.exceeded(evaluate([quantity], prior.destandardise(line), motion))
    failure = int(operations[over.argmax()])
    if not over.any() or failure < change + 2 * WINDOW * n:
        return None
    lived = (each[:failure] for each in (operations, line, theta))
    return Life(*lived, change, changed, ratio, scatter, limit, failure)


def _log_uniform(ends: Sequence[float], rng: np.random.Generator) -> float:
    return float(np.exp(rng.uniform(*np.log(ends))))


def slope_error(
    models: Mapping[str, Model],
    centre: np.ndarray,
    scatter: np.ndarray,
    change: int,
    settings: Mapping,
) -> np.ndarray:
    r"""Return the standard error of the change of each slope, ``(p,)``, a thousand operations.

    Of the weighted least-squares fit of lines to all parameters, one of which bends at the change,
    to all records until 3 % of the life after it. A record weighs :math:`W = (I^{-1} + S)^{-1}`,
    its information near ``centre`` and its scatter. As all records weigh the same, the error is
    that of a bend in one series of variance :math:`1 / W_{ii}`, other parameters known or not.

    Args:
        centre: Standardised parameters at the change, ``(p,)``.
        scatter: Scatter, standardised, ``(p,)``.
        change: Operation after which the slope changes.
        settings: The section ``lives`` of the configuration.
    """
    weight = record_weight(record_information(models, centre), scatter)
    return bend_error(change, settings) / np.sqrt(weight.diagonal())


def bend_error(change: int, settings: Mapping) -> float:
    """Standard error of the bend of a line at the change, 3 % of the life after it.

    Of values of unit variance at every record, in a unit per thousand operations.
    """
    last = change + round(WINDOW * settings["operations"])
    s = (np.arange(settings["every"], last + 1, settings["every"]) - change) / _PER
    design = np.stack([np.ones(s.size), s, np.maximum(s, 0.0)])  # level, slope, bend
    return float(np.sqrt(np.linalg.inv(design @ design.T)[2, 2]))


def record_information(models: Mapping[str, Model], centre: np.ndarray) -> np.ndarray:
    """Information ``(p, p)`` of the records of an operation, near standardised parameters."""
    matrix = np.zeros((len(centre), len(centre)))
    for model in models.values():
        at = np.append(model.prior.destandardise(centre), 0.0)[None, : len(model.names)]
        matrix += information(model, model.curves(at), centre[None], np.zeros(1)).matrix[0]
    return matrix


def record_weight(matrix: np.ndarray, scatter: np.ndarray) -> np.ndarray:
    """Information ``(p, p)`` about the trend that is left of a record's by the scatter ``(p,)``."""
    return np.linalg.solve(np.eye(len(matrix)) + matrix * np.square(scatter), matrix)
