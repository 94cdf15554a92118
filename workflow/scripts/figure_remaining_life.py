"""Draw the remaining life of each limit over the operations, beside the truth where it is known."""

from breaker.figures.remaining_life import remaining_life
from breaker.stores import open_store
from breaker.workflow import start

log = start(snakemake)
data = open_store(snakemake.input.remaining).load()
truth = None
if "failure" in data:
    truth = dict(zip(data.limit.values.tolist(), data.failure.values.tolist(), strict=True))

remaining_life(data, truth=truth).savefig(snakemake.output[0])
