"""Infer some operations of the endurance test."""

from breaker.common.zarr_store import describe, open_store, save
from breaker.paper.inference import infer
from breaker.paper.posterior import Posterior
from breaker.workflow.jobs import start

log = start(snakemake)
params, motion = snakemake.params, snakemake.wildcards.motion

posterior = Posterior.load(snakemake.input.model, own_functions=True)
curves = open_store(snakemake.input.curves).load()
settings = {key: params[key] for key in ("seed", "draws", "misfit_p_value")}
result = infer(posterior, curves, **settings)
log.info(
    "%d operations: %d rejected, %d do not fit the model, %d outside what the prior can produce",
    result.sizes["operation"],
    (~result.accepted).sum(),
    result.misfit.sum(),
    result.outside_prior.sum(),
)
title = f"posteriors of measured {motion} operations"
save(
    describe(result, title, **settings, model=posterior.settings),
    snakemake.output[0],
)
