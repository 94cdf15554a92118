"""Draw what a service costs by its operation."""

from breaker.common.zarr_store import open_store
from breaker.figures.service_cost import service_cost
from breaker.figures.style import save
from breaker.workflow.jobs import start

start(snakemake)
standing = open_store(snakemake.input.standing).load()
save(service_cost(standing), snakemake.output[0])
