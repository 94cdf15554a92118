"""Draw the posterior predictive check on simulated records (Fig. 8)."""

from breaker.figures.predictive import posterior_predictive
from breaker.stores import open_store
from breaker.workflow import start

log = start(snakemake)
data = open_store(snakemake.input.predictive)

figure = posterior_predictive(
    data, motion=snakemake.wildcards.motion, noise_sd=data.attrs["noise_sd"]
)
figure.savefig(snakemake.output[0])
