"""Records with missing samples: what is taken away, and how much wider posteriors become."""

import numpy as np
import pytest
import xarray as xr
from scipy.stats import chi2, norm

from breaker.common.randomness import generator
from breaker.paper.posterior.amortised import validate
from studies.networks.missing import over_curves, remove, validate_missing, widening
from tests.networks_fixtures import DEEP_SET, NETWORK, frozen, pin

pytestmark = pytest.mark.usefixtures("one_thread")


def removed(share, *, n=40, t=10, name="remove"):
    measured = np.arange(1.0, n * t + 1).reshape(n, t)
    return measured, remove(measured, share, generator(1, "test missing", name))


@pytest.mark.parametrize(
    ("share", "count"), [(0.0, 0), (0.1, 1), (0.3, 3), (0.66, 7), (0.64, 6), (1.0, 10)]
)
def test_each_record_loses_the_same_share(share, count):
    measured, found = removed(share)
    lost = np.isnan(found)
    assert (lost.sum(axis=1) == count).all()
    np.testing.assert_array_equal(found[~lost], measured[~lost])
    assert np.isfinite(measured).all()  # the argument stays as it was
    assert found.dtype == np.float64


def sets_p_value(found):
    """Of the sets of two lost samples of five: ten of them, each as likely. Chi-square."""
    lost = np.isnan(found)
    numbers = np.sort(np.argsort(~lost, axis=1, kind="stable")[:, :2], axis=1)
    counts = np.bincount(numbers[:, 0] * 5 + numbers[:, 1], minlength=25)
    counts = counts[np.flatnonzero(np.triu(np.ones((5, 5)), 1))]
    expected = len(found) / 10
    assert counts.sum() == len(found)
    return chi2(9).sf(np.square(counts - expected).sum() / expected)


def test_each_set_of_samples_is_as_likely():
    """False alarm 1e-3. Faults: runs of samples are lost, or the same of all records."""
    _, found = removed(0.4, n=2000, t=5)
    assert sets_p_value(found) > 1e-3
    runs = np.where(np.isin((np.arange(5) - np.arange(2000)[:, None]) % 5, [0, 1]), np.nan, 1.0)
    assert sets_p_value(runs) < 1e-9
    assert sets_p_value(np.repeat(found[:1], 2000, axis=0)) < 1e-9


def test_records_lose_samples_of_their_own():
    """Whether two records lose a sample has nothing to do with each other: false alarm 1e-3."""
    _, found = removed(0.5, n=2000, t=8)
    lost = np.isnan(found) - 0.5  # of each record, half of 8 are above zero
    together = (lost[0::2] * lost[1::2]).sum(axis=1)
    error = np.sqrt(2 * 2 / 7 / 1000)  # of a permutation: product of the sums of squares, over 7
    assert abs(together.mean()) < norm.isf(0.5e-3) * error
    # Fault: pairs of records lose the same.
    assert np.square(lost).sum(axis=1).mean() > 50 * error


def test_the_generator_decides():
    _, first = removed(0.3)
    _, again = removed(0.3)
    _, other = removed(0.3, name="other")
    np.testing.assert_array_equal(first, again)
    assert not np.array_equal(np.isnan(first), np.isnan(other))


def test_what_is_missing_already_stays_missing():
    measured = np.ones((3, 6))
    measured[1, 2] = np.nan
    found = remove(measured, 0.5, generator(1, "test missing", "already"))
    assert np.isnan(found[1, 2])
    assert np.isnan(found).sum() >= 9


def test_validation_with_samples_missing():
    """The same records and truth, of which each has lost its share of samples at random."""
    network = {"summary": DEEP_SET, "inference": NETWORK["inference"]}
    deep_set = pin(frozen(network=network, curves=256), 0.0, 0.5)
    whole = validate(deep_set, 30, 5, seed=11)
    missing, again = (validate_missing(deep_set, whole, 0.3) for _ in range(2))
    xr.testing.assert_identical(missing, again)
    lost = np.isnan(missing.measured.values)
    assert (lost.sum(axis=1) == round(0.3 * deep_set.sensor.samples)).all()
    assert len({tuple(row) for row in lost}) == 30
    np.testing.assert_array_equal(missing.measured.values[~lost], whole.measured.values[~lost])
    np.testing.assert_array_equal(missing.truth, whole.truth)
    assert np.isfinite(missing.draws).all()
    xr.testing.assert_identical(validate_missing(deep_set, whole, 0.0), whole)
    other = validate_missing(deep_set, validate(deep_set, 30, 5, seed=12), 0.3)
    assert not np.array_equal(np.isnan(other.measured.values), lost)


