"""Draw the first page: four sentences and how each limit stands."""

import xarray as xr

from breaker.figures.verdict import verdict
from breaker.workflow import start

log = start(snakemake)
verdict(xr.open_zarr(snakemake.input.verdict).load()).savefig(snakemake.output[0])
