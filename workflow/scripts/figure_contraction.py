"""Draw z-score against contraction of one motion (Fig. 5)."""

import xarray as xr

from breaker.figures.validation import contraction
from breaker.mechanism import is_logarithmic, prior_sds
from breaker.validation import scores
from breaker.workflow import start

log = start(snakemake)
params = snakemake.params
data = xr.open_zarr(snakemake.input.validation)
limit = xr.open_zarr(snakemake.input.limit)
names = data.output.values

judged = scores(
    data.draws.values,
    data.truth.values,
    prior_sd=prior_sds(names, params.prior, params.onset_sd),
    log=is_logarithmic(names),
)
figure = contraction(
    judged,
    names,
    motion=snakemake.wildcards.motion,
    limit=limit.contraction.mean("curve").values,
    setting=params.setting,
)
figure.savefig(snakemake.output[0])
