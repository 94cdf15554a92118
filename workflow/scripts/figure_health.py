"""Draw the probability of each limit and its state, over the operations."""

from breaker.common.zarr_store import open_store
from breaker.figures.health import health
from breaker.figures.style import save
from breaker.workflow.jobs import start

start(snakemake)
life, standing = (open_store(snakemake.input[name]).load() for name in ("life", "standing"))
save(health(life, standing), snakemake.output[0])
