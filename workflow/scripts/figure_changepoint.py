"""Draw the changes of a drive, and the evidence for them."""

from breaker.figures.changepoint import changepoint
from breaker.stores import open_store
from breaker.workflow import start

log = start(snakemake)
changepoint(open_store(snakemake.input.life).load()).savefig(snakemake.output[0])
