"""Draw the calibration of one motion (Fig. 4)."""

import xarray as xr

from breaker.figures.validation import sbc
from breaker.validation import ranks, verdict
from breaker.workflow import start

log = start(snakemake)
data = xr.open_zarr(snakemake.input.validation)

judged = verdict(ranks(data.draws.values, data.truth.values), data.sizes["draw"])
figure = sbc(
    judged,
    data.output.values,
    motion=snakemake.wildcards.motion,
    subject=snakemake.params.subject,
)
figure.savefig(snakemake.output[0])
