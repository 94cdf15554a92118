"""Train this package, sbi or BayesFlow within a budget, and score it on the same records.

    python -m studies.peers breaker --motion closing --seconds 120 --table peers.csv
    python -m studies.peers sbi --motion closing --seconds 120 --table peers.csv

Each run is a process of its own and adds a row to the table; ``studies/requirements.txt`` is its
environment. The machine should do nothing else. Two short trainings find how many steps fit into
the budget; then the training starts from nothing. All outputs are standardised.

- log_density: of the true values of held-out records, nats, with its standard error. A difference
  between two rows is a difference of their divergences from the exact posterior.
- efficiency: median relative effective sample size, when draws are weighed by the exact density.
- calibration_p: p-value of the ranks of the true values, all outputs together.
"""

import argparse
import os
from collections.abc import Callable
from time import perf_counter

import numpy as np
import pandas as pd
import torch

from breaker.common.randomness import generator
from breaker.configuration.loading import defaults
from breaker.model.parameters import MOTIONS
from breaker.paper.bank import simulate, truth
from breaker.paper.calibration import calibration_p_values, family_p_value, ranks
from breaker.paper.correction import importance
from breaker.paper.joint_model import Model
from studies.shared import append, parser

ARMS = ("breaker", "sbi", "bayesflow")
SEED, ROWS = 101, 262_144  # of the bank, and of the held-out records: for all arms the same
HELD_OUT, CALIBRATION = 1000, 100  # records, and draws among which a true value is ranked
WEIGHED, DRAWS = 100, 500  # records whose draws are weighed, and draws
WARM_UP = 0.03  # share of the budget by which two short trainings differ, at least


def make(arm: str):
    """Return an arm, untrained; its tool is imported here, with the backend that it has to use."""
    os.environ.setdefault("KERAS_BACKEND", "torch")
    if arm == "bayesflow":
        from studies.peers.fit_bayesflow import BayesFlow as Arm
    elif arm == "sbi":
        from studies.peers.fit_sbi import Sbi as Arm
    else:
        from studies.peers.fit_breaker import Breaker as Arm
    return Arm()


def steps_within(seconds: float, train: Callable[[int], object], unit: int) -> int:
    """Return how many steps of a training fit into a budget, set-up and compilation included.

    Args:
        train: Does a training of so many steps, from nothing.
        unit: Steps that contain all that happens now and then, such as an evaluation.
    """

    def spent(steps: int) -> float:
        begin = perf_counter()
        train(steps)
        return perf_counter() - begin

    spent(unit)  # what a process does only once
    few, units = spent(unit), 3
    while (many := spent(units * unit)) - few < WARM_UP * seconds:
        units *= 3
    step = (many - few) / ((units - 1) * unit)
    left = seconds - max(0.0, few - unit * step)
    return max(unit, int(left / step) // unit * unit)


def score(arm, model: Model, measured: np.ndarray, z: np.ndarray, seed: int) -> dict[str, float]:
    """Score an arm on records ``(n, t)``, mm, with true values ``(n, q)``."""
    density = arm.log_prob(measured, z[:, None])[:, 0]
    row = {"log_density": density.mean(), "error": density.std(ddof=1) / np.sqrt(len(density))}
    begin = perf_counter()
    draws = arm.sample(measured, CALIBRATION, seed)
    row["draws_per_second"] = draws[..., 0].size / (perf_counter() - begin)
    row["calibration_p"] = family_p_value(calibration_p_values(ranks(draws, z), CALIBRATION))
    draws = arm.sample(measured[:WEIGHED], DRAWS, seed + 1)
    densities = arm.log_prob(measured[:WEIGHED], draws)
    judged = [
        importance(model.log_joint(points, record), proposed)
        for points, proposed, record in zip(draws, densities, measured[:WEIGHED], strict=True)
    ]
    sound = [weights.efficiency for weights in judged if not weights.faulty]
    return row | {"efficiency": float(np.median(sound)), "faulty": len(judged) - len(sound)}


def run(given: argparse.Namespace) -> dict[str, object]:
    """Train and score one arm; return the row of the table."""
    torch.set_num_threads(given.threads)
    model = Model.from_settings({**defaults(), "motion": given.motion})
    bank = simulate(model, given.bank, generator(SEED, "peers bank", given.motion))
    rng = generator(SEED, "peers", given.motion)
    new = simulate(model, given.held_out, rng)
    measured = model.sensor.corrupt(new.travel.values.astype(np.float64), rng)
    arm = make(given.arm)
    steps = steps_within(
        given.seconds, lambda count: arm.train(bank, model, count, given.seed), arm.unit
    )
    begin = perf_counter()
    arm.train(bank, model, steps, given.seed)
    spent = perf_counter() - begin
    row = {"motion": given.motion, "arm": given.arm, "seed": given.seed, "steps": steps}
    z = model.standardise(truth(new, model))
    return row | {"seconds": spent} | score(arm, model, measured, z, given.seed)


def main() -> None:
    options = parser(__doc__)
    options.add_argument("arm", choices=ARMS)
    options.add_argument("--motion", choices=MOTIONS, default="closing")
    options.add_argument("--seconds", type=float, default=120.0, help="budget of the training")
    options.add_argument("--seed", type=int, default=1, help="of weights, batches and draws")
    options.add_argument("--threads", type=int, default=2)
    options.add_argument("--bank", type=int, default=ROWS, help="curves to train with")
    options.add_argument("--held-out", type=int, default=HELD_OUT, help="curves to score by")
    given = options.parse_args()
    table = pd.DataFrame([run(given)])
    print(table.to_string(index=False, float_format="%.4g"))
    if given.table:
        append(table, given.table, float_format="%.4g")


if __name__ == "__main__":
    main()
