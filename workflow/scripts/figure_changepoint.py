"""Draw the trend of a source, its run length and its changes."""

import xarray as xr

from breaker.figures.changepoint import changepoint
from breaker.workflow import start

log = start(snakemake)
store = snakemake.input.truth
truth = xr.open_zarr(store).value if store else None

trend = xr.open_zarr(snakemake.input.trend).load()
figure = changepoint(trend, source=snakemake.wildcards.source, truth=truth)
figure.savefig(snakemake.output[0])
