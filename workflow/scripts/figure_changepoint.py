"""Draw the trend of a source, its run length and its changes."""

import xarray as xr

from breaker.figures.changepoint import changepoint
from breaker.workflow import start

log = start(snakemake)
files = snakemake.input.effective
effective = xr.open_zarr(files[0]).effective if files else None

trend = xr.open_zarr(snakemake.input.trend).load()
figure = changepoint(trend, source=snakemake.wildcards.source, effective=effective)
figure.savefig(snakemake.output[0])
