"""Judge some operations by their own posteriors: how probably limits are exceeded."""

import numpy as np

from breaker.decisions import align, condition
from breaker.mechanism import from_list, speeds_of
from breaker.stores import describe, open_store, save
from breaker.workflow import start

log = start(snakemake)
params = snakemake.params
operations = np.array(params.operations)
data = {
    motion: align([open_store(file) for file in snakemake.input[motion]], operations).load()
    for motion in params.motions
}
limits = from_list(params.limits, params.motions, speeds_of(params.speeds))
result = condition(data, limits)
log.info("%d operations, %d limits", *result.probability.shape)
settings = {"limits": params.limits, "speeds": params.speeds}
save(describe(result, "condition at single operations", **settings), snakemake.output[0])
