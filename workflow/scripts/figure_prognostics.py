"""Draw how early changes are found, and how good the remaining life is."""

from breaker.figures.prognostics import prognostics
from breaker.stores import open_store
from breaker.workflow import start

log = start(snakemake)
prognostics(open_store(snakemake.input.scores).load()).savefig(snakemake.output[0])
