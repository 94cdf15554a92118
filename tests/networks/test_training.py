"""Training: randomness, numbers by formula, what is kept, rows made by workers, and resuming."""

import math
import random
import time
from pathlib import Path

import numpy as np
import pytest
import torch

from breaker.networks.blocks import Hidden, ResidualMLP
from breaker.networks.training import MadeRows, Trainer, optimisers, orthogonal
from tests.networks_fixtures import Trap, normal


def same(*trainings):
    """Whether two trainings ended with the same weights, bit for bit."""
    return all(map(torch.equal, *(item.network.state_dict().values() for item in trainings)))


def test_the_seed_alone_decides(trainer):
    """Global generators are neither used nor touched, and an evaluation leaves the training."""

    def states():
        return torch.random.get_rng_state().tolist(), random.getstate(), np.random.get_state()[1:]

    runs = [trainer(evaluate_every=10), trainer(evaluate_every=2), trainer(seed=2)]
    before = str(states())
    history = runs[0].run()
    assert str(states()) == before
    for other in runs[1:]:
        other.checkpoint.file.unlink()
        with torch.random.fork_rng(devices=[]):
            torch.manual_seed(12345)
            other.run()
    assert runs[0].losses == runs[1].losses
    assert all(map(torch.equal, runs[0].means, runs[1].means))
    assert not set(runs[0].losses) & set(runs[2].losses)
    assert np.unique(history.training_loss.values).size == 10  # fresh noise at each step
    still = trainer(learning_rate=0.0, seed=3)  # the records that it is validated by stay
    still.checkpoint.file.unlink()
    assert np.unique(still.run().validation_loss.values).size == 1


def test_every_step_has_its_learning_rate_and_a_clipped_gradient(trainer):
    """A linear warm-up over 3 % of the steps, times a cosine."""
    training, rates, norms = trainer(clip=0.01, learning_rate=2e-3), [], []

    def watch(optimiser, *_):
        rates.append(optimiser.param_groups[0]["lr"])
        norms.append(math.sqrt(sum(float(w.grad.square().sum()) for w in training.weights)))

    training.optimisers[0].register_step_pre_hook(watch)
    history = training.run()
    np.testing.assert_allclose(rates, 1e-3 * (1 + np.cos(np.pi * np.arange(10) / 10)))
    np.testing.assert_array_equal(history.learning_rate.values, rates)
    ramp = [trainer(learning_rate=2e-3, steps=100).learning_rate(k) for k in range(4)]
    cosine = 1e-3 * (1 + np.cos(np.pi * np.arange(4) / 100))
    np.testing.assert_allclose(ramp, cosine * [1 / 3, 2 / 3, 1, 1])
    # Unclipped, every norm is far above: clipping scales all of them to the bound.
    np.testing.assert_allclose(norms, 0.01, rtol=1e-3)


def test_moving_average_by_hand(trainer):
    """Decay min(ema, k / (k + 10)) after step k: short memory at first, then the one set. The only
    evaluation is at the end, so that the average is what is kept.
    """
    training = trainer(steps=6, ema=0.3, evaluate_every=100)
    expected = [weight.detach().clone() for weight in training.weights]
    decays = iter([1 / 11, 2 / 12, 3 / 13, 4 / 14, 0.3, 0.3])

    def follow(*_):
        decay = next(decays)
        for mean, weight in zip(expected, training.weights, strict=True):
            mean.mul_(decay).add_(weight.detach(), alpha=1 - decay)

    training.optimisers[-1].register_step_post_hook(follow)
    training.run()
    torch.testing.assert_close(training.means, expected, rtol=1e-5, atol=1e-6)
    assert all(map(torch.equal, training.weights, training.means))


def test_the_best_average_is_kept(trainer):
    """A learning rate that is far too high: the loss of the average rises."""
    training = trainer(steps=8, learning_rate=0.1, evaluate_every=1, clip=100.0)
    averages = {}
    training.optimisers[0].register_step_pre_hook(
        lambda *_: averages.update({training.step: [w.clone() for w in training.means]})
    )
    history = training.run()
    losses = history.validation_loss.values
    best = int(losses.argmin())
    assert best + 1 < 8, "the training must get worse for this test to say anything"
    assert history.attrs == {"best_step": best + 1, "best_validation_loss": losses[best]}
    assert all(map(torch.equal, training.weights, averages[best + 1]))


def test_optimisers_share_the_weights():
    """Muon takes the matrices between hidden layers, and AdamW all else."""
    network = ResidualMLP(4, 16, 3, blocks=2)
    every = {id(weight): weight for weight in network.parameters()}
    hidden = {id(layer.weight) for layer in network.modules() if isinstance(layer, Hidden)}
    matrices = {number for number, weight in every.items() if weight.ndim == 2}
    for kind, expected in (("muon", hidden), ("muon_edges", matrices)):
        adamw, muon = (
            {id(weight) for weight in optimiser.param_groups[0]["params"]}
            for optimiser in optimisers(network, kind, learning_rate=5e-3, weight_decay=0.01)
        )
        assert (muon, adamw) == (expected, every.keys() - expected)


