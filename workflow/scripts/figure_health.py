"""Draw how probably each limit is exceeded, over the operations."""

from breaker.figures.health import health
from breaker.stores import open_store
from breaker.workflow import start

log = start(snakemake)
life, standing = (open_store(snakemake.input[name]).load() for name in ("life", "standing"))
health(life, standing).savefig(snakemake.output[0])
