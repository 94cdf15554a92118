"""How urgent limits are, and by when to service."""

import numpy as np
import xarray as xr

from breaker.decisions.actions import due_of


def judged(early, exceeded, since):
    """A judgement of one limit: the 5 % quantile of the operations left, and when it is beyond."""
    n = len(early)
    told = np.stack([early, early, early], axis=-1)[:, None]
    return xr.Dataset(
        {
            "told": (("operation", "limit", "quantile"), told),
            "exceeded": (("operation", "limit"), np.reshape(exceeded, (n, 1))),
            "since": (("operation", "limit"), np.reshape(since, (n, 1))),
        },
        {"operation": np.arange(1, n + 1)},
    )


def test_a_service_is_due_sooner_only_where_three_operations_in_a_row_say_so():
    odd = [500.0, 499, 10, 497, 496, 9, 8, 7, 492]
    never = np.zeros(len(odd), dtype=bool)
    due = due_of(judged(odd, never, np.full(len(odd), np.nan)), after=3)[:, 0]
    assert due.tolist() == [501] * 7 + [15] + [501]
    at_once = due_of(judged(odd, never, np.full(len(odd), np.nan)), after=1)[:, 0]
    assert at_once[2] == 13  # what the rule is there to prevent


def test_a_limit_that_is_exceeded_is_due_since_then():
    early, nan = [5.0, np.nan, 0, 0], np.nan
    found = due_of(judged(early, [False, False, True, True], [nan, nan, 3, 3]), after=2)[:, 0]
    assert found.tolist() == [6, np.inf, 3, 3]
