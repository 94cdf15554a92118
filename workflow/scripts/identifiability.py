"""Compute the contraction that an exact posterior reaches, over draws from the prior."""

from breaker.model import Model, generator, limit_over_prior
from breaker.workflow import describe, save, start

log = start(snakemake)
params, motion = snakemake.params, snakemake.wildcards.motion

model = Model.from_settings({"prior": params.prior, "sensor": params.sensor, "motion": motion})
rng = generator(params.seed, "identifiability", motion)
limit = limit_over_prior(model, params.curves, rng)
settings = {key: params[key] for key in ("seed", "prior", "sensor", "curves")}
save(describe(limit, f"exact limit of contraction, {motion}", **settings), snakemake.output[0])
