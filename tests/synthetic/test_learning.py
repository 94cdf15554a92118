"""What is learned of the model's error: known moments, drives held back, and planted faults."""

import numpy as np
import pytest
import xarray as xr

from breaker.mechanism.curves import travel
from breaker.mechanism.parameters import MOTIONS, NAMES
from breaker.model.discrepancy import Discrepancy, open_discrepancy
from breaker.stores import save
from breaker.synthetic.family import Family
from breaker.synthetic.learning import ensemble, learn

N = 4000
LAG_MEAN, LAG_SLOPES, LAG_SD = 0.4, np.linspace(-0.1, 0.2, 7), 0.05
COMPONENTS = 3


@pytest.fixture(scope="module")
def family(prior, defaults) -> Family:
    return Family(prior, defaults["rigs"])


def made(sensor, rng, n=N):
    """An ensemble of known moments: shapes of both motions, and the joint covariance of a and b."""
    time = np.linspace(0.0, 1.0, sensor.samples)
    shapes = np.stack([time, np.sin(7 * time), np.exp(-20 * time)])
    basis = {"closing": shapes, "opening": shapes[::-1] + time**2}
    mean, slopes = 0.3 * time, 0.2 * np.outer(np.linspace(-1, 1, 7), np.cos(3 * time))
    root = rng.standard_normal((19, 19)) / 5  # of dz, a of both, b of both
    rows = rng.standard_normal((n, 19)) @ root
    z = rng.standard_normal((n, 7))
    delta = np.empty((2, 2, n, sensor.samples))
    for m, motion in enumerate(MOTIONS):
        a, b = rows[:, 7 + 3 * m :][:, :3], rows[:, 13 + 3 * m :][:, :3]
        delta[0, m] = mean + z @ slopes + a @ basis[motion]
        delta[1, m] = delta[0, m] + rows[:, :7] @ slopes + b @ basis[motion]
    loading = np.array([0.5, -0.2, 0.3])  # of the lag, by a
    lags = LAG_MEAN + z @ LAG_SLOPES + rows[:, 7:13].reshape(n, 2, 3).swapaxes(0, 1) @ loading
    lags = lags + LAG_SD * np.random.default_rng(8).standard_normal(lags.shape)
    lags[0, :5] = np.nan  # contacts that do not touch
    drives = xr.Dataset(
        {
            "lag": (("condition", "motion", "drive"), np.stack([lags, lags])),
            "delta": (("condition", "motion", "drive", "time"), delta),
            "z": (("condition", "drive", "parameter"), np.stack([z, z + rows[:, :7]])),
        },
        {"motion": list(MOTIONS), "parameter": list(NAMES), "time": sensor.times},
    )
    return drives, mean, slopes, basis, root.T @ root


@pytest.fixture(scope="module")
def known(sensor):
    drives, *truth = made(sensor, np.random.default_rng(1))
    return learn(drives, sensor, components=COMPONENTS, widening=1.0), *truth


@pytest.fixture(scope="module")
def stored(family, sensor):
    """Drives of the family, and what is learned from them."""
    drives = ensemble(family, sensor, MOTIONS, 400, np.random.default_rng(2))
    return drives, learn(drives, sensor, components=12, widening=1.3)


def test_known_moments_are_given_back(known):
    """Everything in mm, at all times: the basis itself may be turned."""
    learned, mean, slopes, basis, covariance = known
    blocks = np.split(np.arange(19), [7, 10, 13, 16])
    true = dict.fromkeys(MOTIONS)
    for m, motion in enumerate(MOTIONS):
        one = learned.sel(motion=motion)
        a = covariance[np.ix_(blocks[1 + m], blocks[1 + m])]
        sd = np.sqrt(np.einsum("it,ij,jt->t", basis[motion], a, basis[motion]))
        # Coefficients of a regression on 4000 drives have an error of sd / 63; six of them.
        assert np.all(np.abs(one["mean"] - mean) < 6 * sd / 63)
        assert np.all(np.abs(one.slopes.values - slopes) < 6 * sd / 63)
        spread = np.sqrt(np.square(one.factor.values).sum(0))
        # A variance has a relative error of sqrt(2 / 4000), an sd of 1.1 %; six of them.
        np.testing.assert_allclose(spread, sd, rtol=0.067)
        true[motion] = basis[motion]
    # The joint moments, of the changes of the parameters and of deltas in mm at three times.
    at = [20, 75, 150]
    shapes = [np.eye(7)] + [true[m][:, at] for m in MOTIONS] * 2
    own = [np.eye(7)] + [learned.basis.sel(motion=m).values[:, at] for m in MOTIONS] * 2
    found, expected = (
        joint(np.asarray(c), s) for c, s in ((learned.covariance, own), (covariance, shapes))
    )
    scale = np.sqrt(np.diag(expected))
    # An entry of a correlation matrix of 4000 drives has an error of at most 2.3 %; five of them
    # in 361 entries by chance with 2e-4.
    np.testing.assert_allclose(
        found / np.outer(scale, scale), expected / np.outer(scale, scale), atol=0.115
    )
    assert np.abs(learned.left).max() < 1e-9


