"""The mark of the touch: drawn where the bend is clear, and not where noise hides it."""

import numpy as np
import pytest

from breaker.common.randomness import generator
from breaker.model.curves import travel
from breaker.model.evaluation import evaluate
from breaker.reading.inspection.bends import seen_touch

TIME = np.arange(0.0, 60.0, 0.1)


@pytest.fixture(scope="module")
def closings(prior):
    theta = prior.sample(60, generator(1, "test closings that touch"))
    curves = travel(theta, TIME, "closing", onset=np.zeros(60)).travel
    return curves, np.ravel(evaluate(["touch_time"], theta, "closing"))


def marks(curves, noise_sd):
    rng = generator(2, "test noise of closings that touch")
    records = curves + noise_sd * rng.standard_normal(curves.shape)
    found = [seen_touch(TIME, record) for record in records]
    return np.array([np.nan if each is None else each for each in found])


def test_a_quiet_record_shows_where_the_contact_touches(closings):
    curves, touches = closings
    off = np.abs(marks(curves, 0.02) - touches)
    assert np.isfinite(off).mean() > 0.8
    assert np.nanmedian(off) < 0.4
    # Planted: touches of other records are farther away.
    assert np.nanmedian(np.abs(marks(curves, 0.02) - np.roll(touches, 1))) > 0.8


def test_noise_hides_it_rather_than_moving_the_mark(closings):
    curves, _ = closings
    assert np.isnan(marks(curves, 0.3)).mean() > 0.9


def test_a_motion_without_a_bend_has_no_touch():
    rng = generator(3, "test motions without a bend")
    smooth = np.clip(TIME, 0.0, 20.0)
    found = [seen_touch(TIME, smooth + 0.02 * rng.standard_normal(TIME.size)) for _ in range(100)]
    # At most one of a hundred: the largest of 71 correlated scores beyond 5 sd is below 1e-5.
    assert sum(each is not None for each in found) == 0


def test_a_few_samples_or_none_show_nothing():
    assert seen_touch(TIME[:10], TIME[:10]) is None
    assert seen_touch(TIME, np.full(TIME.size, np.nan)) is None
