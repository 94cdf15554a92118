"""Compute the contraction of an exact posterior over draws from the prior."""

from breaker.common.randomness import generator
from breaker.common.zarr_store import describe, save
from breaker.paper.joint_model import Model, limit_over_prior
from breaker.workflow.jobs import start

log = start(snakemake)
params, motion = snakemake.params, snakemake.wildcards.motion

settings = {key: params[key] for key in ("seed", "model", "prior", "sensor", "curves")}
model = Model.from_settings({**settings, "motion": motion})
rng = generator(params.seed, "identifiability", motion)
limit = limit_over_prior(model, params.curves, rng)
save(describe(limit, f"exact limit of contraction, {motion}", **settings), snakemake.output[0])
