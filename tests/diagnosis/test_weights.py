"""How draws of networks are held against what is given, and against each other."""

import numpy as np

from breaker.diagnosis.inference import evidence_of_one

P, DRAWS, DRIVES = 3, 4000, 400
MEAN = np.array([0.5, -1.0, 2.0])
PRIOR = np.array([[0.3, 0.1, 0.0], [0.1, 0.2, 0.05], [0.0, 0.05, 0.1]])
NOISE = np.diag([0.2, 0.05, 0.3]), np.diag([0.1, 0.4, 0.02])


def draws_of(theta, noise, rng):
    """Draws of the exact posterior of a drive by a reading with a noise."""
    reading = rng.multivariate_normal(theta, noise)
    gain = PRIOR @ np.linalg.inv(PRIOR + noise)
    center, left = MEAN + gain @ (reading - MEAN), PRIOR - gain @ PRIOR
    return rng.multivariate_normal(center, left, DRAWS)


def evidence(rng, *, two):
    """Of pairs of readings of one drive, or of two."""
    found = []
    for _ in range(DRIVES):
        theta = rng.multivariate_normal(MEAN, PRIOR, 2 if two else 1)
        pair = (
            draws_of(each, noise, rng) for each, noise in zip(theta[[0, -1]], NOISE, strict=True)
        )
        found.append(evidence_of_one(*pair, MEAN, PRIOR))
    return np.array(found)


def test_the_evidence_is_the_ratio_of_two_probabilities():
    """The mean of a Bayes factor is 1 where the other hypothesis holds: false alarm below 1e-3."""
    rng = np.random.default_rng(1)
    of_two = np.exp(evidence(rng, two=True))
    error = of_two.std() / np.sqrt(DRIVES)
    assert abs(of_two.mean() - 1.0) < 3.5 * error + 0.05
    of_one = np.exp(-evidence(rng, two=False))
    assert (of_one > 100.0).mean() < 0.03  # at most 1 %; 12 of 400 by chance: 2e-4
    assert np.median(of_one) < 1.0 < np.median(1.0 / of_two)
