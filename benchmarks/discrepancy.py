"""What a density costs with the model's own error, beside one without.

The log joint of 500 draws and a record of the default sensor, as a round of correction evaluates
it. The error has as many components as the default; both are timed in turn, so that the ratio holds
whatever else the machine does: `python benchmarks/discrepancy.py`.
"""

import os
from time import perf_counter

os.environ.setdefault("NUMBA_NUM_THREADS", "1")

import numpy as np
import yaml

from breaker.model import Discrepancy, Model, generator

REPEATS, DRAWS, COMPONENTS = 300, 500, 12

with open("config/config.yaml", encoding="utf-8") as file:
    config = yaml.safe_load(file)
rng = generator(1, "benchmark")
samples = config["sensor"]["samples"]
known = Discrepancy(
    *(0.1 * rng.standard_normal(shape).cumsum(-1) for shape in (samples, (7, samples))),
    0.1 * rng.standard_normal((COMPONENTS, samples)).cumsum(-1),
)
for motion in config["motions"]:
    plain = Model.from_settings({**config, "motion": motion})
    models = {"right": plain, "error": plain.leaving_out(known)}
    z = 0.3 * rng.standard_normal((DRAWS, 8))
    record = plain.curves(plain.destandardise(z[:1]))[0]
    took = {name: [] for name in models}
    for _ in range(REPEATS):
        for name, model in models.items():
            start = perf_counter()
            model.log_joint(z, record)
            took[name].append(perf_counter() - start)
    right, error = (1e6 * np.median(took[name]) / DRAWS for name in models)
    print(f"{motion}: {right:.2f} us a draw, with the error {error:.2f} us: {error / right:.2f}")
