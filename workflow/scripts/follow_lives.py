"""Simulate some lives, infer their records and follow them."""

from breaker.posterior import Posterior
from breaker.stores import describe, save
from breaker.synthetic import WIDENINGS, follow_lives
from breaker.workflow import start

log = start(snakemake)
params, seed = snakemake.params, int(snakemake.wildcards.seed)
found = [Posterior.load(file) for file in snakemake.input.models]
posteriors = {posterior.motion: posterior for posterior in found}
size = params.lives["lives_per_job"]
first = int(snakemake.wildcards.chunk) * size
numbers = range(first, min(first + size, params.lives["lives"]))

tried = WIDENINGS if seed == params.calibration_seed else ()
result = follow_lives(
    posteriors, numbers, params.lives, params.wear_model, seed=seed, widenings=tried
)
log.info("lives %d to %d followed", numbers[0], numbers[-1])
settings = {"lives": params.lives, "wear_model": params.wear_model, "seed": seed}
save(describe(result, "simulated lives, followed", **settings), snakemake.output[0])
