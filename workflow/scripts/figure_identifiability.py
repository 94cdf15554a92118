"""Draw how well a curve determines each parameter, and how much of it posteriors reach."""

from breaker.common.zarr_store import open_store
from breaker.figures.identifiability import identifiability
from breaker.figures.style import save
from breaker.model.parameters import is_logarithmic, prior_sds
from breaker.paper.validation import contraction, reached
from breaker.workflow.jobs import start

start(snakemake)
params, motion = snakemake.params, snakemake.wildcards.motion
limit, amortised, corrected = (
    open_store(snakemake.input[name]) for name in ("limit", "amortised", "corrected")
)
corrected = corrected.isel(curve=corrected.resolved.values)  # of the others, no width is known
names = amortised.output.values
scale = {"prior_sd": prior_sds(names, params.prior, params.onset_sd), "log": is_logarithmic(names)}
found = {"limit": limit.contraction.values}
for name, data in (("amortised", amortised), ("corrected", corrected)):
    if data.sizes["curve"]:
        found[name] = contraction(data.draws.values, **scale)
save(identifiability(reached(found, names), motion=motion), snakemake.output[0])
