"""Draw measured records beside what their posteriors predict (Fig. 9)."""

from breaker.common.zarr_store import open_store
from breaker.figures.predictive import endurance_predictive
from breaker.figures.style import save
from breaker.workflow.jobs import start

start(snakemake)
predictive = open_store(snakemake.input.predictive).load()
save(endurance_predictive(predictive, motion=snakemake.wildcards.motion), snakemake.output[0])
