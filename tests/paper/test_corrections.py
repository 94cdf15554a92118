"""Adaptive importance sampling against known posteriors, from draws that are wrong."""

import numpy as np
import pytest
from scipy.stats import chi2
from scipy.stats import t as student

from breaker.common.randomness import generator
from breaker.paper import correction as corrections
from breaker.paper.correction import Importance, correct, importance, temper
from tests.paper.known import LOG_EVIDENCE, RECORD, Banana, HeavyTailed, Known, Truncated

REPEATS = 30
NORMAL, BANANA, TRUNCATED = Known(), Banana(0.2, 0.2), Truncated()
STARTS = {
    "shifted": lambda model, z: z + 2 * np.sqrt(model.variance),
    "wide": lambda model, z: model.mean + 3 * (z - model.mean),
    "narrow": lambda model, z: model.mean + 0.5 * (z - model.mean),
}


def start(model, how, rng, n=500):
    """Draws of a bad network, physical units."""
    return model.destandardise(STARTS[how](model, model.sample(n, rng)))


def evidence_p_value(results):
    """p-value of the log evidence, two-sided, with the errors of the delta method: chi-square."""
    weights = [result.importance for result in results]
    errors = np.array([weight.log_evidence - LOG_EVIDENCE for weight in weights])
    square = np.sum(errors**2 / [1 / weight.size - 1 / 2000 for weight in weights])
    return 2 * min(chi2.cdf(square, len(errors)), chi2.sf(square, len(errors)))


def moments_p_value(model, draws):
    """p-value of means, and of squares around the true mean, of all outputs: Student's t.

    Repeats are independent, so their scatter is the Monte-Carlo error. A self-normalised mean is
    off by about 1 / 1200 of a variance; the error of 30 repeats' mean is ten times that.
    """
    centred = np.array([model.standardise(draw) - model.mean for draw in draws])
    moments = np.hstack([centred.mean(1), np.square(centred).mean(1)])
    errors = moments - np.r_[np.zeros(4), model.variance]
    score = errors.mean(axis=0) / (errors.std(axis=0, ddof=1) / np.sqrt(len(errors)))
    return min(1.0, 2 * student(len(errors) - 1).sf(np.abs(score).max()) * score.size)


@pytest.mark.parametrize(
    ("model", "how"), [(BANANA, "shifted"), (BANANA, "narrow"), (TRUNCATED, "wide")]
)
def test_known_posteriors_are_reached(model, how):
    """Evidence and moments: false alarm 1e-3 each. Planted fault: the draws it started from."""
    starts, results = [], []
    for i in range(REPEATS):
        rng = generator(1, "test correction", type(model).__name__, how, i)
        starts.append(start(model, how, rng))
        results.append(correct(model, RECORD, starts[-1], rng))
    assert all(r.resolved and r.reason == "" for r in results)
    assert all(r.importance.size >= 400 and r.importance.pareto_k < 0.7 for r in results)
    z = model.standardise(np.concatenate([result.draws for result in results]))
    assert np.isfinite(model.log_posterior(z)).all()
    assert evidence_p_value(results) > 1e-3
    assert moments_p_value(model, [result.draws for result in results]) > 1e-3
    assert moments_p_value(model, starts) < 1e-9


def test_what_cannot_be_resolved_is_not():
    """No map of this kind follows a Cauchy, not even from draws of the posterior itself."""
    model, rng = HeavyTailed(), generator(1, "test correction", "unresolved")
    draws = model.destandardise(model.sample(500, rng))
    result = correct(model, RECORD, draws, rng)
    assert not result.resolved
    assert result.importance.size < 400
    assert f"{result.importance.size:.0f}" in result.reason
    assert (result.rounds, result.importance.faulty) == (20, 0)
    assert np.isfinite(result.draws).all()


def test_a_tail_that_is_not_known_to_be_good_is_not(monkeypatch):
    for k, good in ((-np.inf, True), (0.69, True), (0.7, False), (np.inf, False), (np.nan, False)):
        monkeypatch.setattr(Importance, "pareto_k", k)
        assert (importance(np.zeros(2000), np.zeros(2000)).fault == "") == good
        assert importance(np.zeros(399), np.zeros(399)).fault  # too few, whatever the tail


