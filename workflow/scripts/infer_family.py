"""Infer some operations of the endurance test by shipped networks of families."""

from breaker.common.zarr_store import describe, open_store, save
from breaker.family.networks import shipped_levels
from breaker.family.operation_inference import infer_operations
from breaker.workflow.jobs import start

log = start(snakemake)
params, motion = snakemake.params, snakemake.wildcards.motion

families = [*shipped_levels()]
curves = open_store(snakemake.input.curves).load()
settings = {key: params[key] for key in ("seed", "draws", "misfit_p_value")}
result = infer_operations(curves, families, **settings)
log.info(
    "%d operations: %d rejected, %d of no family",
    result.sizes["operation"],
    (~result.accepted).sum(),
    result.misfit.sum(),
)
title = f"answers of families to measured {motion} operations"
save(describe(result, title, **settings), snakemake.output[0])
