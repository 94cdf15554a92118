"""What the tests of networks, posterior, training and inference share: a small model, its bank."""

import numpy as np
import pytest
import torch

from breaker.bank import simulate
from breaker.batches import freeze_inputs
from breaker.posterior import Posterior
from breaker.randomness import generator

PRIOR = {
    "mu": {"median": 2.0, "log_sd": 0.20},
    "k_a": {"median": 0.045, "log_sd": 0.15},
    "k_b": {"median": 0.040, "log_sd": 0.20},
    "gamma_a": {"median": 0.30, "log_sd": 0.20},
    "gamma_b": {"median": 0.12, "log_sd": 0.40},
    "f": {"median": 0.75, "log_sd": 0.10},
    "L": {"median": 10.0, "log_sd": 0.05},
}
SENSOR = {
    "start": -2.0,
    "stop": 58.0,
    "samples": 31,
    "noise_sd": 0.1,
    "onset_sd": 0.3,
    "zero_sd": 0.1,
}
NETWORK = {
    "summary": {
        "kind": "time_series",
        "features": 12,
        "components": 8,
        "channels": [4, 6],
        "kernels": [5, 3],
        "strides": [2, 1],
        "gru_width": 5,
        "skip": 3,
        "skip_width": 2,
        "width": 24,
        "blocks": 1,
    },
    "inference": {"kind": "flow_matching", "width": 24, "blocks": 1},
}


@pytest.fixture
def one_thread():
    """One thread of torch, so that the order of its sums is always the same."""
    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    yield
    torch.set_num_threads(threads)


def settings(*, motion="closing", onset=True):
    """Settings of a small model."""
    sensor = SENSOR if onset else {**SENSOR, "onset_sd": 0.0, "zero_sd": 0.0}
    return {"motion": motion, "prior": PRIOR, "sensor": sensor, "network": NETWORK}


def bank_of(posterior, n, *, seed=5):
    """A bank of n curves for a model."""
    sensor, motion = posterior.sensor, posterior.motion
    rng = generator(seed, "test bank", motion)
    return simulate(posterior.prior, sensor.times, motion, n, rng, onset_sd=sensor.onset_sd)


def frozen(*, motion="closing", onset=True, curves=512, seed=0):
    """A small new model, its inputs frozen on a bank of its own."""
    posterior = Posterior(settings(motion=motion, onset=onset), seed=seed)
    travel = bank_of(posterior, curves).travel.values
    freeze_inputs(posterior, travel, generator(0, "test components"))
    return posterior.eval()


@torch.no_grad()
def perturb(module, scale, *, seed=3):
    """Draw all weights anew, so that no layer is zero; returns the module."""
    rng = torch.Generator().manual_seed(seed)
    for weight in module.parameters():
        weight.copy_(scale * torch.randn(weight.shape, generator=rng, dtype=weight.dtype))
    return module


@torch.no_grad()
def pin(posterior, mean, sd):
    """Make a new model the Gaussian N(mean, sd^2) of standardised outputs, whatever the record.

    The velocity field of a new model is zero, so its posterior is the head's Gaussian.
    """
    q = len(posterior.outputs)
    head = posterior.inference.head
    head.weight.zero_()
    head.bias.zero_()
    head.bias[:q] = torch.as_tensor(np.broadcast_to(mean, q).copy(), dtype=torch.float32)
    head.bias[q : 2 * q] = -float(np.log(sd))
    return posterior
