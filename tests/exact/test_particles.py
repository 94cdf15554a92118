"""Particles find posteriors that are known, whatever the emulator tells them.

Monte Carlo errors follow from the effective size that particles state; with the fixed seeds here
nothing varies, and with others a false alarm is at most 1e-3.
"""

from dataclasses import replace

import numpy as np
import pytest

from breaker.common.randomness import generator
from breaker.drive.exact import exact_posterior, particles, residual_emulator
from breaker.drive.exact.particles import Particles, Smooth, effective_size
from tests.exact.toys import bent, kinds, log_prior, switched

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
    effective = effective_size(asked, found.ancestor)
    assert effective > SIZE
    mean, sd = asked.mean(axis=(0, 1)), asked.std(axis=(0, 1))
    # Squares are worth fewer independent draws than values: at least half as many here.
    of_sds = (sd / known.sd - 1.0) * np.sqrt(effective)
    of_means = (mean - known.mean) / known.sd * np.sqrt(effective)
    # Weights of a step that leaves half vary as much as their mean.
    of_evidence = (found.log_evidence - known.log_evidence) / np.sqrt(powers / SIZE)
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
        mixed = self.rng.permutation(SIZE)
        for own, other in np.array([np.split(mixed, 2), np.split(mixed, 2)[::-1]]):
            walked, _ = self._walked(own, other)
            self.scores[own] = walked
            self.numbers[own], self.log_like[own] = self.simulate(walked)
        return 1.0, 1.0

    patch.setattr(Particles, "round", round_)


def takes_evidence_of_the_last_step_alone(patch):
    temper = Particles.temper

    def last(self):
        self.log_evidence = 0.0
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


def test_kinds_keep_their_shares_whatever_share_of_their_draws_works():
    """Where a kind's draws hardly work, it is drawn again, and is as frequent as another."""

    def error(target):
        found = Particles.of_prior(target, SIZE, generator(3, "toy"))
        exact_posterior.lead(found, lambda _: None)
        asked = walked(found)
        assert np.isfinite(found.log_like).all()
        sd = 0.5 / np.sqrt(effective_size(asked, found.ancestor))
        return abs(asked[..., 0].mean() - 0.5) / sd

    target = kinds([0.4, 1.0])
    assert error(target) < SURE
    assert error(replace(target, log_prior=log_prior)) > SURE  # a planted fault


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


def test_scores_that_move_different_numbers_smoothly_form_a_group():
    known = switched()  # of which the second score decides, and the last moves nothing
    examples = generator(1, "toy").standard_normal((40, known.target.unknowns))
    smooth = Smooth.of(known.target, examples)
    assert smooth.scores.tolist() == [0, 2]
    assert smooth.groups == [[0, 2]]
    assert smooth.moves.tolist() == [[[1.0, 0.0], [0.0, 1.0]]]


def test_the_effective_size_is_that_of_independent_draws_and_of_families():
    rng = generator(1, "effective")
    n, times = 500, 40
    own = rng.standard_normal((times, n, 2))
    assert effective_size(own, np.arange(n)) == pytest.approx(n * times, rel=0.25)
    assert effective_size(own[:1].repeat(times, axis=0), np.arange(n)) == pytest.approx(n, rel=0.25)
    of_one = own[:1, :50].repeat(10, axis=1).repeat(times, axis=0)  # ten of each ancestor
    assert effective_size(of_one, np.arange(50).repeat(10)) == pytest.approx(50, rel=0.5)
