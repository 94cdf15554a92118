"""Infer simulated records of one motion whose truth is known."""

from breaker.common.zarr_store import describe, save
from breaker.paper.inference import validate
from breaker.paper.posterior import Posterior
from breaker.workflow.jobs import start

log = start(snakemake)
params, wildcards = snakemake.params, snakemake.wildcards

posterior = Posterior.load(snakemake.input.model, own_functions=True)
result = validate(posterior, params.curves, params.draws, int(wildcards.seed))
title = f"posteriors of simulated {wildcards.motion} records"
save(describe(result, title, model=posterior.settings), snakemake.output[0])
