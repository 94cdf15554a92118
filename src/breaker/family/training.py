"""A network of a family, trained on its bank, with what records of its drives look like."""

from collections.abc import Mapping, Sequence

import numpy as np
import torch
import xarray as xr
from torch import Tensor, nn

from breaker.common.randomness import generator, seed_integer
from breaker.family.bank import shapes
from breaker.family.inputs import Basis, NormalisedRecords
from breaker.family.membership import Membership
from breaker.family.training_records import record_shapes
from breaker.family.training_rows import BankRows
from breaker.model.parameters import MOTIONS
from breaker.networks.blocks import ResidualMLP
from breaker.networks.mixture import AutoregressiveMixture
from breaker.networks.training import Checkpoint, MadeRows, Trainer, choose_device

_LEVELS = np.geomspace(1e-4, 3e-2, 8)  # of the noise, at which membership is judged

# The highest learning rate with which no training diverged; edges by Muon fare worse here.
_OPTIMISER = {"optimiser": "muon", "learning_rate": 0.002}
# What differs from the defaults of the trainer: drives of a bank are seen many times, so weights
# decay; mixtures have rare steep gradients; and the average is of the last 500 steps.
_TRAINING = {"weight_decay": 0.01, "clip": 5.0, "ema": 0.998}


class FamilyNetwork(nn.Module):
    """Residual network and autoregressive mixture, of ``networks.Network`` with torch.

    Args:
        settings: Sizes: ``width``, ``blocks``, ``features``, ``components`` and ``head``.
        name: What it is of, for messages.
        sizes: Numbers of inputs and outputs.
    """

    def __init__(
        self,
        settings: Mapping,
        name: str,
        sizes: tuple[int, int],
        *,
        atoms: Sequence[bool],
        seed: int,
    ) -> None:
        super().__init__()
        self.name, features = name, settings["features"]
        inputs, outputs = sizes
        with torch.random.fork_rng(devices=[]):
            torch.manual_seed(seed_integer(seed, "first weights", name))
            self.summary = ResidualMLP(
                inputs, settings["width"], features, blocks=settings["blocks"]
            )
            self.inference = AutoregressiveMixture(
                outputs,
                features,
                atoms=atoms,
                components=settings["components"],
                width=settings["head"],
            )

    def loss(self, x: Tensor, y: Tensor, there: Tensor) -> Tensor:
        """Minus the log density of rows ``(n, i)``, ``(n, q)``, ``(n, q)``, ``(n,)``."""
        return -self.inference.log_prob(y, self.summary(x), there).sum(dim=1)

    validation_loss = loss


def train_network(
    rows: BankRows,
    held_out: xr.Dataset,
    settings: Mapping,
    seed: int,
    *,
    workers: int = 0,
    checkpoint: Checkpoint | None = None,
) -> tuple[xr.Dataset, dict[str, np.ndarray], dict]:
    """Train a network of "levels" or "changes" on the drives of a bank.

    Args:
        rows: Of a bank, from ``rows_of``; its last ``validation_curves`` drives judge the training.
        held_out: Drives that show what records of members look like.
        settings: The sections ``network`` and ``training`` of the section ``family``, and the
            ``device``.
        workers: Processes that make batches ahead; no weight depends on them.
        checkpoint: Where the state of the training is kept.

    Returns:
        The history of the training; weights by name, and what inputs and outputs are scaled by,
        both as ``network_files.write_network`` takes them.
    """
    rows.freeze(generator(seed, "family", rows.kind, "scales"))
    device = choose_device(settings["device"])
    network = FamilyNetwork(settings["network"], rows.kind, rows.sizes, atoms=rows.atoms, seed=seed)
    aside = len(rows) - settings["training"]["validation_curves"]
    history = Trainer(
        network=network.to(device),
        rows=MadeRows(np.arange(aside), rows.rows, device, workers),
        validation=MadeRows(np.arange(aside, len(rows)), rows.rows, device),
        settings=_OPTIMISER | settings["training"],
        seed=seed,
        checkpoint=checkpoint,
        **_TRAINING,
    ).run()
    frozen = rows.frozen
    if rows.kind == "levels":
        rng = generator(seed, "family members")
        frozen["members"] = _members_of(held_out, frozen["bases"], rng)
    weights = {name: each.detach().cpu().numpy() for name, each in network.state_dict().items()}
    return history, weights, frozen


def _members_of(
    bank: xr.Dataset, bases: Mapping[str, Basis], rng: np.random.Generator
) -> dict[str, Membership]:
    """Return what records of drives look like that were held out, of each motion."""
    found = {}
    for motion in MOTIONS:
        curves = shapes(bank["shape"].sel(motion=motion, condition="new").values)
        levels = {}
        for noise in _LEVELS:
            seen, *_ = record_shapes(curves, rng, noise=(noise, 1.01 * noise))
            seen = NormalisedRecords(*(each[seen.there] for each in seen))
            levels[float(np.median(seen.noise))] = seen
        found[motion] = Membership.of(levels, bases[motion])
    return found
