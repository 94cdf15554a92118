"""Follow a source through some operations, from the state after those before."""

import numpy as np
import xarray as xr

from breaker.decisions import agreement, align, usable
from breaker.mechanism import from_list
from breaker.model import Model
from breaker.wear import Follower, State, series_of
from breaker.workflow import describe, save, start

log = start(snakemake)
params, source = snakemake.params, snakemake.wildcards.source
wear_model, operations = params.wear_model, np.array(params.operations)
shared = {key: params[key] for key in ("prior", "sensor")}
motions = params.motions if source == "both" else [source]
models = {motion: Model.from_settings({**shared, "motion": motion}) for motion in motions}
limits = [each for each in from_list(params.limits, params.motions) if each.motion in motions]
follower = Follower.from_settings(models, limits, wear_model, params.seed)
first = snakemake.input.get("first")
agree = agreement(xr.open_zarr(first[0]), wear_model["baseline"]) if first else 1.0
if not agree >= wear_model["agreement"]:
    # The motions have different parameters: nothing to follow together.
    log.info("the motions agree in %.0f %% of the first operations: not fused", 100 * agree)
    state, result = follower.idle(int(operations[0]))
else:
    data = {
        motion: align([xr.open_zarr(file) for file in snakemake.input[motion]], operations).load()
        for motion in motions
    }
    series = series_of(models, data, {motion: usable(each) for motion, each in data.items()})
    before = snakemake.input.get("state")
    state = State.from_dataset(xr.open_zarr(before[0])) if before else follower.begin(series)
    state, result = follower.follow(state, series)
    log.info("%d operations, changes noticed at %s", operations.size, list(state.alarms))
settings = shared | {"limits": params.limits, "wear_model": wear_model, "seed": params.seed}
result = result.assign_attrs(agree=agree)
save(describe(result, f"trend of {source}", **settings), snakemake.output.trend)
save(describe(state.to_dataset(), f"state of the trend of {source}"), snakemake.output.state)
