"""Draw the trend of a source, its run length and its changes."""

from breaker.figures.changepoint import changepoint
from breaker.stores import open_store
from breaker.workflow import start

log = start(snakemake)
store = snakemake.input.truth
truth = open_store(store).value if store else None

trend = open_store(snakemake.input.trend).load()
figure = changepoint(trend, source=snakemake.wildcards.source, truth=truth)
figure.savefig(snakemake.output[0])
