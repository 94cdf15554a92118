"""Draw the path of the wear and its changes."""

from breaker.common.zarr_store import open_store
from breaker.figures.changepoint import changepoint
from breaker.figures.style import save
from breaker.workflow.jobs import start

start(snakemake)
life = open_store(snakemake.input.life).load()
save(changepoint(life), snakemake.output[0])
