"""Importance weights against problems in closed form: evidence, size, divergence, tail."""

import math
from functools import partial

import numpy as np
import pytest
from scipy.stats import chisquare, multivariate_normal, norm

from breaker.model.randomness import generator
from breaker.posterior import weights as exact
from breaker.posterior.weights import importance, resample
from tests.corrections import errors_p_value

TWO_SIDED = norm.isf(0.5e-3)  # 3.29 standard errors: false alarm 1e-3


# ---- a linear Gaussian model -------------------------------------------------------------------


class Linear:
    """``z ~ N(0, I)`` of three, ``x = A z + e`` of five, and a proposal near the posterior.

    In coordinates in which the posterior is ``N(0, I)`` the proposal is ``N(shift, width^2 I)``.
    """

    width, shift = 1.3, np.array([0.4, -0.3, 0.2])

    def __init__(self):
        rng = generator(1, "test exact", "linear")
        slope, sd = rng.normal(size=(5, 3)), 0.5
        self.slope, self.sd = slope, sd
        self.record = slope @ rng.standard_normal(3) + sd * rng.standard_normal(5)
        precision = np.eye(3) + slope.T @ slope / sd**2
        self.mean = np.linalg.solve(precision, slope.T @ self.record / sd**2)
        self.root = np.linalg.cholesky(np.linalg.inv(precision))
        marginal = multivariate_normal(np.zeros(5), slope @ slope.T + sd**2 * np.eye(5))
        self.log_evidence = marginal.logpdf(self.record)

    def sample(self, n, rng):
        u = self.shift + self.width * rng.standard_normal((n, 3))
        return self.mean + u @ self.root.T

    def log_joint(self, z):
        error = self.record - z @ self.slope.T
        return norm.logpdf(z).sum(1) + norm.logpdf(error, scale=self.sd).sum(1)

    def log_density(self, z):
        u = np.linalg.solve(self.root, (z - self.mean).T).T
        normal = norm.logpdf(u, self.shift, self.width).sum(1)
        return normal - np.log(np.diag(self.root)).sum()

    def weigh(self, n, rng):
        z = self.sample(n, rng)
        return self.log_joint(z), self.log_density(z)

    def moment(self, j):
        """``E_q[w^j]`` of weights of mean one.

        For each coordinate, with the proposal standardised, the posterior is ``N(m, s^2)``. The
        product ``p^j q^(1-j)`` is a Gaussian of precision ``j / s^2 - (j - 1)``.
        """
        s, m = 1 / self.width, -self.shift / self.width
        precision = j / s**2 - (j - 1)
        exponent = (j * m / s**2) ** 2 / (2 * precision) - j * m**2 / (2 * s**2)
        return float(np.prod(np.exp(exponent) / (s**j * np.sqrt(precision))))

    @property
    def divergence(self):
        """``KL(p | q)`` of two Gaussians."""
        s, m = 1 / self.width, -self.shift / self.width
        return float(0.5 * np.sum(s**2 + m**2 - 1 - 2 * np.log(s)))


@pytest.fixture(scope="module")
def linear():
    return Linear()


@pytest.fixture(scope="module")
def judged(linear):
    n = 40_000
    joint, density = linear.weigh(n, generator(1, "test exact", "judged"))
    return joint, density, importance(joint, density)


def test_weights_are_normalised_ratios(judged):
    joint, density, result = judged
    weights = np.exp(joint - density - np.max(joint - density))
    np.testing.assert_allclose(np.exp(result.log_weights), weights / weights.sum(), rtol=1e-10)
    assert result.size == pytest.approx(weights.sum() ** 2 / np.square(weights).sum(), rel=1e-10)
    assert result.efficiency == result.size / len(joint)
    assert result.faulty == 0


def test_evidence_in_closed_form(linear, judged):
    """False alarm 1e-3. The fault, a proposal density off by 0.03 nats, is ten such errors."""
    *_, result = judged
    assert abs(result.log_evidence - linear.log_evidence) < TWO_SIDED * result.log_evidence_se
    error = np.sqrt((linear.moment(2) - 1) / 40_000)
    assert result.log_evidence_se == pytest.approx(error, rel=0.05)
    joint, density, _ = judged
    wrong = importance(joint, density + 0.03).log_evidence - linear.log_evidence
    assert abs(wrong) > TWO_SIDED * error


