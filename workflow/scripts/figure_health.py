"""Draw how probably each limit is exceeded, over the operations."""

from breaker.figures.health import health
from breaker.stores import open_store
from breaker.workflow import start

log = start(snakemake)
health(open_store(snakemake.input.health).load()).savefig(snakemake.output[0])
