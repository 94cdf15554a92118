"""From a network's draws to the exact posterior, record by record, without the network's density.

Adaptive importance sampling. A map is fitted to the network's draws, draws from it are weighed by
the exact joint density, and the map is fitted again to all of them, each weighed by the mixture of
the maps that they came from (Cornuet et al., 2012, "Adaptive multiple importance sampling"), until
a round's efficiency is good. Then fresh draws from the last map are weighed by its density alone:
they make the result, so that the weights do not depend on the fit. Where their weights are still
poor, the adaptation goes on from them. A record whose weights stay poor is marked *unresolved*.

While the weights are few, they are tempered: raised to the largest power below one that leaves an
effective size to fit to.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from breaker.paper.model.joint_model import Model
from breaker.paper.posterior.importance_weights import Importance, importance, resample
from breaker.paper.posterior.transport import TriangularMap

_NOTHING = Importance(np.full(1, np.nan), *[np.nan] * 4, 0)  # before there are weights


class _Draws(NamedTuple):
    """Draws of one map."""

    proposal: TriangularMap
    z: np.ndarray  # standardised, (n, q)
    log_joint: np.ndarray  # exact, with the record, (n,)
    weights: Importance  # by the density of this map alone


@dataclass(frozen=True)
class Corrected:
    """Exact posterior of one record, as far as it was reached.

    Attributes:
        draws: Equally weighted draws, resampled, ``(d, q)``, physical units; those of an
            unresolved record are its best so far, nan if there are none.
        importance: Weights of the last round, and what they say.
        rounds: Rounds of adaptation.
        resolved: Whether effective size and tail of the weights are good enough.
        reason: Why not, in words; empty if resolved.
    """

    draws: np.ndarray
    importance: Importance
    rounds: int
    resolved: bool
    reason: str


def correct(
    model: Model,
    record: np.ndarray,
    draws: np.ndarray,
    settings: Mapping,
    rng: np.random.Generator,
) -> Corrected:
    """Correct the draws of one record.

    Args:
        record: Record on the sensor's grid, ``(t,)``, mm; nan where a sample is missing.
        draws: The network's draws, ``(d, q)``, physical units. Only their rough place and spread
            matter.
        settings: The section ``correction`` of the configuration.
        rng: Generator of maps' draws and resampling.
    """

    def draw(n: int) -> _Draws:
        z = proposal.sample(n, rng)
        log_joint = model.log_joint(z, record)
        return _Draws(proposal, z, log_joint, importance(log_joint, proposal.log_prob(z)))

    unknown = np.full(draws.shape, np.nan)
    drawn: list[_Draws] = []  # all so far, adaptation and result
    result, rounds, failure = None, 0, ""
    try:
        with np.errstate(divide="ignore"):  # a draw of 0 makes no map
            z = model.standardise(draws)
        proposal = TriangularMap.fit(z)
        while rounds < settings["rounds"] and (not result or poor(result.weights, settings)):
            drawn.append(draw(settings["round_draws"]))
            proposal = _refit(drawn, settings["fit_size"])
            rounds += 1
            efficient = drawn[-1].weights.efficiency >= settings["efficiency"]
            if efficient or rounds == settings["rounds"]:
                drawn.append(draw(settings["draws"]))
                if poor(drawn[-1].weights, settings):
                    proposal = _refit(drawn, settings["fit_size"])
                result = drawn[-1]
    except np.linalg.LinAlgError as error:
        failure = f"no map: {error}"
    if result is None:
        weights = drawn[-1].weights if drawn else _NOTHING
        return Corrected(unknown, weights, rounds, False, failure)
    weights, reason = result.weights, failure or poor(result.weights, settings)
    if weights.size == 0:
        return Corrected(unknown, weights, rounds, False, reason)
    chosen = result.z[resample(weights.log_weights, len(draws), rng)]
    return Corrected(model.destandardise(chosen), weights, rounds, not reason, reason)


def _refit(drawn: Sequence[_Draws], size: float) -> TriangularMap:
    """Fit a map to all draws so far, weighed by the mixture of all maps so far.

    While too few of them are in the prior's support, more are drawn from the last map.
    """
    z = np.concatenate([each.z for each in drawn])
    densities = [each.proposal.log_prob(z) + np.log(len(each.z) / len(z)) for each in drawn]
    log_joint = np.concatenate([each.log_joint for each in drawn])
    log_ratio = log_joint - np.logaddexp.reduce(densities)
    if np.sum(log_ratio > -np.inf) < size and np.all(log_ratio < np.inf):
        return drawn[-1].proposal
    return TriangularMap.fit(z, temper(log_ratio, size))


def temper(log_ratio: np.ndarray, size: float) -> np.ndarray:
    """Return normalised weights of at least an effective size, ``(d,) -> (d,)``.

    The ratios are raised to the largest power up to 1 that leaves it.

    Raises:
        numpy.linalg.LinAlgError: If fewer than ``size`` draws have a finite ratio.
    """
    finite = np.isfinite(log_ratio)
    faulty = np.sum(~finite & (log_ratio != -np.inf))
    if faulty:
        raise np.linalg.LinAlgError(f"{faulty} weights are not finite")
    if finite.sum() < size:
        raise np.linalg.LinAlgError(
            f"{finite.sum()} of {finite.size} draws have a usable weight, {size:g} are needed"
        )
    centred = log_ratio[finite] - log_ratio[finite].max()

    def excess(power: float) -> float:
        weights = np.exp(power * centred)
        return weights.sum() ** 2 / np.square(weights).sum() - size

    # The root is found to 1e-3 of itself, however small, and taken from below.
    power = 1.0
    if excess(power) < 0:
        power = (1 - 1e-3) * brentq(excess, 0.0, 1.0, xtol=1e-300, rtol=1e-3)
    weights = np.zeros(log_ratio.size)
    weights[finite] = np.exp(power * centred)
    return weights / weights.sum()


def poor(judged: Importance, settings: Mapping) -> str:
    """Say what is wrong with weights, if anything, by the section ``correction``."""
    if judged.faulty:
        return f"{judged.faulty} weights are not finite"
    if not judged.size >= settings["smallest_size"]:
        return f"effective size {judged.size:.0f}, {settings['smallest_size']} are needed"
    if not judged.pareto_k < settings["largest_k"]:
        return f"Pareto k {judged.pareto_k:.2f}, below {settings['largest_k']} is needed"
    return ""
