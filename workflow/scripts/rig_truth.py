"""Write down the true state of the stand-in, operation by operation."""

from breaker.common.zarr_store import describe, save
from breaker.family.endurance_rig import Rig
from breaker.family.rig_truth import truth_of
from breaker.model.quantities import speeds_of
from breaker.model.sensor import grid
from breaker.workflow.jobs import start

log = start(snakemake)
params = snakemake.params

rig = Rig.from_settings(params.rig, params.seed)
truth = truth_of(rig, params.motions, grid(**params.grid), speeds_of(params.speeds))
for motion in params.motions:
    far = truth.difference.sel(motion=motion)
    log.info("%s: the model differs by %.2f to %.2f mm", motion, far.min(), far.max())
settings = {key: params[key] for key in ("seed", "rig", "grid", "motions", "speeds")}
save(describe(truth, "true state of the stand-in", **settings), snakemake.output[0])
