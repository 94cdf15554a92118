"""Draw the parameters over the operations of the endurance test (Fig. 10)."""

import xarray as xr

from breaker.figures.evolution import evolution
from breaker.posterior import choose
from breaker.workflow import start

log = start(snakemake)
inferred = choose(xr.open_zarr(snakemake.input.inferred), snakemake.params.posterior)
store = snakemake.input.truth
truth = xr.open_zarr(store).value if store else None

figure = evolution(inferred, motion=snakemake.wildcards.motion, truth=truth)
figure.savefig(snakemake.output[0])
