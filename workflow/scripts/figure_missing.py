"""Draw calibration and widths of posteriors from records with missing samples."""

import xarray as xr

from breaker.figures.networks import missing
from breaker.posterior import widening
from breaker.validation import judge_draws, over_curves
from breaker.workflow import start

start(snakemake)
data = {key: xr.open_zarr(path) for key, path in snakemake.input.items() if key != "code"}
names = data["missing"].output.values

figure = missing(
    judge_draws(data["missing"].draws.values, data["missing"].truth.values),
    over_curves(widening(data["whole"], data["missing"], names)),
    over_curves(widening(data["exact_whole"], data["exact_missing"], names)),
    names,
    motion=snakemake.wildcards.motion,
    share=snakemake.params.share,
)
figure.savefig(snakemake.output[0])
