"""What the tests of networks, posterior, training and inference share: a small model, its bank."""

from functools import cache
from pathlib import Path

import numpy as np
import torch
from scipy.stats import norm

from breaker.common.randomness import generator
from breaker.configuration.loading import defaults
from breaker.model.curves import travel
from breaker.networks.training import Checkpoint, Trainer
from breaker.paper.bank import simulate, truth
from breaker.paper.posterior import Posterior
from breaker.paper.training import Rows, freeze_inputs, split

PRIOR, SENSOR = defaults()["prior"], defaults()["sensor"] | {"samples": 31}
SUMMARY = {"kind": "time_series", "features": 12, "components": 8, "channels": [4, 6]}
SUMMARY |= {"kernels": [5, 3], "strides": [2, 1], "gru_width": 5, "skip": 3, "skip_width": 2}
SUMMARY |= {"width": 24, "blocks": 1}
NETWORK = {
    "summary": SUMMARY,
    "inference": {"kind": "flow_matching", "width": 24, "blocks": 1},
}
COUPLING_FLOW = {"kind": "coupling_flow", "transforms": 3, "bins": 5, "hidden": [10, 12]}
COMBINATIONS = {
    "flow_matching": NETWORK,
    "coupling_flow": {"summary": SUMMARY, "inference": COUPLING_FLOW},
}

TRAINING = {"steps": 10, "batch": 16, "optimiser": "muon", "learning_rate": 5e-3}
TRAINING |= {"evaluate_every": 5, "checkpoint_every": 4}
CONSTANTS = {"weight_decay": 0.01, "clip": 1.0, "ema": 0.6}


def settings(*, motion="closing", onset=True, network=NETWORK):
    """Settings of a small model."""
    sensor = SENSOR if onset else {**SENSOR, "onset_sd": 0.0, "zero_sd": 0.0}
    return {"motion": motion, "prior": PRIOR, "sensor": sensor, "network": network}


def bank_of(posterior, n, *, seed=5):
    """A bank of n curves for a model."""
    return simulate(posterior.model, n, generator(seed, "test bank", posterior.motion))


def frozen(*, motion="closing", onset=True, network=NETWORK, curves=512, seed=0):
    """A small new model, its inputs frozen on a bank of its own."""
    made_from = settings(motion=motion, onset=onset, network=network)
    posterior = Posterior(made_from, seed=seed)
    freeze_inputs(posterior, bank_of(posterior, curves), generator(0, "test components"))
    return posterior.eval()


def built(kind, *sizes, seed=0, **more):
    """A new network ``kind(*sizes, **more)``; torch's global generator stays as it was."""
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(seed)
        return kind(*sizes, **more)


@torch.no_grad()
def perturb(module, scale, *, seed=3):
    """Draw all weights anew, so that no layer is zero; returns the module."""
    rng = torch.Generator().manual_seed(seed)
    for weight in module.parameters():
        weight.copy_(scale * torch.randn(weight.shape, generator=rng, dtype=weight.dtype))
    return module


@torch.no_grad()
def pin(posterior, mean, sd):
    """Make a new model the Gaussian N(mean, sd^2) of standardised outputs, whatever the record: the
    velocity field of a new model is zero, and its splines are the identity.
    """
    q = len(posterior.outputs)
    head = posterior.inference.head
    head.weight.zero_()
    head.bias.zero_()
    head.bias[:q] = torch.as_tensor(np.broadcast_to(mean, q).copy(), dtype=torch.float32)
    head.bias[q : 2 * q] = -float(np.log(sd))
    return posterior


@cache
def training_rows():
    """Rows of a small bank to train on, and to judge on."""
    bank = bank_of(Posterior(settings()), 400)
    return [bank.isel(curve=part) for part in split(400, 24)]


def new_trainer(folder, *, kind=Trainer, seed=1, mark="this one", motion="closing", **changes):
    """A small training with its checkpoint in a folder, as a new process would set it up."""
    posterior = Posterior(settings(motion=motion), seed=seed)
    rows, validation = training_rows()
    freeze_inputs(posterior, rows, generator(seed, "components"))
    return kind(
        network=posterior,
        rows=Rows.of(rows, posterior),
        validation=Rows.of(validation, posterior),
        settings=TRAINING | {name: changes[name] for name in changes.keys() & TRAINING},
        seed=seed,
        checkpoint=Checkpoint(folder / "checkpoints" / "closing.pt", mark),
        **CONSTANTS | {name: changes[name] for name in changes.keys() & CONSTANTS},
    )


def exact_curves(posterior, values):
    """Noise-free curves of values ``(n, q)``, by the mechanism."""
    onset = values[:, 7] if values.shape[1] == 8 else 0.0
    times = posterior.sensor.times
    return travel(values[:, :7], times, posterior.motion, onset=onset).travel


def simulated(posterior, n, *, seed=11):
    """Truth ``(n, q)``, exact curves and records ``(n, t)``."""
    values = truth(bank_of(posterior, n, seed=seed), posterior.model)
    exact = exact_curves(posterior, values)
    return values, exact, posterior.sensor.corrupt(exact, generator(seed, "test noise"))


def curved_model(network=NETWORK):
    """A model whose posteriors depend on the record and are far from Gaussian, and records."""
    posterior = frozen(network=network)
    perturb(posterior.inference, 0.15)
    for steps in (posterior.solver_steps, posterior.density_solver_steps):
        steps.fill_(3)
    _, _, records = simulated(posterior, 5, seed=6)
    return posterior, records


def noise_of(posterior, o, d):
    """Start points of draws, ``(o, d, q)``."""
    return generator(2, "test noise").standard_normal((o, d, len(posterior.outputs)))


def normal(*shape, seed=1):
    """Standard normal numbers in float64."""
    return torch.from_numpy(np.random.default_rng(seed).standard_normal(shape))


def silu(x):
    """``x sigmoid(x)``."""
    return x / (1.0 + np.exp(-x))


def arrays(module):
    """Weights of a module by name, as arrays."""
    return {name: weight.detach().numpy() for name, weight in module.state_dict().items()}


def residual_by_hand(x, module, blocks):
    """What a ``ResidualMLP`` makes of one row."""
    w = arrays(module)
    h = w["enter.weight"] @ x + w["enter.bias"]
    for k in range(blocks):
        inside = silu(w[f"inner.{k}.weight"] @ silu(h) + w[f"inner.{k}.bias"])
        h = h + w[f"outer.{k}.weight"] @ inside + w[f"outer.{k}.bias"]
    return w["leave.weight"] @ silu(h) + w["leave.bias"]


def density_by_autograd(network, noise, features, steps=1):
    """Draws, and their log density from the Jacobian of the sampling map, one point at a time."""
    points, densities = torch.empty_like(noise), torch.empty(noise.shape[:2], dtype=noise.dtype)
    for i, j in np.ndindex(*noise.shape[:2]):

        def sample(start, condition=features[i : i + 1]):
            return network.sample(start[None, None], condition, steps=steps)[0, 0]

        points[i, j] = sample(noise[i, j]).detach()
        jacobian = torch.autograd.functional.jacobian(sample, noise[i, j])
        change = torch.linalg.slogdet(jacobian).logabsdet
        densities[i, j] = norm.logpdf(noise[i, j].numpy()).sum() - change
    return points, densities


class Trap:
    """A pickle that makes a file when it is read."""

    def __init__(self, target):
        self.target = target

    def __reduce__(self):
        return Path.touch, (self.target,)
