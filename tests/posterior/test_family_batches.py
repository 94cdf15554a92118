"""Batches of a family's networks that other processes make: the same, in their order."""

import time

import numpy as np
import pytest
import torch

from breaker.family.training import FamilyNetwork
from breaker.networks.training import Checkpoint, MadeRows, Trainer
from tests.networks_fixtures import CONSTANTS, TRAINING, same, weights

SIZES = {"width": 12, "blocks": 1, "features": 6, "components": 3, "head": 5}
# Of Python on systems with more cores or fewer than this test takes.
pytestmark = pytest.mark.filterwarnings("ignore:This process|This DataLoader")


def make(drives, rng):
    """Inputs that tell the drive, and outputs with atoms, some of which are not there."""
    x = drives[:, None] / 50.0 + 0.1 * rng.standard_normal((len(drives), 4))
    y = x[:, :3] * (rng.random((len(drives), 3)) < 0.8)
    return x, y, rng.random(y.shape) < 0.7


def training(folder, workers=0, *, device="cpu", make=make, **changes):
    network = FamilyNetwork(SIZES, "levels", (4, 3), atoms=(True, False, True), seed=1)
    return Trainer(
        network=network.to(device),
        rows=MadeRows(np.arange(80), make, device, workers),
        validation=MadeRows(np.arange(80, 100), make, device),
        settings=TRAINING | changes,
        seed=1,
        checkpoint=Checkpoint(folder / "levels.pt", "this one"),
        **CONSTANTS,
    )


def test_weights_do_not_depend_on_workers(tmp_path):
    """Also where one batch takes longer than the next; generators of torch stay as they are."""
    before = torch.get_rng_state()

    def uneven(drives, rng):
        time.sleep(0.05 * (drives[0] % 2))
        return make(drives, rng)

    trained = []
    for workers in (0, 2):
        each = training(tmp_path / str(workers), workers, make=uneven)
        history = each.run()
        trained.append((weights(each), history))
    (alone, said), (helped, also_said) = trained
    assert torch.equal(torch.get_rng_state(), before)
    assert same(alone, helped)
    assert said.identical(also_said)
    assert len(set(said.training_loss.values.tolist())) == TRAINING["steps"]


def test_a_killed_training_with_workers_goes_on_where_it_was(tmp_path):
    class Killed(Exception):
        pass

    class Stopping(Trainer):
        def _advance(self):
            if self.step == 7:
                raise Killed
            super()._advance()

    whole = training(tmp_path / "whole")
    whole.run()
    killed = training(tmp_path / "killed", 2)
    killed.__class__ = Stopping
    with pytest.raises(Killed):
        killed.run()
    resumed = training(tmp_path / "killed", 1)
    resumed.run()
    assert len(resumed.losses) == TRAINING["steps"]
    assert same(weights(whole), weights(resumed))


def test_a_fault_of_a_worker_ends_the_training(tmp_path):
    def faulty(drives, rng):
        if len(drives) == TRAINING["batch"]:  # not the rows for validation
            raise FloatingPointError("no record")
        return make(drives, rng)

    with pytest.raises(FloatingPointError, match="no record"):
        training(tmp_path, 1, make=faulty).run()
