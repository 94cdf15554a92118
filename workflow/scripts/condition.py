"""Judge some operations by their own posteriors: how probably limits are exceeded."""

import numpy as np

from breaker.decisions import align, condition
from breaker.mechanism import from_list
from breaker.stores import describe, open_store, save
from breaker.workflow import start

log = start(snakemake)
params = snakemake.params
operations = np.array(params.operations)
data = {
    motion: align([open_store(file) for file in snakemake.input[motion]], operations).load()
    for motion in params.motions
}
result = condition(data, from_list(params.limits, params.motions))
log.info("%d operations, %d limits", *result.probability.shape)
save(describe(result, "condition at single operations", limits=params.limits), snakemake.output[0])
