"""Compute the contraction that an exact posterior reaches, over draws from the prior."""

from breaker.model import Model, generator, limit_over_prior, open_discrepancy
from breaker.stores import describe, save
from breaker.workflow import start

log = start(snakemake)
params, motion = snakemake.params, snakemake.wildcards.motion

left_out = open_discrepancy(snakemake.input.get("discrepancy"), motion)
settings = {key: params[key] for key in ("seed", "prior", "sensor", "discrepancy", "curves")}
model = Model.from_settings({**settings, "motion": motion}, left_out, params.discrepancy)
rng = generator(params.seed, "identifiability", motion)
limit = limit_over_prior(model, params.curves, rng)
save(describe(limit, f"exact limit of contraction, {motion}", **settings), snakemake.output[0])
