"""Speed of following a drive: seconds of processor time for an operation, and what they go into.

    python benchmarks/trend.py

Records of model curves with the default configuration, no network: posterior means are the truth.
Rates depend on how many hypotheses are held, so that they are of the last half of 400 operations.
"""

from pathlib import Path
from time import process_time

import numpy as np
import yaml

from breaker.mechanism import MOTIONS, from_list
from breaker.model import Model, generator
from breaker.wear import Follower, Series, likelihood, remaining_life

DEFAULTS = Path(__file__).parents[1] / "config" / "config.yaml"
OPERATIONS = 400


def records(model: Model, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return records ``(o, t)`` of standardised parameters ``(o, p)``, and their outputs."""
    rng = generator(1, "benchmark of trends", model.motion)
    outputs = np.column_stack([z, rng.standard_normal(len(z))])
    curves = model.curves(model.destandardise(outputs))
    return model.sensor.corrupt(curves, rng), outputs


def main() -> None:
    """Follow closing, opening and both, and print a table."""
    settings = yaml.safe_load(DEFAULTS.read_text(encoding="utf-8"))
    operations = np.arange(1, OPERATIONS + 1)
    z = 0.3 * operations[:, None] / 1000.0 * np.array([0, -1, 0, 1, 0, -1, 1.0])
    print(f"{'source':18}{'ms an operation':>17}{'likelihood':>12}{'life':>8}{'hypotheses':>12}")
    for motions in (("closing",), ("opening",), MOTIONS):
        parts = {key: settings[key] for key in ("prior", "sensor")}
        models = {motion: Model.from_settings({**parts, "motion": motion}) for motion in motions}
        found = {motion: records(model, z) for motion, model in models.items()}
        series = Series(operations, *({m: f[k] for m, f in found.items()} for k in (0, 1)))
        limits = from_list(settings["limits"], motions)
        follower = Follower.from_settings(models, limits, settings["wear_model"], settings["seed"])
        state = follower.begin(series)
        usable = {motion: series.usable(motion) for motion in models}
        for i in range(OPERATIONS):
            if i == OPERATIONS // 2:
                begin = process_time()
            state, _, _ = follower.step(state, series, i, usable)
        whole = 1e3 * (process_time() - begin) / (OPERATIONS - OPERATIONS // 2)
        level, cov = state.hypotheses.level()
        p = z.shape[1]
        arguments = models, series, OPERATIONS - 1, state.reference, (level[:p], cov[:p, :p])
        share = [
            timed(lambda a=arguments: likelihood(*a)),
            timed(
                lambda f=follower, s=state: remaining_life(
                    f.tracker, s.hypotheses, f.limits, f.prior, f.horizon
                )
            ),
        ]
        count = len(state.hypotheses.weight)
        name = " and ".join(motions)
        print(f"{name:18}{whole:17.1f}{share[0]:12.1f}{share[1]:8.1f}{count:12d}")


def timed(call) -> float:
    """Milliseconds of processor time of a call, the mean of fifty."""
    begin = process_time()
    for _ in range(50):
        call()
    return 1e3 * (process_time() - begin) / 50


if __name__ == "__main__":
    main()
