"""Draw the posterior predictive check on simulated records (Fig. 8)."""

import xarray as xr

from breaker.figures.predictive import posterior_predictive
from breaker.workflow import start

log = start(snakemake)
data = xr.open_zarr(snakemake.input.predictive)

figure = posterior_predictive(
    data, motion=snakemake.wildcards.motion, noise_sd=data.attrs["noise_sd"]
)
figure.savefig(snakemake.output[0])
