"""Draw predicted records and parameters over the operations of the endurance test (Figs. 9, 10)."""

from breaker.common.zarr_store import open_store
from breaker.figures.endurance import evolution
from breaker.figures.predictive import endurance_predictive
from breaker.figures.style import save
from breaker.paper.run_numbers import blocks_of, held
from breaker.workflow.jobs import start

start(snakemake)
files, motion = snakemake.input, snakemake.wildcards.motion
predictive = open_store(files.predictive).load()
save(endurance_predictive(predictive, motion=motion), snakemake.output.predictive)

blocks = {by: blocks_of(open_store(files[by])) for by in ("paper", "family")}
truth = open_store(files.truth).value.load() if files.truth else None
shares = None if truth is None else {by: held(one, truth) for by, one in blocks.items()}
save(evolution(blocks, truth, shares, motion=motion), snakemake.output.evolution)
