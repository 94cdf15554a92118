"""Infer simulated records that were written to curve files and read."""

from breaker.common.randomness import generator
from breaker.common.zarr_store import describe, save
from breaker.family.exports import through_files
from breaker.paper.inference import sample_records
from breaker.paper.posterior import Posterior
from breaker.workflow.jobs import start

log = start(snakemake)
params, motion, seed = snakemake.params, snakemake.wildcards.motion, int(snakemake.wildcards.seed)

posterior = Posterior.load(snakemake.input.model, own_functions=True)
rng = generator(seed, "records through files", motion)
model = posterior.model
measured, truth, reasons = through_files(model.prior, model.sensor, motion, params.curves, rng)
log.info("%d of %d curves of the prior rejected", len(reasons), params.curves)
for reason in reasons:
    log.info("rejected: %s", reason)
if posterior.sensor.infers_onset:
    error = truth[:, -1]
    log.info("first motion found too late by %.3f ms, sd %.3f ms", -error.mean(), error.std())
result = sample_records(posterior, measured, truth, params.draws, seed)
result.attrs["rejected"] = len(reasons)
title = f"posteriors of simulated {motion} records, read from files"
save(describe(result, title, model=posterior.settings), snakemake.output[0])
