"""Draw the remaining life of each limit over the operations, beside the truth where it is known."""

from breaker.figures.remaining_life import remaining_life
from breaker.stores import open_store
from breaker.workflow import start

log = start(snakemake)
remaining_life(open_store(snakemake.input.remaining).load()).savefig(snakemake.output[0])
