"""Posteriors of simulated curves, judged and corrected, with numbers that tests can know."""

import numpy as np
import xarray as xr

from breaker.common.randomness import generator
from breaker.model.parameters import NAMES as PARAMETERS

NAMES = [*PARAMETERS, "onset"]


def exact_posteriors(rng, n, draws, *, prior_sd, contraction, bias=0.0, width=1.0):
    """Draws ``(n, d, q)`` and truth ``(n, q)`` of outputs that are normal, as their prior is.

    With prior variance v and contraction c the exact posterior of an observation of variance
    v (1 - c) / c has mean c x and variance v (1 - c). ``bias`` is in its sds, ``width`` their
    factor.
    """
    truth = prior_sd * rng.standard_normal((n, len(prior_sd)))
    error = prior_sd * np.sqrt((1 - contraction) / contraction)
    mean = contraction * (truth + error * rng.standard_normal(truth.shape))
    sd = prior_sd * np.sqrt(1 - contraction)
    noise = rng.standard_normal((n, draws, len(prior_sd)))
    return mean[:, None] + sd * (bias + width * noise), truth


def corrected_curves(curves):
    """A result of ``correct_validation``, without its draws."""
    rng, number = generator(21, "test", "exactness"), np.arange(curves)
    values = {"efficiency": rng.uniform(0.4, 0.7, curves), "rounds": 1 + (number % 5 == 0)}
    values |= {"pareto_k": rng.normal(0.2, 0.1, curves), "resolved": number >= 0}
    return xr.Dataset({name: ("curve", value) for name, value in values.items()})


def judgement(corrected, curves):
    """A result of ``judge`` for the first curves."""
    rng = generator(22, "test", "exactness")
    values = {
        "efficiency": rng.uniform(0.6, 0.95, curves),
        "faulty_weights": np.zeros(curves, dtype=int),
        "pareto_k": np.where(np.arange(curves) < 2, 0.8, rng.normal(0.2, 0.1, curves)),
        "divergence": rng.lognormal(-2.3, 0.5, curves),
        "gap": rng.normal(0.1, 0.5, curves),
        "c2st": np.full(curves, 0.55),
        "resolved": corrected.resolved.values[:curves],
    }
    item = {name: ("curve", value) for name, value in values.items()}
    return xr.Dataset(item, attrs={"motion": "closing"})