def test_efficiency_in_closed_form(linear, judged):
    """``E[w]^2 / E[w^2]``; its error by the delta method from four moments. False alarm 1e-3."""
    second, third, fourth = (linear.moment(j) for j in (2, 3, 4))
    covariance = np.array([[second - 1, third - second], [third - second, fourth - second**2]])
    gradient = np.array([2 / second, -1 / second**2])
    error = np.sqrt(gradient @ covariance @ gradient / 40_000)
    *_, result = judged
    assert linear.moment(1) == pytest.approx(1, rel=1e-12)
    assert abs(result.efficiency - 1 / second) < TWO_SIDED * error
    # The faults: the size of unnormalised weights of another power.
    for power in (0.5, 2):
        size = np.exp(-2 * power * result.log_weights).sum()
        wrong = np.exp(power * result.log_weights).sum() ** 2 / size / 40_000
        assert abs(wrong - 1 / second) > 10 * error


def test_gap_is_the_divergence_of_posterior_from_proposal(linear, judged):
    """False alarm 1e-3: the estimate's influence function is ``w (log w - KL - 1) + 1``.

    The faults: the divergence the other way round, and without the evidence.
    """
    joint, density, result = judged
    log_w = joint - density - linear.log_evidence
    error = np.std(np.exp(log_w) * (log_w - linear.divergence - 1)) / np.sqrt(len(joint))
    assert abs(result.gap - linear.divergence) < TWO_SIDED * error
    assert abs(-np.mean(log_w) - linear.divergence) > 10 * error
    assert abs(result.gap + result.log_evidence - linear.divergence) > 10 * error


@pytest.fixture(scope="module")
def repeats(linear):
    """Log evidence over the truth and its standard error, of many small samples."""
    rng = generator(1, "test exact", "repeats")
    results = [importance(*linear.weigh(400, rng)) for _ in range(800)]
    error = np.array([r.log_evidence for r in results]) - linear.log_evidence
    return error, np.array([r.log_evidence_se for r in results]), results


def test_evidence_is_unbiased_and_its_error_calibrated(repeats):
    """False alarm 1e-3 each. The evidence itself is unbiased, its logarithm only nearly."""
    error, error_sd, results = repeats
    ratio = np.exp(error)
    assert abs(ratio.mean() - 1) < TWO_SIDED * ratio.std() / np.sqrt(len(ratio))
    assert errors_p_value(error, error_sd) > 1e-3
    # The faults: the error of a weight that has the effective size, and of equal weights.
    sizes = np.array([result.size for result in results])
    assert errors_p_value(error, 1 / np.sqrt(sizes)) < 1e-6
    assert errors_p_value(error, np.full(len(error), 1 / np.sqrt(400))) < 1e-6


def test_constants_shift_the_evidence_alone(judged):
    """Weights are never exponentiated before their largest is taken off.

    Round-off: 1e5 has a spacing of 1.5e-11, and normalised weights sum to 1 within 1e-11.
    """
    joint, density, result = judged
    for constant in (-1e5, 1e5):
        shifted = importance(joint + constant, density)
        np.testing.assert_allclose(shifted.log_weights, result.log_weights, atol=1e-9)
        assert shifted.log_evidence == pytest.approx(result.log_evidence + constant, abs=1e-9)
        assert shifted.size == pytest.approx(result.size, rel=1e-9)
        assert shifted.gap == pytest.approx(result.gap, abs=1e-6)
        assert shifted.pareto_k == pytest.approx(result.pareto_k, abs=1e-6)


# ---- Pareto k ----------------------------------------------------------------------------------

N = 100_000
TAIL = math.floor(3 * math.sqrt(N))  # largest weights to which the tail is fitted


def gaussian_log_ratio(width, rng):
    """Log ratio of ``N(0, I)`` in the plane to a proposal of the given width, at its draws.

    ``w = const exp(a r^2 / 2)`` with ``a = 1 / width^2 - 1``, and ``r^2 / (2 width^2)`` is
    exponential. A narrow proposal's weights so are exactly Pareto, ``P(w > t) ~ t^(-1/k)``, with
    ``k = a width^2 = 1 - width^2``; a wide one's end at their largest value with a uniform law,
    ``k = -1``.
    """
    z = width * rng.standard_normal((N, 2))
    return norm.logpdf(z).sum(1) - norm.logpdf(z, scale=width).sum(1)


