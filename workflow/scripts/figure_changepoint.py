"""Draw the trend of a source, its run length and its changes."""

import xarray as xr

from breaker.figures.changepoint import changepoint
from breaker.workflow import start

log = start(snakemake)
effective = None
if "effective" in snakemake.input.keys():  # noqa: SIM118
    effective = xr.open_zarr(snakemake.input.effective).effective

trend = xr.open_zarr(snakemake.input.trend).load()
figure = changepoint(trend, source=snakemake.wildcards.source, effective=effective)
figure.savefig(snakemake.output[0])
