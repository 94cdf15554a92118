"""A training that was killed ends with the weights of an uninterrupted one, bit for bit."""

import pickle
from pathlib import Path

import pytest
import torch

from breaker.networks.training import Trainer
from tests.networks_fixtures import Trap, same, weights

UNREADABLE = (EOFError, RuntimeError, ValueError, pickle.UnpicklingError)


class Killed(Exception):
    pass


def stopping_at(step):
    class Stopping(Trainer):
        def _advance(self):
            if self.step == step:
                raise Killed
            super()._advance()

    return Stopping


def kill(trainer, step, **more):
    """Let a training run up to a step."""
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
        assert same(weights(complete), weights(resumed))
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
    assert same(weights(training), weights(fresh))


def test_a_checkpoint_is_written_completely_or_not_at_all(trainer, monkeypatch):
    """A kill during writing leaves the checkpoint before."""
    kill(trainer, 7)
    training = trainer()
    before = training.checkpoint.file.read_bytes()

    def torn(state, path):
        Path(path).write_bytes(b"half a")
        raise Killed

    monkeypatch.setattr(torch, "save", torn)
    with pytest.raises(Killed):
        training.run()
    assert training.checkpoint.file.read_bytes() == before


def test_a_checkpoint_that_cannot_be_read_stops_the_training(trainer, tmp_path):
    """Never a silent start from the beginning, nor from half a state; and no pickle is run."""
    kill(trainer, 7)
    training, trap = trainer(), tmp_path / "ran"
    file = training.checkpoint.file
    content = file.read_bytes()
    torch.save({"fingerprint": Trap(trap)}, file)
    for bad in (b"", content[: len(content) // 2], file.read_bytes()):
        file.write_bytes(bad)
        with pytest.raises(UNREADABLE):
            training.run()
    assert training.step == 0
    assert not trap.exists()