def true_k(width):
    return 1 - width**2 if width < 1 else -1.0


def k_error(k, width):
    """Distance of ``k`` from the truth, in standard errors.

    The fit shrinks ``k`` to 1/2 by ten weights more; its variance is ``(1 + k)^2 / tail``, that
    of the largest likelihood, and that of ``k = -1/2`` below, where the likelihood's is too small.
    """
    expected = (TAIL * true_k(width) + 5) / (TAIL + 10)
    return abs(k - expected) / ((1 + max(true_k(width), -0.5)) / np.sqrt(TAIL))


WIDTHS = [0.9, 0.75, 0.6, 0.4, 1.3]


@pytest.mark.parametrize("width", WIDTHS)
def test_pareto_k_of_a_known_tail(width):
    """False alarm 1e-3 each."""
    log_ratio = gaussian_log_ratio(width, generator(1, "test exact", "tail", str(width)))
    assert k_error(importance(log_ratio, np.zeros(N)).pareto_k, width) < TWO_SIDED


@pytest.mark.parametrize("width", WIDTHS)
def test_wrong_sign_of_the_weights_is_caught(width, monkeypatch):
    """The fault: the tail is that of the smallest weights."""
    right = exact._pareto_k
    monkeypatch.setattr(exact, "_pareto_k", lambda log_weights: right(-log_weights))
    log_ratio = gaussian_log_ratio(width, generator(1, "test exact", "tail", str(width)))
    assert k_error(importance(log_ratio, np.zeros(N)).pareto_k, width) > 10


def reference_k(log_weights):
    """Zhang & Stephens (2009), with the prior and the tail of Vehtari et al. (2024), rounded down.

    In their notation a generalised Pareto of shape ``-k`` and ``theta = k / scale``.
    """
    s = len(log_weights)
    tail = math.floor(min(0.2 * s, 3 * math.sqrt(s)))
    weights = np.sort(np.exp(log_weights - log_weights.max()))
    x = weights[-tail:] - weights[-tail - 1]
    grid = 30 + math.floor(math.sqrt(tail))
    quartile = x[math.floor(tail / 4 + 0.5) - 1]
    log_likelihood, thetas = [], []
    for j in range(1, grid + 1):
        theta = 1 / x[-1] + (1 - math.sqrt(grid / (j - 0.5))) / (3 * quartile)
        k = -sum(math.log1p(-theta * value) for value in x) / tail
        thetas.append(theta)
        log_likelihood.append(tail * (math.log(theta / k) + k - 1))
    posterior = np.exp(np.array(log_likelihood) - max(log_likelihood))
    theta = posterior @ thetas / posterior.sum()
    k = sum(math.log1p(-theta * value) for value in x) / tail
    return (tail * k + 10 * 0.5) / (tail + 10)


@pytest.mark.parametrize("n", [25, 100, 500, 2000])
@pytest.mark.parametrize("width", [0.5, 0.8, 1.3])
def test_pareto_k_by_a_second_fit(n, width):
    rng = generator(1, "test exact", "second fit", n)
    log_ratio = gaussian_log_ratio(width, rng)[:n]
    expected = reference_k(log_ratio)
    assert importance(log_ratio, np.zeros(n)).pareto_k == pytest.approx(expected, abs=1e-9)
    assert abs(reference_k(-log_ratio) - expected) > 0.01


def test_too_few_weights_have_no_tail():
    log_ratio = generator(1, "test exact", "few").standard_normal(200)
    for positive, finite in ((24, False), (25, True)):
        log_joint = np.where(np.arange(200) < positive, log_ratio, -np.inf)
        assert np.isfinite(importance(log_joint, np.zeros(200)).pareto_k) == finite


@pytest.mark.parametrize("ahead", [30, 700, 740, 2000, 1e5])
def test_one_weight_that_is_everything_is_not_a_good_tail(ahead):
    """Also where the others underflow beside it."""
    log_ratio = generator(1, "test exact", "one").standard_normal(500)
    log_ratio[7] += ahead
    result = importance(log_ratio, np.zeros(500))
    assert not result.pareto_k < 0.7
    assert result.size == pytest.approx(1)


