"""Draw what the model leaves out of a motion, and what it costs."""

from breaker.figures.discrepancy import discrepancy
from breaker.stores import open_store
from breaker.workflow import start

start(snakemake)
params, motion = snakemake.params, snakemake.wildcards.motion
learned = open_store(snakemake.input.discrepancy).sel(motion=motion).load()
cost = open_store(snakemake.input.cost)

figure = discrepancy(learned, cost, motion=motion, noise_sd=params.noise_sd)
figure.savefig(snakemake.output[0])