class Failing(Known):
    """Counts the points of each call; at two points of the calls ``fails`` its density is nan."""

    def __init__(self, *fails):
        self.fails, self.asked = fails, []

    def log_joint(self, z, record):
        self.asked.append(len(z))
        result = super().log_joint(z, record)
        if len(self.asked) in self.fails:
            result[:2] = np.nan
        return result


@pytest.mark.parametrize(
    ("efficiency", "asked"), [(0.999, [500, 500, 500, 2000]), (0.001, [500, 2000])]
)
def test_rounds_end_with_a_good_one_or_the_last(efficiency, asked, monkeypatch):
    monkeypatch.setattr(corrections, "_EFFICIENCY", efficiency)
    monkeypatch.setattr(Importance, "pareto_k", 0.0)
    model, rng = Failing(), generator(1, "test correction", "counting")
    result = correct(model, RECORD, start(model, "wide", rng, n=200), rng, rounds=3)
    assert model.asked == asked
    assert result.rounds == len(asked) - 1
    assert result.draws.shape == (200, 4)


@pytest.mark.parametrize("fault", ["nan", "same", "few"])
def test_draws_that_carry_no_map(fault):
    rng = generator(1, "test correction", "no map")
    values = start(NORMAL, "wide", rng, n=3 if fault == "few" else 500)
    if fault != "few":
        values[:] = np.nan if fault == "nan" else values[0]
    result = correct(NORMAL, RECORD, values, rng)
    assert result.reason
    assert result.draws.shape == values.shape
    assert np.isnan([*result.draws.ravel(), result.importance.log_evidence]).all()
    assert (result.resolved, result.rounds, result.importance.faulty) == (False, 0, 0)


@pytest.mark.parametrize(("faulty", "rounds"), [(0, 2), (2, 0)])
def test_a_record_that_no_draw_explains_has_no_posterior(faulty, rounds):
    """More draws are tried, but not after densities that are not numbers."""

    class Nowhere(Known):
        def log_joint(self, z, record):
            return np.where(np.arange(len(z)) < faulty, np.nan, -np.inf)

    rng = generator(1, "test correction", "nowhere")
    result = correct(Nowhere(), RECORD, start(NORMAL, "wide", rng), rng, rounds=2)
    assert np.isnan(result.draws).all()
    assert (result.rounds, result.resolved) == (rounds, False)
    assert result.importance.faulty == faulty


@pytest.mark.parametrize(("call", "kept"), [(1, False), (2, False), (3, True)])
def test_faulty_densities_are_counted(call, kept, monkeypatch):
    """In a round of adaptation, in the result, and after a first result, which is kept."""
    monkeypatch.setattr(corrections, "_SMALLEST_SIZE", 1999)
    monkeypatch.setattr(corrections, "_EFFICIENCY", 0.01)
    model, rng = Failing(call), generator(1, "test correction", "faulty")
    result = correct(model, RECORD, start(model, "wide", rng), rng)
    assert len(model.asked) == call
    assert not result.resolved
    assert "2" in result.reason
    assert np.isfinite(result.draws).all() == np.isfinite(result.importance.log_evidence) == kept
    assert result.importance.faulty == (0 if kept else 2)


def effective_size(weights):
    return weights.sum() ** 2 / np.square(weights).sum()


@pytest.mark.parametrize("spread", [0.1, 1, 1e2, 1e6])
def test_tempered_weights_have_the_size(spread):
    """The largest power up to 1 that leaves it: one per cent more leaves less."""
    log_ratio = spread * generator(1, "test correction", "temper").standard_normal(500)
    weights = temper(log_ratio, 300)
    assert effective_size(weights) >= 300 * (1 - 1e-9)
    top, other = np.argsort(log_ratio)[[-1, 300]]
    power = np.log(weights[top] / weights[other]) / (log_ratio[top] - log_ratio[other])
    by_hand, more = (np.exp(k * power * (log_ratio - log_ratio.max())) for k in (1.0, 1.01))
    np.testing.assert_allclose(weights, by_hand / by_hand.sum(), rtol=1e-6)
    # These weights are even enough, or the power is the largest.
    assert power == pytest.approx(1.0) if spread == 0.1 else effective_size(more) < 300
    log_ratio[:3] = np.nan, np.inf, -np.inf
    with pytest.raises(np.linalg.LinAlgError, match="2 weights"):
        temper(log_ratio, 100)
