"""Fits of one breaker: the mode, from any start, whatever the number of records."""

import numpy as np
import pytest

from breaker.model.randomness import generator
from breaker.model.reference import reference_model
from breaker.typical.fits import fit_breaker
from tests.typical.drives import breakers_of, records_of, type_of

START = np.zeros((1, 7))


@pytest.fixture(scope="module")
def models():
    return {motion: reference_model(motion) for motion in ("closing", "opening")}


@pytest.fixture(scope="module")
def records(models, prior, defaults):
    rng = generator(3, "test fits")
    (drive,) = breakers_of(type_of(prior, rng), defaults["rigs"], 1, rng)
    return {motion: records_of(drive, model, 2, rng) for motion, model in models.items()}


def test_every_start_leads_to_the_same_mode(models, records):
    starts = np.vstack([START, generator(1, "test starts").standard_normal((3, 7))])
    modes = [fit_breaker(models, records, start[None]).mode for start in starts]
    np.testing.assert_allclose(modes, modes[:1] * 4, atol=0.01)


def test_the_highest_mode_is_taken(models, records):
    far = fit_breaker(models, records, np.full((1, 7), 60.0))
    assert not far.reached
    both = fit_breaker(models, records, np.vstack([np.full(7, 60.0), START]))
    assert both.reached
    assert np.abs(both.mode).max() < 5.0


def test_the_same_record_again_says_nothing_more(models, records):
    once = {motion: each[:1] for motion, each in records.items()}
    again = {motion: np.repeat(each[:1], 5, axis=0) for motion, each in records.items()}
    first, second = (fit_breaker(models, each, START) for each in (once, again))
    np.testing.assert_allclose(first.matrix, second.matrix, rtol=1e-6)
    np.testing.assert_allclose(first.mode, second.mode, atol=1e-6)


def test_motions_are_independent(models, records):
    """Of both there is as much information as of each, at the same place."""
    both = fit_breaker(models, records, START)
    found = sum(
        fit_breaker(models, {motion: each}, both.mode[None]).matrix.trace()
        for motion, each in records.items()
    )
    assert both.matrix.trace() == pytest.approx(found, rel=0.3)
    mean, cov = both.posterior(models["closing"].prior.precision)
    np.testing.assert_allclose(mean, both.mode, atol=0.01)
    assert np.all(cov.diagonal() < 1.0)
