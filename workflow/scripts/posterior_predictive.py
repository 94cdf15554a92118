"""Predict a few simulated records from their posteriors."""

from breaker.common.zarr_store import describe, open_store, save
from breaker.paper.inference import predict
from breaker.paper.joint_model import Model
from breaker.workflow.jobs import start

log = start(snakemake)
params, motion = snakemake.params, snakemake.wildcards.motion
model = Model.from_settings({**dict(params.items()), "motion": motion})
data = open_store(snakemake.input.validation)
data = data.isel(curve=slice(0, params.curves))

result = predict(model, data.measured.values, data.draws.values, seed=params.seed)
save(describe(result, f"predicted {motion} records", seed=params.seed), snakemake.output[0])
