"""What is known beside a record, facts and the contact's time, linearised for climbs to a mode."""

import numpy as np

from breaker.model.joint import Model

__all__ = ["linearise_beside"]

_STEP = 1e-4  # of a derivative, prior sd


def linearise_beside(model: Model, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return what is known beside a record as ``Model.residuals_beside``, with its derivatives.

    Args:
        z: Standardised outputs, ``(q,)``.

    Returns:
        Residuals ``(k,)`` and derivatives ``(q, k)``, by central differences; both 0 for what does
        not exist at these outputs, which leads nowhere.

    Example:
        >>> from breaker.model import Facts, Prior, Sensor
        >>> prior = Prior([2.0, 0.045, 0.040, 0.30, 0.12, 0.75, 10.0], [0.1] * 7)
        >>> sensor = Sensor(-2.0, 58.0, 151, noise_sd=0.1, onset_sd=0.3, zero_sd=0.1)
        >>> facts = Facts.from_settings({"L": [10.2, 0.1]})
        >>> model = Model(prior, sensor, "closing").knowing(facts)
        >>> residuals, slopes = linearise_beside(model, np.zeros(8))
        >>> residuals.round(2), slopes[6].round(2)  # L is 2 sd off; a prior sd of it is 10 %
        (array([-2.]), array([10.]))
    """
    if model.facts is None and model.contact is None:
        return np.empty(0), np.empty((len(z), 0))
    steps = _STEP * np.eye(len(z))
    found = model.residuals_beside(np.concatenate([z[None], z + steps, z - steps]))
    up, down = found[1 : len(z) + 1], found[len(z) + 1 :]
    there = np.isfinite(found).all(axis=0)
    slopes = (np.where(there, up, 0.0) - np.where(there, down, 0.0)) / (2 * _STEP)
    return np.where(there, found[0], 0.0), slopes
