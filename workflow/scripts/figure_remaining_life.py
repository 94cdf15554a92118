"""Draw the remaining life of each limit over the operations, beside the truth where it is known."""

import xarray as xr

from breaker.common.zarr_store import open_store
from breaker.drive.simulation.failure_times import held, true_lives
from breaker.figures.remaining_life import remaining_life
from breaker.figures.style import save
from breaker.model.limits import from_list
from breaker.model.quantities import speeds_of
from breaker.workflow.jobs import start

log = start(snakemake)
life, standing = (open_store(snakemake.input[name]).load() for name in ("life", "standing"))
params, truth = snakemake.params, None
if snakemake.input.truth:
    limits = from_list(params.limits, params.motions, speeds_of(params.speeds))
    lives = true_lives(open_store(snakemake.input.truth).load(), limits)
    truth = xr.Dataset(lives, {"limit": [limit.name for limit in limits]})
    truth = truth.sel(limit=life.limit.values)
    truth["held"] = "limit", held(life, truth.failure.values)
save(remaining_life(life, standing, truth), snakemake.output[0])
