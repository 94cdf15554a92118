"""Write the true state of the simulated endurance test, operation by operation."""

from breaker.common.zarr_store import describe, save
from breaker.family.endurance import EnduranceTest
from breaker.family.endurance_truth import truth_of
from breaker.model.quantities import speeds_of
from breaker.model.sensor import grid
from breaker.workflow.jobs import start

log = start(snakemake)
params = snakemake.params

test = EnduranceTest.from_settings(params.rig, params.seed)
truth = truth_of(test, params.motions, grid(**params.grid), speeds_of(params.speeds))
for motion in params.motions:
    far = truth.difference.sel(motion=motion)
    log.info("%s: the model differs by %.2f to %.2f mm", motion, far.min(), far.max())
settings = {key: params[key] for key in ("seed", "rig", "grid", "motions", "speeds")}
save(describe(truth, "true state of the simulated endurance test", **settings), snakemake.output[0])
