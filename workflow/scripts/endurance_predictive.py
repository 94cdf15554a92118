"""Predict the records at a few stages of the endurance test from their own posteriors."""

from breaker.common.zarr_store import describe, open_store, save
from breaker.paper.inference import predict_stages
from breaker.paper.joint_model import Model
from breaker.workflow.jobs import start

STAGES = 4  # new, two between, and worn, as in the figure of the paper

log = start(snakemake)
params, motion = snakemake.params, snakemake.wildcards.motion
model = Model.from_settings({**dict(params.items()), "motion": motion})
inferred = open_store(snakemake.input.inferred)

result = predict_stages(model, inferred, stages=STAGES, seed=params.seed)
shares = ", ".join(f"{share:.1%}" for share in result.share_inside.values)
log.info("main motion inside the 95 %% band, stage by stage: %s", shares)
save(describe(result, f"predicted {motion} records", seed=params.seed), snakemake.output[0])