def test_the_lag_of_the_contact_is_learned_with_the_curve(sensor):
    """Mean, slopes, covariance with the curve and variance; some drives do not touch.

    Errors of 4000 drives as above. Planted fault: the loading by other components.
    """
    drives, *_, basis, covariance = made(sensor, np.random.default_rng(1))
    learned = learn(drives, sensor, components=COMPONENTS, widening=1.0)
    weights = np.array([0.5, -0.2, 0.3])
    for m, motion in enumerate(MOTIONS):
        lag = Discrepancy.from_dataset(learned.sel(motion=motion)).lag
        rows = slice(7 + 3 * m, 10 + 3 * m)
        a = covariance[rows, rows]
        sd = np.sqrt(weights @ a @ weights + LAG_SD**2)
        assert abs(lag.mean - LAG_MEAN) < 6 * sd / 63
        assert np.all(np.abs(lag.slopes - LAG_SLOPES) < 6 * sd / 63)
        assert lag.sd == pytest.approx(LAG_SD, rel=0.067)
        assert lag.loading @ lag.loading + lag.sd**2 == pytest.approx(sd**2, rel=0.13)
        expected = weights @ a @ basis[motion]  # covariance with the curve, ms mm
        curve = np.sqrt(np.einsum("it,ij,jt->t", basis[motion], a, basis[motion]))
        factor = learned.factor.sel(motion=motion).values
        assert np.all(np.abs(lag.loading @ factor - expected) < 6 * 1.5 * sd * curve / 63)
        assert np.abs(lag.loading[::-1] @ factor - expected).max() > 12 * sd * curve.max() / 63
    wide = learn(drives, sensor, components=COMPONENTS, widening=1.3).sel(motion="closing")
    narrow = learned.sel(motion="closing")
    for name in ("lag_loading", "lag_sd"):
        np.testing.assert_allclose(wide[name], 1.3 * narrow[name], rtol=1e-9)
    for name in ("lag_mean", "lag_slopes"):
        np.testing.assert_array_equal(wide[name], narrow[name])


def joint(covariance, shapes):
    """Covariance of what a state's blocks make at some times."""
    sizes = [len(each) for each in shapes]
    starts = np.cumsum([0, *sizes])
    turn = np.zeros((starts[-1], sum(each.shape[1] for each in shapes)))
    column = 0
    for start, each in zip(starts, shapes, strict=False):
        turn[start : start + len(each), column : column + each.shape[1]] = each
        column += each.shape[1]
    return turn.T @ covariance @ turn


def test_widening_is_of_deltas_and_not_of_parameters(sensor):
    drives, *_ = made(sensor, np.random.default_rng(1), n=500)
    one, two = (learn(drives, sensor, components=3, widening=w) for w in (1.0, 1.3))
    np.testing.assert_allclose(two.factor, 1.3 * one.factor)
    factor = np.repeat([1.0, 1.3], [7, 12])
    np.testing.assert_allclose(two.covariance, one.covariance * np.outer(factor, factor))
    for name in ("mean", "slopes", "basis"):
        np.testing.assert_array_equal(one[name], two[name])


def test_factor_is_the_block_of_its_motion(stored):
    _, learned = stored
    for motion in MOTIONS:
        one = learned.sel(motion=motion)
        names = [f"a {motion} {k}" for k in range(1, 13)]
        a = learned.covariance.values[np.ix_(*[learned.indexes["state"].get_indexer(names)] * 2)]
        basis = one.basis.values
        np.testing.assert_allclose(
            one.factor.values.T @ one.factor.values, basis.T @ a @ basis, atol=1e-10
        )
        sizes = np.square(sensor_sizes(one))
        assert (np.diff(sizes) <= 1e-9 * sizes[0]).all()


def sensor_sizes(one):
    """Sizes of the scaled components in the basis, largest first."""
    return np.linalg.norm(np.linalg.lstsq(one.basis.values.T, one.factor.values.T)[0], axis=0)


def test_few_components_hold_nearly_all(stored):
    _, learned = stored
    assert learned.left.max() < 0.01