@pytest.mark.parametrize("shape", [(20, 20), (30, 12)])
def test_a_step_of_muon_is_nearly_orthogonal(shape):
    matrix = normal(*shape).float()
    left, _, right = torch.linalg.svd(matrix, full_matrices=False)
    turned = left.T @ orthogonal(torch.stack([matrix, -matrix]))[0] @ right.T
    assert ((turned.diagonal() - 0.95).abs() < 0.35).all()
    assert (turned - turned.diagonal().diag()).abs().max() < 0.05


def test_a_loss_that_is_not_finite_names_motion_and_step(trainer):
    """That of the validation, too, or the first weights would be kept as the best."""
    training = trainer()
    training.fixed_batch.measured[5] = math.nan
    with pytest.raises(FloatingPointError, match="closing is nan at step 5"):
        training.run()
    training.checkpoint.file.unlink()
    training = trainer(motion="opening")
    training.rows.travel = torch.full_like(training.rows.travel, math.inf)
    with pytest.raises(FloatingPointError, match=r"opening is (nan|inf) at step 0"):
        training.run()


def uneven(numbers, rng):
    """Rows of which some take longer than the next."""
    time.sleep(0.02 * (numbers[0] % 2))
    return numbers + rng.random(len(numbers)), rng.standard_normal((len(numbers), 3))


def faulty(numbers, rng):
    raise FloatingPointError("no record")


@pytest.mark.filterwarnings("ignore:This process|This DataLoader")
def test_batches_depend_on_seed_and_step_alone():
    """Not on workers, nor on the steps before, as after a kill; a worker's fault is raised."""

    def batches(workers, steps, make=uneven):
        rows, rng = MadeRows(np.arange(80), make, workers=workers), torch.Generator().manual_seed(1)
        return [rows.batch(step, 4, rng) for step in steps]

    before = torch.get_rng_state()
    alone, helped, later = batches(0, range(6)), batches(2, range(6)), batches(0, [4])
    assert torch.equal(torch.get_rng_state(), before)
    for one, other in zip([*alone, alone[4]], [*helped, *later], strict=True):
        assert all(map(torch.equal, one, other))
    assert len({float(batch[0][0]) for batch in alone}) == 6
    with pytest.raises(FloatingPointError, match="no record"):
        batches(1, [0], faulty)


class Killed(Exception):
    pass


def stopping_at(step):
    """A kind of trainer that is killed before a step."""

    class Stopping(Trainer):
        def _advance(self):
            if self.step == step:
                raise Killed
            super()._advance()

    return Stopping


def kill(trainer, step, **more):
    with pytest.raises(Killed):
        trainer(kind=stopping_at(step), **more).run()


@pytest.mark.parametrize("step", [8, 7, 2], ids=["at a checkpoint", "after one", "before any"])
def test_a_resumed_training_is_the_uninterrupted_one(trainer, step):
    """Bit for bit: weights, losses, history. A second kill changes nothing either, nor does one
    between the last step and the model file."""
    complete = trainer(checkpoint_every=4)
    history = complete.run()
    complete.checkpoint.file.unlink()
    kill(trainer, step)
    assert complete.checkpoint.file.exists() == (step >= 4)
    if step == 8:
        kill(trainer, 9)
    for last in (10, 5):
        resumed = trainer(checkpoint_every=last, kind=stopping_at(10))
        assert resumed.run().identical(history)
        assert same(complete, resumed)
    assert [*resumed.checkpoint.file.parent.iterdir()] == [resumed.checkpoint.file]


def test_a_checkpoint_of_another_training_is_ignored(trainer):
    """It stays at first, and is written over by this training's own."""
    kill(trainer, 7, mark="another training", learning_rate=1e-4)
    training = trainer()
    training.run()
    state = torch.load(training.checkpoint.file, weights_only=True)
    assert (state["fingerprint"], state["step"]) == ("this one", 8)
    training.checkpoint.file.unlink()
    fresh = trainer()
    fresh.run()
    assert same(training, fresh)


def test_a_checkpoint_is_written_completely_and_read_completely(trainer, tmp_path, monkeypatch):
    """A kill during writing leaves the checkpoint before. One that cannot be read stops the
    training: never a silent start from the beginning, nor from half a state; no pickle is run.
    """
    kill(trainer, 7)
    training, trap = trainer(), tmp_path / "ran"
    file = training.checkpoint.file
    content = file.read_bytes()

    def torn(state, path):
        Path(path).write_bytes(b"half a")
        raise Killed

    with monkeypatch.context() as patch:
        patch.setattr(torch, "save", torn)
        with pytest.raises(Killed):
            training.run()
    assert file.read_bytes() == content
    torch.save({"fingerprint": Trap(trap)}, file)
    training = trainer()
    for bad in (b"", content[: len(content) // 2], file.read_bytes()):
        file.write_bytes(bad)
        with pytest.raises(ValueError, match="cannot be read"):
            training.run()
    assert training.step == 0
    assert not trap.exists()
