"""Draw the parameters over the operations of the endurance test (Fig. 10)."""

from breaker.figures.evolution import evolution
from breaker.posterior import choose
from breaker.stores import open_store
from breaker.workflow import start

log = start(snakemake)
inferred = choose(open_store(snakemake.input.inferred), snakemake.params.posterior)
store = snakemake.input.truth
truth = open_store(store).value if store else None

figure = evolution(inferred, motion=snakemake.wildcards.motion, truth=truth)
figure.savefig(snakemake.output[0])
