"""Draw what was inferred against the truth, for one motion (Fig. 6)."""

import xarray as xr

from breaker.figures.validation import recovery as recovery_figure
from breaker.validation import recovery
from breaker.workflow import start

log = start(snakemake)
data = xr.open_zarr(snakemake.input.validation)

summary = recovery(data.draws.values, data.truth.values)
figure = recovery_figure(summary, data.output.values, motion=snakemake.wildcards.motion)
figure.savefig(snakemake.output[0])
