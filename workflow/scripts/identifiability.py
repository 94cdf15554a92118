"""Compute the contraction that an exact posterior reaches, over draws from the prior."""

from breaker.identifiability import limit_over_prior
from breaker.jobs import start
from breaker.prior import Prior
from breaker.randomness import generator
from breaker.sensor import Sensor
from breaker.stores import describe, save

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
