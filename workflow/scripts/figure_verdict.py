"""Draw the picture of the first page: how each limit stands."""

from breaker.figures.verdict import verdict
from breaker.stores import open_store
from breaker.workflow import start

log = start(snakemake)
life, standing = (open_store(snakemake.input[name]).load() for name in ("life", "standing"))
verdict(life, standing).savefig(snakemake.output[0])
