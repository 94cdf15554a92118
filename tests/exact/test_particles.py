"""Particles find posteriors that are known, whatever the emulator tells them.

Monte Carlo errors follow from the effective size that particles state; with the fixed seeds here
nothing varies, and with others a false alarm is at most 1e-3.
"""

import numpy as np
import pytest

from breaker.common.randomness import generator
from breaker.drive.exact import exact_posterior, particles, residual_emulator
from breaker.drive.exact.particles import Particles, smooth_scores
from tests.exact.toys import bent, kinds, switched

SIZE = 300
SURE = 4.0  # standard errors: 1e-3 for a dozen numbers
TOYS = {"bent": bent, "switched": switched}


@pytest.fixture(autouse=True)
def small(monkeypatch):
    """Few draws of the prior, and an emulator that learns little: a poor one, and quick."""
    monkeypatch.setattr(particles, "_FIRST", 4000)
    monkeypatch.setattr(residual_emulator, "_HIDDEN", (24, 24))
    monkeypatch.setattr(exact_posterior, "_EARLY", 30)


def led(known, seed=1):
    """Particles at the posterior, and the number of powers on the way."""
    found, lines = Particles.of_prior(known.target, SIZE, generator(seed, "toy")), []
    exact_posterior.lead(found, lines.append)
    return found, len(lines)