@pytest.mark.parametrize("sd", [10, 100, 1000, 1e4])
def test_weights_of_many_magnitudes_are_not_a_good_tail(sd):
    log_ratio = sd * generator(1, "test exact", "magnitudes").standard_normal(500)
    assert not importance(log_ratio, np.zeros(500)).pareto_k < 0.7


def test_largest_weights_alike_are_a_bounded_tail():
    """Weights that end at a value which many of them have: nothing is beyond it."""
    log_ratio = np.repeat([0.0, -1.0], [200, 300])
    result = importance(log_ratio, np.zeros(500))
    assert result.pareto_k < 0.7
    share = np.exp(-1.0)
    assert result.size == pytest.approx((200 + 300 * share) ** 2 / (200 + 300 * share**2))


# ---- edges -------------------------------------------------------------------------------------


def test_equal_weights():
    """Also with the round-off of a density taken off a large joint."""
    density = generator(1, "test exact", "equal").normal(size=300)
    result = importance(density + 120.0, density)
    assert result.size == pytest.approx(300)
    assert result.log_evidence == pytest.approx(120.0)
    assert result.log_evidence_se == pytest.approx(0, abs=1e-7)  # the root of round-off
    assert result.gap == pytest.approx(0, abs=1e-12)
    assert result.pareto_k == -np.inf


def test_zero_weights_are_legitimate():
    """A proposal cut by the support: everything is a binomial share, in closed form."""
    rng = generator(1, "test exact", "cut")
    z = rng.standard_normal(4000)
    share = np.mean(z > 0.3)
    result = importance(np.where(z > 0.3, norm.logpdf(z), -np.inf), norm.logpdf(z))
    assert result.faulty == 0
    assert result.size == pytest.approx(4000 * share)
    assert result.log_evidence == pytest.approx(np.log(share))
    assert result.log_evidence_se == pytest.approx(np.sqrt((1 - share) / (4000 * share)))
    assert result.gap == pytest.approx(-np.log(share))
    assert np.isneginf(result.log_weights[z <= 0.3]).all()


def test_zero_weights_count_as_draws():
    """The tail of the others is fitted without them, the mean weight is taken over all."""
    log_ratio = generator(1, "test exact", "padded").standard_normal(500)
    padded = np.concatenate([log_ratio, np.full(500, -np.inf)])
    few, all_ = importance(log_ratio, np.zeros(500)), importance(padded, np.zeros(1000))
    assert all_.size == pytest.approx(few.size)
    assert all_.efficiency == pytest.approx(few.efficiency / 2)
    assert all_.log_evidence == pytest.approx(few.log_evidence - np.log(2))
    assert all_.pareto_k == pytest.approx(few.pareto_k)


def test_nothing_in_the_support():
    result = importance(np.full(50, -np.inf), np.zeros(50))
    assert (result.size, result.efficiency, result.faulty) == (0, 0, 0)
    assert result.log_evidence == -np.inf
    assert result.log_evidence_se == result.gap == np.inf
    assert np.isnan(result.pareto_k)
    assert np.isneginf(result.log_weights).all()


@pytest.mark.parametrize(
    ("joint", "density"),
    [(np.nan, 0.0), (np.inf, 0.0), (0.0, np.nan), (0.0, -np.inf), (-np.inf, -np.inf)],
)
@pytest.mark.parametrize("count", [1, 3])
def test_faults_are_counted_and_leave_nothing_defined(joint, density, count):
    log_joint, log_density = np.zeros(40), generator(1, "test exact", "faults").normal(size=40)
    log_joint[5] = -np.inf  # legitimate
    log_joint[10 : 10 + count], log_density[10 : 10 + count] = joint, density
    result = importance(log_joint, log_density)
    assert result.faulty == count
    numbers = (result.size, result.pareto_k, result.log_evidence, result.log_evidence_se)
    assert np.isnan([*numbers, result.gap, result.efficiency]).all()
    assert np.isnan(result.log_weights).all()
    assert result.log_weights.shape == (40,)


# ---- resampling --------------------------------------------------------------------------------

