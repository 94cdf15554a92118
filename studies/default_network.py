"""Which inference network is the default: coupling flow against flow matching at equal time.

    python -m studies.default_network    # makes docs/default_network.csv

Both inference networks of the paper, each with the TimeSeriesNetwork, are trained on one bank of a
motion, with the default sensor and with that of ``config/paper.yaml``. The coupling flow takes the
steps of the configuration. Flow matching takes as many as fit into the same processor time, found
by short trainings of both in turn. What is measured is kept, so that the study can be resumed.

- lost: how far the log density of the true values of new records, nats, is behind that of the
  coupling flow, curve by curve, so that the interval is narrow;
- divergence: KL(p | q) of the exact posterior p from the network's q, by importance weights, nats;
- draws_per_second: of processor time. Intervals of means are of 95 %.
"""

from collections.abc import Mapping
from copy import deepcopy
from pathlib import Path
from time import process_time

import numpy as np
import pandas as pd
import torch
import xarray as xr

from breaker.common.randomness import generator
from breaker.configuration.loading import load, of_motion
from breaker.model.parameters import MOTIONS
from breaker.networks.training import Trainer
from breaker.paper.bank import simulate
from breaker.paper.correction import importance
from breaker.paper.inference import validate
from breaker.paper.joint_model import Model
from breaker.paper.posterior import Posterior
from breaker.paper.training import Rows, convergence, freeze_inputs, split

NETWORKS = ("coupling_flow", "flow_matching")
SENSORS = {"default": [], "paper": ["config/paper.yaml"]}  # files of settings
KEPT, TABLE = Path("results/default_network"), Path("docs/default_network.csv")
HELD_OUT = 8192  # curves: the standard error of a difference is about 0.003 nats
JUDGED = 400  # curves whose divergence is estimated: standard error about 0.002 nats
PACE = 40  # steps of a short training: two seconds

Kept = dict[str, np.ndarray]


def main() -> None:
    torch.set_num_threads(1)
    KEPT.mkdir(parents=True, exist_ok=True)
    tables = []
    for sensor, files in SENSORS.items():
        config = load(files)
        for motion in MOTIONS:
            kept = compare(config, motion, KEPT / f"{sensor}_{motion}")
            tables.append(table(f"{motion} curves of the prior, {sensor} sensor", kept))
    rows = pd.concat(tables)
    print(rows.to_string(index=False))
    rows.to_csv(TABLE, index=False, float_format="%.4g")


def compare(config: Mapping, motion: str, place: Path) -> dict[str, Kept]:
    """Return what is measured of each network, now or before."""
    files = {kind: place.with_name(f"{place.name}_{kind}.npz") for kind in NETWORKS}
    if not all(file.exists() for file in files.values()):
        size = config["bank"]["shards"] * config["bank"]["curves_per_shard"]
        model = Model.from_settings({**config, "motion": motion})
        bank = simulate(model, size, generator(config["seed"], "bank", motion))
        of = (config, model, bank)
        steps = of_motion(config, motion)["training"]["steps"]
        for kind in (kind for kind, file in files.items() if not file.exists()):
            if kind != NETWORKS[0]:
                few, order = min(PACE, steps), (NETWORKS[0], kind) * 2
                pace = [train(*of, network, few)[1] for network in order]
                steps = round(steps * min(pace[::2]) / min(pace[1::2]))
            posterior, _ = train(*of, kind, steps)
            np.savez(files[kind], **measure(posterior, config["validation"], config["seed"]))
    return {kind: dict(np.load(file)) for kind, file in files.items()}


def train(config: Mapping, model: Model, bank: xr.Dataset, kind: str, steps: int) -> tuple:
    """Train a kind of network; return its posterior and the processor seconds of its training."""
    start, seed, motion = process_time(), config["seed"], model.motion
    config = deepcopy(config)
    config["network"]["inference"]["kind"] = kind
    own = of_motion(config, motion)
    network, training = own["network"], {**own["training"], "steps": steps}
    made_from = {key: config[key] for key in ("prior", "sensor")}
    made_from |= {"motion": motion, "network": network, "training": training, "seed": seed}
    parts = split(bank.sizes["curve"], training["validation_curves"])
    curves, validation = (bank.isel(curve=part) for part in parts)
    posterior = Posterior(made_from, seed=seed)
    freeze_inputs(posterior, curves, generator(seed, "components", motion))
    aside = Rows.of(validation, posterior)
    Trainer(posterior, Rows.of(curves, posterior), aside, training, seed).run()
    posterior.eval()
    some = model.sensor.corrupt(bank.travel.values[-100:], generator(1, "solver"))
    convergence(posterior, some, 1)
    return posterior, process_time() - start


def measure(posterior: Posterior, validation: Mapping, seed: int) -> Kept:
    """Judge a network by new records."""
    start, draws = process_time(), validation["draws"]
    data = validate(posterior, validation["curves"], draws, validation["seed"])
    seconds, some = process_time() - start, data.isel(curve=slice(JUDGED))
    return {
        "curves": np.array(data.sizes["curve"]),
        "draws_per_second": np.array(data.draws[..., 0].size / seconds),
        "log_density": log_density(posterior, seed),
        "divergence": divergence(posterior, some.measured.values, some.draws.values),
    }


@torch.no_grad()
def log_density(posterior: Posterior, seed: int) -> np.ndarray:
    """Return the log density of the true values of new records, ``(n,)``."""
    new = simulate(posterior.model, HELD_OUT, generator(seed, "held out", posterior.motion))
    rows, rng = Rows.of(new, posterior), torch.Generator().manual_seed(seed)
    parts = torch.arange(HELD_OUT).split(512)
    losses = [posterior.validation_loss(*rows.draw(part, rng)) for part in parts]
    return -torch.cat(losses).numpy()


def divergence(posterior: Posterior, measured: np.ndarray, draws: np.ndarray) -> np.ndarray:
    """Return KL(exact | network) of records ``(n, t)`` from draws ``(n, d, q)``, ``(n,)``."""
    model, divergences = posterior.model, []
    for record, values in zip(measured, draws, strict=True):
        density = posterior.log_prob(values[None], record[None])[0] - model.log_scaling(values)
        joint = model.log_joint(model.standardise(values), record)
        divergences.append(importance(joint, density).gap)
    return np.array(divergences)


def table(population: str, kept: Mapping[str, Kept]) -> pd.DataFrame:
    """Return a row a network and quantity: value, interval and number of curves."""
    best, rows = kept[NETWORKS[0]]["log_density"], []
    for network, of in kept.items():
        n = int(of["curves"])
        rows.append((network, "draws_per_second", float(of["draws_per_second"]), None, None, n))
        means = {"lost": best - of["log_density"], "divergence": of["divergence"]}
        for name, values in means.items():
            half, mean = 1.96 * values.std(ddof=1) / len(values) ** 0.5, values.mean()
            rows.append((network, name, mean, mean - half, mean + half, len(values)))
    columns = ["network", "quantity", "value", "low", "high", "n"]
    return pd.DataFrame([(population, *row) for row in rows], columns=["population", *columns])


if __name__ == "__main__":
    main()
