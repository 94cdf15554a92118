"""The regression of a block: against one solved at once, and what a column explains."""

import numpy as np
import pytest

from breaker.prognosis.trend import Block, PathFit, evidence


def a_fit(n=40, k=3, last=39, precision=0.01):
    rng = np.random.default_rng(1)
    time = np.linspace(0.0, 1.0, n)
    design = np.stack([np.ones(n), time], axis=1)
    values = rng.standard_normal((n, k)) + np.outer(time, [3.0, -1.0, 0.0])
    values[5] = np.nan
    fit = PathFit([Block(values, np.ones(k), np.ones(k))])
    fit.noise = np.array([1.0, 2.0, 0.5])
    fit.design(design, 10)
    for i in range(10, last + 1):
        fit.add(i, i + 1)
    fit.solve(last, np.full((k, 2), precision))
    return fit, design, values


def test_records_one_after_the_other_give_the_regression_of_all():
    fit, design, values = a_fit()
    there = np.isfinite(values[:, 0])
    for k in range(3):
        square = design[there].T @ design[there] / fit.noise[k] + 0.01 * np.eye(2)
        expected = np.linalg.solve(square, design[there].T @ values[there, k] / fit.noise[k])
        np.testing.assert_allclose(fit.mean[k], expected)
        np.testing.assert_allclose(fit.cov[k], np.linalg.inv(square))


@pytest.mark.parametrize("start", [10, 25, 38])
@pytest.mark.parametrize("step", [True, False])
def test_the_evidence_of_a_column_is_that_of_the_larger_regression(start, step):
    """Log evidence with the column less that without it, both from normal densities of all data."""
    fit, design, values = a_fit()
    time = design[:, 1]
    row = np.array([1.0, 0.0]) if step else np.array([-time[start], 1.0])
    explained = fit.explained(np.array([start]), 39, row[None])
    (found,) = evidence(*explained, np.full((1, 3), 4.0))
    there = np.isfinite(values[:, 0])
    column = (np.arange(40) >= start) * (design @ row)

    def log_evidence(columns, variances, k):
        some = columns[there]
        cov = some @ np.diag(variances) @ some.T + fit.noise[k] * np.eye(there.sum())
        y = values[there, k]
        return -0.5 * (y @ np.linalg.solve(cov, y) + np.linalg.slogdet(cov)[1])

    expected = sum(
        log_evidence(np.column_stack([design, column]), [100.0, 100.0, 4.0], k)
        - log_evidence(design, [100.0, 100.0], k)
        for k in range(3)
    )
    assert found == pytest.approx(expected, rel=1e-6)
