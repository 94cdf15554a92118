"""Draw how far posteriors are from the exact ones, and how well a curve determines parameters."""

from breaker.common.zarr_store import open_store
from breaker.figures.exactness import exactness
from breaker.figures.identifiability import identifiability
from breaker.figures.style import save
from breaker.model.parameters import is_logarithmic, prior_sds
from breaker.paper.validation import contraction, examples, reached, summary
from breaker.workflow.jobs import start

start(snakemake)
params, motion = snakemake.params, snakemake.wildcards.motion
judged, amortised, corrected, limit = (
    open_store(snakemake.input[name]).load()
    for name in ("judged", "amortised", "corrected", "limit")
)
found = examples(judged, amortised, corrected), summary(judged, corrected).iloc[0]
save(exactness(judged, corrected, *found, motion=motion), snakemake.output.exactness)

resolved = corrected.isel(curve=corrected.resolved.values)  # of the others, no width is known
names = amortised.output.values
scale = {"prior_sd": prior_sds(names, params.prior, params.onset_sd), "log": is_logarithmic(names)}
widths = {"limit": limit.contraction.values}
for name, data in (("amortised", amortised), ("corrected", resolved)):
    if data.sizes["curve"]:
        widths[name] = contraction(data.draws.values, **scale)
save(identifiability(reached(widths, names), motion=motion), snakemake.output.identifiability)
