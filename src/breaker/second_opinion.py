"""Change points by another method: offline, with ruptures, on the posterior medians.

Truong et al. (2020), "Selective review of offline change point detection methods". A continuous
piecewise linear function is fitted to the medians of single operations, standardised by their own
scatter, with a penalty for each bend. It sees all operations at once and knows neither prior nor
posterior widths: not a judge, a second opinion.
"""

import numpy as np
import ruptures

__all__ = ["bends"]

_BINS = 120  # the method's time grows with the square
_PENALTY = 6.0  # times the parameters and the log of the bins, for each bend


def bends(operations: np.ndarray, medians: np.ndarray) -> np.ndarray:
    """Return the operations at which the series bend together, rising, float.

    Args:
        operations: Numbers of the operations, ``(o,)``.
        medians: Posterior medians of log parameters, ``(o, p)``; nan where there is none.
    """
    there = np.isfinite(medians).all(axis=1)
    operations, medians = operations[there], medians[there]
    if len(operations) < 20:
        return np.array([])
    blocks = np.array_split(np.arange(len(operations)), min(_BINS, len(operations)))
    series = np.array([medians[block].mean(axis=0) for block in blocks])
    ends = np.array([operations[block[-1]] for block in blocks], dtype=float)
    # What is left of second differences: free of lines, six times the variance of the noise.
    noise = np.sqrt(np.square(np.diff(series, n=2, axis=0)).mean(axis=0) / 6.0)
    if not np.all(noise > 0):
        return np.array([])
    found = ruptures.BottomUp(model="clinear", min_size=3, jump=1).fit(series / noise)
    penalty = _PENALTY * series.shape[1] * np.log(len(series))
    return ends[np.array(found.predict(pen=penalty)[:-1], dtype=int) - 1]
