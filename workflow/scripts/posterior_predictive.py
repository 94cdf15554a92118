"""Predict a few simulated records from their own posteriors."""

import xarray as xr

from breaker.posterior import Posterior, predict
from breaker.workflow import describe, save, start

log = start(snakemake)
params, motion = snakemake.params, snakemake.wildcards.motion
posterior = Posterior.load(snakemake.input.model)
data = xr.open_zarr(snakemake.input.validation)
data = data.isel(curve=slice(0, params.curves))

result = predict(posterior, data.measured.values, data.draws.values, seed=params.seed)
save(describe(result, f"predicted {motion} records", seed=params.seed), snakemake.output[0])
