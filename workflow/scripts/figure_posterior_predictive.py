"""Draw simulated records with predictions of their posteriors (Fig. 8)."""

from breaker.common.zarr_store import open_store
from breaker.figures.predictive import posterior_predictive
from breaker.figures.style import save
from breaker.workflow.jobs import start

start(snakemake)
predictive = open_store(snakemake.input.predictive).load()
save(posterior_predictive(predictive, motion=snakemake.wildcards.motion), snakemake.output[0])
