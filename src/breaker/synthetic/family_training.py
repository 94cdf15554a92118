"""Networks of a family trained on its bank: rows of it, the training, draws for held-out drives."""

from collections.abc import Mapping, Sequence
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from breaker.family import (
    Basis,
    Changes,
    Levels,
    Membership,
    NormalisedRecords,
    plausible_wear,
)
from breaker.mechanism import MOTIONS, NAMES
from breaker.model import generator
from breaker.stores import open_store
from breaker.synthetic.family_bank import shapes
from breaker.synthetic.family_records import record_shapes
from breaker.synthetic.family_rows import ChangeRows, LevelRows, Rows

if TYPE_CHECKING:
    from breaker.posterior import Checkpoint

_LEVELS = np.geomspace(1e-4, 3e-2, 8)  # of the noise, at which membership is judged


def rows_of(kind: str, bank: xr.Dataset, like: Levels | Changes | None = None) -> Rows:
    """Return rows of "levels" or "changes", scaled as those that a network was trained on."""
    frozen = {} if like is None else {each.name: getattr(like, each.name) for each in fields(like)}
    return {each.kind: each for each in (LevelRows, ChangeRows)}[kind](bank, frozen)


def sample_rows(
    network: Levels | Changes,
    rows: Rows,
    source: str,
    draws: int,
    rng: np.random.Generator,
    **sensor,
) -> xr.Dataset:
    """Draw from the posteriors of one record of each motion of each drive.

    Args:
        network: The network.
        rows: Drives, in the scales of the network.
        source: Which motions there are: "closing", "opening" or "both".
        draws: Number of draws of each.
        sensor: As of the ``unscaled`` of the rows.

    Returns:
        ``draws (curve, draw, output)`` and ``truth (curve, output)``: parameters, or their changes
        in percent, and events, in durations. What is exactly 0 has a random order, by a jitter of
        a billionth of a scale. Changes beyond any wear are left out, as answers withhold them; the
        attribute ``withheld`` counts them.
    """
    n = len(rows)
    motions = np.tile([source != "opening", source != "closing"], (n, 1))
    x, y, there, units = rows.unscaled(np.arange(n), rng, motions=motions, **sensor)
    told = there.any(axis=0)
    x, y, units = (each[(there == told).all(axis=1)] for each in (x, y, units))
    features = network.network.features(x)
    values = np.stack(
        [network.network.sample(each[None], told, draws, rng)[0] for each in features]
    )
    values = network.centre + network.scale * values
    kept = (
        plausible_wear(values[..., : len(NAMES)])
        if rows.atoms
        else np.ones(len(values), dtype=bool)
    )
    values, y, units = values[kept], y[kept], units[kept]

    def physical(outputs: np.ndarray, units: np.ndarray) -> np.ndarray:
        jitter = 1e-9 * network.scale * rng.standard_normal(outputs.shape)
        found = outputs + units + rows.atoms * jitter
        p = len(NAMES)
        found[..., :p] = 100.0 * np.expm1(found[..., :p]) if rows.atoms else np.exp(found[..., :p])
        return found[..., told]

    return xr.Dataset(
        {
            "draws": (("curve", "draw", "output"), physical(values, units[:, None])),
            "truth": (("curve", "output"), physical(y, units)),
        },
        {"output": np.array(rows.names)[told]},
        {"withheld": int((~kept).sum())},
    )


def open_family(shards: Sequence[str | Path], held_out: int) -> tuple[xr.Dataset, xr.Dataset]:
    """Read the shards of a bank, and set its last drives aside.

    Raises:
        ValueError: If that leaves no drives to train on.
    """
    bank = xr.concat([open_store(each) for each in shards], dim="drive", combine_attrs="override")
    rest = bank.sizes["drive"] - held_out
    if rest <= 0:
        raise ValueError(
            f"the bank has {rest + held_out} drives, and {held_out} are held out: none is left to "
            "train on; raise family.drives"
        )
    return bank.isel(drive=slice(rest)), bank.isel(drive=slice(rest, None))


def train_network(
    rows: Rows,
    held_out: xr.Dataset,
    settings: Mapping,
    seed: int,
    *,
    checkpoint: "Checkpoint | None" = None,
) -> tuple[xr.Dataset, dict[str, np.ndarray], dict]:
    """Train a network of "levels" or "changes" on the drives of a bank.

    Args:
        rows: Of a bank, from ``rows_of``; its last ``validation_curves`` drives judge the training.
        held_out: Drives that show what records of members look like.
        settings: The section ``family_networks`` of the configuration.
        seed: Seed of the configuration.
        checkpoint: As of ``posterior.Trainer``.

    Returns:
        The history of the training; weights by name, and what inputs and outputs are scaled by,
        both as ``family.write_network`` takes them.
    """
    from breaker.posterior import FamilyNetwork, FamilyRows, Trainer, choose_device  # loads torch

    rows.freeze(generator(seed, "family", rows.kind, "scales"))
    device = choose_device(settings["training"]["device"])
    network = FamilyNetwork(settings["network"], rows.kind, rows.sizes, atoms=rows.atoms, seed=seed)
    aside = len(rows) - settings["training"]["validation_curves"]
    history = Trainer(
        posterior=network.to(device),
        rows=FamilyRows(np.arange(aside), rows.rows, device),
        validation=FamilyRows(np.arange(aside, len(rows)), rows.rows, device),
        settings=settings["training"],
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
