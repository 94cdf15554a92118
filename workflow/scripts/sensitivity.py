"""Infer a few operations at several scales of what the model leaves out."""

from breaker.decisions import over_scales, spread
from breaker.mechanism import from_list, speeds_of
from breaker.posterior import Posterior
from breaker.records import open_curves
from breaker.stores import open_store
from breaker.workflow import start

log = start(snakemake)
params, motion = snakemake.params, snakemake.wildcards.motion

posterior = Posterior.load(snakemake.input.model)
truth = open_store(snakemake.input.truth).value if snakemake.input.truth else None
table = over_scales(
    posterior,
    spread(open_curves(snakemake.input.curves), params.operations).load(),
    params.scales,
    from_list(params.limits, [motion], speeds_of(params.speeds)),
    params.correction,
    truth=truth,
    seed=params.seed,
    **params.endurance,
)
for scale, rows in table.groupby("scale"):
    found = rows.groupby("operation").first()
    log.info("s = %g: p-values %s", scale, ", ".join(f"{p:.2g}" for p in found.p_value))
table.to_csv(snakemake.output[0], index=False, float_format="%.5g")
