"""A simulator of your own: a mass, a spring and a damper, with a prior of three parameters.

In the configuration:
``model: {simulator: own_simulator:simulate, prior: own_simulator:Oscillator}`` and
``sensor: {onset_sd: 0.0}``
"""

import numpy as np


class Oscillator:
    """Stroke (mm), natural frequency (1/ms) and damping ratio."""

    names = ("stroke", "frequency", "damping")

    def sample(self, n, rng):
        z = rng.standard_normal((n, 3))
        return np.array([14.0, 0.2, 0.4]) * np.exp(z * [0.1, 0.2, 0.3])


def simulate(theta, times, motion, rng):
    """Return the travel (n, t), mm; a stochastic simulator draws from ``rng``."""
    stroke, frequency, damping = theta.T[:, :, None]
    t = np.maximum(times, 0.0)
    slow, fast = frequency * damping, frequency * np.sqrt(np.maximum(1.0 - damping**2, 1e-6))
    left = np.exp(-slow * t) * (np.cos(fast * t) + slow / fast * np.sin(fast * t))
    return stroke * (1.0 - left if motion == "closing" else left)
