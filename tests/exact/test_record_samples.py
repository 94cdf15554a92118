"""Samples of a record, whose residuals are white and know no zero."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from breaker.common.randomness import generator
from breaker.drive.exact.record_samples import RecordSamples, mean_noise
from tests.raws import raw_of, smooth

_RECORDS = 2000
_SURE = 4.5  # standard errors: 1e-3 for the hundred numbers of this file
STROKE, TENTH, DURATION = 80.0, 22.9, 4.5  # of ``smooth``


def process(rng, shape, sd, colour):
    """A first-order process along the last axis."""
    white = rng.standard_normal(shape)
    white[..., 1:] *= np.sqrt(1.0 - colour**2)
    return sd * lfilter([1.0], [1.0, -colour], white, axis=-1)


def samples(travel, sd, colour, lost=()):
    """Those of a record of 60 samples of which some are lost."""
    kept = np.setdiff1d(np.arange(60), lost)
    joined = np.append(False, np.diff(kept) == 1)
    return RecordSamples(kept.astype(float), travel[kept], sd, colour, joined), kept


@pytest.mark.parametrize("lost", [[], [20, 21, 22, 40], range(59)])
@pytest.mark.parametrize("colour", [0.0, 0.7])
def test_residuals_are_white_but_for_the_zero(colour, lost):
    """A gap, behind which all is independent, included; of one sample nothing is left."""
    rng = generator(1, "white", str(colour), len(lost))
    noise = process(rng, (_RECORDS, 60), 0.1, colour)
    if len(lost) == 4:  # independent on both sides
        for behind in (23, 41):
            noise[:, behind:] = process(rng, (_RECORDS, 60 - behind), 0.1, colour)
    way = np.linspace(0.0, 10.0, 60)
    record, kept = samples(way, 0.1, colour, lost)
    residuals = record.residuals((way + noise)[:, kept])
    assert record.free == kept.size - 1
    squares = np.square(residuals).sum(axis=1)
    sure = _SURE * np.sqrt(2.0 * max(record.free, 1e-12) / _RECORDS)
    assert squares.mean() == pytest.approx(record.free, abs=sure + 1e-9)
    assert squares.var() == pytest.approx(2.0 * record.free, rel=0.2, abs=1e-9)
    if record.free:
        beside = (residuals[:, 1:] * residuals[:, :-1]).sum(axis=1).mean() / record.free
        # The zero that is taken out leaves -1 over the number of samples at most.
        assert abs(beside) < _SURE / np.sqrt(record.free * _RECORDS) + 1.5 / kept.size


def test_a_likelihood_is_that_with_a_free_zero():
    """Differences of log likelihoods are those of a normal with a very wide zero."""
    rng, colour, sd = generator(2, "zero"), 0.6, 0.1
    noise = process(rng, 60, sd, colour)
    record, kept = samples(noise, sd, colour, [30, 31])
    curves = 0.05 * rng.standard_normal((2, kept.size)).cumsum(axis=1)
    apart = np.abs(kept[:, None] - kept)
    covariance = sd**2 * np.where((kept[:, None] < 30) == (kept < 30), colour**apart, 0.0)
    square = [o @ np.linalg.solve(covariance + 1e4, o) for o in record.travel - curves]
    own = np.square(record.residuals(curves)).sum(axis=1)
    assert own[1] - own[0] == pytest.approx(square[1] - square[0], rel=1e-4)


def test_a_shift_of_the_travel_changes_nothing():
    rng = generator(3, "shift")
    record, kept = samples(rng.standard_normal(60), 0.1, 0.5, [7])
    curves = rng.standard_normal((3, kept.size))
    shifted = record.residuals(curves + np.array([[-30.0], [0.01], [500.0]]))
    assert np.allclose(shifted, record.residuals(curves), atol=1e-8)
    assert not np.allclose(record.residuals(1.01 * curves), record.residuals(curves), atol=1e-3)


@pytest.mark.parametrize("colour", [0.0, 0.3, 0.9])
@pytest.mark.parametrize("every", [1, 2, 7])
def test_noise_of_means_is_that_of_simulated_ones(colour, every):
    rng, means = generator(4, "means", str(colour), every), 400
    noise = process(rng, (_RECORDS, means * every), 0.2, colour)
    found = noise.reshape(_RECORDS, means, every).mean(axis=2)
    sd, next_ = mean_noise(0.2, colour, every)
    variances = np.square(found).mean(axis=1)
    beside = (found[:, 1:] * found[:, :-1]).mean(axis=1)
    for each, expected in ((variances, sd**2), (beside, next_ * sd**2)):
        error = each.std() / np.sqrt(_RECORDS)
        assert each.mean() == pytest.approx(expected, abs=_SURE * error)


def test_samples_of_a_record_lie_about_its_motion_and_keep_their_times():
    raw = smooth(generator(5, "record"), noise=0.0)
    record = RecordSamples.of(raw, TENTH, STROKE, DURATION)
    assert record.times[0] == pytest.approx(-3.0 * DURATION, abs=0.1)
    assert record.times[-1] == pytest.approx(60.0 - 0.1 - TENTH)
    assert np.allclose(np.diff(record.times), 0.1)
    assert record.joined.tolist() == [False, *[True] * (record.times.size - 1)]
    assert record.sd == pytest.approx(5e-5 * STROKE)  # none smaller was trained
    at = np.searchsorted(raw.time, record.times + TENTH - 0.01)
    assert np.array_equal(record.travel, raw.left[at])


def test_fine_samples_are_averaged_and_a_gap_parts_neighbours():
    rng, step = generator(6, "fine"), 0.02
    time = np.arange(0.0, 60.0, step)
    rise = np.clip((time - 20.0) / 15.0, 0.0, 1.0)
    way = STROKE * rise**2 * (3.0 - 2.0 * rise)
    noisy = way + process(rng, time.size, 0.1, 0.5)
    lost = (time > 30.0) & (time < 31.0)
    noisy[lost] = np.nan
    record = RecordSamples.of(raw_of(noisy, step, 19.0), TENTH, STROKE, DURATION)
    assert np.diff(record.times).min() == pytest.approx(9 * step)  # 0.04 durations are 0.18 ms
    assert np.diff(record.times).max() == pytest.approx(1.0, abs=0.2)
    behind = np.diff(record.times).argmax() + 1
    assert np.flatnonzero(~record.joined).tolist() == [0, behind]
    sd, colour = mean_noise(0.1, 0.5, 9)
    assert record.sd == pytest.approx(sd, rel=0.15)
    assert record.colour == pytest.approx(colour, abs=0.1)
    residuals = record.residuals(np.interp(record.times + TENTH, time, way)[None])
    # The noise is that of some 100 means at rest.
    assert np.square(residuals).sum() == pytest.approx(record.free, rel=0.4)


@pytest.mark.parametrize(("lead", "colour"), [(20.0, 0.0), (3.0, 0.0), (20.0, 0.6)])
def test_p_values_are_those_of_records_whose_noise_is_seen_at_rest(lead, colour):
    """Of 300 records of a motion behind a rest of 200 samples or of 30, by the true motion."""
    rng, found, as_if_known = generator(7, "p values", str(lead), str(colour)), [], []
    time = np.arange(0.0, 40.0 + lead, 0.1)
    rise = np.clip((time - lead) / 15.0, 0.0, 1.0)
    way = STROKE * rise**2 * (3.0 - 2.0 * rise)
    for _ in range(300):
        raw = raw_of(way + process(rng, time.size, 0.1, colour), 0.1, lead)
        record = RecordSamples.of(raw, lead + 2.9, STROKE, DURATION)
        true = np.interp(record.times + lead + 2.9, time, way)
        squares = np.square(record.residuals(true[None])).sum(axis=1)
        found.append(record.p_values(squares)[0])
        as_if_known.append(replace(record, rest=np.inf).p_values(squares)[0])
    few = 0.01
    sure = few + 4.5 * np.sqrt(few * (1.0 - few) / len(found))
    assert (np.array(found) < few).mean() < sure
    assert 0.35 < np.median(found) < 0.7
    if lead < 10.0:
        assert (np.array(as_if_known) < few).mean() > 2.0 * sure  # a planted fault
