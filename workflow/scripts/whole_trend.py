"""Put the trend of a source into one store, with its changes."""

import numpy as np
import xarray as xr

from breaker.decisions import complete, join
from breaker.posterior import choose
from breaker.workflow import describe, save, start

log = start(snakemake)
source = snakemake.wildcards.source
trend = join([xr.open_zarr(file).load() for file in snakemake.input.trends])
if source == "both":
    medians = join([xr.open_zarr(file)[["median"]] for file in snakemake.input.medians])
else:
    medians = choose(xr.open_zarr(snakemake.input.medians), "corrected")
    medians = medians.rename(output="parameter")[["median"]]

medians = medians["median"].reindex(operation=trend.operation, parameter=trend.parameter)
result = complete(trend, np.asarray(medians.values), snakemake.params.wear_model, source)
log.info("%s: %d changes", source, result.sizes["change"])
save(describe(result, f"trend of {source}, all operations"), snakemake.output[0])
