"""Draw how probably each limit is exceeded, over the operations."""

import xarray as xr

from breaker.figures.health import health
from breaker.workflow import start

log = start(snakemake)
health(xr.open_zarr(snakemake.input.health).load()).savefig(snakemake.output[0])
