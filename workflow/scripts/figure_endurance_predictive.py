"""Draw the posterior predictive check at stages of the endurance test (Fig. 9)."""

from breaker.figures.predictive import endurance_predictive
from breaker.stores import open_store
from breaker.workflow import start

log = start(snakemake)
data = open_store(snakemake.input.predictive)

figure = endurance_predictive(
    data, motion=snakemake.wildcards.motion, noise_sd=data.attrs["noise_sd"]
)
figure.savefig(snakemake.output[0])
