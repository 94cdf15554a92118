"""Draw the divergence from exact posteriors, and how well a curve determines parameters."""

from breaker.common.zarr_store import open_store
from breaker.figures.exactness import exactness, identifiability
from breaker.figures.style import save
from breaker.paper.validation import contraction, reached, scale_of, summary
from breaker.workflow.jobs import start

start(snakemake)
motion = snakemake.wildcards.motion
judged, amortised, corrected, limit = (
    open_store(snakemake.input[name]).load()
    for name in ("judged", "amortised", "corrected", "limit")
)
row = summary(judged, corrected).iloc[0]
save(exactness(judged, corrected, row, motion=motion), snakemake.output.exactness)

resolved = corrected.isel(curve=corrected.resolved.values)  # the others have no known width
widths = {"limit": limit.contraction.values}
for name, data in (("amortised", amortised), ("corrected", resolved)):
    if data.sizes["curve"]:
        widths[name] = contraction(data.draws.values, **scale_of(amortised))
save(
    identifiability(reached(widths, amortised.output.values), motion=motion),
    snakemake.output.identifiability,
)
