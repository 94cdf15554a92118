"""Judge some operations by their own posteriors: limits, and whether both motions agree."""

import numpy as np
import xarray as xr

from breaker.decisions import align, condition
from breaker.mechanism import from_list
from breaker.model import Model
from breaker.workflow import describe, save, start

log = start(snakemake)
params = snakemake.params
settings = {key: params[key] for key in ("prior", "sensor")}
models = {motion: Model.from_settings({**settings, "motion": motion}) for motion in params.motions}
operations = np.array(params.operations)
data = {
    motion: align([xr.open_zarr(file) for file in snakemake.input[motion]], operations).load()
    for motion in models
}

limits = from_list(params.limits, params.motions)
result = condition(models, data, limits, params.correction, params.seed)
log.info("%d operations, motions agree in %d", operations.size, result.agree.sum())
settings |= {"limits": params.limits, "correction": params.correction, "seed": params.seed}
save(describe(result, "condition at single operations", **settings), snakemake.output[0])
