"""Draw the first page: four sentences and how each limit stands."""

from breaker.figures.verdict import verdict
from breaker.stores import open_store
from breaker.workflow import start

log = start(snakemake)
verdict(open_store(snakemake.input.verdict).load()).savefig(snakemake.output[0])
