"""Training of the networks of a family on its bank. Needs torch."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import torch
import xarray as xr
from torch import Tensor, nn

from breaker.common.randomness import generator, seed_integer
from breaker.family.bank import shapes
from breaker.family.inputs import Basis, NormalisedRecords, Sensors
from breaker.family.membership import Membership, distances
from breaker.family.training_records import record_shapes
from breaker.family.training_rows import BankRows
from breaker.model.parameters import MOTIONS
from breaker.networks.blocks import ResidualMLP
from breaker.networks.mixture import AutoregressiveMixture
from breaker.networks.training import Checkpoint, MadeRows, Trainer, choose_device

_LEVELS = 8  # of the noise, over the range of the training
_QUANTILES = 64  # of squared distances: interpolation between more changes no p-value

# Highest learning rate with which no training diverged; training edges by Muon gave worse results.
_OPTIMISER = {"optimiser": "muon", "learning_rate": 0.002}
# Differences from defaults of the trainer: weights decay, as drives of a bank are used many times;
# gradients are clipped, as mixtures have rare steep ones; 500 steps are averaged.
_TRAINING = {"weight_decay": 0.01, "clip": 5.0, "ema": 0.998}


class FamilyNetwork(nn.Module):
    """``networks.Network`` with torch: residual network and autoregressive mixture, by settings
    ``width``, ``blocks``, ``features``, ``components`` and ``head``, and sizes of input and output.
    """

    def __init__(
        self, settings: Mapping, name: str, sizes: Sequence[int], *, atoms: Sequence, seed: int
    ) -> None:
        super().__init__()
        self.name, (inputs, outputs) = name, sizes
        width, blocks, features = (settings[key] for key in ("width", "blocks", "features"))
        mixture = {"components": settings["components"], "width": settings["head"]}
        with torch.random.fork_rng(devices=[]):
            torch.manual_seed(seed_integer(seed, "first weights", name))
            self.summary = ResidualMLP(inputs, width, features, blocks=blocks)
            self.inference = AutoregressiveMixture(outputs, features, atoms=atoms, **mixture)

    def loss(self, x: Tensor, y: Tensor, there: Tensor) -> Tensor:
        """Return minus the log density of rows ``(n, i)``, ``(n, q)``, ``(n, q)``, ``(n,)``."""
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
) -> tuple[xr.Dataset, dict[str, np.ndarray], dict[str, Any]]:
    """Train a network of "levels" or "changes" on the drives of a bank; return the history of the
    training, and weights and scales as ``network_files.write_network`` takes them.

    Args:
        rows: From ``rows_of``; the last ``validation_curves`` drives judge the training.
        held_out: Drives whose distances from the family define membership.
        settings: ``network`` and ``training`` of the section ``family``, and the ``device``.
        workers: Processes that prepare batches.
        checkpoint: File that keeps the state of the training.
    """
    rows.freeze(generator(seed, "family", rows.network.kind, "scales"))
    device = choose_device(settings["device"])
    sizes = [part.shape[1] for part in rows.rows(np.arange(1), np.random.default_rng(1))[:2]]
    kind, atoms = rows.network.kind, rows.network.atoms
    network = FamilyNetwork(settings["network"], kind, sizes, atoms=atoms, seed=seed)
    last = len(rows) - settings["training"]["validation_curves"]
    history = Trainer(
        network=network.to(device),
        rows=MadeRows(np.arange(last), rows.rows, device, workers),
        validation=MadeRows(np.arange(last, len(rows)), rows.rows, device),
        settings=_OPTIMISER | settings["training"],
        seed=seed,
        checkpoint=checkpoint,
        **_TRAINING,
    ).run()
    frozen, rng = {**rows.frozen}, generator(seed, "family members")
    if kind == "levels":
        curves = {m: held_out["shape"].sel(motion=m, condition="new").values for m in MOTIONS}
        frozen["members"] = {
            m: _membership(shapes(curve), frozen["bases"][m], rows.sensors, rng)
            for m, curve in curves.items()
        }
    weights = {name: part.detach().cpu().numpy() for name, part in network.state_dict().items()}
    return history, weights, frozen


def _membership(
    curves: np.ndarray, basis: Basis, sensors: Sensors, rng: np.random.Generator
) -> Membership:
    """Return the distances of curves ``(n, u)`` of held-out drives, at several levels of noise."""
    tables = []
    for level in np.geomspace(*sensors.noise, _LEVELS):
        seen, _ = record_shapes(curves, rng, sensors._replace(noise=(level, 1.01 * level)))
        seen = NormalisedRecords(*(part[seen.there] for part in seen))
        if not tables:
            shares = 1.0 - np.geomspace(1.0, 0.5 / len(seen.way), _QUANTILES)
        square, parts, *_ = distances(seen, basis)
        left = np.nanquantile(parts, 0.99, axis=0)
        tables.append((np.median(seen.noise), np.quantile(square, shares), left))
    noise, squares, left = map(np.array, zip(*tables, strict=True))
    return Membership(noise, squares, shares, left)
