"""Fit the model to noise-free curves of the stand-in, at stages of its life."""

import numpy as np

from breaker.model import Model
from breaker.synthetic import Rig, effective_values
from breaker.workflow import describe, save, start

log = start(snakemake)
params, motion = snakemake.params, snakemake.wildcards.motion

rig = Rig.from_settings(params.rig, params.seed)
count = min(params.rig["effective_stages"], params.rig["operations"])
stages = np.unique(np.linspace(1, params.rig["operations"], count).round().astype(int))
model = Model.from_settings({"prior": params.prior, "sensor": params.sensor, "motion": motion})
result = effective_values(rig, model, stages.tolist())
log.info(
    "new %s: the model leaves at most %.2f noise sd of the main motion, %.2f of the end",
    *(motion, result.main_largest[0], result.end_largest[0]),
)
settings = {key: params[key] for key in ("seed", "rig", "prior", "sensor")}
save(
    describe(result, f"effective values of the stand-in, {motion}", **settings), snakemake.output[0]
)
