"""Compute the contraction that an exact posterior reaches, over draws from the prior."""

from breaker.model import Prior, Sensor, generator, limit_over_prior
from breaker.workflow import describe, save, start

log = start(snakemake)
params, motion = snakemake.params, snakemake.wildcards.motion

limit = limit_over_prior(
    Prior.from_settings(params.prior),
    Sensor.from_settings(params.sensor),
    motion,
    params.curves,
    generator(params.seed, "identifiability", motion),
)
settings = {key: params[key] for key in ("seed", "prior", "sensor", "curves")}
save(describe(limit, f"exact limit of contraction, {motion}", **settings), snakemake.output[0])
