"""Correct the posteriors of simulated records of one motion."""

from breaker.common.zarr_store import describe, open_store, save
from breaker.paper.correction import correct_validation
from breaker.paper.joint_model import Model
from breaker.workflow.jobs import start

log = start(snakemake)
params, wildcards = snakemake.params, snakemake.wildcards
settings = {key: params[key] for key in ("model", "prior", "sensor", "rounds")}
model = Model.from_settings({**settings, "motion": wildcards.motion})
data = open_store(snakemake.input.validation).load()

result = correct_validation(model, data, rounds=params.rounds, seed=int(wildcards.seed))
log.info(
    "%d of %d curves resolved, %.1f rounds on average",
    result.resolved.sum(),
    result.sizes["curve"],
    result.rounds.mean(),
)
title = f"exact posteriors of simulated {wildcards.motion} records"
save(describe(result, title, **settings), snakemake.output[0])
