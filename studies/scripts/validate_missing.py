"""Infer the records of a validation again, with samples missing at random."""

from breaker.common.zarr_store import describe, open_store, save
from breaker.paper.posterior.estimator import Posterior
from breaker.workflow.jobs import start
from studies.networks.missing import validate_missing

log = start(snakemake)
posterior = Posterior.load(snakemake.input.model)
result = validate_missing(posterior, open_store(snakemake.input.whole), snakemake.params.share)
title = f"posteriors of simulated {snakemake.wildcards.motion} records with missing samples"
save(describe(result, title, model=posterior.settings), snakemake.output[0])
