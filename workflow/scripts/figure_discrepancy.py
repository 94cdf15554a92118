"""Draw what the model leaves out of a motion, and what it costs."""

import xarray as xr

from breaker.figures.discrepancy import discrepancy
from breaker.workflow import start

start(snakemake)
params, motion = snakemake.params, snakemake.wildcards.motion
learned = xr.open_zarr(snakemake.input.discrepancy).sel(motion=motion).load()
cost = xr.open_zarr(snakemake.input.cost)

figure = discrepancy(learned, cost, motion=motion, noise_sd=params.noise_sd)
figure.savefig(snakemake.output[0])
