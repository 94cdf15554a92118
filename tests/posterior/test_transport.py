"""The triangular map: a normalised density, the one of its draws, that bends with the posterior."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import gammaln
from scipy.stats import f as f_distribution
from scipy.stats import kstest, multivariate_normal, multivariate_t, norm, ortho_group, t

from breaker.model.randomness import generator
from breaker.posterior.transport import TriangularMap

FREEDOM = 5  # of the Student-t
TWO_SIDED = norm.isf(0.5e-3)  # 3.29 standard errors: false alarm 1e-3
SIZES = [1, 2, 3, 8]


def bent(n, q, rng):
    """Draws along a curve, ``(n, q)``, turned: the first coordinate is the widest and bends all."""
    z = rng.standard_normal((n, q)) * 0.6 ** np.arange(q)
    for k in range(1, q):
        z[:, k] += 0.3 * (z[:, 0] ** 2 - 1) / k + 0.2 * z[:, 0] * z[:, k - 1]
    return z @ rotation(q) + np.arange(q)


def rotation(q):
    return ortho_group.rvs(q, random_state=5) if q > 1 else np.eye(1)


def fitted(q, n=1000):
    return TriangularMap.fit(bent(n, q, generator(1, "test transport", "fitted", q)))


# ---- density and draws of one map ----------------------------------------------------------------


class Given:
    """Generator whose normal numbers ``(n, q)`` are given, and whose Student-t is then normal."""

    def __init__(self, noise):
        self.noise = noise

    def standard_normal(self, shape):
        assert shape == self.noise.T.shape
        return self.noise.T.copy()

    def chisquare(self, freedom, n):
        assert freedom == FREEDOM
        return np.full(n, float(freedom))


def change_of_variables(chosen, noise):
    """Log density at the images of noise ``(n, q)``, by central differences, and the images.

    The map is a polynomial of round 1 in noise of round 1: a step of 1e-5 leaves 1e-10 of its
    third derivative, and round-off of 1e-11.
    """
    n, q = noise.shape
    step = 1e-5
    jacobian = np.empty((n, q, q))
    for j in range(q):
        up, down = noise.copy(), noise.copy()
        up[:, j] += step
        down[:, j] -= step
        difference = chosen.sample(n, Given(up)) - chosen.sample(n, Given(down))
        jacobian[:, :, j] = difference / (2 * step)
    base = multivariate_t(np.zeros(q), np.eye(q), FREEDOM).logpdf(noise)
    return base - np.linalg.slogdet(jacobian)[1], chosen.sample(n, Given(noise))


@pytest.mark.parametrize("q", SIZES)
def test_density_is_the_change_of_variables_of_the_draws(q):
    chosen = fitted(q)
    noise = generator(1, "test transport", "noise", q).standard_normal((20, q))
    expected, points = change_of_variables(chosen, noise)
    np.testing.assert_allclose(chosen.log_prob(points), expected, atol=1e-6)
    # The faults: a forgotten volume, and functions of the points that are not those of the draws.
    faults = [replace(chosen, axes=1.1 * chosen.axes), replace(chosen, scales=1.1 * chosen.scales)]
    if q > 1:
        faults.append(replace(chosen, coefficients=1.1 * chosen.coefficients))
    for fault in faults:
        assert np.max(np.abs(fault.log_prob(points) - expected)) > 1e-2


def log_t(square, q):
    """Log density of the standard multivariate Student-t at a squared distance."""
    constant = gammaln((FREEDOM + q) / 2) - gammaln(FREEDOM / 2) - q / 2 * np.log(FREEDOM * np.pi)
    return constant - (FREEDOM + q) / 2 * np.log1p(square / FREEDOM)


def log_volume(chosen):
    return np.log(chosen.scales).sum() + np.linalg.slogdet(chosen.axes)[1]


@pytest.mark.parametrize("q", SIZES)
def test_draws_are_spread_as_their_density_says(q):
    """False alarm 1e-3 each.

    The map keeps volumes but for a constant, so the density of a draw says how far out its noise
    was, and that distance has an F distribution. The fault: normal instead of Student-t draws.
    """
    chosen, rng = fitted(q), generator(1, "test transport", "spread", q)

    def p_value(points):
        depth = log_t(0.0, q) - log_volume(chosen) - chosen.log_prob(points)
        square = FREEDOM * np.expm1(2 * depth / (FREEDOM + q))
        return kstest(square / q, f_distribution(q, FREEDOM).cdf).pvalue

    assert p_value(chosen.sample(20_000, rng)) > 1e-3
    normal = chosen.sample(20_000, Given(rng.standard_normal((20_000, q))))
    assert p_value(normal) < 1e-9


@pytest.mark.parametrize("q", SIZES)
def test_each_noise_is_a_student_t_of_its_own_direction(q):
    """Undone by its definition, coordinate by coordinate. All q together: false alarm 1e-3."""
    chosen = fitted(q)
    draws = chosen.sample(20_000, generator(1, "test transport", "directions", q))
    noise = undone(chosen, draws)
    p_values = [kstest(column, t(FREEDOM).cdf).pvalue for column in noise.T]
    assert min(p_values) * q > 1e-3
    # Uncorrelated, and sharing one spread: squares are correlated.
    if q > 1:
        # Of signs, whose products have a variance of 1, however heavy the tails.
        signs = np.sign(noise)
        correlation = (signs.T @ signs / len(signs))[np.triu_indices(q, 1)]
        assert np.max(np.abs(correlation)) * 20_000**0.5 < norm.isf(1e-3 / 2 / correlation.size)
        assert np.min(np.corrcoef(np.abs(noise.T))[np.triu_indices(q, 1)]) > 0.05


def undone(chosen, points):
    """Noise of points: ``e_k = (y_k - c_k(y_1 ... y_{k-1})) / s_k``, with c_k written out."""
    y = np.linalg.solve(chosen.axes, (points - chosen.mean).T)
    noise = np.empty_like(y)
    for k in range(len(y)):
        bend, column = np.zeros(y.shape[1]) + chosen.coefficients[k, 0], 1
        for j in range(k):
            for other in (None, *range(j + 1)):
                bend += chosen.coefficients[k, column] * y[j] * (1 if other is None else y[other])
                column += 1
        assert not np.any(chosen.coefficients[k, column:])
        noise[k] = (y[k] - bend) / chosen.scales[k]
    return noise.T


def test_density_integrates_to_one_on_a_grid():
    """In the plane, by the trapezium rule in ``asinh`` of the coordinates.

    Left out beyond 300: (1 + 300^2 / 8)^-4, and the bent coordinate's square of 17: below 1e-5.
    Far out along the bend the grid is coarser than the density is wide, 1e-4 of the probability.
    """
    chosen = fitted(2)
    bound = np.arcsinh(300.0)
    u = np.linspace(-bound, bound, 1500)
    x, slope = np.sinh(u), np.cosh(u)
    total = 0.0
    for row, weight in zip(x, slope, strict=True):
        points = chosen.mean + np.column_stack([np.full_like(x, row), x])
        total += weight * np.sum(np.exp(chosen.log_prob(points)) * slope)
    assert total * (u[1] - u[0]) ** 2 == pytest.approx(1, abs=1e-3)


@pytest.mark.parametrize("q", SIZES)
def test_weights_of_a_known_density_have_mean_one(q):
    """``E_q[p / q] = 1`` for a normal ``p`` inside the map. False alarm 1e-3.

    It has half the map's spread at its centre, where the map is nearly linear: weights are
    bounded by about 2^q. The fault: a density that is not normalised, by 20 per cent.
    """
    chosen, n = fitted(q), 60_000
    centre = chosen.sample(1, Given(np.zeros((1, q))))[0]
    slope = (chosen.sample(q, Given(1e-6 * np.eye(q))) - centre) / 1e-6
    known = multivariate_normal(centre, 0.25 * slope.T @ slope)
    points = chosen.sample(n, generator(1, "test transport", "known", q))
    ratio = np.exp(known.logpdf(points) - chosen.log_prob(points))
    error = ratio.std() / np.sqrt(n)
    assert error < 0.05
    assert abs(ratio.mean() - 1) < TWO_SIDED * error
    assert abs(1.2 * ratio.mean() - 1) > TWO_SIDED * error


@pytest.mark.parametrize("q", SIZES)
def test_entropy(q):
    """``-E_q[log q]`` is that of the Student-t and the log of the volume. False alarm 1e-3."""
    chosen, n = fitted(q), 40_000
    log_prob = chosen.log_prob(chosen.sample(n, generator(1, "test transport", "entropy", q)))
    expected = multivariate_t(np.zeros(q), np.eye(q), FREEDOM).entropy() + log_volume(chosen)
    assert abs(-log_prob.mean() - expected) < TWO_SIDED * log_prob.std() / np.sqrt(n)


def test_same_generator_same_draws():
    chosen = fitted(3)
    first, second = (chosen.sample(5, generator(2, "test transport", "same")) for _ in range(2))
    np.testing.assert_array_equal(first, second)
    assert first.shape == (5, 3)


# ---- fit -----------------------------------------------------------------------------------------

SD = 0.25


def banana(n, q, rng):
    """``y_1`` standard normal, the next bent by its square, the rest plain; turned and moved."""
    y = rng.standard_normal((n, q))
    y[:, 1] = (y[:, 0] ** 2 - 1) / 2 + SD * y[:, 1]
    y[:, 2:] *= 0.1
    return y @ rotation(q) + 3.0


def banana_density(points):
    y = (points - 3.0) @ rotation(points.shape[1]).T
    widest = norm.logpdf(y[:, 0])
    bend = norm.logpdf(y[:, 1], (y[:, 0] ** 2 - 1) / 2, SD)
    return widest + bend + norm.logpdf(y[:, 2:], scale=0.1).sum(1)


def efficiency(chosen, purpose, n=20_000):
    points = chosen.sample(n, generator(1, "test transport", "efficiency", purpose))
    log_ratio = banana_density(points) - chosen.log_prob(points)
    ratio = np.exp(log_ratio - log_ratio.max())
    return ratio.sum() ** 2 / np.square(ratio).sum() / n


def best_efficiency(q):
    """That of a Student-t for a standard normal, ``1 / E[p^2 / q]``, by its radial integral."""

    def integrand(r):
        surface = np.log(2) + q / 2 * np.log(np.pi) - gammaln(q / 2) + (q - 1) * np.log(r)
        return np.exp(surface - q * np.log(2 * np.pi) - r**2 - log_t(r**2, q))

    return 1 / quad(integrand, 0, 30, points=[1, 3])[0]


@pytest.mark.parametrize("q", [2, 8])
def test_a_bent_density_is_recovered(q):
    """To nine tenths of what a Student-t can do for a Gaussian.

    Of 20,000 draws the fit's 36 or fewer coefficients a coordinate cost 1 per cent. The fault: no
    functions, which is a plain Student-t of the right moments.
    """
    draws = banana(20_000, q, generator(1, "test transport", "banana", q))
    chosen = TriangularMap.fit(draws)
    limit = best_efficiency(q)
    assert 0.9 * limit < efficiency(chosen, "bent") < 1.02 * limit
    straight = replace(
        chosen,
        coefficients=np.zeros_like(chosen.coefficients),
        scales=np.ones(q),
    )
    assert efficiency(straight, "straight") < 0.5 * limit


def test_widest_direction_first():
    """The order of coordinates in which a bend is a function: the other way round it is not."""
    chosen = TriangularMap.fit(banana(20_000, 3, generator(1, "test transport", "order")))
    spreads = np.linalg.norm(chosen.axes, axis=0)
    assert np.all(np.diff(spreads) < 0)
    product = chosen.axes.T @ chosen.axes
    np.testing.assert_allclose(product, np.diag(spreads**2), atol=1e-12)
    # In units of each direction's spread: y_2 = (y_1^2 - 1) / 2 of sd sqrt(1/2 + SD^2), with the
    # eigenvector's sign; the pure square is the last of y_1's features. Error about 1 / sqrt(n).
    expected = 0.5 / np.sqrt(0.5 + SD**2)
    assert abs(chosen.coefficients[1, 2]) == pytest.approx(expected, abs=0.03)
    assert abs(chosen.coefficients[1, 1]) < 0.03


def test_moments_of_the_fit_are_those_of_weighted_draws():
    rng = generator(1, "test transport", "moments")
    draws = bent(400, 3, rng)
    weights = rng.exponential(size=400)
    weights /= weights.sum()
    chosen = TriangularMap.fit(draws, weights)
    np.testing.assert_allclose(chosen.mean, np.average(draws, axis=0, weights=weights), rtol=1e-12)
    covariance = np.cov(draws.T, aweights=weights, ddof=0)
    np.testing.assert_allclose(chosen.axes @ chosen.axes.T, covariance, atol=1e-12)
    noise = undone(chosen, draws)
    np.testing.assert_allclose(weights @ noise**2, 1, rtol=1e-12)
    assert not np.allclose(TriangularMap.fit(draws).mean, chosen.mean, atol=1e-3)


def same(one, other, points, shift=0.0):
    np.testing.assert_allclose(one.log_prob(points), other.log_prob(points) + shift, atol=1e-8)


def test_weights_of_zero_are_as_good_as_absent():
    rng = generator(1, "test transport", "absent")
    draws = bent(600, 3, rng)
    weights = np.where(np.arange(600) % 3 == 0, 0.0, 1 / 400)
    kept = TriangularMap.fit(draws[weights > 0])
    same(TriangularMap.fit(draws, weights), kept, draws[:50])
    draws[weights == 0] = 1e3
    same(TriangularMap.fit(draws, weights), kept, draws[1:3])


def test_equal_weights_are_the_default():
    draws = bent(300, 3, generator(1, "test transport", "default"))
    same(TriangularMap.fit(draws), TriangularMap.fit(draws, np.full(300, 1 / 300)), draws)


def test_weighted_draws_give_the_density_they_are_weighted_to():
    """From draws of a wide Student-t, weighted: the banana, as from draws of its own.

    The fault: weights that are not used.
    """
    rng = generator(1, "test transport", "weighted")
    wide = multivariate_t(np.full(2, 3.0), np.eye(2), 3)
    draws = wide.rvs(40_000, random_state=rng)
    ratio = np.exp(banana_density(draws) - wide.logpdf(draws))
    chosen = TriangularMap.fit(draws, ratio / ratio.sum())
    assert efficiency(chosen, "weighted") > 0.9 * best_efficiency(2)
    assert efficiency(TriangularMap.fit(draws), "unweighted") < 0.5 * best_efficiency(2)


def test_similarities_of_the_draws_are_similarities_of_the_map():
    """Moved, turned, mirrored and scaled by one factor; other maps change which way is widest."""
    draws = bent(800, 3, generator(1, "test transport", "similar"))
    turn = 7.0 * rotation(3) * np.array([1.0, -1.0, 1.0])
    moved = draws @ turn + np.array([5.0, -20.0, 1e3])
    one, other = TriangularMap.fit(draws), TriangularMap.fit(moved)
    points = draws[:100]
    expected = one.log_prob(points) - 3 * np.log(7.0)
    image = points @ turn + np.array([5.0, -20.0, 1e3])
    # To the round-off of a thousand over a spread of about one.
    np.testing.assert_allclose(other.log_prob(image), expected, atol=1e-8)


def least_squares(chosen, draws):
    """Planted fault: the map by plain regression, without the ridge."""
    y = np.linalg.solve(chosen.axes, (draws - chosen.mean).T)
    coefficients, scales = np.zeros_like(chosen.coefficients), np.empty(len(y))
    for k in range(len(y)):
        products = [y[j] * y[: j + 1] for j in range(k)]
        features = [np.ones((1, len(draws)))]
        for j in range(k):
            features += [y[j : j + 1], products[j]]
        design = np.concatenate(features).T
        found, *_ = np.linalg.lstsq(design, y[k])
        coefficients[k, : len(found)] = found
        scales[k] = np.sqrt(np.mean((y[k] - design @ found) ** 2))
    return replace(chosen, coefficients=coefficients, scales=scales)


def test_few_draws_do_not_overfit():
    """40 draws of a normal carry 36 functions of 7 coordinates: the ridge holds them down.

    Without any functions the map would be the truth. In the log density of fresh draws it loses
    to that, but less than half of what plain regression loses.
    """
    rng = generator(1, "test transport", "few")
    draws, fresh = rng.standard_normal((40, 8)), rng.standard_normal((4000, 8))
    chosen = TriangularMap.fit(draws)
    straight = replace(chosen, coefficients=0 * chosen.coefficients, scales=np.ones(8))
    best = straight.log_prob(fresh).mean()
    lost = best - chosen.log_prob(fresh).mean()
    assert 0 < lost < 0.5 * (best - least_squares(chosen, draws).log_prob(fresh).mean())


def test_the_ridge_yields_to_many_draws():
    draws = bent(100_000, 3, generator(1, "test transport", "many"))
    chosen = TriangularMap.fit(draws)
    plain = least_squares(chosen, draws)
    # Ten draws' worth of 100,000, and of coefficients of round 1.
    np.testing.assert_allclose(chosen.coefficients, plain.coefficients, atol=1e-3)
    np.testing.assert_allclose(chosen.scales, plain.scales, rtol=1e-3)


# ---- what cannot be fitted -----------------------------------------------------------------------


def spoilt(which):
    """Draws and weights that no density can be fitted to."""
    draws = bent(200, 3, generator(1, "test transport", "spoilt"))
    weights = np.full(200, 1 / 200)
    if which == "nan draw":
        draws[7, 1] = np.nan
    elif which == "infinite draw":
        draws[7, 1] = np.inf
    elif which == "nan weight":
        weights[3] = np.nan
    elif which == "infinite weight":
        weights[3] = np.inf
    elif which == "one direction":
        draws[:, 2] = draws[:, 0] - 2 * draws[:, 1]
    elif which == "constant":
        draws[:, 1] = 4.0
    elif which == "one point":
        draws[:] = draws[0]
    elif which == "one weight":
        weights = np.eye(200)[5]
    elif which == "few draws":
        draws, weights = draws[:3], np.full(3, 1 / 3)
    elif which == "one draw":
        draws, weights = draws[:1], np.ones(1)
    return draws, weights


@pytest.mark.parametrize(
    ("which", "message"),
    [
        *((which, "finite") for which in ("nan draw", "infinite draw")),
        *((which, "finite") for which in ("nan weight", "infinite weight")),
        *((which, "span") for which in ("one direction", "constant", "one point")),
        *((which, "span") for which in ("one weight", "few draws", "one draw")),
    ],
)
def test_degenerate_draws_are_refused(which, message):
    with pytest.raises(np.linalg.LinAlgError, match=message):
        TriangularMap.fit(*spoilt(which))
    TriangularMap.fit(*spoilt("nothing"))
