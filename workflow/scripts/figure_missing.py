"""Draw calibration and widths of posteriors from records with missing samples."""

import xarray as xr

from breaker.figures.networks import missing
from breaker.posterior import widening
from breaker.validation import ranks, verdict
from breaker.workflow import start

start(snakemake)
data = {key: xr.open_zarr(path) for key, path in snakemake.input.items() if key != "code"}
names = data["missing"].output.values
draws, truth = data["missing"].draws.values, data["missing"].truth.values

figure = missing(
    verdict(ranks(draws, truth), draws.shape[1]),
    widening(data["whole"], data["missing"], names),
    widening(data["exact_whole"], data["exact_missing"], names),
    names,
    motion=snakemake.wildcards.motion,
    share=snakemake.params.share,
)
figure.savefig(snakemake.output[0])
