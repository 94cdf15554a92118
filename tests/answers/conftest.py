"""Answers that the tests of the room share: simulated records of the reference drive."""

import numpy as np
import pytest
import xarray as xr

from breaker.answers.judgement import with_limits, with_quantities, with_trust
from breaker.mechanism.limits import Limit
from breaker.model.randomness import generator
from breaker.model.reference import reference_model
from breaker.posterior.exact import infer_exactly

LIMITS = [
    Limit("slow", "closing", (("touch_time", 5.0, True),)),
    Limit("late", "closing", (("touch_time", 50.0, True),)),
    Limit("wide", "opening", (("L", 30.0, True),)),
]
DRAWS = 300


def simulated(model, n, rng):
    """Unknowns ``(n, q)``, records and what the model leaves out of them, ``(n, t)``."""
    values = model.destandardise(rng.standard_normal((n, len(model.outputs))))
    left_out = model.shift(values) + model.sensor.discrepancy.sample((n,), rng)
    plain = model.leaving_out(None)
    return values, plain.sensor.corrupt(plain.curves(values) + left_out, rng), left_out


def as_curves(motion, model, records):
    """Records as ``records.read_curves`` returns them; of the last one there is none."""
    n = len(records)
    accepted = np.arange(n) < n - 1
    texts = {"reason": np.where(accepted, "", "b.csv: is empty"), "remarks": [""] * n}
    return xr.Dataset(
        {
            "travel": (("operation", "time"), np.where(accepted[:, None], records, np.nan)),
            "accepted": ("operation", accepted),
            **{name: ("operation", np.array(each, dtype=str)) for name, each in texts.items()},
            "file": ("operation", [f"{motion}_{i}.csv" for i in range(n)]),
            "missing": ("operation", np.zeros(n, dtype=int)),
            "masked": ("operation", np.zeros(n, dtype=int)),
            "noise": ("operation", np.full(n, 0.1)),
            "phase": ("operation", np.full(n, "L1")),
        },
        coords={"operation": np.arange(1, n + 1), "time": model.sensor.times},
        attrs={"motion": motion},
    )


@pytest.fixture(scope="package")
def models():
    return {motion: reference_model(motion) for motion in ("closing", "opening")}


@pytest.fixture(scope="package")
def answers(models, defaults):
    """Three records of each motion, the last of them rejected."""
    found = {}
    for motion, model in models.items():
        _, records, _ = simulated(model, 3, generator(1, "test answers", motion))
        curves = as_curves(motion, model, records)
        look = {"draws": DRAWS, "seed": 1, "misfit_p_value": 1e-3}
        answer = infer_exactly(model, curves, defaults["correction"], **look)
        answer = with_trust(with_quantities(answer), model, seed=1)
        found[motion] = with_limits(answer, LIMITS, {"raise": 0.95})
    return found
