"""Hold the network's own density against the exact posterior, curve by curve."""

import xarray as xr

from breaker.posterior import Posterior, judge, summary
from breaker.workflow import describe, save, start

log = start(snakemake)
posterior = Posterior.load(snakemake.input.model).at(snakemake.params.discrepancy)
data = xr.open_zarr(snakemake.input.validation).isel(curve=slice(snakemake.params.curves)).load()
corrected = xr.open_zarr(snakemake.input.corrected)

judged = judge(posterior, data, corrected)
table = summary(judged, corrected)
log.info("%s", ", ".join(f"{key} {value:.4g}" for key, value in table.iloc[0, 1:].items()))
title = f"the {posterior.motion} network against the exact posterior"
save(describe(judged, title, model=posterior.settings), snakemake.output.store)
table.to_csv(snakemake.output.table, index=False, float_format="%.5g")