WEIGHTS = np.array([0.0, 0.31, 0.004, 0.0, 0.11, 0.2, 0.05, 0.0, 0.026, 0.3, 0.0])
DRAWN, TIMES = 37, 4000


def log(weights):
    with np.errstate(divide="ignore"):
        return np.log(weights)


def by_midpoints(log_weights, n, rng):
    """Planted fault: systematic resampling without its random start."""
    edges = np.cumsum(np.exp(log_weights))
    return rng.permutation(np.searchsorted(edges, (np.arange(n) + 0.5) / n * edges[-1]))


def in_order(log_weights, n, rng):
    """Planted fault: systematic resampling in the order of the draws."""
    return np.sort(resample(log_weights, n, rng))


def multinomial(log_weights, n, rng):
    """Planted fault: each draw is taken by itself."""
    return rng.choice(len(log_weights), n, p=np.exp(log_weights))


def taken(method, purpose):
    rng = generator(1, "test exact", purpose)
    return np.array([method(log(WEIGHTS), DRAWN, rng) for _ in range(TIMES)])


def counts_of(indices):
    return np.array([np.bincount(row, minlength=len(WEIGHTS)) for row in indices])


def rounded(counts):
    expected = DRAWN * WEIGHTS
    return np.all((counts >= np.floor(expected)) & (counts <= np.ceil(expected)))


def bias(counts):
    """Largest error of mean counts, in standard errors of a share of roundings up."""
    share = DRAWN * WEIGHTS % 1
    uncertain = share > 0
    error = (counts - DRAWN * WEIGHTS)[:, uncertain].mean(0)
    return np.max(np.abs(error) / np.sqrt((share * (1 - share))[uncertain] / TIMES))


def test_each_draw_is_taken_its_number_of_times():
    """Seven uncertain counts together: false alarm 1e-3."""
    counts = counts_of(taken(resample, "counts"))
    assert rounded(counts)
    assert bias(counts) < norm.isf(1e-3 / 14)
    assert not np.any(counts[:, WEIGHTS == 0])


def test_wrong_counts_are_caught():
    assert bias(counts_of(taken(by_midpoints, "midpoints"))) > 20
    assert not rounded(counts_of(taken(multinomial, "multinomial")))


def order_p_value(indices):
    """Of the index at the first, a middle and the last place, each by its weight."""
    positive = WEIGHTS > 0
    expected = TIMES * WEIGHTS[positive]
    p_values = []
    for place in (0, DRAWN // 2, -1):
        observed = np.bincount(indices[:, place], minlength=len(WEIGHTS))[positive]
        p_values.append(chisquare(observed, expected).pvalue)
    return min(p_values) * len(p_values)


def test_any_place_is_as_good_as_another():
    """Three places together: false alarm 1e-3."""
    assert order_p_value(taken(resample, "order")) > 1e-3
    assert order_p_value(taken(in_order, "order")) < 1e-9


class Start:
    """Generator whose one random number is given, and which keeps the order."""

    def __init__(self, number):
        self.number = number

    def random(self):
        return self.number

    def permutation(self, values):
        return values


@pytest.mark.parametrize("start", [0.0, 1e-300, 0.5, np.nextafter(1.0, 0.0)])
@pytest.mark.parametrize("n", [1, 37, 1000, 99_991])
def test_zero_weights_are_never_taken(start, n):
    """Not at either end either, where positions meet edges in round-off."""
    weights = np.concatenate([WEIGHTS, np.full(5, 0.1), np.zeros(2)])
    indices = resample(log(weights / weights.sum()), n, Start(start))
    assert indices.shape == (n,)
    assert np.all(weights[indices] > 0)


def test_weights_need_not_sum_to_one():
    """The last edge is the sum as it came out: with positions up to 1 the last draw would be
    taken ten times more."""
    indices = resample(np.log(np.full(10, 0.099)), 1000, Start(0.5))
    np.testing.assert_array_equal(np.bincount(indices), np.full(10, 100))


def test_same_generator_same_indices():
    draw = partial(resample, log(WEIGHTS), DRAWN)
    first, second = (draw(generator(3, "test exact", "same")) for _ in range(2))
    np.testing.assert_array_equal(first, second)
