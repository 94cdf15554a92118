"""Draw how far the network's posteriors are from the exact ones."""

from breaker.common.zarr_store import open_store
from breaker.figures.exactness import exactness
from breaker.figures.style import save
from breaker.paper.validation import examples, summary
from breaker.workflow.jobs import start

start(snakemake)
judged, amortised, corrected = (
    open_store(snakemake.input[name]).load() for name in ("judged", "amortised", "corrected")
)
figure = exactness(
    judged,
    corrected,
    examples(judged, amortised, corrected),
    summary(judged, corrected).iloc[0],
    motion=snakemake.wildcards.motion,
)
save(figure, snakemake.output[0])
