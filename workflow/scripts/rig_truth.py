"""Write down the true parameters of the stand-in, operation by operation."""

from breaker.model import grid
from breaker.stores import describe, save
from breaker.synthetic import Rig, truth_of
from breaker.workflow import start

log = start(snakemake)
params = snakemake.params

rig = Rig.from_settings(params.rig, params.seed)
truth = truth_of(rig, params.motions, grid(**params.grid))
for motion in params.motions:
    far = truth.difference.sel(motion=motion)
    log.info("%s: the model differs by %.2f to %.2f mm", motion, far.min(), far.max())
settings = {key: params[key] for key in ("seed", "rig", "grid", "motions")}
save(describe(truth, "true parameters of the stand-in", **settings), snakemake.output[0])