def walked(found, rounds=40):
    """What is asked after each round, ``(t, n, a)``, after a few that are left out."""
    asked = []
    for _ in range(rounds):
        found.round()
        asked.append(found.asked)
    return np.array(asked[rounds // 4 :])


def errors(known, seed=1):
    """Of means, sds and the log evidence, in standard errors."""
    found, powers = led(known, seed)
    asked = walked(found)
    effective = found.effective_size(asked)
    assert effective > SIZE
    mean, sd = asked.mean(axis=(0, 1)), asked.std(axis=(0, 1))
    # Squares are worth fewer independent draws than values: at least half as many here.
    of_sds = (sd / known.sd - 1.0) * np.sqrt(effective)
    of_means = (mean - known.mean) / known.sd * np.sqrt(effective)
    # Weights of a step that leaves half vary as much as their mean.
    assert found.log_evidence_se < 2.0 * np.sqrt(powers / SIZE)
    of_evidence = (found.log_evidence - known.log_evidence) / found.log_evidence_se
    return np.array([*of_means, *of_sds, of_evidence])


# ---- known posteriors ----------------------------------------------------------------------------


@pytest.mark.parametrize("name", TOYS)
def test_means_sds_and_evidence_are_those_of_the_posterior(name):
    assert np.abs(errors(TOYS[name]())).max() < SURE


def forgets_what_the_walk_gained(patch):
    walk = Particles._walked
    patch.setattr(Particles, "_walked", lambda *a: (walk(*a)[0], 0.0))


def believes_the_emulator(patch):
    def round_(self):
        self.scores, _ = self._walked()
        self.numbers, self.log_like = self.simulate(self.scores)
        return 1.0, 1.0

    patch.setattr(Particles, "round", round_)


def takes_evidence_of_the_last_step_alone(patch):
    temper = Particles.temper

    def last(self):
        self.log_shares = np.log(self.target.shares)
        temper(self)

    patch.setattr(Particles, "temper", last)


@pytest.mark.parametrize(
    "fault",
    [
        forgets_what_the_walk_gained,
        believes_the_emulator,
        takes_evidence_of_the_last_step_alone,
    ],
)
def test_a_planted_fault_shows(fault, monkeypatch):
    fault(monkeypatch)
    assert np.abs(errors(bent())).max() > SURE


@pytest.mark.parametrize("off", [0.0, 1.5])
def test_kinds_have_their_probability_whatever_share_of_their_draws_works(off):
    """Where a kind's draws hardly work, it is drawn again, and is as frequent as another."""

    def error(target):
        found = Particles.of_prior(target, SIZE, generator(3, "toy"))
        exact_posterior.lead(found, lambda _: None)
        assert np.isfinite(found.log_like).all()
        odds = np.log(found.shares[1] / found.shares[0])
        return abs(odds - -0.5 * off**2) / np.sqrt(found.variances.sum())

    target = kinds([0.4, 1.0], off)
    assert error(target) < SURE
    target.shares[:] = 0.286, 0.714  # a planted fault: shares of those that work
    assert error(target) > SURE


def test_a_kind_of_which_hardly_a_draw_works_has_its_probability():
    """Of 2,000 draws it has some 20, fewer than the particles that it is to have."""
    found = Particles.of_prior(kinds([0.01, 1.0]), SIZE, generator(1, "toy"))
    assert np.bincount(found.kind)[0] < SIZE / 10
    exact_posterior.lead(found, lambda _: None)
    assert np.bincount(found.kind).tolist() == [SIZE / 2, SIZE / 2]
    assert abs(np.diff(found.log_shares)[0]) < SURE * np.sqrt(found.variances.sum())
    assert found.variances[0] > 0.02  # its draws tell little


def test_a_kind_that_is_hardly_possible_is_given_up():
    found = Particles.of_prior(kinds([1.0, 1.0], 7.0), SIZE, generator(4, "toy"))
    exact_posterior.lead(found, lambda _: None)
    assert found.shares.tolist() == [1.0, 0.0]
    assert len(found.kind) == SIZE
    assert not found.kind.any()


# ---- what particles are made of ------------------------------------------------------------------


def test_a_target_of_which_hardly_a_draw_moves_is_refused():
    with pytest.raises(ValueError, match="of 4000 draws of the family only 0 move"):
        Particles.of_prior(kinds([0.0, 0.0]), SIZE, generator(1, "toy"))


def test_a_step_of_tempering_leaves_half_and_keeps_drives_with_their_scores():
    known = bent()
    found = Particles.of_prior(known.target, SIZE, generator(1, "toy"))
    weights = found.log_like.copy()
    found.temper()
    weights = np.exp(found.power * (weights - weights.max()))
    left = weights.sum() ** 2 / np.square(weights).sum()
    assert 0.0 < found.power < 1.0
    assert left == pytest.approx(0.5 * SIZE, rel=1e-6)
    assert len(found.scores) == SIZE
    assert np.array_equal(known.target.numbers(found.scores), found.numbers)
    residuals = known.target.residuals(found.numbers)
    assert np.allclose(found.log_like, -0.5 * np.square(residuals).sum(axis=1))


def test_same_seed_same_particles():
    first, again = (led(bent())[0] for _ in range(2))
    assert np.array_equal(first.scores, again.scores)
    assert first.log_evidence == again.log_evidence
    assert not np.array_equal(first.scores, led(bent(), seed=2)[0].scores)


def test_scores_that_move_a_number_by_a_little_are_smooth():
    known = switched()  # of which the second score decides, and the last moves nothing
    examples = generator(1, "toy").standard_normal((40, known.target.unknowns))
    assert smooth_scores(known.target, examples).tolist() == [0, 2]


def test_particles_do_not_depend_on_the_number_of_cores(monkeypatch):
    both = led(bent())[0].scores
    monkeypatch.setattr(particles, "at_once", lambda *calls: [call() for call in calls])
    assert np.array_equal(led(bent())[0].scores, both)


def test_the_effective_size_is_that_of_independent_draws_and_of_families():
    rng = generator(1, "effective")
    n, times = 500, 40

    def size(walked, ancestor, kind=None, log_shares=(0.0,), variances=(0.0,)):
        kind = np.zeros(n, int) if kind is None else kind
        about = ancestor, kind, np.array(log_shares), np.array(variances)
        found = Particles(bent().target, n, rng, *[np.empty(0)] * 3, *about)
        return found.effective_size(walked)

    own = rng.standard_normal((times, n, 2))
    assert size(own, np.arange(n)) == pytest.approx(n * times, rel=0.25)
    assert size(own[:1].repeat(times, axis=0), np.arange(n)) == pytest.approx(n, rel=0.25)
    of_one = own[:1, :50].repeat(10, axis=1).repeat(times, axis=0)  # ten of each ancestor
    assert size(of_one, np.arange(50).repeat(10)) == pytest.approx(50, rel=0.5)
    # Two kinds far apart, as likely as each other: their share is known by the evidence alone.
    kind = np.arange(n) % 2
    apart = own + 100.0 * kind[:, None]
    known = size(apart, np.arange(n), kind, np.log([0.5, 0.5]), [0.02, 0.02])
    assert known == pytest.approx(1.0 / (0.5**2 * 0.04), rel=0.05)
