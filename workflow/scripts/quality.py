"""Put the quality of one motion's posterior into a table: one row an output."""

import xarray as xr

from breaker.jobs import start
from breaker.parameters import is_logarithmic, prior_sds
from breaker.quality import quality, words

log = start(snakemake)
params = snakemake.params
data, reader, limit = (
    xr.open_zarr(snakemake.input[name]) for name in ("validation", "reader", "limit")
)
names = data.output.values

table = quality(
    data,
    reader,
    limit.contraction.mean("curve").values,
    prior_sd=prior_sds(names, params.prior, params.onset_sd),
    log=is_logarithmic(names),
)
table.to_csv(snakemake.output[0], index=False, float_format="%.5g")
log.info("%s", words(table))