# ---- widening ------------------------------------------------------------------------------------

NAMES = ["mu", "L", "onset"]


def posteriors(log_sd, *, curves=4, draws=50):
    """Draws of which the log of parameters, and the onset itself, has exactly such an sd."""
    z = generator(1, "test missing", "draws").standard_normal((curves, draws, 3))
    z = (z - z.mean(axis=1, keepdims=True)) / z.std(axis=1, ddof=1, keepdims=True)
    values = [0.7, 2.3, -0.1] + np.broadcast_to(log_sd, (curves, 3))[:, None] * z
    values[..., :2] = np.exp(values[..., :2])
    return xr.Dataset({"draws": (("curve", "draw", "output"), values)}, {"output": NAMES})


WHOLE = np.array([0.3, 0.02, 0.05])
RATIO = np.array([1.0, 1.5, 1.1]) * np.array([[1.0], [1.2], [0.9], [3.0]])


def test_widening_is_of_logarithms_and_of_the_plain_onset():
    found = widening(posteriors(WHOLE), posteriors(WHOLE * RATIO), NAMES)
    assert found.shape == (4, 3)
    np.testing.assert_allclose(found, RATIO, rtol=1e-9)
    # Planted: plain units of a parameter as wide as 0.9 give another ratio.
    plain = widening(posteriors(WHOLE), posteriors(WHOLE * RATIO), ["onset"] * 3)
    assert abs(plain[3, 0] - 3.0) > 0.3
    np.testing.assert_allclose(plain[:, 2], RATIO[:, 2], rtol=1e-9)


def test_units_of_a_parameter_do_not_matter():
    whole, missing = posteriors(WHOLE), posteriors(WHOLE * RATIO)
    scaled = [data.assign(draws=data.draws * [1e-3, 1e3, 1.0]) for data in (whole, missing)]
    np.testing.assert_allclose(widening(*scaled, NAMES), widening(whole, missing, NAMES), rtol=1e-9)


def test_single_precision_and_other_numbers_of_draws():
    """Stores keep float32; the posteriors may have different numbers of draws."""
    whole, missing = posteriors(WHOLE, draws=40), posteriors(WHOLE * RATIO)
    before = whole.copy(deep=True)
    found = widening(whole.astype(np.float32), missing.astype(np.float32), NAMES)
    np.testing.assert_allclose(found, RATIO, rtol=1e-4)
    xr.testing.assert_identical(whole, before)


def test_what_is_not_resolved_has_no_ratio():
    """In either; draws of those may be nan, or one draw again and again. No warning."""
    whole, missing = posteriors(WHOLE), posteriors(WHOLE * RATIO)
    whole.draws[1] = whole.draws[1, 0]
    missing.draws[2] = np.nan
    whole["resolved"] = ("curve", [True, False, True, True])
    missing["resolved"] = ("curve", [True, True, False, True])
    found = widening(whole, missing, NAMES)
    assert np.isnan(found).all(axis=1).tolist() == [False, True, True, False]
    np.testing.assert_allclose(found[[0, 3]], RATIO[[0, 3]], rtol=1e-9)
    # A network's draws are judged as they are.
    alone = widening(posteriors(WHOLE), missing.drop_vars("resolved"), NAMES)
    assert np.isfinite(alone[[0, 1, 3]]).all()


def test_ratios_over_curves_leave_out_those_without():
    ratios = np.tile(np.arange(101.0)[:, None], (1, 2)) * [1.0, 2.0]
    expected = np.array([[5, 10], [50, 100], [95, 190], [101, 101]])
    with_gaps = np.concatenate([ratios, np.full((7, 2), np.nan)])
    np.testing.assert_allclose(over_curves(with_gaps), expected)
    none = over_curves(np.full((7, 2), np.nan))
    assert np.isnan(none[:3]).all()
    assert none[3].tolist() == [0, 0]
