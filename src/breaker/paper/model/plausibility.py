"""Distance of a record from the curves of a bank, by principal components and by envelope.

The components are those of noise-free curves whitened by the covariance of a record, so that each
is ranked by its signal over noise. A record's scores on them, scaled to unit variance over the bank
(noise included), contain all information that the noise leaves.
"""

import numpy as np

from breaker.mechanism.sensor import Sensor


def principal_components(
    travel: np.ndarray, sensor: Sensor, count: int
) -> tuple[np.ndarray, np.ndarray]:
    """Find the components of noise-free curves that stand out of the noise most.

    Args:
        travel: Noise-free curves, ``(n, t)``, mm.
        count: Number c of components.

    Returns:
        Mean curve ``(t,)``, mm, and weights ``(t, c)``, 1/mm, so that
        ``(record - mean) @ weights`` has unit variance over records of the bank.
    """
    mean = travel.mean(axis=0, dtype=np.float64)
    whitened = sensor.whiten(travel - mean)
    variances, vectors = np.linalg.eigh(whitened.T @ whitened / len(travel))
    variances, vectors = variances[::-1][:count], vectors[:, ::-1][:, :count]
    # eigh leaves the sign open; fix it, so that it does not depend on the library.
    vectors = vectors * np.sign(vectors[np.abs(vectors).argmax(axis=0), np.arange(count)])
    return mean, sensor.whiten(vectors.T).T / np.sqrt(1.0 + variances)


def distance(measured: np.ndarray, mean: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Return how far records lie from the bank's centre, ``(n, t) -> (n,)``.

    The largest score, in standard deviations of the bank; a mean over all scores would hide it.
    """
    return np.abs((measured - mean) @ weights).max(axis=-1)


def excess(measured: np.ndarray, lowest: np.ndarray, highest: np.ndarray) -> np.ndarray:
    """Return how far records leave the bank's envelope, ``(n, t) -> (n,)``, mm.

    The largest over the samples; negative where a record stays inside everywhere. It sees what
    the components cannot: a record of half the stroke lies near the bank's mean in all of them.

    Args:
        measured: Records, ``(n, t)``, mm.
        lowest: Lowest noise-free curve of the bank, sample by sample, ``(t,)``, mm.
        highest: The highest, ``(t,)``, mm.
    """
    return np.maximum(measured - highest, lowest - measured).max(axis=-1)
