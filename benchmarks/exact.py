"""Compare starts of the exact posterior: the mode alone, and a trained network.

Records of drives from the prior, and what the model leaves out where its scale is not 0. One row
for each setting and start: share resolved, rounds of adaptation, effective size of the result
(of ``correction.draws``), and records per second of processor time, both start and correction.

    python benchmarks/exact.py [--records 100] [--models results/models] [--noise 0.01 0.1] ...
"""

import argparse
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import product
from pathlib import Path

import numpy as np

from breaker.mechanism import MOTIONS, Size
from breaker.model import Model, generator, reference_model
from breaker.posterior import approximate, correct
from breaker.shipped import DEFAULTS
from breaker.workflow import load

DRAWS = 500  # to start from
Start = Callable[[Model, np.ndarray, np.random.Generator], np.ndarray]


def by_mode(model: Model, record: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Draws about the mode."""
    return approximate(model, record, DRAWS, rng)


def by_network(folder: Path, motion: str, scale: float) -> Start:
    """Draws of the network in a folder of models."""
    from breaker.posterior import Posterior

    posterior = Posterior.load(folder / f"{motion}.safetensors").at(scale)

    def draw(model: Model, record: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        noise = rng.standard_normal((1, DRAWS, len(model.outputs)))
        return posterior.sample(record[None], noise)[0]

    return draw


def records_of(model: Model, n: int) -> tuple[np.ndarray, np.ndarray]:
    """Truth ``(n, q)`` and records ``(n, t)`` of drives from the prior."""
    rng = generator(5, "benchmark of starts", model.motion)
    onset = model.sensor.onset_sd * rng.standard_normal((n, 1))
    values = np.hstack([model.prior.sample(n, rng), onset])[:, : len(model.outputs)]
    return values, model.sensor.corrupt(model.curves(values), rng)


def row(model: Model, start: Start, n: int, settings: dict) -> str:
    """Measure one start in one setting."""
    _, records = records_of(model, n)
    start(model, records[0], generator(1, "warm up"))
    began, found = time.process_time(), []
    for i, record in enumerate(records):
        rng = generator(1, "benchmark of starts", i)
        found.append(correct(model, record, start(model, record, rng), settings, rng))
    seconds = time.process_time() - began
    rounds = [each.rounds for each in found]
    sizes = np.nan_to_num([each.importance.size for each in found])
    return (
        f"{np.mean([each.resolved for each in found]):8.1%} {np.mean(rounds):7.1f} "
        f"{np.quantile(rounds, 0.95):5.0f} {np.median(sizes):6.0f} {np.quantile(sizes, 0.05):6.0f} "
        f"{n / seconds:9.1f}"
    )


def settings_of(options: argparse.Namespace) -> Iterator[tuple[str, Model, float]]:
    """Yield motion, model and scale of each setting."""
    for motion, scale, noise in product(MOTIONS, options.scales, options.noise):
        model = reference_model(motion, scale).sized(Size(), options.unknown)
        yield motion, replace(model, sensor=replace(model.sensor, noise_sd=noise)), scale


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--records", type=int, default=100)
    parser.add_argument("--models", type=Path, help="folder of trained networks, to compare with")
    parser.add_argument("--noise", type=float, nargs="+", default=[0.003, 0.01, 0.03, 0.1, 0.3])
    parser.add_argument("--scales", type=float, nargs="+", default=[0.0, 1.0])
    parser.add_argument("--unknown", type=float, default=0.0, help="log sd of the drive's size")
    options = parser.parse_args()
    correction = load([DEFAULTS])["correction"]
    print("motion   scale noise start    resolved  rounds  95 %   size    5 % records/s")
    for motion, model, scale in settings_of(options):
        starts: dict[str, Start] = {"mode": by_mode}
        if options.models:
            starts["network"] = by_network(options.models, motion, scale)
        for name, start in starts.items():
            numbers = row(model, start, options.records, correction)
            noise = model.sensor.noise_sd
            print(f"{motion:8s} {scale:5g} {noise:5g} {name:8s} {numbers}", flush=True)


if __name__ == "__main__":
    main()
