"""A network of a family, trained on its bank, with what records of its drives look like."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from breaker.common.randomness import generator
from breaker.drive.family.membership import Membership
from breaker.drive.family.network_inputs import Basis, NormalisedRecords
from breaker.drive.training.family_bank import shapes
from breaker.drive.training.family_records import record_shapes
from breaker.drive.training.level_rows import BankRows
from breaker.model.parameters import MOTIONS

if TYPE_CHECKING:
    from breaker.networks.training import Checkpoint

RECIPE = {
    "optimiser": "muon",
    "learning_rate": 0.002,  # highest one with which no training diverged
    "warm_up": 0.03,  # share of the steps with rising learning rate, as in the paper's networks
    "weight_decay": 0.01,  # decoupled: drives of a bank are seen many times
    "clip": 5.0,  # norm of the gradient: mixtures have rare steep ones
    "ema": 0.998,  # averages the last 500 steps
}
"""Settings of a training that are not in the configuration."""

_LEVELS = np.geomspace(1e-4, 3e-2, 8)  # of the noise, at which membership is judged


def train_network(
    rows: BankRows,
    held_out: xr.Dataset,
    settings: Mapping,
    seed: int,
    *,
    workers: int = 0,
    checkpoint: "Checkpoint | None" = None,
) -> tuple[xr.Dataset, dict[str, np.ndarray], dict]:
    """Train a network of "levels" or "changes" on the drives of a bank.

    Args:
        rows: Of a bank, from ``rows_of``; its last ``validation_curves`` drives judge the training.
        held_out: Drives that show what records of members look like.
        settings: The sections ``network`` and ``training`` of the section ``family``, and the
            ``device``.
        workers: As of ``FamilyRows``; no weight depends on them.
        checkpoint: As of ``training.Trainer``.

    Returns:
        The history of the training; weights by name, and what inputs and outputs are scaled by,
        both as ``network_files.write_network`` takes them.
    """
    from breaker.drive.training.family_density import FamilyNetwork, FamilyRows
    from breaker.networks.training import Trainer, choose_device  # loads torch

    rows.freeze(generator(seed, "family", rows.kind, "scales"))
    device = choose_device(settings["device"])
    network = FamilyNetwork(settings["network"], rows.kind, rows.sizes, atoms=rows.atoms, seed=seed)
    aside = len(rows) - settings["training"]["validation_curves"]
    history = Trainer(
        posterior=network.to(device),
        rows=FamilyRows(np.arange(aside), rows.rows, device, workers),
        validation=FamilyRows(np.arange(aside, len(rows)), rows.rows, device),
        settings=RECIPE | settings["training"],
        seed=seed,
        checkpoint=checkpoint,
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
