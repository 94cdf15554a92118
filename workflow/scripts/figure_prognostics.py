"""Draw how early changes are found, and how good the remaining life is."""

import xarray as xr

from breaker.figures.prognostics import prognostics
from breaker.workflow import start

log = start(snakemake)
prognostics(xr.open_zarr(snakemake.input.scores).load()).savefig(snakemake.output[0])
