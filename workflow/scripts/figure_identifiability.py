"""Draw what a curve can say of each parameter, and what was reached of it."""

import xarray as xr

from breaker.figures.identifiability import identifiability
from breaker.mechanism import is_logarithmic, prior_sds
from breaker.validation import reached, scores
from breaker.workflow import start

start(snakemake)
params = snakemake.params
limit, amortised, corrected = (
    xr.open_zarr(snakemake.input[name]) for name in ("limit", "amortised", "corrected")
)
corrected = corrected.isel(curve=corrected.resolved.values)  # of the others, no width is known
names = amortised.output.values
contractions = [
    scores(
        data.draws.values,
        data.truth.values,
        prior_sd=prior_sds(names, params.prior, params.onset_sd),
        log=is_logarithmic(names),
    ).contraction
    for data in (amortised, corrected)
]
found = reached(limit.contraction.values, *contractions, names)
figure = identifiability(found, motion=snakemake.wildcards.motion)
figure.savefig(snakemake.output[0])
