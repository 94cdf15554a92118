"""Draw the parameters over the operations of the endurance test (Fig. 10)."""

import xarray as xr

from breaker.figures.evolution import evolution
from breaker.posterior import choose
from breaker.workflow import start

log = start(snakemake)
inferred = choose(xr.open_zarr(snakemake.input.inferred), snakemake.params.posterior)
files = snakemake.input.effective
effective = xr.open_zarr(files[0]).effective if files else None

figure = evolution(inferred, motion=snakemake.wildcards.motion, effective=effective)
figure.savefig(snakemake.output[0])
