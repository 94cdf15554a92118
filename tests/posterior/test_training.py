"""Training: its randomness, what is judged and kept, and the numbers behind it by formula."""

import math
import random

import numpy as np
import pytest
import torch

from breaker.networks.training import fingerprint
from tests.networks_fixtures import same, weights

# ---- randomness ---------------------------------------------------------------------------------


def test_the_seed_decides(trainer):
    runs = [trainer(seed=seed, checkpoint_every=100, evaluate_every=10) for seed in (1, 1, 2)]
    for run in runs:
        run.run()
    assert same(weights(runs[0]), weights(runs[1]))
    assert runs[0].losses == runs[1].losses
    assert not set(runs[0].losses) & set(runs[2].losses)


def test_global_randomness_is_neither_used_nor_touched(trainer):
    def states():
        return torch.random.get_rng_state(), np.random.get_state()[1].copy(), random.getstate()

    before = states()
    first = trainer(checkpoint_every=100, evaluate_every=10)
    first.run()
    after = states()
    assert torch.equal(before[0], after[0])
    np.testing.assert_array_equal(before[1], after[1])
    assert before[2] == after[2]
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(12345)
        second = trainer(checkpoint_every=100, evaluate_every=10)
        second.run()
    assert same(weights(first), weights(second))


def test_validation_is_fixed(trainer):
    """Its records are drawn once: weights at rest have one loss."""
    training = trainer(learning_rate=0.0)
    history = training.run()
    assert history.evaluation_step.values.tolist() == [5, 10]
    assert np.unique(history.validation_loss.values).size == 1
    assert np.unique(history.training_loss.values).size == 10
    assert all(map(torch.equal, training.fixed_batch, trainer().fixed_batch))
    measured = training.fixed_batch.measured
    assert (measured - training.validation.travel).abs().max() > 0.1


# ---- the numbers by formula ---------------------------------------------------------------------


def test_learning_rate_warms_up_and_falls_by_a_cosine(trainer):
    training = trainer(steps=100, learning_rate=2e-3, warm_up=0.1)
    half_cosine = [0.5 * (1 + math.cos(math.pi * k / 100)) for k in range(100)]
    ramp = [(k + 1) / 10 if k < 10 else 1.0 for k in range(100)]
    expected = [2e-3 * a * b for a, b in zip(ramp, half_cosine, strict=True)]
    np.testing.assert_allclose([training.learning_rate(k) for k in range(100)], expected)
    assert training.learning_rate(50) == pytest.approx(1e-3)
    assert training.learning_rate(100) == pytest.approx(0.0, abs=1e-18)
    assert trainer(steps=100, learning_rate=2e-3, warm_up=0.0).learning_rate(0) == 2e-3


def test_every_step_has_its_learning_rate_and_a_clipped_gradient(trainer):
    training, rates, norms = trainer(clip=0.01), [], []

    def watch(optimiser, *_):
        rates.append(optimiser.param_groups[0]["lr"])
        norms.append(math.sqrt(sum(float(w.grad.square().sum()) for w in training.weights)))

    training.optimisers[0].register_step_pre_hook(watch)
    history = training.run()
    assert rates == [training.learning_rate(k) for k in range(10)]
    np.testing.assert_array_equal(history.learning_rate.values, rates)
    # Unclipped, every norm is far above: clipping scales all of them to the bound.
    np.testing.assert_allclose(norms, 0.01, rtol=1e-3)


def test_moving_average_by_hand(trainer):
    """Decay min(ema, k / (k + 10)) after step k: short memory at first, then the one set."""
    training = trainer(steps=6, ema=0.3, evaluate_every=100)
    expected = [weight.detach().clone() for weight in training.weights]
    count = 0

    def follow(*_):
        nonlocal count
        count += 1
        decay = [0, 1 / 11, 2 / 12, 3 / 13, 4 / 14][count] if count < 5 else 0.3
        for mean, weight in zip(expected, training.weights, strict=True):
            mean.mul_(decay).add_(weight.detach(), alpha=1 - decay)

    training.optimisers[-1].register_step_post_hook(follow)
    training.run()
    assert count == 6
    for mean, weight in zip(expected, training.means, strict=True):
        torch.testing.assert_close(weight, mean, rtol=1e-5, atol=1e-6)
    # The only evaluation is at the end, so that the average is what is kept.
    assert all(map(torch.equal, training.weights, training.means))


def test_the_best_average_is_kept(trainer):
    """A learning rate that is far too high: the loss of the average rises."""
    training = trainer(steps=8, learning_rate=0.1, warm_up=0.9, evaluate_every=1, clip=100.0)
    averages = {}
    training.optimisers[0].register_step_pre_hook(
        lambda *_: averages.update({training.step: [w.clone() for w in training.means]})
    )
    history = training.run()
    losses = history.validation_loss.values
    best = int(losses.argmin())
    assert best + 1 < 8, "the training must get worse for this test to say anything"
    assert history.attrs["best_step"] == training.best_step == best + 1
    assert history.attrs["best_validation_loss"] == losses[best]
    assert all(map(torch.equal, training.weights, averages[best + 1]))
    with torch.no_grad():
        loss = training.network.validation_loss(*training.fixed_batch)
    assert loss.mean().item() == losses[best]


def test_an_evaluation_leaves_the_training_alone(trainer):
    """Judging the average more often does not change what is trained."""
    often, seldom = trainer(evaluate_every=2), trainer(evaluate_every=10)
    for training in (often, seldom):
        training.run()
        training.checkpoint.file.unlink()
    assert often.losses == seldom.losses
    assert all(map(torch.equal, often.means, seldom.means))


# ---- faults -------------------------------------------------------------------------------------


@pytest.mark.parametrize("bad", [math.nan, math.inf])
def test_a_loss_that_is_not_finite_names_motion_and_step(trainer, bad):
    training = trainer(motion="opening")

    def spoil(*_):
        if training.step == 5:
            training.rows.travel = torch.full_like(training.rows.travel, bad)

    training.optimisers[-1].register_step_post_hook(spoil)
    message = r"the loss of opening is (nan|inf) at step 6; lower training.learning_rate"
    with pytest.raises(FloatingPointError, match=message):
        training.run()


def test_a_validation_loss_that_is_not_finite_is_not_passed_over(trainer):
    """Or the first weights, which no comparison with NaN replaces, would be kept as the best."""
    training = trainer()
    training.fixed_batch.measured[5] = math.nan
    with pytest.raises(FloatingPointError, match="closing"):
        training.run()


def test_fingerprint_tells_settings_and_code_apart(tmp_path):
    code = tmp_path / "code.py"
    code.write_text("x = 1\n")
    first = fingerprint({"a": 1, "b": {"c": 2}}, [code])
    assert fingerprint({"b": {"c": 2}, "a": 1}, [code]) == first
    assert fingerprint({"a": 1, "b": {"c": 3}}, [code]) != first
    assert fingerprint({"a": 1, "b": {"c": 2}}, []) != first
    code.write_text("x = 2\n")
    assert fingerprint({"a": 1, "b": {"c": 2}}, [code]) != first
