"""The prior as part of somebody's PyMC or NumPyro model, and the draws of such a model as ours.

Both packages are imported where they are used; neither is installed with this one. The condition
that the closed contact is pressed is a factor that also normalises, so that the log density of the
variables is ``Prior.log_prob``.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from breaker.mechanism.prior import Prior
from breaker.quantities.parameters import NAMES

_PRESSED = "pressed"  # name of the factor


def prior_in_pymc(prior: Prior) -> dict[str, Any]:
    """Add the parameters of a drive to the PyMC model in whose context this is called.

    Returns:
        Its variables, by name of the parameter, in the units of the parameters.

    Raises:
        ModuleNotFoundError: If PyMC is not installed.
    """
    import pymc
    import pytensor.tensor

    found = {
        name: pymc.LogNormal(name, mu=np.log(median), sigma=sd)
        for name, median, sd in zip(NAMES, prior.medians, prior.log_sds, strict=True)
    }
    holds = _pressed(prior, {name: pytensor.tensor.log(each) for name, each in found.items()}) > 0.0
    factor = pytensor.tensor.switch(holds, -prior.log_support, -np.inf)
    pymc.Potential(_PRESSED, factor)
    return found


def prior_in_numpyro(prior: Prior) -> dict[str, Any]:
    """Add the parameters of a drive to the NumPyro model in which this is called.

    In 32 bits, unless JAX is told otherwise.

    Returns:
        Its samples, by name of the parameter, in the units of the parameters.

    Raises:
        ModuleNotFoundError: If NumPyro is not installed.
    """
    import jax.numpy
    import numpyro
    from numpyro.distributions import LogNormal

    found = {
        name: numpyro.sample(name, LogNormal(np.log(median), sd))
        for name, median, sd in zip(NAMES, prior.medians, prior.log_sds, strict=True)
    }
    holds = _pressed(prior, {name: jax.numpy.log(each) for name, each in found.items()}) > 0.0
    numpyro.factor(_PRESSED, jax.numpy.where(holds, -prior.log_support, -np.inf))
    return found


def theta_of(posterior: Mapping[str, Any]) -> np.ndarray:
    """Return draws of the parameters, ``(n, p)``, such as ``evaluation.evaluate`` and limits take.

    Args:
        posterior: Draws of each parameter by its name, all of one shape: the group ``posterior`` of
            what PyMC returns, what ``MCMC.get_samples`` of NumPyro returns, or the posterior of one
            record that ``breaker infer --draws`` wrote. All other variables are left out.

    Raises:
        ValueError: If a parameter is missing, or draws are not positive, finite and of one shape.

    Example:
        >>> theta_of({name: [[1.0, 2.0]] for name in NAMES}).shape
        (2, 7)
    """
    if missing := [name for name in NAMES if name not in posterior]:
        raise ValueError(f"the draws have no {', '.join(missing)}; name variables as parameters")
    draws = [np.asarray(posterior[name], dtype=np.float64) for name in NAMES]
    if len({each.shape for each in draws}) > 1:
        raise ValueError(
            "the draws of the parameters have several shapes; take those of one record"
        )
    theta = np.stack([each.ravel() for each in draws], axis=-1)
    if not np.all(np.isfinite(theta) & (theta > 0.0)):
        raise ValueError("the draws are not all positive and finite, as parameters are")
    return theta


def _pressed(prior: Prior, logs: Mapping[str, Any]) -> Any:
    """What is positive where the closed contact is pressed, of logarithms by name."""
    slope, offset = prior.condition
    z = (
        (logs[name] - np.log(median)) / sd
        for name, median, sd in zip(NAMES, prior.medians, prior.log_sds, strict=True)
    )
    return sum((float(a) * each for a, each in zip(slope, z, strict=True) if a), offset)
