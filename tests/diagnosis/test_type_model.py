"""What drives of a type have in common, and which of them is odd."""

from types import SimpleNamespace

import numpy as np
import pytest

from breaker.diagnosis.type_model import TypeDraws, learn_contact_lag, learn_type

SPREAD, NOISE = 0.03, 0.02
USUAL = np.array([0.2, 0.15, 0.2, 0.2, 0.4, 0.1, 0.05])


def drawn(rng, n=30, operations=3, odd=()):
    """Draws of drives of a type, with an error that all of them share."""
    own = SPREAD * rng.standard_normal((n, 7))
    for drive, parameter, share in odd:
        own[drive, parameter] = np.log1p(share)
    each = own[:, None] + 0.5 + NOISE * rng.standard_normal((n, operations, 7))
    mean = each.mean(axis=1)
    squares = np.einsum("noi,noj->nij", each - mean[:, None], each - mean[:, None])
    theta = np.exp(mean[:, None] + 0.15 * rng.standard_normal((n, 100, 7)))
    return TypeDraws(mean, squares, np.full(n, operations), theta)


def test_odd_drives_are_found_and_no_others():
    for seed in range(5):
        rng = np.random.default_rng(seed)
        odd = [(3, 3, 0.4), (7, 1, -0.2), (20, 6, 0.25)]
        found = learn_type(drawn(rng, odd=odd), USUAL)
        named = np.argwhere(found.evidence > 10.0).tolist()
        assert named == [[drive, parameter] for drive, parameter, _ in odd]


def test_odd_drives_do_not_widen_the_type():
    rng = np.random.default_rng(1)
    found = learn_type(drawn(rng, n=40, odd=[(k, 3, 0.5) for k in range(3)]), USUAL)
    assert found.spread == pytest.approx(np.full(7, SPREAD), rel=0.5)
    assert np.log(found.medians) == pytest.approx(np.full(7, 0.5), abs=0.03)


def test_few_drives_tell_nothing_odd():
    rng = np.random.default_rng(1)
    found = learn_type(drawn(rng, n=4, odd=[(0, 3, 1.0)]), USUAL)
    assert (found.evidence == -np.inf).all()
    assert np.isfinite(found.log_sds).all()


def test_the_lag_of_contacts_is_of_breakers_not_of_records():
    """Of a breaker with many records no more than of another; one that contradicts is left out."""

    def records(*lags, surprise=1.0):
        about = SimpleNamespace(motion="closing")
        return [SimpleNamespace(record=about, surprise=surprise, lag=lag) for lag in lags]

    untimed = records(np.nan, surprise=np.nan)
    breakers = [records(*[0.1] * 9), records(0.3), records(9.0, surprise=6.0), untimed]
    mean, sd = learn_contact_lag(breakers)["closing"]
    assert mean == pytest.approx(0.2)
    expected = (2 * 0.1**2 + 8 * 0.15**2) / (1 + 8) * 1.5
    assert sd == pytest.approx(np.sqrt(expected))
    assert learn_contact_lag([untimed]) == {}