def test_what_is_stored_is_read_back(stored, tmp_path):
    _, learned = stored
    save(learned, tmp_path / "discrepancy.zarr")
    found = open_discrepancy(tmp_path / "discrepancy.zarr", "opening")
    np.testing.assert_array_equal(found.factor, learned.factor.sel(motion="opening"))
    assert found.slopes.shape == (7, 151)
    assert open_discrepancy(None, "opening") is None
    assert open_discrepancy([], "opening") is None


def excess(learned, drives, sensor, motion):
    """How far squares of residuals of drives are from what was learned, in standard errors.

    Along the components, each by itself, with the error of the mean square of the
    drives at hand and of as many that it was learned from.
    """
    left_out = Discrepancy.from_dataset(learned.sel(motion=motion))
    delta = drives.delta.sel(motion=motion).values[0]
    residual = sensor.whiten(delta - left_out.shift(drives.z.values[0]))
    whitened = sensor.whiten(left_out.factor)
    _, sizes, directions = np.linalg.svd(whitened, full_matrices=False)
    squares = np.square(residual @ directions.T / sizes)
    error = np.sqrt(2) * squares.std(0) / np.sqrt(len(squares))
    return (squares.mean(0) - 1) / error


@pytest.mark.parametrize("motion", MOTIONS)
def test_drives_held_back_have_the_learned_variance(family, sensor, stored, motion):
    drives, _ = stored
    learned = learn(drives, sensor, components=12, widening=1.0)
    fresh = ensemble(family, sensor, MOTIONS, 400, np.random.default_rng(3))
    # Twelve ratios, one of them beyond 4.3 by chance with 2e-4; and both planted faults:
    assert np.abs(excess(learned, fresh, sensor, motion)).max() < 4.3
    # what is learned is narrower than it should be,
    narrow = learned.assign(factor=learned.factor / 1.5)
    assert np.abs(excess(narrow, fresh, sensor, motion)).max() > 4.3
    # or the model beside a drive starts at another time than the drive.
    curves, z = fresh.travel.sel(motion=motion).values[0], fresh.z.values[0]
    late = fresh.copy(deep=True)
    exact = travel(family.prior.destandardise(z), sensor.times, motion).travel
    late.delta.values[0, list(MOTIONS).index(motion)] = curves - exact
    assert np.abs(excess(learned, late, sensor, motion)).max() > 4.3


@pytest.mark.parametrize("motion", MOTIONS)
def test_lags_of_drives_held_back_are_told_by_their_curves(family, sensor, stored, motion):
    """Squares of what is left of a lag, over the learned variance: 1, to 4.3 standard errors.

    False alarm 2e-5 a motion. Planted fault: a loading of the other sign.
    """
    drives, _ = stored
    learned = learn(drives, sensor, components=12, widening=1.0).sel(motion=motion)
    fresh = ensemble(family, sensor, MOTIONS, 400, np.random.default_rng(3)).sel(motion=motion)
    left_out, z = Discrepancy.from_dataset(learned), fresh.z.values[0]
    known, lag = left_out.lag, fresh.lag.values[0]
    delta = sensor.whiten(fresh.delta.values[0] - left_out.shift(z))
    xi = np.linalg.lstsq(sensor.whiten(left_out.factor).T, delta.T)[0].T
    ratios = []
    for loading in (known.loading, -known.loading):
        left = lag - known.mean - z @ known.slopes - xi @ loading
        squares = np.square(left / known.sd)
        ratios.append((squares.mean() - 1) / (np.sqrt(2) * squares.std() / 20))
    assert abs(ratios[0]) < 4.3
    assert ratios[1] > 4.3


def test_drives_that_are_the_model_leave_nothing_out(family, sensor):
    """With an onset: the same for drive and model."""
    bare = Family(family.prior, family.settings | {"strength": 0.0})
    drives = ensemble(bare, sensor, MOTIONS, 20, np.random.default_rng(4))
    assert np.abs(drives.delta).max() < 1e-6
    assert np.abs(drives.lag).max() < 1e-4
    assert drives.onset.std() > 0.1
    learned = learn(drives, sensor, components=2, widening=1.3)
    for name in ("mean", "slopes", "factor", "lag_mean", "lag_slopes", "lag_loading", "lag_sd"):
        assert np.abs(learned[name]).max() < 1e-4


def test_one_motion_by_itself(family, sensor):
    drives = ensemble(family, sensor, ["opening"], 40, np.random.default_rng(5))
    learned = learn(drives, sensor, components=4, widening=1.3)
    assert learned.covariance.shape == (15, 15)
    assert learned["state"].values[7:].tolist() == [
        *(f"a opening {k}" for k in range(1, 5)),
        *(f"b opening {k}" for k in range(1, 5)),
    ]
