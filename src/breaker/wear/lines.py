"""The inner loops of the change points, compiled: Gaussian lines that learn from one operation.

Information is about the level of a line, the first half of its state. Its matrix ``W`` may be
singular, so everything goes through ``I + W P`` with the line's own covariance ``P``. For the some
800 lines of a trend this is faster than batches of numpy.linalg, which take twice as long to learn
and ten times as long to merge.
"""

import numpy as np

from breaker.mechanism import compiled

__all__ = ["SPACING", "evidence", "thin", "update"]

_fast = compiled()
SPACING = 0.2  # of neighbouring starts, share of their age,
_FINE, _LIKELY = 0.05, -9.0  # and where both have such a log weight below the best, or more


@_fast
def _solve(matrix, right):
    """Solve in place by elimination with pivots; return the log of the determinant's size."""
    p, columns = right.shape
    log_determinant = 0.0
    for i in range(p):
        pivot = i
        for row in range(i + 1, p):
            if abs(matrix[row, i]) > abs(matrix[pivot, i]):
                pivot = row
        if pivot != i:
            for j in range(p):
                matrix[i, j], matrix[pivot, j] = matrix[pivot, j], matrix[i, j]
            for j in range(columns):
                right[i, j], right[pivot, j] = right[pivot, j], right[i, j]
        log_determinant += np.log(abs(matrix[i, i]))
        for row in range(i + 1, p):
            share = matrix[row, i] / matrix[i, i]
            for j in range(i + 1, p):
                matrix[row, j] -= share * matrix[i, j]
            for j in range(columns):
                right[row, j] -= share * right[i, j]
    for i in range(p - 1, -1, -1):
        for j in range(columns):
            for row in range(i + 1, p):
                right[i, j] -= matrix[i, row] * right[row, j]
            right[i, j] /= matrix[i, i]
    return log_determinant


@_fast
def _gain(mean, cov, weight, slope, system, solved):
    """Fill ``solved`` with ``(I + W P)^-1 [r, W]``, r the slope at the mean; return evidence."""
    p = slope.size
    log_evidence = 0.0
    for i in range(p):
        left = slope[i]
        for j in range(p):
            left -= weight[i, j] * mean[j]
            solved[i, 1 + j] = weight[i, j]
            system[i, j] = 1.0 if i == j else 0.0
            for k in range(p):
                system[i, j] += weight[i, k] * cov[k, j]
        solved[i, 0] = left
        log_evidence += 0.5 * mean[i] * (slope[i] + left)
    residual = solved[:, 0].copy()
    log_evidence -= 0.5 * _solve(system, solved)
    for i in range(p):
        for j in range(p):
            log_evidence += 0.5 * residual[i] * cov[i, j] * solved[j, 0]
    return log_evidence


@_fast
def evidence(mean, cov, weight, slope):
    """Return the log evidence of information ``(p, p)``, ``(p,)`` about a Gaussian of size p."""
    p = slope.size
    return _gain(mean, cov, weight, slope, np.empty((p, p)), np.empty((p, p + 1)))


@_fast
def update(mean, cov, group, weights, slopes, base, log_out):
    """Let lines learn, in place, where that is likelier than that the operation is an outlier.

    Args:
        mean: ``(h, n)``, relative to where the information is about, the level first.
        cov: ``(h, n, n)``.
        group: Which information a line learns from, ``(h,)``.
        weights, slopes, base: Information ``(k, p, p)``, ``(k, p)`` and constant ``(k,)``.
        log_out: Log evidence of an outlier, ``(k,)``.

    Returns:
        Log evidence of each line, ``(h,)``.
    """
    h, n = mean.shape
    p = slopes.shape[1]
    system, solved, moved = np.empty((p, p)), np.empty((p, p + 1)), np.empty((n, p))
    result = np.empty(h)
    for i in range(h):
        g = group[i]
        result[i] = base[g] + _gain(mean[i], cov[i, :p, :p], weights[g], slopes[g], system, solved)
        if result[i] < log_out[g]:
            continue
        gains = cov[i, :, :p].copy()
        for row in range(n):
            for j in range(p):
                moved[row, j] = 0.0
                for k in range(p):
                    moved[row, j] += gains[row, k] * solved[k, 1 + j]
            for k in range(p):
                mean[i, row] += gains[row, k] * solved[k, 0]
        for row in range(n):
            for column in range(row + 1):
                change = 0.0
                for k in range(p):
                    change += moved[row, k] * gains[column, k]
                cov[i, row, column] -= change
                if column < row:
                    cov[i, column, row] = cov[i, row, column]
    return result


@_fast
def _absorb(mean, cov, log_weight, start, variance, i, other):
    """Replace a line and its start by the moments of its mixture with another, in place."""
    n = mean.shape[1]
    total = np.logaddexp(log_weight[i], log_weight[other])
    share = np.exp(log_weight[other] - total)
    later = start[other] - start[i]
    variance[i] += share * (variance[other] - variance[i]) + share * (1.0 - share) * later * later
    start[i] += share * later
    for row in range(n):
        for column in range(n):
            apart = (mean[other, row] - mean[i, row]) * (mean[other, column] - mean[i, column])
            cov[i, row, column] += share * (cov[other, row, column] - cov[i, row, column])
            cov[i, row, column] += share * (1.0 - share) * apart
    for row in range(n):
        mean[i, row] += share * (mean[other, row] - mean[i, row])
    log_weight[i] = total


@_fast
def thin(log_weight, mean, cov, start, kind, scatter, variance, now, hopeless, young):
    """Merge and drop hypotheses; return which are kept, ``(h,)``.

    They are sorted by scatter, kind and start. Neighbours nearer than a fifth of their age become
    one, with mean and variance of their mixture, of the line and of its start, in place: so the
    width still contains both. Where both are likely, it takes a twentieth: what comes later shall
    still tell them apart.
    """
    h = log_weight.size
    kept = np.ones(h, dtype=np.bool_)
    best = log_weight.max()
    last, oldest = 0, start[0]
    for i in range(1, h):
        together = kind[i] == kind[last] and scatter[i] == scatter[last]
        likely = min(log_weight[i], log_weight[last]) > best + _LIKELY
        if together and start[i] - oldest < (_FINE if likely else SPACING) * (now - oldest):
            stays, goes = (i, last) if log_weight[i] > log_weight[last] else (last, i)
            _absorb(mean, cov, log_weight, start, variance, stays, goes)
            kept[goes] = False
            last = stays
        else:
            last, oldest = i, start[i]
    for i in range(h):
        if kind[i] >= 0 and now - start[i] > young and log_weight[i] < best - hopeless:
            kept[i] = False
    return kept
